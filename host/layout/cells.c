#include "cells.h"
#include "memory.h"
#include <string.h>

enum { MOST_REFINEMENTS = 12 };

static pc_status make_walls(pc_cells *cells, pc_context *ctx, const pc_overlay *overlay,
                            const pc_adjacency *adjacency) {
    pc_free(ctx, cells->wall);
    pc_status status = pc_new(&cells->wall, ctx, adjacency->edge_count);
    if (status != PC_OK) return status;
    for (pc_index h = 0; h < 3 * overlay->mesh.face_count; h++)
        if (overlay->drawn[h] || adjacency->twin[h] == PC_NONE) cells->wall[adjacency->edge[h]] = 1;
    return PC_OK;
}

/* ---- what is known while regions are looked at one by one ---- */

typedef struct pending {
    pc_index face,
        cell; /* to look at the region around face, unless that has been done since it was `cell` */
} pending;

typedef struct working {
    pc_context *ctx;
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    pc_cells *cells;
    pc_index *degree; /* per vertex: walls */
    pc_index *seen;   /* per vertex: the last search that came by */
    pc_index search;
    pc_index *region; /* the faces of the region at hand, breadth first */
    pc_index region_count;
    pc_index selfish; /* the least half-edge of a wall with that region on both sides, PC_NONE */
    bool walled;      /* the region has a rim */
    int64_t euler;    /* of its interior: faces minus open edges plus open vertices; 1 for a disk */
    pending *todo;
    size_t todo_count, todo_room;
    uint8_t *crossed; /* per edge: by a tree of faces, or pruned; all 0 between regions */
    uint8_t *mark;    /* per face; all 0 between regions */
    pc_index *open;   /* per vertex: open edges that are not crossed; all 0 between regions */
    pc_index *rim, rim_count, rim_room;  /* half-edges of the region's rim */
    pc_index *position;                  /* per half-edge of the rim */
    pc_index *from;                      /* per vertex inside: half-edge by which a search came */
    pc_index *queue, queued, queue_room; /* half-edges to follow */
    uint8_t *stuck;                      /* per face: its region has found no way across */
    pc_index stuck_count;
    pc_cells_stats *stats;
} working;

static void free_working(working *w) {
    void *const blocks[] = {w->degree, w->seen, w->region,   w->todo, w->crossed, w->mark,
                            w->open,   w->rim,  w->position, w->from, w->queue,   w->stuck};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++)
        pc_free(w->ctx, blocks[i]);
}

static pc_status new_working(working *w, pc_context *ctx, pc_cells *cells, pc_cells_stats *stats,
                             const pc_mesh *mesh, const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    size_t faces = mesh->face_count, vertices = mesh->vertex_count;
    *w = (working){.ctx = ctx, .mesh = mesh, .adjacency = adjacency, .cells = cells, .stats = stats};
    PC_TRY(pc_new(&w->degree, ctx, vertices));
    PC_TRY(pc_new(&w->seen, ctx, vertices));
    PC_TRY(pc_new(&w->region, ctx, faces));
    PC_TRY(pc_new(&w->crossed, ctx, adjacency->edge_count));
    PC_TRY(pc_new(&w->mark, ctx, faces));
    PC_TRY(pc_new(&w->open, ctx, vertices));
    PC_TRY(pc_new(&w->position, ctx, 3 * faces));
    PC_TRY(pc_new(&w->from, ctx, vertices));
    PC_TRY(pc_new(&w->stuck, ctx, faces));
    for (pc_index e = 0; e < adjacency->edge_count; e++)
        if (cells->wall[e]) {
            w->degree[pc_tail(mesh, adjacency->edge_half[e])]++;
            w->degree[pc_head(mesh, adjacency->edge_half[e])]++;
        }
done:
    return status;
}

static void set_wall(working *w, pc_index e) {
    pc_index h = w->adjacency->edge_half[e];
    w->cells->wall[e] = 1;
    w->degree[pc_tail(w->mesh, h)]++, w->degree[pc_head(w->mesh, h)]++;
}

