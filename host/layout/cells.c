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

static pc_status count_walls(pc_index **degree, pc_context *ctx, const pc_cells *cells, const pc_mesh *mesh,
                             const pc_adjacency *adjacency) {
    pc_status status = pc_new(degree, ctx, mesh->vertex_count);
    if (status != PC_OK) return status;
    for (pc_index e = 0; e < adjacency->edge_count; e++)
        if (cells->wall[e]) {
            (*degree)[pc_tail(mesh, adjacency->edge_half[e])]++;
            (*degree)[pc_head(mesh, adjacency->edge_half[e])]++;
        }
    return PC_OK;
}

/* A half-edge at v, out of it or on its border into it, on an edge e with wall[e] == is_wall and not skip[e]
 * (NULL: none); PC_NONE where there is none. */
static pc_index edge_at(const pc_adjacency *a, pc_index v, const uint8_t *wall, uint8_t is_wall,
                        const uint8_t *skip) {
    pc_index first = a->vertex_half[v], h = first;
    while (h != PC_NONE) {
        pc_index back = pc_prev(h), out = a->edge[h], in = a->edge[back];
        if (wall[out] == is_wall && !(skip && skip[out])) return h;
        if (a->twin[back] == PC_NONE && wall[in] == is_wall && !(skip && skip[in])) return back;
        h = pc_turn_ccw(a, h);
        if (h == first) break;
    }
    return PC_NONE;
}

static pc_status remove_dangling(pc_cells *cells, pc_index *removed, pc_context *ctx, const pc_mesh *mesh,
                                 const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    pc_index *degree = NULL;
    PC_TRY(count_walls(&degree, ctx, cells, mesh, adjacency));
    for (pc_index start = 0; start < mesh->vertex_count; start++)
        for (pc_index v = start; degree[v] == 1;) {
            pc_index h = edge_at(adjacency, v, cells->wall, 1, NULL);
            pc_index other = pc_tail(mesh, h) == v ? pc_head(mesh, h) : pc_tail(mesh, h);
            cells->wall[adjacency->edge[h]] = 0;
            degree[v]--, degree[other]--, ++*removed;
            v = other;
        }
done:
    pc_free(ctx, degree);
    return status;
}

/* Numbers the regions in order of their first face and computes each one's Euler characteristic: faces minus
 * open edges plus open vertices. */
static pc_status flood(pc_cells *cells, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    pc_index *stack = NULL, *degree = NULL;
    pc_free(ctx, cells->cell);
    pc_free(ctx, cells->euler);
    cells->cell = NULL, cells->euler = NULL, cells->cell_count = 0;
    PC_TRY(pc_new(&cells->cell, ctx, mesh->face_count));
    PC_TRY(pc_new(&stack, ctx, mesh->face_count));
    memset(cells->cell, 0xff, sizeof(pc_index) * mesh->face_count);
    for (pc_index start = 0; start < mesh->face_count; start++) {
        if (cells->cell[start] != PC_NONE) continue;
        pc_index height = 0;
        cells->cell[start] = cells->cell_count;
        stack[height++] = start;
        while (height) {
            pc_index f = stack[--height];
            for (pc_index h = 3 * f; h < 3 * f + 3; h++) {
                pc_index twin = adjacency->twin[h];
                if (cells->wall[adjacency->edge[h]] || cells->cell[twin / 3] != PC_NONE) continue;
                cells->cell[twin / 3] = cells->cell_count;
                stack[height++] = twin / 3;
            }
        }
        cells->cell_count++;
    }
    PC_TRY(pc_new(&cells->euler, ctx, cells->cell_count));
    PC_TRY(count_walls(&degree, ctx, cells, mesh, adjacency));
    for (pc_index f = 0; f < mesh->face_count; f++)
        cells->euler[cells->cell[f]]++;
    for (pc_index e = 0; e < adjacency->edge_count; e++)
        if (!cells->wall[e]) cells->euler[cells->cell[adjacency->edge_half[e] / 3]]--;
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        if (degree[v] == 0 && adjacency->vertex_half[v] != PC_NONE)
            cells->euler[cells->cell[adjacency->vertex_half[v] / 3]]++;
done:
    pc_free(ctx, stack);
    pc_free(ctx, degree);
    return status;
}

/* ---- regions that are no disks ---- */

