#include "memory.h"
#include "overlay.h"
#include "vec3.h"
#include <string.h>

static bool splits(const pc_adjacency *a, const uint8_t *flag, const uint8_t *keep, pc_index h) {
    pc_index twin = a->twin[h];
    return twin != PC_NONE && flag[h / 3] && flag[twin / 3] && !keep[h] && !keep[twin];
}

/* A flagged face becomes a fan around its centroid: one triangle per side, two where the side is halved. */
static void fan_face(pc_overlay *fine, pc_index *at, const pc_overlay *coarse, const pc_adjacency *adjacency,
                     const pc_index *middle, pc_index centre, pc_index f) {
    for (pc_index k = 0; k < 3; k++) {
        pc_index h = 3 * f + k, m = middle[adjacency->edge[h]];
        pc_index chain[3] = {pc_tail(&coarse->mesh, h), m, pc_head(&coarse->mesh, h)};
        int pieces = m == PC_NONE ? 1 : 2;
        if (m == PC_NONE) chain[1] = chain[2];
        for (int piece = 0; piece < pieces; piece++) {
            pc_index *t = fine->mesh.triangle + 3 * (size_t)*at;
            t[0] = chain[piece], t[1] = chain[piece + 1], t[2] = centre;
            fine->drawn[3 * (size_t)*at] = coarse->drawn[h];
            fine->source_face[(*at)++] = coarse->source_face[f];
        }
    }
}

pc_status pc_overlay_refine(pc_overlay *overlay, pc_context *ctx, const pc_adjacency *adjacency,
                            const uint8_t *flag, const uint8_t *keep) {
    pc_status status = PC_OK;
    pc_overlay fine = {0};
    pc_index *middle = NULL;
    size_t vertices = overlay->mesh.vertex_count, faces = 0;
    PC_TRY(pc_new(&middle, ctx, adjacency->edge_count));
    for (pc_index e = 0; e < adjacency->edge_count; e++)
        middle[e] = splits(adjacency, flag, keep, adjacency->edge_half[e]) ? (pc_index)vertices++ : PC_NONE;
    size_t first_centre = vertices;
    for (pc_index f = 0; f < overlay->mesh.face_count; f++) {
        faces += flag[f] ? 3 : 1;
        vertices += flag[f];
        for (pc_index k = 0; k < 3 && flag[f]; k++)
            faces += middle[adjacency->edge[3 * f + k]] != PC_NONE;
    }
    PC_TRY(pc_mesh_make(&fine.mesh, ctx, vertices, faces));
    PC_TRY(pc_new(&fine.source_face, ctx, faces));
    PC_TRY(pc_new(&fine.drawn, ctx, 3 * faces));
    const double *p = overlay->mesh.position;
    memcpy(fine.mesh.position, p, 3 * sizeof(double) * overlay->mesh.vertex_count);
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        pc_index h = adjacency->edge_half[e];
        if (middle[e] == PC_NONE) continue;
        pc_vec3 sum =
            pc_add(pc_vec3_at(p, pc_tail(&overlay->mesh, h)), pc_vec3_at(p, pc_head(&overlay->mesh, h)));
        pc_vec3_put(fine.mesh.position, middle[e], pc_scale(0.5, sum));
    }
    pc_index at = 0, centre = (pc_index)first_centre;
    for (pc_index f = 0; f < overlay->mesh.face_count; f++) {
        const pc_index *t = overlay->mesh.triangle + 3 * (size_t)f;
        if (!flag[f]) {
            memcpy(fine.mesh.triangle + 3 * (size_t)at, t, 3 * sizeof *t);
            memcpy(fine.drawn + 3 * (size_t)at, overlay->drawn + 3 * (size_t)f, 3);
            fine.source_face[at++] = overlay->source_face[f];
            continue;
        }
        pc_vec3 sum = pc_add(pc_vec3_at(p, t[0]), pc_add(pc_vec3_at(p, t[1]), pc_vec3_at(p, t[2])));
        pc_vec3_put(fine.mesh.position, centre, pc_scale(1.0 / 3, sum));
        fan_face(&fine, &at, overlay, adjacency, middle, centre++, f);
    }
    pc_overlay_free(overlay, ctx);
    *overlay = fine;
    fine = (pc_overlay){0};
done:
    pc_free(ctx, middle);
    pc_overlay_free(&fine, ctx);
    return status;
}
