#include "layout.h"
#include "cells.h"
#include "geometry.h"
#include "memory.h"
#include "overlay.h"
#include "vec3.h"
#include <string.h>

/* What is known while the graph is read off the walls of a mesh. */
typedef struct reading {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    const pc_cells *cells;
    pc_layout *layout;
    pc_index *node; /* per vertex: its node, PC_NONE */
    pc_index *side; /* per half-edge that starts a side at a node: 2*arc+reversed, PC_NONE */
} reading;

static bool is_wall(const reading *r, pc_index h) {
    return r->cells->wall[r->adjacency->edge[h]];
}

/* The wall that goes on at the head of h, where just two meet; works along boundaries too. Returned as the
 * half-edge that leaves the head; PC_NONE where that one has no face, its edge is then in *edge. */
static pc_index next_along(const reading *r, pc_index edge, pc_index vertex, pc_index *next_edge) {
    const pc_adjacency *a = r->adjacency;
    pc_index first = a->vertex_half[vertex], h = first;
    while (h != PC_NONE) {
        if (is_wall(r, h) && a->edge[h] != edge) return *next_edge = a->edge[h];
        pc_index back = pc_prev(h);
        if (a->twin[back] == PC_NONE && a->edge[back] != edge) return *next_edge = a->edge[back];
        h = pc_turn_ccw(a, h);
        if (h == first) break;
    }
    return *next_edge = PC_NONE;
}

static pc_index other_end(const reading *r, pc_index edge, pc_index vertex) {
    pc_index h = r->adjacency->edge_half[edge];
    return pc_tail(r->mesh, h) == vertex ? pc_head(r->mesh, h) : pc_tail(r->mesh, h);
}

/* ---- nodes ---- */

static void add_node(reading *r, pc_index vertex) {
    r->node[vertex] = r->layout->node_count;
    r->layout->node_vertex[r->layout->node_count++] = vertex;
}

/* Walks from a node (or, on a loop without nodes, from `vertex` back to it) and returns the number of edges.
 */
static pc_index chain_length(const reading *r, pc_index vertex, pc_index edge, pc_index *end) {
    pc_index start = vertex, count = 0;
    do {
        vertex = other_end(r, edge, vertex);
        count++;
        if (r->node[vertex] != PC_NONE || vertex == start) break;
        next_along(r, edge, vertex, &edge);
    } while (edge != PC_NONE);
    *end = vertex;
    return count;
}

/* Puts a node after every `step` edges of a chain of `count` edges, the end left out. */
static void cut_chain(reading *r, pc_index vertex, pc_index edge, pc_index count, pc_index pieces,
                      uint8_t *seen) {
    for (pc_index i = 1, piece = 1; i <= count; i++) {
        seen[edge] = 1;
        vertex = other_end(r, edge, vertex);
        if (i == count) break;
        if (piece < pieces && i * pieces >= piece * count) add_node(r, vertex), piece++;
        next_along(r, edge, vertex, &edge);
    }
}

/* Every vertex where other than two walls meet; then loops get three nodes, arcs from a node to itself two
 * more. */
static pc_status find_nodes(reading *r, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index *degree = NULL;
    uint8_t *seen = NULL;
    const pc_adjacency *a = r->adjacency;
    PC_TRY(pc_new(&degree, ctx, r->mesh->vertex_count));
    PC_TRY(pc_new(&seen, ctx, a->edge_count));
    for (pc_index e = 0; e < a->edge_count; e++)
        if (r->cells->wall[e])
            degree[pc_tail(r->mesh, a->edge_half[e])]++, degree[pc_head(r->mesh, a->edge_half[e])]++;
    for (pc_index v = 0; v < r->mesh->vertex_count; v++)
        if (degree[v] > 2) add_node(r, v);
    for (pc_index pass = 0; pass < 2; pass++) /* first arcs that start at nodes, then loops without any */
        for (pc_index e = 0; e < a->edge_count; e++) {
            if (!r->cells->wall[e] || seen[e]) continue;
            pc_index v = pc_tail(r->mesh, a->edge_half[e]), w = pc_head(r->mesh, a->edge_half[e]), end;
            if (pass == 0 && r->node[v] == PC_NONE && r->node[w] == PC_NONE) continue;
            if (pass == 0 && r->node[v] == PC_NONE) v = w;
            pc_index count = chain_length(r, v, e, &end);
            bool loop = end == v;
            if (pass == 1) add_node(r, v);
            cut_chain(r, v, e, count, loop ? 3 : 1, seen);
        }
done:
    pc_free(ctx, degree);
    pc_free(ctx, seen);
    return status;
}