typedef struct cutting {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    pc_cells *cells;
    pc_index *queue;  /* faces */
    uint8_t *reached; /* per face */
    uint8_t *crossed; /* per edge: by the tree of faces, or pruned */
    pc_index *degree; /* per vertex: open edges not crossed; PC_NONE marks a vertex on a wall, which is never
                         pruned */
} cutting;

/* A breadth-first tree over the faces of one cell; what remains of the open edges, dangling ends pruned, cuts
 * the cell into one disk (tree and cotree, Eppstein 2003). */
static pc_index grow_tree(cutting *c, pc_index seed) {
    pc_index head = 0, tail = 0;
    c->queue[tail++] = seed;
    c->reached[seed] = 1;
    while (head < tail) {
        pc_index f = c->queue[head++];
        for (pc_index h = 3 * f; h < 3 * f + 3; h++) {
            pc_index twin = c->adjacency->twin[h];
            if (c->cells->wall[c->adjacency->edge[h]] || c->reached[twin / 3]) continue;
            c->reached[twin / 3] = 1;
            c->crossed[c->adjacency->edge[h]] = 1;
            c->queue[tail++] = twin / 3;
        }
    }
    return tail;
}

static bool is_open(const cutting *c, pc_index e) {
    return !c->cells->wall[e] && !c->crossed[e];
}

static void prune(cutting *c, pc_index v) {
    while (c->degree[v] == 1) {
        pc_index h = edge_at(c->adjacency, v, c->cells->wall, 0, c->crossed);
        if (h == PC_NONE) return;
        pc_index e = c->adjacency->edge[h];
        pc_index other = pc_tail(c->mesh, h) == v ? pc_head(c->mesh, h) : pc_tail(c->mesh, h);
        c->crossed[e] = 1;
        c->degree[v] = 0;
        if (c->degree[other] == PC_NONE) return;
        c->degree[other]--;
        v = other;
    }
}

static void cut_cell(cutting *c, pc_index seed) {
    pc_index count = grow_tree(c, seed);
    bool walled = false;
    for (pc_index i = 0; i < 3 * count; i++) {
        pc_index h = 3 * c->queue[i / 3] + i % 3, e = c->adjacency->edge[h], v = pc_tail(c->mesh, h);
        walled = walled || c->cells->wall[e];
        if (is_open(c, e) && c->degree[v] != PC_NONE) c->degree[v]++;
    }
    for (pc_index i = 0; i < 3 * count; i++)
        prune(c, pc_tail(c->mesh, 3 * c->queue[i / 3] + i % 3));
    bool cut = false;
    for (pc_index i = 0; i < 3 * count; i++) {
        pc_index e = c->adjacency->edge[3 * c->queue[i / 3] + i % 3];
        if (!is_open(c, e)) continue;
        c->cells->wall[e] = 1;
        cut = true;
    }
    /* A sphere without any line: the rim of its first half, in order of distance, parts it in two. */
    if (!cut && !walled)
        for (pc_index i = 0; i < count; i++)
            c->reached[c->queue[i]] = i < (count + 1) / 2 ? 2 : 3;
    for (pc_index i = 0; !cut && !walled && i < 3 * count; i++) {
        pc_index h = 3 * c->queue[i / 3] + i % 3;
        if (c->reached[h / 3] == 2 && c->reached[c->adjacency->twin[h] / 3] == 3)
            c->cells->wall[c->adjacency->edge[h]] = 1;
    }
}

static pc_status cut_to_disks(pc_cells *cells, pc_index *cut_count, pc_context *ctx, const pc_mesh *mesh,
                              const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    cutting c = {.mesh = mesh, .adjacency = adjacency, .cells = cells};
    pc_index *seed = NULL, todo = 0;
    for (pc_index i = 0; i < cells->cell_count; i++)
        todo += cells->euler[i] != 1;
    if (todo == 0) return PC_OK;
    PC_TRY(pc_new(&c.queue, ctx, mesh->face_count));
    PC_TRY(pc_new(&c.reached, ctx, mesh->face_count));
    PC_TRY(pc_new(&c.crossed, ctx, adjacency->edge_count));
    PC_TRY(count_walls(&c.degree, ctx, cells, mesh, adjacency));
    PC_TRY(pc_new(&seed, ctx, cells->cell_count));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        c.degree[v] = c.degree[v] ? PC_NONE : 0;
    for (pc_index f = mesh->face_count; f-- > 0;)
        seed[cells->cell[f]] = f;
    for (pc_index i = 0; i < cells->cell_count; i++)
        if (cells->euler[i] != 1) cut_cell(&c, seed[i]);
    *cut_count += todo;
done:
    pc_free(ctx, c.queue);
    pc_free(ctx, c.reached);
    pc_free(ctx, c.crossed);
    pc_free(ctx, c.degree);
    pc_free(ctx, seed);
    return status;
}