static pc_status look_again(working *w, pc_index face) {
    pc_status status = PC_OK;
    if (w->todo_count == w->todo_room) {
        w->todo_room = 2 * w->todo_room + 64;
        PC_TRY(pc_resize(&w->todo, w->ctx, w->todo_room));
    }
    w->todo[w->todo_count++] = (pending){face, w->cells->cell[face]};
done:
    return status;
}

static bool is_wall(const working *w, pc_index h) {
    return w->cells->wall[w->adjacency->edge[h]];
}

/* A half-edge at v, out of it or on its border into it, on an edge e with wall[e] == kind and not skip[e]
 * (NULL: none); PC_NONE where there is none. */
static pc_index edge_at(const pc_adjacency *a, pc_index v, const uint8_t *wall, uint8_t kind,
                        const uint8_t *skip) {
    pc_index first = a->vertex_half[v], h = first;
    while (h != PC_NONE) {
        pc_index back = pc_prev(h), out = a->edge[h], in = a->edge[back];
        if (wall[out] == kind && !(skip && skip[out])) return h;
        if (a->twin[back] == PC_NONE && wall[in] == kind && !(skip && skip[in])) return back;
        h = pc_turn_ccw(a, h);
        if (h == first) break;
    }
    return PC_NONE;
}

static void remove_dangling(working *w) {
    for (pc_index start = 0; start < w->mesh->vertex_count; start++)
        for (pc_index v = start; w->degree[v] == 1;) {
            pc_index h = edge_at(w->adjacency, v, w->cells->wall, 1, NULL);
            pc_index other = pc_tail(w->mesh, h) == v ? pc_head(w->mesh, h) : pc_tail(w->mesh, h);
            w->cells->wall[w->adjacency->edge[h]] = 0;
            w->degree[v]--, w->degree[other]--, w->stats->dangling_edges++;
            v = other;
        }
}

/* Collects the faces of the region around `seed` and gives it a new number. */
static void gather_region(working *w, pc_index seed) {
    pc_index *cell = w->cells->cell, number = w->cells->cell_count++;
    w->region_count = 0;
    w->region[w->region_count++] = seed;
    cell[seed] = number;
    for (pc_index next = 0; next < w->region_count; next++)
        for (pc_index h = 3 * w->region[next], k = 0; k < 3; h++, k++) {
            if (is_wall(w, h)) continue;
            pc_index f = w->adjacency->twin[h] / 3;
            if (cell[f] == number) continue;
            cell[f] = number;
            w->region[w->region_count++] = f;
        }
}

static void measure_region(working *w) {
    const pc_index *cell = w->cells->cell;
    pc_index number = cell[w->region[0]];
    int64_t open_halves = 0;
    w->euler = w->region_count;
    w->walled = false, w->selfish = PC_NONE;
    w->search++;
    for (pc_index i = 0; i < w->region_count; i++)
        for (pc_index h = 3 * w->region[i], k = 0; k < 3; h++, k++) {
            pc_index twin = w->adjacency->twin[h], v = pc_tail(w->mesh, h);
            if (w->degree[v] == 0 && w->seen[v] != w->search) w->seen[v] = w->search, w->euler++;
            if (!is_wall(w, h)) {
                open_halves++;
                continue;
            }
            w->walled = true;
            if (twin != PC_NONE && cell[twin / 3] == number && h < w->selfish) w->selfish = h;
        }
    w->euler -= open_halves / 2;
}

/* ---- regions that are no disks ---- */

static bool is_open(const working *w, pc_index e) {
    return !w->cells->wall[e] && !w->crossed[e];
}

/* A breadth-first tree over the faces of the region, which are listed in that order. */
static void grow_tree(working *w) {
    w->mark[w->region[0]] = 1;
    for (pc_index i = 0; i < w->region_count; i++)
        for (pc_index h = 3 * w->region[i], k = 0; k < 3; h++, k++) {
            if (is_wall(w, h) || w->mark[w->adjacency->twin[h] / 3]) continue;
            w->mark[w->adjacency->twin[h] / 3] = 1;
            w->crossed[w->adjacency->edge[h]] = 1;
        }
}

