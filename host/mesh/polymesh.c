#include "polymesh.h"
#include "memory.h"

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

void pc_polymesh_free(pc_polymesh *mesh, pc_context *ctx) {
    if (!mesh) return;
    pc_free(ctx, mesh->position);
    pc_free(ctx, mesh->start);
    pc_free(ctx, mesh->corner);
    pc_free(ctx, mesh->corner_flat);
    *mesh = (pc_polymesh){0};
}