/* ---- cells that meet themselves ---- */

/* A rim may come by a vertex several times, even all of its vertices. Ways across a cell therefore begin and
 * end at positions of the rim, each with the faces of the cell between the wall that arrives there and the
 * one that leaves. */
typedef struct splitting {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    pc_cells *cells;
    const pc_index *degree; /* walls per vertex */
    pc_index *rim;          /* half-edges of the rim of the cell at hand */
    pc_index rim_count;
    pc_index *position; /* per half-edge of the rim */
    pc_index *from;     /* per vertex inside: half-edge by which the search came */
    pc_index *stamp;    /* per vertex inside: the search that reached it last */
    pc_index *queue;    /* half-edges to follow */
    pc_index queued, search;
} splitting;

/* The positions of the rim where it runs along the same wall; false where there are none. */
static bool find_repeat(const splitting *s, pc_index *first, pc_index *second) {
    for (pc_index i = 0; i < s->rim_count; i++) {
        pc_index twin = s->adjacency->twin[s->rim[i]];
        if (twin == PC_NONE || s->cells->cell[twin / 3] != s->cells->cell[s->rim[i] / 3]) continue;
        *first = i, *second = s->position[twin];
        if (*first > *second) *first = s->position[twin], *second = i;
        return true;
    }
    return false;
}

static void queue_sector(splitting *s, pc_index at) {
    for (pc_index back = pc_prev(s->rim[at]); !s->cells->wall[s->adjacency->edge[back]];) {
        pc_index h = s->adjacency->twin[back];
        s->queue[s->queued++] = h;
        back = pc_prev(h);
    }
}

/* The position of the rim at which the open half-edge h, whose head is on the rim, arrives. */
static pc_index arrival(const splitting *s, pc_index h) {
    pc_index leaving = s->adjacency->twin[h];
    while (!s->cells->wall[s->adjacency->edge[leaving]])
        leaving = pc_next(s->adjacency->twin[leaving]);
    return s->position[leaving];
}

static void mark_way(splitting *s, pc_index h) {
    for (;;) {
        s->cells->wall[s->adjacency->edge[h]] = 1;
        if (s->degree[pc_tail(s->mesh, h)]) return;
        h = s->from[pc_tail(s->mesh, h)];
    }
}

/* Breadth first over the open edges of the cell from `starts` positions of the rim after `start` to any of
 * `goals` positions after `goal`, all modulo the rim; marks the way as wall. */
static bool cut_across(splitting *s, pc_index start, pc_index starts, pc_index goal, pc_index goals) {
    s->queued = 0, s->search++;
    for (pc_index i = 0; i < starts; i++)
        queue_sector(s, (start + i) % s->rim_count);
    for (pc_index next = 0; next < s->queued; next++) {
        pc_index h = s->queue[next], w = pc_head(s->mesh, h);
        if (s->degree[w]) {
            if ((arrival(s, h) + s->rim_count - goal) % s->rim_count >= goals) continue;
            mark_way(s, h);
            return true;
        }
        if (s->stamp[w] == s->search) continue;
        s->stamp[w] = s->search, s->from[w] = h;
        pc_index first = s->adjacency->twin[h];
        for (pc_index g = pc_turn_ccw(s->adjacency, first); g != first; g = pc_turn_ccw(s->adjacency, g))
            s->queue[s->queued++] = g;
    }
    return false;
}

static void walk_rim(splitting *s, pc_index h) {
    pc_index first = h;
    s->rim_count = 0;
    do {
        s->position[h] = s->rim_count;
        s->rim[s->rim_count++] = h;
        h = pc_rim_next(s->adjacency, s->cells->wall, h);
    } while (h != first);
}

