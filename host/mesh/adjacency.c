#include "adjacency.h"
#include "memory.h"

/* Half-edges sorted by their smaller end vertex: a bucket per vertex, filled in index order. */
static pc_status bucket_halves(pc_index **start, pc_index **bucket, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    pc_index half_count = 3 * mesh->face_count;
    PC_TRY(pc_new(start, ctx, (size_t)mesh->vertex_count + 2));
    PC_TRY(pc_new(bucket, ctx, half_count));
    for (pc_index h = 0; h < half_count; h++) {
        pc_index a = pc_tail(mesh, h), b = pc_head(mesh, h);
        (*start)[(a < b ? a : b) + 2]++;
    }
    for (size_t v = 2; v < (size_t)mesh->vertex_count + 2; v++)
        (*start)[v] += (*start)[v - 1];
    for (pc_index h = 0; h < half_count; h++) {
        pc_index a = pc_tail(mesh, h), b = pc_head(mesh, h);
        (*bucket)[(*start)[(a < b ? a : b) + 1]++] = h;
    }
done:
    return status;
}

static pc_status pair_twins(pc_adjacency *adjacency, pc_context *ctx, const pc_mesh *mesh,
                            const pc_index *start, const pc_index *bucket) {
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        for (pc_index i = start[v]; i < start[v + 1]; i++) {
            pc_index h = bucket[i];
            if (adjacency->twin[h] != PC_NONE) continue;
            for (pc_index j = i + 1; j < start[v + 1]; j++) {
                pc_index g = bucket[j];
                bool same = pc_tail(mesh, g) == pc_tail(mesh, h) && pc_head(mesh, g) == pc_head(mesh, h);
                bool opposite = pc_tail(mesh, g) == pc_head(mesh, h) && pc_head(mesh, g) == pc_tail(mesh, h);
                if (same || (opposite && (adjacency->twin[h] != PC_NONE || adjacency->twin[g] != PC_NONE)))
                    return pc_fail(ctx, PC_E_MESH,
                                   "edge %u-%u is not manifold: faces %u and %u run along it %s",
                                   pc_tail(mesh, h), pc_head(mesh, h), h / 3, g / 3,
                                   same ? "in the same direction" : "with a third one");
                if (opposite) adjacency->twin[h] = g, adjacency->twin[g] = h;
            }
        }
    return PC_OK;
}

static void number_edges(pc_adjacency *adjacency, pc_index half_count) {
    pc_index count = 0;
    for (pc_index h = 0; h < half_count; h++) {
        pc_index twin = adjacency->twin[h];
        if (twin == PC_NONE) adjacency->boundary_edge_count++;
        if (twin < h) {
            adjacency->edge[h] = adjacency->edge[twin];
            continue;
        }
        adjacency->edge[h] = count;
        adjacency->edge_half[count++] = h;
    }
    adjacency->edge_count = count;
}

static pc_status check_fans(pc_adjacency *adjacency, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    pc_index half_count = 3 * mesh->face_count;
    uint8_t *seen = NULL;
    PC_TRY(pc_new(&seen, ctx, half_count));
    for (pc_index h = 0; h < half_count; h++) {
        pc_index v = pc_tail(mesh, h);
        if (adjacency->vertex_half[v] == PC_NONE) adjacency->vertex_half[v] = h;
        if (adjacency->twin[h] == PC_NONE) {
            adjacency->vertex_half[v] = h;
            adjacency->vertex_boundary[v] = 1;
        }
    }
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_index first = adjacency->vertex_half[v], h = first;
        while (h != PC_NONE && !seen[h]) {
            seen[h] = 1;
            h = pc_turn_ccw(adjacency, h);
        }
    }
    for (pc_index h = 0; h < half_count; h++)
        if (!seen[h]) {
            status = pc_fail(ctx, PC_E_MESH, "vertex %u joins two fans of faces (face %u is in the second)",
                             pc_tail(mesh, h), h / 3);
            break;
        }
done:
    pc_free(ctx, seen);
    return status;
}

pc_status pc_adjacency_make(pc_adjacency *adjacency, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    pc_index half_count = 3 * mesh->face_count;
    pc_index *start = NULL, *bucket = NULL;
    *adjacency = (pc_adjacency){0};
    PC_TRY(pc_new(&adjacency->twin, ctx, half_count));
    PC_TRY(pc_new(&adjacency->edge, ctx, half_count));
    PC_TRY(pc_new(&adjacency->vertex_half, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&adjacency->vertex_boundary, ctx, mesh->vertex_count));
    for (pc_index h = 0; h < half_count; h++)
        adjacency->twin[h] = PC_NONE;
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        adjacency->vertex_half[v] = PC_NONE;
    PC_TRY(bucket_halves(&start, &bucket, ctx, mesh));
    PC_TRY(pair_twins(adjacency, ctx, mesh, start, bucket));
    PC_TRY(pc_new(&adjacency->edge_half, ctx, half_count));
    number_edges(adjacency, half_count);
    PC_TRY(check_fans(adjacency, ctx, mesh));
done:
    pc_free(ctx, start);
    pc_free(ctx, bucket);
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
