#include "trimesh.h"
#include "memory.h"
#include <math.h>
#include <string.h>

pc_status pc_mesh_make(pc_mesh *mesh, pc_context *ctx, size_t vertex_count, size_t face_count) {
    pc_status status = PC_OK;
    *mesh = (pc_mesh){0};
    if (vertex_count >= PC_NONE - 1 || face_count >= PC_NONE / 3 - 1)
        return pc_fail(ctx, PC_E_MESH, "%zu vertices and %zu faces exceed the 32-bit indices of this version",
                       vertex_count, face_count);
    mesh->vertex_count = (pc_index)vertex_count;
    mesh->face_count = (pc_index)face_count;
    PC_TRY(pc_new(&mesh->position, ctx, 3 * vertex_count));
    PC_TRY(pc_new(&mesh->triangle, ctx, 3 * face_count));
done:
    if (status != PC_OK) pc_mesh_free(mesh, ctx);
    return status;
}

void pc_mesh_free(pc_mesh *mesh, pc_context *ctx) {
    if (!mesh) return;
    pc_free(ctx, mesh->position);
    pc_free(ctx, mesh->triangle);
    *mesh = (pc_mesh){0};
}

pc_status pc_mesh_check(const pc_mesh *mesh, pc_context *ctx) {
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++)
        if (!isfinite(mesh->position[i]))
            return pc_fail(ctx, PC_E_MESH, "vertex %zu has a coordinate that is not finite", i / 3);
    for (pc_index f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        for (int k = 0; k < 3; k++)
            if (t[k] >= mesh->vertex_count)
                return pc_fail(ctx, PC_E_MESH, "face %u uses vertex %u of %u", f, t[k], mesh->vertex_count);
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
            return pc_fail(ctx, PC_E_MESH, "face %u uses a vertex twice (%u %u %u)", f, t[0], t[1], t[2]);
    }
    return PC_OK;
}

pc_status pc_mesh_copy(pc_mesh *copy, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = pc_mesh_make(copy, ctx, mesh->vertex_count, mesh->face_count);
    if (status != PC_OK) return status;
    memcpy(copy->position, mesh->position, 3 * sizeof(double) * (size_t)mesh->vertex_count);
    memcpy(copy->triangle, mesh->triangle, 3 * sizeof(pc_index) * (size_t)mesh->face_count);
    return PC_OK;
}