/* Tries to split the cell with rim half-edge h. Returns 0: not needed, 1: split, 2: no way through. */
static int split_cell(splitting *s, pc_index h) {
    pc_index a, b;
    walk_rim(s, h);
    if (!find_repeat(s, &a, &b)) return 0;
    /* A way from a position in a+1 .. b to one in b+1 .. a+n parts the two sides of the wall; best from
     * middle to middle. */
    pc_index inner = b - a, outer = s->rim_count - inner;
    if (cut_across(s, a + 1 + inner / 4, inner - inner / 4 * 2, b + 1 + outer / 4, outer - outer / 4 * 2))
        return 1;
    return cut_across(s, a + 1, inner, b + 1, outer) ? 1 : 2;
}

static pc_status split_selfish(pc_cells *cells, pc_index *split_count, uint8_t *stuck, pc_index *stuck_count,
                               pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    splitting s = {.mesh = mesh, .adjacency = adjacency, .cells = cells};
    pc_index *degree = NULL;
    uint8_t *done_cell = NULL;
    pc_index halves = 3 * mesh->face_count;
    PC_TRY(pc_new(&s.rim, ctx, halves));
    PC_TRY(pc_new(&s.position, ctx, halves));
    PC_TRY(pc_new(&s.from, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&s.stamp, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&s.queue, ctx, halves));
    PC_TRY(pc_new(&done_cell, ctx, cells->cell_count));
    PC_TRY(count_walls(&degree, ctx, cells, mesh, adjacency));
    s.degree = degree;
    for (pc_index h = 0; h < halves; h++) {
        pc_index cell = cells->cell[h / 3], twin = adjacency->twin[h];
        if (done_cell[cell] || twin == PC_NONE || !cells->wall[adjacency->edge[h]]) continue;
        if (cells->cell[twin / 3] != cell) continue;
        done_cell[cell] = 1;
        int result = split_cell(&s, h);
        *split_count += result == 1;
        *stuck_count += result == 2;
        stuck[cell] = result == 2;
    }
done:
    pc_free(ctx, s.rim);
    pc_free(ctx, s.position);
    pc_free(ctx, s.from);
    pc_free(ctx, s.stamp);
    pc_free(ctx, s.queue);
    pc_free(ctx, done_cell);
    pc_free(ctx, degree);
    return status;
}

/* Finer triangles in the cells that found no way through; walls are written back as drawn edges first. */
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
        flag[h / 3] = stuck[cells->cell[h / 3]];
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
    uint8_t *stuck = NULL;
    *cells = (pc_cells){0};
    *stats = (pc_cells_stats){0};
    PC_TRY(make_walls(cells, ctx, overlay, adjacency));
    PC_TRY(remove_dangling(cells, &stats->dangling_edges, ctx, &overlay->mesh, adjacency));
    for (int refinements = 0;;) {
        pc_index cut = 0, split = 0, stuck_count = 0;
        PC_TRY(flood(cells, ctx, &overlay->mesh, adjacency));
        PC_TRY(cut_to_disks(cells, &cut, ctx, &overlay->mesh, adjacency));
        if (cut) PC_TRY(flood(cells, ctx, &overlay->mesh, adjacency));
        pc_free(ctx, stuck);
        stuck = NULL;
        PC_TRY(pc_new(&stuck, ctx, cells->cell_count));
        PC_TRY(split_selfish(cells, &split, stuck, &stuck_count, ctx, &overlay->mesh, adjacency));
        stats->cut_cells += cut, stats->split_cells += split;
        if (!cut && !split && !stuck_count) break;
        if (!stuck_count) continue; /* each split parts two sides of a wall, so that this ends */
        if (refinements++ == MOST_REFINEMENTS) {
            status = pc_fail(ctx, PC_E_BUG, "%u cells still meet themselves in triangles refined %d times",
                             stuck_count, MOST_REFINEMENTS);
            goto done;
        }
        PC_TRY(refine_stuck(cells, stuck, ctx, overlay, adjacency));
    }
done:
    pc_free(ctx, stuck);
    if (status != PC_OK) pc_cells_free(cells, ctx);
    return status;
}

void pc_cells_free(pc_cells *cells, pc_context *ctx) {
    if (!cells) return;
    pc_free(ctx, cells->wall);
    pc_free(ctx, cells->cell);
    pc_free(ctx, cells->euler);
    *cells = (pc_cells){0};
}