/* ---- arcs ---- */

static void note_side(reading *r, pc_index edge, pc_index tail, pc_index side) {
    pc_index h = r->adjacency->edge_half[edge];
    if (pc_tail(r->mesh, h) != tail) h = r->adjacency->twin[h];
    if (h != PC_NONE) r->side[h] = side;
}

static pc_index cell_left_of(const reading *r, pc_index edge, pc_index tail) {
    pc_index h = r->adjacency->edge_half[edge];
    if (pc_tail(r->mesh, h) != tail) h = r->adjacency->twin[h];
    return h == PC_NONE ? PC_NONE : r->cells->cell[h / 3];
}

static void trace_arc(reading *r, pc_index edge, pc_index vertex, uint8_t *seen) {
    pc_layout *l = r->layout;
    pc_index arc = l->arc_count++, at = l->arc_start[arc];
    l->arc_vertex[at++] = vertex;
    l->arc_node[2 * arc] = r->node[vertex];
    l->arc_cell[2 * arc] = cell_left_of(r, edge, vertex);
    l->arc_cell[2 * arc + 1] = cell_left_of(r, edge, other_end(r, edge, vertex));
    note_side(r, edge, vertex, 2 * arc);
    for (;;) {
        seen[edge] = 1;
        vertex = other_end(r, edge, vertex);
        l->arc_vertex[at++] = vertex;
        if (r->node[vertex] != PC_NONE) {
            note_side(r, edge, vertex, 2 * arc + 1);
            break;
        }
        next_along(r, edge, vertex, &edge);
    }
    l->arc_node[2 * arc + 1] = r->node[vertex];
    l->arc_start[arc + 1] = at;
}

static pc_status trace_arcs(reading *r, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_layout *l = r->layout;
    uint8_t *seen = NULL;
    size_t walls = 0, ends = 0;
    const pc_adjacency *a = r->adjacency;
    for (pc_index e = 0; e < a->edge_count; e++) {
        if (!r->cells->wall[e]) continue;
        walls++;
        ends += r->node[pc_tail(r->mesh, a->edge_half[e])] != PC_NONE;
        ends += r->node[pc_head(r->mesh, a->edge_half[e])] != PC_NONE;
    }
    PC_TRY(pc_new(&seen, ctx, a->edge_count));
    PC_TRY(pc_new(&l->arc_start, ctx, ends / 2 + 1));
    PC_TRY(pc_new(&l->arc_vertex, ctx, walls + ends / 2));
    PC_TRY(pc_new(&l->arc_node, ctx, ends));
    PC_TRY(pc_new(&l->arc_cell, ctx, ends));
    for (pc_index e = 0; e < a->edge_count; e++) {
        if (!r->cells->wall[e] || seen[e]) continue;
        pc_index v = pc_tail(r->mesh, a->edge_half[e]), w = pc_head(r->mesh, a->edge_half[e]);
        if (r->node[v] != PC_NONE)
            trace_arc(r, e, v, seen);
        else if (r->node[w] != PC_NONE)
            trace_arc(r, e, w, seen);
    }
done:
    pc_free(ctx, seen);
    return status;
}

/* ---- cells ---- */

/* The angle inside the cell at the tail of the rim half-edge h. */
static double rim_angle(const reading *r, pc_index h) {
    double angle = pc_corner_angle(r->mesh, h);
    for (pc_index g = pc_prev(h); !is_wall(r, g);) {
        g = r->adjacency->twin[g];
        angle += pc_corner_angle(r->mesh, g);
        g = pc_prev(g);
    }
    return angle;
}

