#include "adjacency.h"
#include "halfsort.h"
#include "memory.h"

/* Edges are numbered in this many fixed blocks of half-edges. */
enum { BLOCKS = 256 };

/* Pairs the half-edges whose smaller end is v; returns the first of a run that does not pair, else PC_NONE.
 */
static pc_index pair_at(pc_index *twin, const pc_mesh *mesh, const pc_halfsort *sorted, pc_index v) {
    for (pc_index i = sorted->start[v], end = sorted->start[v + 1], next; i < end; i = next) {
        const pc_index *half = sorted->half + i;
        next = pc_run_end(sorted, mesh, i, end);
        if (next - i == 1) continue;
        if (next - i > 2 || pc_tail(mesh, half[0]) == pc_tail(mesh, half[1])) return i;
        twin[half[0]] = half[1];
        twin[half[1]] = half[0];
    }
    return PC_NONE;
}

static pc_status refuse_edge(pc_context *ctx, const pc_mesh *mesh, const pc_halfsort *sorted, pc_index i) {
    const pc_index *half = sorted->half + i;
    pc_index g = half[1];
    bool same = pc_tail(mesh, half[0]) == pc_tail(mesh, half[1]);
    if (!same) g = half[2];
    return pc_fail(ctx, PC_E_MESH, "edge %u-%u is not manifold: faces %u and %u run along it %s",
                   pc_tail(mesh, half[0]), pc_head(mesh, half[0]), half[0] / 3, g / 3,
                   same ? "in the same direction" : "with a third one");
}

static pc_status pair_twins(pc_adjacency *adjacency, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    pc_halfsort sorted = {0};
    pc_index worst = PC_NONE; /* the smallest place in sorted.half where pairing fails */
    PC_TRY(pc_halfsort_make(&sorted, ctx, mesh));
#pragma omp parallel for schedule(static) reduction(min : worst)
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_index bad = pair_at(adjacency->twin, mesh, &sorted, v);
        if (bad < worst) worst = bad;
    }
    if (worst != PC_NONE) status = refuse_edge(ctx, mesh, &sorted, worst);
done:
    pc_halfsort_free(&sorted, ctx);
    return status;
}

static pc_index block_begin(pc_index half_count, int block) {
    return (pc_index)((uint64_t)half_count * (uint64_t)block / BLOCKS);
}

/* Edges in order of their smaller half-edge: counted per block, then numbered from each block's first number
 * on. */
static pc_status number_edges(pc_adjacency *adjacency, pc_context *ctx, pc_index half_count) {
    pc_index first[BLOCKS + 1] = {0}, open[BLOCKS] = {0};
    const pc_index *twin = adjacency->twin;
#pragma omp parallel for schedule(static)
    for (int b = 0; b < BLOCKS; b++) {
        pc_index count = 0, boundary = 0;
        for (pc_index h = block_begin(half_count, b); h < block_begin(half_count, b + 1); h++)
            count += twin[h] > h, boundary += twin[h] == PC_NONE;
        first[b + 1] = count, open[b] = boundary;
    }
    for (int b = 0; b < BLOCKS; b++)
        first[b + 1] += first[b], adjacency->boundary_edge_count += open[b];
    adjacency->edge_count = first[BLOCKS];
    pc_status status = pc_new(&adjacency->edge_half, ctx, adjacency->edge_count);
    if (status != PC_OK) return status;
#pragma omp parallel for schedule(static)
    for (int b = 0; b < BLOCKS; b++) {
        pc_index e = first[b];
        for (pc_index h = block_begin(half_count, b); h < block_begin(half_count, b + 1); h++) {
            if (twin[h] < h) continue;
            adjacency->edge_half[e] = h;
            adjacency->edge[h] = e;
            if (twin[h] != PC_NONE) adjacency->edge[twin[h]] = e;
            e++;
        }
    }
    return PC_OK;
}

static void choose_vertex_halves(pc_adjacency *adjacency, const pc_mesh *mesh) {
    for (pc_index h = 3 * mesh->face_count; h-- > 0;) /* the smallest one stays */
        adjacency->vertex_half[pc_tail(mesh, h)] = h;
    if (!adjacency->boundary_edge_count) return;
    for (pc_index h = 0; h < 3 * mesh->face_count; h++)
        if (adjacency->twin[h] == PC_NONE) {
            adjacency->vertex_half[pc_tail(mesh, h)] = h;
            adjacency->vertex_boundary[pc_tail(mesh, h)] = 1;
        }
}

static pc_status refuse_vertex(pc_adjacency *adjacency, pc_context *ctx, const pc_mesh *mesh) {
    uint8_t *seen = NULL;
    pc_status status = pc_new(&seen, ctx, 3 * (size_t)mesh->face_count);
    if (status != PC_OK) return status;
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        for (pc_index h = adjacency->vertex_half[v]; h != PC_NONE && !seen[h]; h = pc_turn_ccw(adjacency, h))
            seen[h] = 1;
    pc_index h = 0;
    while (seen[h])
        h++;
    pc_free(ctx, seen);
    return pc_fail(ctx, PC_E_MESH, "vertex %u joins two fans of faces (face %u is in the second)",
                   pc_tail(mesh, h), h / 3);
}

/* Every corner must be met on the way round its vertex. */
static pc_status check_fans(pc_adjacency *adjacency, pc_context *ctx, const pc_mesh *mesh) {
    uint64_t met = 0;
#pragma omp parallel for schedule(static) reduction(+ : met)
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_index first = adjacency->vertex_half[v], h = first;
        while (h != PC_NONE) {
            met++;
            h = pc_turn_ccw(adjacency, h);
            if (h == first) break;
        }
    }
    return met == 3 * (uint64_t)mesh->face_count ? PC_OK : refuse_vertex(adjacency, ctx, mesh);
}

pc_status pc_adjacency_make(pc_adjacency *adjacency, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    pc_index half_count = 3 * mesh->face_count;
    *adjacency = (pc_adjacency){0};
    PC_TRY(pc_new(&adjacency->twin, ctx, half_count));
    PC_TRY(pc_new(&adjacency->edge, ctx, half_count));
    PC_TRY(pc_new(&adjacency->vertex_half, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&adjacency->vertex_boundary, ctx, mesh->vertex_count));
#pragma omp parallel for schedule(static)
    for (pc_index h = 0; h < half_count; h++)
        adjacency->twin[h] = PC_NONE;
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        adjacency->vertex_half[v] = PC_NONE;
    PC_TRY(pair_twins(adjacency, ctx, mesh));
    PC_TRY(number_edges(adjacency, ctx, half_count));
    choose_vertex_halves(adjacency, mesh);
    PC_TRY(check_fans(adjacency, ctx, mesh));
done:
    if (status != PC_OK) pc_adjacency_free(adjacency, ctx);
    return status;
}

void pc_adjacency_free(pc_adjacency *adjacency, pc_context *ctx) {
    if (!adjacency) return;
    pc_free(ctx, adjacency->twin);
    pc_free(ctx, adjacency->edge);
    pc_free(ctx, adjacency->edge_half);
    pc_free(ctx, adjacency->vertex_half);
    pc_free(ctx, adjacency->vertex_boundary);
    *adjacency = (pc_adjacency){0};
}