static void prune(working *w, pc_index v) {
    while (w->degree[v] == 0 && w->open[v] == 1) {
        pc_index h = edge_at(w->adjacency, v, w->cells->wall, 0, w->crossed);
        pc_index other = pc_tail(w->mesh, h) == v ? pc_head(w->mesh, h) : pc_tail(w->mesh, h);
        w->crossed[w->adjacency->edge[h]] = 1;
        w->open[v]--, w->open[other]--;
        v = other;
    }
}

/* A sphere without any line: the rim of its first half, in order of distance, parts it in two. */
static pc_status halve_sphere(working *w) {
    pc_status status = PC_OK;
    for (pc_index i = 0; i < w->region_count; i++)
        w->mark[w->region[i]] = i < (w->region_count + 1) / 2 ? 2 : 3;
    for (pc_index i = 0; i < w->region_count; i++)
        for (pc_index h = 3 * w->region[i], k = 0; k < 3; h++, k++) {
            pc_index beyond = w->adjacency->twin[h] / 3;
            if (w->mark[h / 3] != 2 || w->mark[beyond] != 3) continue;
            set_wall(w, w->adjacency->edge[h]);
            PC_TRY(look_again(w, beyond)); /* the second half may be in several pieces */
        }
done:
    return status;
}

/* What a tree of faces leaves of the open edges, dangling ends pruned, cuts the region into one disk (tree
 * and cotree, Eppstein 2003). */
static pc_status cut_region(working *w) {
    pc_status status = PC_OK;
    bool cut = false;
    grow_tree(w);
    for (pc_index i = 0; i < w->region_count; i++)
        for (pc_index h = 3 * w->region[i], k = 0; k < 3; h++, k++)
            if (is_open(w, w->adjacency->edge[h])) w->open[pc_tail(w->mesh, h)]++;
    for (pc_index i = 0; i < 3 * w->region_count; i++)
        prune(w, pc_tail(w->mesh, 3 * w->region[i / 3] + i % 3));
    for (pc_index i = 0; i < 3 * w->region_count; i++) {
        pc_index e = w->adjacency->edge[3 * w->region[i / 3] + i % 3];
        if (!is_open(w, e)) continue;
        set_wall(w, e);
        cut = true;
    }
    if (!cut && !w->walled) PC_TRY(halve_sphere(w));
    PC_TRY(look_again(w, w->region[0]));
    w->stats->cut_cells++;
done:
    for (pc_index i = 0; i < w->region_count; i++) {
        w->mark[w->region[i]] = 0;
        for (pc_index h = 3 * w->region[i], k = 0; k < 3; h++, k++) {
            w->crossed[w->adjacency->edge[h]] = 0;
            w->open[pc_tail(w->mesh, h)] = 0;
        }
    }
    return status;
}

/* ---- cells that meet themselves ---- */

/* A rim may come by a vertex several times, even all of its vertices. Ways across a cell therefore begin and
 * end at positions of the rim, each with the faces of the cell between the wall that arrives there and the
 * one that leaves. */

/* The positions of the rim where it runs along the same wall; false where there are none. */
static bool find_repeat(const working *w, pc_index *first, pc_index *second) {
    for (pc_index i = 0; i < w->rim_count; i++) {
        pc_index twin = w->adjacency->twin[w->rim[i]];
        if (twin == PC_NONE || w->cells->cell[twin / 3] != w->cells->cell[w->rim[i] / 3]) continue;
        *first = i, *second = w->position[twin];
        if (*first > *second) *first = w->position[twin], *second = i;
        return true;
    }
    return false;
}

static void queue_sector(working *w, pc_index at) {
    for (pc_index back = pc_prev(w->rim[at]); !is_wall(w, back);) {
        pc_index h = w->adjacency->twin[back];
        w->queue[w->queued++] = h;
        back = pc_prev(h);
    }
}

/* The position of the rim at which the open half-edge h, whose head is on the rim, arrives. */
static pc_index arrival(const working *w, pc_index h) {
    pc_index leaving = w->adjacency->twin[h];
    while (!is_wall(w, leaving))
        leaving = pc_next(w->adjacency->twin[leaving]);
    return w->position[leaving];
}