static bool is_flat(const reading *r, pc_index h, const uint8_t *valence) {
    return valence[r->node[pc_tail(r->mesh, h)]] == 3 && rim_angle(r, h) > 0.75 * PC_PI;
}

static pc_status list_sides(reading *r, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_layout *l = r->layout;
    uint8_t *valence = NULL, *done_cell = NULL;
    l->cell_count = r->cells->cell_count;
    PC_TRY(pc_new(&valence, ctx, l->node_count));
    PC_TRY(pc_new(&done_cell, ctx, l->cell_count));
    PC_TRY(pc_new(&l->cell_start, ctx, (size_t)l->cell_count + 1));
    for (pc_index i = 0; i < 2 * l->arc_count; i++) {
        if (valence[l->arc_node[i]] < 255) valence[l->arc_node[i]]++;
        if (l->arc_cell[i] != PC_NONE) l->cell_start[l->arc_cell[i] + 1]++;
    }
    for (pc_index c = 0; c < l->cell_count; c++)
        l->cell_start[c + 1] += l->cell_start[c];
    PC_TRY(pc_new(&l->cell_side, ctx, l->cell_start[l->cell_count]));
    PC_TRY(pc_new(&l->cell_side_flat, ctx, l->cell_start[l->cell_count]));
    for (pc_index h = 0; h < 3 * r->mesh->face_count; h++) {
        if (r->side[h] == PC_NONE || done_cell[r->cells->cell[h / 3]]) continue;
        pc_index cell = r->cells->cell[h / 3], at = l->cell_start[cell], g = h;
        done_cell[cell] = 1;
        do {
            if (r->side[g] != PC_NONE && at < l->cell_start[cell + 1]) {
                l->cell_side[at] = r->side[g];
                l->cell_side_flat[at++] = is_flat(r, g, valence);
            }
            g = pc_rim_next(r->adjacency, r->cells->wall, g);
        } while (g != h);
        if (at != l->cell_start[cell + 1]) {
            status = pc_fail(ctx, PC_E_BUG, "cell %u has %u sides but its rim meets %u", cell,
                             l->cell_start[cell + 1] - l->cell_start[cell], at - l->cell_start[cell]);
            goto done;
        }
    }
done:
    pc_free(ctx, valence);
    pc_free(ctx, done_cell);
    return status;
}

/* ---- the whole ---- */

static pc_status read_graph(pc_layout *layout, pc_context *ctx, const pc_mesh *mesh,
                            const pc_adjacency *adjacency, const pc_cells *cells) {
    pc_status status = PC_OK;
    reading r = {.mesh = mesh, .adjacency = adjacency, .cells = cells, .layout = layout};
    PC_TRY(pc_new(&r.node, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&r.side, ctx, 3 * (size_t)mesh->face_count));
    PC_TRY(pc_new(&layout->node_vertex, ctx, mesh->vertex_count));
    memset(r.node, 0xff, sizeof(pc_index) * mesh->vertex_count);
    memset(r.side, 0xff, sizeof(pc_index) * 3 * (size_t)mesh->face_count);
    PC_TRY(find_nodes(&r, ctx));
    PC_TRY(pc_resize(&layout->node_vertex, ctx, layout->node_count));
    PC_TRY(trace_arcs(&r, ctx));
    PC_TRY(list_sides(&r, ctx));
done:
    pc_free(ctx, r.node);
    pc_free(ctx, r.side);
    return status;
}

