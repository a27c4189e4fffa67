#include "cone.h"
#include "memory.h"
#include "vec3.h"
#include <string.h>

bool pc_cone_point(pc_point2 *point, const pc_param *param, pc_index face) {
    size_t h = 3 * (size_t)face;
    pc_transition g =
        pc_transition_after(pc_transition_after(pc_transition_of(param, h), pc_transition_of(param, h + 1)),
                            pc_transition_of(param, h + 2));
    int64_t half = PC_PERIOD / 2;
    switch (g.turn) {
    case 1:
        *point = (pc_point2){half * (g.a + g.b), half * (g.b - g.a)};
        return true;
    case 2:
        *point = (pc_point2){half * g.a, half * g.b};
        return true;
    case 3:
        *point = (pc_point2){half * (g.a - g.b), half * (g.a + g.b)};
        return true;
    default:
        return false;
    }
}

static bool is_near(pc_point2 p, pc_point2 q) {
    int64_t s = p.s - q.s, t = p.t - q.t;
    return s > -PC_PERIOD && s < PC_PERIOD && t > -PC_PERIOD && t < PC_PERIOD;
}

static bool holds_cone(pc_point2 *point, const pc_param *param, const pc_mesh *mesh, pc_index face) {
    pc_point2 corner[3];
    if (param->singular[face] != PC_FIELD_SINGULARITY || !pc_cone_point(point, param, face)) return false;
    pc_param_corners(corner, param, mesh->triangle, face);
    /* The third corner by way of the second is another image of it; the cone is as far from both. */
    return is_near(corner[0], *point) && is_near(corner[1], *point) && is_near(corner[2], *point);
}

static void put_transition(pc_param *param, size_t h, pc_transition g) {
    param->turn[h] = (uint8_t)g.turn;
    param->shift[2 * h] = (int32_t)g.a, param->shift[2 * h + 1] = (int32_t)g.b;
}

/* Three faces (corner k, corner k+1, cone) from face `at` on. The cone's frame is that of the first corner.
 */
static void split_face(pc_coned *coned, pc_index at, const pc_mesh *mesh, const pc_param *param, pc_index f,
                       pc_index cone) {
    pc_transition to[3] = {{0, 0, 0},
                           pc_transition_of(param, 3 * (size_t)f),
                           pc_transition_inverse(pc_transition_of(param, 3 * (size_t)f + 2))};
    for (pc_index k = 0; k < 3; k++) {
        size_t h = 3 * ((size_t)at + k);
        coned->mesh.triangle[h] = mesh->triangle[3 * (size_t)f + k];
        coned->mesh.triangle[h + 1] = mesh->triangle[3 * (size_t)f + (k + 1) % 3];
        coned->mesh.triangle[h + 2] = cone;
        put_transition(&coned->param, h, pc_transition_of(param, 3 * (size_t)f + k));
        put_transition(&coned->param, h + 1, pc_transition_inverse(to[(k + 1) % 3]));
        put_transition(&coned->param, h + 2, to[k]);
        coned->param.singular[at + k] = PC_REGULAR;
        coned->source_face[at + k] = f;
    }
}

static void copy_face(pc_coned *coned, pc_index at, const pc_mesh *mesh, const pc_param *param, pc_index f) {
    memcpy(coned->mesh.triangle + 3 * (size_t)at, mesh->triangle + 3 * (size_t)f, 3 * sizeof(pc_index));
    memcpy(coned->param.turn + 3 * (size_t)at, param->turn + 3 * (size_t)f, 3);
    memcpy(coned->param.shift + 6 * (size_t)at, param->shift + 6 * (size_t)f, 6 * sizeof(int32_t));
    coned->param.singular[at] = param->singular[f];
    coned->source_face[at] = f;
}

pc_status pc_coned_make(pc_coned *coned, pc_context *ctx, const pc_mesh *mesh, const pc_param *param) {
    pc_status status = PC_OK;
    pc_index cones = 0;
    pc_point2 point;
    *coned = (pc_coned){.first_cone = mesh->vertex_count};
    for (pc_index f = 0; f < mesh->face_count; f++)
        cones += holds_cone(&point, param, mesh, f);
    size_t vertices = (size_t)mesh->vertex_count + cones,
           faces = (size_t)mesh->face_count + 2 * (size_t)cones;
    PC_TRY(pc_mesh_make(&coned->mesh, ctx, vertices, faces));
    coned->param = (pc_param){.vertex_count = (pc_index)vertices,
                              .face_count = (pc_index)faces,
                              .period_length = param->period_length};
    PC_TRY(pc_new(&coned->param.coordinate, ctx, 2 * vertices));
    PC_TRY(pc_new(&coned->param.turn, ctx, 3 * faces));
    PC_TRY(pc_new(&coned->param.shift, ctx, 6 * faces));
    PC_TRY(pc_new(&coned->param.singular, ctx, faces));
    PC_TRY(pc_new(&coned->source_face, ctx, faces));
    memcpy(coned->mesh.position, mesh->position, 3 * sizeof(double) * (size_t)mesh->vertex_count);
    memcpy(coned->param.coordinate, param->coordinate, 2 * sizeof(int32_t) * (size_t)mesh->vertex_count);
    pc_index at = 0, cone = mesh->vertex_count;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        if (!holds_cone(&point, param, mesh, f)) {
            copy_face(coned, at++, mesh, param, f);
            continue;
        }
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        pc_vec3 sum = pc_add(pc_vec3_at(mesh->position, t[0]), pc_vec3_at(mesh->position, t[1]));
        pc_vec3_put(coned->mesh.position, cone,
                    pc_scale(1.0 / 3, pc_add(sum, pc_vec3_at(mesh->position, t[2]))));
        coned->param.coordinate[2 * (size_t)cone] = (int32_t)point.s;
        coned->param.coordinate[2 * (size_t)cone + 1] = (int32_t)point.t;
        split_face(coned, at, mesh, param, f, cone++);
        at += 3;
    }
    pc_log(ctx, PC_LOG_DEBUG, "cones: %u", cones);
done:
    if (status != PC_OK) pc_coned_free(coned, ctx);
    return status;
}

void pc_coned_free(pc_coned *coned, pc_context *ctx) {
    if (!coned) return;
    pc_mesh_free(&coned->mesh, ctx);
    pc_param_free(&coned->param, ctx);
    pc_free(ctx, coned->source_face);
    *coned = (pc_coned){0};
}