/* From the vertex before h back to the rim; the walls are counted at its vertices only afterwards, because a
 * vertex with walls ends the way. */
static void mark_way(working *w, pc_index h) {
    for (;;) {
        pc_index tail = pc_tail(w->mesh, h);
        bool ends = w->degree[tail] > 0;
        set_wall(w, w->adjacency->edge[h]);
        if (ends) return;
        h = w->from[tail];
    }
}

/* Breadth first over the open edges of the cell from `starts` positions of the rim after `start` to any of
 * `goals` positions after `goal`, all modulo the rim; marks the way as wall. Returns the half-edge by which
 * the way arrives, PC_NONE where there is none. */
static pc_index cut_across(working *w, pc_index start, pc_index starts, pc_index goal, pc_index goals) {
    w->queued = 0, w->search++;
    for (pc_index i = 0; i < starts; i++)
        queue_sector(w, (start + i) % w->rim_count);
    for (pc_index next = 0; next < w->queued; next++) {
        pc_index h = w->queue[next], v = pc_head(w->mesh, h);
        if (w->degree[v]) {
            if ((arrival(w, h) + w->rim_count - goal) % w->rim_count >= goals) continue;
            mark_way(w, h);
            return h;
        }
        if (w->seen[v] == w->search) continue;
        w->seen[v] = w->search, w->from[v] = h;
        pc_index first = w->adjacency->twin[h];
        for (pc_index g = pc_turn_ccw(w->adjacency, first); g != first; g = pc_turn_ccw(w->adjacency, g))
            w->queue[w->queued++] = g;
    }
    return PC_NONE;
}

/* Room for the region's half-edges in rim and queue: both are shorter. */
static pc_status make_room(working *w) {
    pc_status status = PC_OK;
    pc_index room = 3 * w->region_count;
    if (room > w->rim_room) {
        PC_TRY(pc_resize(&w->rim, w->ctx, 2 * (size_t)room));
        PC_TRY(pc_resize(&w->queue, w->ctx, 2 * (size_t)room));
        w->rim_room = 2 * room;
    }
done:
    return status;
}

static void walk_rim(working *w, pc_index h) {
    pc_index first = h;
    w->rim_count = 0;
    do {
        w->position[h] = w->rim_count;
        w->rim[w->rim_count++] = h;
        h = pc_rim_next(w->adjacency, w->cells->wall, h);
    } while (h != first);
}

static pc_status split_region(working *w) {
    pc_status status = PC_OK;
    pc_index a, b, way;
    PC_TRY(make_room(w));
    walk_rim(w, w->selfish);
    if (!find_repeat(w, &a, &b)) return PC_OK;
    /* A way from a position in a+1 .. b to one in b+1 .. a+n parts the two sides of the wall; best from
     * middle to middle. */
    pc_index inner = b - a, outer = w->rim_count - inner;
    way = cut_across(w, a + 1 + inner / 4, inner - inner / 4 * 2, b + 1 + outer / 4, outer - outer / 4 * 2);
    if (way == PC_NONE) way = cut_across(w, a + 1, inner, b + 1, outer);
    if (way == PC_NONE) {
        w->stuck_count++;
        for (pc_index i = 0; i < w->region_count; i++)
            w->stuck[w->region[i]] = 1;
        return PC_OK;
    }
    w->stats->split_cells++;
    PC_TRY(look_again(w, way / 3));
    PC_TRY(look_again(w, w->adjacency->twin[way] / 3));
done:
    return status;
}

/* ---- the whole ---- */

static pc_status settle(working *w, pc_index seed) {
    pc_status status = PC_OK;
    PC_TRY(look_again(w, seed));
    while (w->todo_count) {
        pending next = w->todo[--w->todo_count];
        if (w->cells->cell[next.face] != next.cell) continue;
        gather_region(w, next.face);
        measure_region(w);
        if (w->euler != 1)
            PC_TRY(cut_region(w));
        else if (w->selfish != PC_NONE)
            PC_TRY(split_region(w)); /* each parts two sides of a wall, so that this ends */
    }
done:
    return status;
}

