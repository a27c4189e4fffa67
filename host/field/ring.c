#include "ring.h"
#include "memory.h"

static pc_index count_spokes(const pc_adjacency *a, pc_index v) {
    pc_index first = a->vertex_half[v], count = 0, h = first;
    if (first == PC_NONE) return 0;
    do {
        count++;
        h = pc_turn_ccw(a, h);
    } while (h != PC_NONE && h != first);
    return count + (h == PC_NONE ? 1 : 0);
}

/* Insertion sort: rows are short. */
static void insert_spoke(pc_index *vertex, pc_index *half, pc_index count, pc_index neighbour, pc_index h) {
    pc_index at = count;
    for (; at > 0 && vertex[at - 1] > neighbour; at--) {
        vertex[at] = vertex[at - 1];
        half[at] = half[at - 1];
    }
    vertex[at] = neighbour;
    half[at] = h;
}

static void fill_row(const pc_ring *ring, const pc_mesh *mesh, const pc_adjacency *a, pc_index v) {
    pc_index *vertex = ring->vertex + ring->start[v], *half = ring->half + ring->start[v];
    pc_index first = a->vertex_half[v], count = 0, h = first, last = PC_NONE;
    if (first == PC_NONE) return;
    do {
        insert_spoke(vertex, half, count++, pc_head(mesh, h), h);
        last = h;
        h = pc_turn_ccw(a, h);
    } while (h != PC_NONE && h != first);
    if (h == PC_NONE) insert_spoke(vertex, half, count, pc_tail(mesh, pc_prev(last)), pc_prev(last));
}

pc_status pc_ring_make(pc_ring *ring, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    *ring = (pc_ring){.vertex_count = mesh->vertex_count};
    PC_TRY(pc_new(&ring->start, ctx, (size_t)mesh->vertex_count + 1));
    PC_TRY(pc_new(&ring->vertex, ctx, 2 * (size_t)adjacency->edge_count));
    PC_TRY(pc_new(&ring->half, ctx, 2 * (size_t)adjacency->edge_count));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        ring->start[v + 1] = ring->start[v] + count_spokes(adjacency, v);
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        fill_row(ring, mesh, adjacency, v);
done:
    if (status != PC_OK) pc_ring_free(ring, ctx);
    return status;
}

void pc_ring_free(pc_ring *ring, pc_context *ctx) {
    if (!ring) return;
    pc_free(ctx, ring->start);
    pc_free(ctx, ring->vertex);
    pc_free(ctx, ring->half);
    *ring = (pc_ring){0};
}
