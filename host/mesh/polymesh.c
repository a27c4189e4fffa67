#include "polymesh.h"
#include "memory.h"
#include <string.h>

pc_status pc_polymesh_make(pc_polymesh *mesh, pc_context *ctx, size_t vertex_count, size_t face_count,
                           size_t corner_count) {
    pc_status status = PC_OK;
    *mesh = (pc_polymesh){.vertex_count = (pc_index)vertex_count, .face_count = (pc_index)face_count};
    PC_TRY(pc_new(&mesh->position, ctx, 3 * vertex_count));
    PC_TRY(pc_new(&mesh->start, ctx, face_count + 1));
    PC_TRY(pc_new(&mesh->corner, ctx, corner_count));
    PC_TRY(pc_new(&mesh->corner_flat, ctx, corner_count));
done:
    if (status != PC_OK) pc_polymesh_free(mesh, ctx);
    return status;
}

pc_status pc_polymesh_copy(pc_polymesh *copy, pc_context *ctx, const pc_polymesh *mesh) {
    const size_t corners = mesh->start[mesh->face_count];
    pc_status status = pc_polymesh_make(copy, ctx, mesh->vertex_count, mesh->face_count, corners);
    if (status != PC_OK) return status;
    memcpy(copy->position, mesh->position, 3 * sizeof(double) * mesh->vertex_count);
    memcpy(copy->start, mesh->start, sizeof *mesh->start * ((size_t)mesh->face_count + 1));
    memcpy(copy->corner, mesh->corner, sizeof *mesh->corner * corners);
    if (mesh->corner_flat) memcpy(copy->corner_flat, mesh->corner_flat, corners);
    return PC_OK;
}

pc_status pc_polymesh_compact(pc_polymesh *mesh, pc_context *ctx, const uint8_t *removed) {
    pc_status status = PC_OK;
    pc_index *number = NULL, faces = 0, corners = 0, vertices = 0, from = mesh->start[0];
    PC_TRY(pc_new(&number, ctx, mesh->vertex_count));
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_index to = mesh->start[f + 1];
        if (!removed[f]) mesh->start[faces++] = corners;
        for (pc_index c = from; c < to && !removed[f]; c++) {
            if (mesh->corner_flat) mesh->corner_flat[corners] = mesh->corner_flat[c];
            mesh->corner[corners++] = mesh->corner[c];
        }
        from = to;
    }
    mesh->start[faces] = corners;
    mesh->face_count = faces;
    for (pc_index c = 0; c < corners; c++)
        number[mesh->corner[c]] = 1;
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        if (!number[v]) continue;
        for (size_t k = 0; k < 3; k++)
            mesh->position[3 * (size_t)vertices + k] = mesh->position[3 * (size_t)v + k];
        number[v] = vertices++;
    }
    mesh->vertex_count = vertices;
    for (pc_index c = 0; c < corners; c++)
        mesh->corner[c] = number[mesh->corner[c]];
done:
    pc_free(ctx, number);
    return status;
}

void pc_polymesh_free(pc_polymesh *mesh, pc_context *ctx) {
    if (!mesh) return;
    pc_free(ctx, mesh->position);
    pc_free(ctx, mesh->start);
    pc_free(ctx, mesh->corner);
    pc_free(ctx, mesh->corner_flat);
    *mesh = (pc_polymesh){0};
}