/* In order of the cells' first faces. */
static pc_status number_cells(pc_cells *cells, pc_context *ctx, pc_index face_count) {
    pc_index *number = NULL;
    pc_status status = pc_new(&number, ctx, cells->cell_count);
    if (status != PC_OK) return status;
    cells->cell_count = 0;
    for (pc_index f = 0; f < face_count; f++) {
        pc_index *given = &number[cells->cell[f]];
        if (*given == 0) *given = ++cells->cell_count;
        cells->cell[f] = *given - 1;
    }
    pc_free(ctx, number);
    return PC_OK;
}

static pc_status settle_all(working *w) {
    pc_status status = PC_OK;
    pc_cells *cells = w->cells;
    pc_free(w->ctx, cells->cell);
    cells->cell = NULL, cells->cell_count = 0;
    PC_TRY(pc_new(&cells->cell, w->ctx, w->mesh->face_count));
    memset(cells->cell, 0xff, sizeof(pc_index) * w->mesh->face_count);
    for (pc_index f = 0; f < w->mesh->face_count; f++) {
        if (f % 65536 == 0) PC_TRY(pc_check_interrupt(w->ctx));
        if (cells->cell[f] == PC_NONE) PC_TRY(settle(w, f));
    }
    PC_TRY(number_cells(cells, w->ctx, w->mesh->face_count));
done:
    return status;
}

/* Finer triangles where `stuck` (per face); walls are written back as drawn edges first. */
static pc_status refine_stuck(pc_cells *cells, const uint8_t *stuck, pc_context *ctx, pc_overlay *overlay,
                              pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    uint8_t *flag = NULL, *keep = NULL;
    pc_index faces = overlay->mesh.face_count;
    PC_TRY(pc_new(&flag, ctx, faces));
    PC_TRY(pc_new(&keep, ctx, 3 * (size_t)faces));
    for (pc_index h = 0; h < 3 * faces; h++) {
        bool wall = cells->wall[adjacency->edge[h]];
        pc_index twin = adjacency->twin[h];
        overlay->drawn[h] = wall;
        flag[h / 3] = stuck[h / 3];
        /* A wall that the cell meets from both sides gets a middle vertex, where a split may begin. */
        keep[h] = wall && (twin == PC_NONE || cells->cell[twin / 3] != cells->cell[h / 3]);
    }
    PC_TRY(pc_overlay_refine(overlay, ctx, adjacency, flag, keep));
    pc_adjacency_free(adjacency, ctx);
    PC_TRY(pc_adjacency_make(adjacency, ctx, &overlay->mesh));
    PC_TRY(make_walls(cells, ctx, overlay, adjacency));
done:
    pc_free(ctx, flag);
    pc_free(ctx, keep);
    return status;
}

pc_status pc_cells_make(pc_cells *cells, pc_cells_stats *stats, pc_context *ctx, pc_overlay *overlay,
                        pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    working w = {.ctx = ctx};
    *cells = (pc_cells){0};
    *stats = (pc_cells_stats){0};
    PC_TRY(make_walls(cells, ctx, overlay, adjacency));
    for (int refinements = 0;; refinements++) {
        PC_TRY(new_working(&w, ctx, cells, stats, &overlay->mesh, adjacency));
        if (refinements == 0) remove_dangling(&w);
        PC_TRY(settle_all(&w));
        if (w.stuck_count == 0) break;
        if (refinements == MOST_REFINEMENTS) {
            status = pc_fail(ctx, PC_E_BUG, "%u cells still meet themselves in triangles refined %d times",
                             w.stuck_count, MOST_REFINEMENTS);
            goto done;
        }
        PC_TRY(refine_stuck(cells, w.stuck, ctx, overlay, adjacency));
        free_working(&w);
        w = (working){.ctx = ctx};
    }
done:
    free_working(&w);
    if (status != PC_OK) pc_cells_free(cells, ctx);
    return status;
}

void pc_cells_free(pc_cells *cells, pc_context *ctx) {
    if (!cells) return;
    pc_free(ctx, cells->wall);
    pc_free(ctx, cells->cell);
    *cells = (pc_cells){0};
}