pc_status pc_layout_make(pc_layout *layout, pc_layout_stats *stats, pc_context *ctx, const pc_mesh *mesh,
                         const pc_param *param) {
    pc_status status = PC_OK;
    pc_coned coned = {0};
    pc_overlay overlay = {0};
    pc_adjacency fine = {0};
    pc_cells cells = {0};
    pc_cells_stats counted;
    *layout = (pc_layout){0};
    *stats = (pc_layout_stats){0};
    PC_TRY(pc_coned_make(&coned, ctx, mesh, param));
    PC_TRY(pc_adjacency_make(&fine, ctx, &coned.mesh));
    PC_TRY(pc_overlay_make(&overlay, ctx, &coned, &fine));
    for (pc_index f = 0; f < overlay.mesh.face_count; f++)
        overlay.source_face[f] = coned.source_face[overlay.source_face[f]];
    pc_coned_free(&coned, ctx);
    pc_adjacency_free(&fine, ctx);
    PC_TRY(pc_adjacency_make(&fine, ctx, &overlay.mesh));
    PC_TRY(pc_cells_make(&cells, &counted, ctx, &overlay, &fine));
    stats->dangling_edges = counted.dangling_edges;
    stats->cut_cells = counted.cut_cells;
    stats->split_cells = counted.split_cells;
    PC_TRY(read_graph(layout, ctx, &overlay.mesh, &fine, &cells));
    layout->mesh = overlay.mesh;
    layout->source_face = overlay.source_face;
    layout->cell = cells.cell;
    overlay.mesh = (pc_mesh){0};
    overlay.source_face = NULL;
    cells.cell = NULL;
done:
    pc_coned_free(&coned, ctx);
    pc_cells_free(&cells, ctx);
    pc_adjacency_free(&fine, ctx);
    pc_overlay_free(&overlay, ctx);
    if (status != PC_OK) pc_layout_free(layout, ctx);
    return status;
}

void pc_layout_free(pc_layout *layout, pc_context *ctx) {
    if (!layout) return;
    pc_mesh_free(&layout->mesh, ctx);
    pc_free(ctx, layout->source_face);
    pc_free(ctx, layout->cell);
    pc_free(ctx, layout->node_vertex);
    pc_free(ctx, layout->arc_start);
    pc_free(ctx, layout->arc_vertex);
    pc_free(ctx, layout->arc_node);
    pc_free(ctx, layout->arc_cell);
    pc_free(ctx, layout->cell_start);
    pc_free(ctx, layout->cell_side);
    pc_free(ctx, layout->cell_side_flat);
    *layout = (pc_layout){0};
}

static pc_status check_cell(const pc_layout *l, pc_context *ctx, pc_index cell) {
    pc_index from = l->cell_start[cell], to = l->cell_start[cell + 1];
    if (from == to) return pc_fail(ctx, PC_E_BUG, "cell %u has no sides", cell);
    for (pc_index i = from; i < to; i++) {
        pc_index side = l->cell_side[i], next = l->cell_side[i + 1 < to ? i + 1 : from];
        if (l->arc_cell[side] != cell)
            return pc_fail(ctx, PC_E_BUG, "arc %u does not know cell %u", side / 2, cell);
        if (l->arc_node[side ^ 1] != l->arc_node[next])
            return pc_fail(ctx, PC_E_BUG, "the sides of cell %u do not meet after side %u", cell, i - from);
    }
    return PC_OK;
}

pc_status pc_layout_check(const pc_layout *layout, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_adjacency adjacency = {0};
    PC_TRY(pc_adjacency_make(&adjacency, ctx, &layout->mesh));
    int64_t chi = (int64_t)layout->mesh.vertex_count - adjacency.edge_count + layout->mesh.face_count;
    int64_t given = (int64_t)layout->node_count - layout->arc_count + layout->cell_count;
    if (given != chi) {
        status = pc_fail(ctx, PC_E_BUG, "the layout's Euler number is %lld, the scan's %lld",
                         (long long)given, (long long)chi);
        goto done;
    }
    for (pc_index a = 0; a < layout->arc_count; a++)
        if (layout->arc_cell[2 * a] == layout->arc_cell[2 * a + 1] ||
            layout->arc_node[2 * a] == layout->arc_node[2 * a + 1]) {
            status = pc_fail(ctx, PC_E_BUG, "arc %u meets itself", a);
            goto done;
        }
    for (pc_index c = 0; c < layout->cell_count; c++)
        PC_TRY(check_cell(layout, ctx, c));
done:
    pc_adjacency_free(&adjacency, ctx);
    return status;
}
