#include "target.h"
#include "geometry.h"
#include "memory.h"

pc_status pc_target_make(pc_target *target, pc_context *ctx, const pc_mesh *mesh,
                         const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    *target = (pc_target){.mesh = mesh, .adjacency = adjacency};
    PC_TRY(pc_bvh_make(&target->tree, ctx, mesh));
    PC_TRY(pc_new(&target->normal, ctx, 3 * (size_t)mesh->vertex_count));
    pc_geometry_vertex_normals(target->normal, mesh, adjacency, PC_NORMAL_ANGLE);
    target->diagonal = pc_box_diagonal(pc_geometry_box(mesh));
done:
    if (status != PC_OK) pc_target_free(target, ctx);
    return status;
}

void pc_target_free(pc_target *target, pc_context *ctx) {
    pc_bvh_free(&target->tree, ctx);
    pc_free(ctx, target->normal);
    *target = (pc_target){0};
}

bool pc_target_on_border(const pc_target *target, pc_index triangle, const double weight[3]) {
    for (pc_index k = 0; k < 3; k++) {
        const pc_index h = 3 * triangle + k;
        if (target->adjacency->twin[h] == PC_NONE && weight[(k + 2) % 3] <= 0) return true;
        if (weight[k] >= 1 && target->adjacency->vertex_boundary[target->mesh->triangle[h]]) return true;
    }
    return false;
}

pc_vec3 pc_target_normal(const pc_target *target, pc_index triangle, const double weight[3]) {
    pc_vec3 sum = {0, 0, 0};
    for (size_t k = 0; k < 3; k++)
        sum = pc_madd(sum, weight[k],
                      pc_vec3_at(target->normal, target->mesh->triangle[3 * (size_t)triangle + k]));
    return pc_unit(sum);
}
