#include "matching.h"
#include "bridge.h"
#include "memory.h"

pc_status pc_matching_make(pc_matching *matching, pc_context *ctx, const pc_tspline *spline,
                           const pc_target *target, int per_side) {
    pc_status status = PC_OK;
    pc_mesh flat = {0};
    *matching = (pc_matching){0};
    PC_TRY(pc_footpoints_make(&matching->feet, ctx, &spline->mesh, per_side));
    PC_TRY(pc_bridge_make(&flat, &matching->feet, ctx, spline, target));
    PC_TRY(pc_correspondence_make(&matching->vertices, ctx, spline, target, &flat));
    pc_footpoints_lift(&matching->feet, target->mesh);
done:
    pc_free(ctx, flat.position);
    if (status != PC_OK) pc_matching_free(matching, ctx);
    return status;
}

void pc_matching_free(pc_matching *matching, pc_context *ctx) {
    pc_footpoints_free(&matching->feet, ctx);
    pc_correspondence_free(&matching->vertices, ctx);
    pc_summits_free(&matching->summits, ctx);
}

void pc_matching_follow(pc_matching *matching, const pc_tspline *spline, const pc_target *target,
                        const uint8_t *active) {
    pc_footpoints_follow(&matching->feet, spline, target, matching->let_go, active);
    pc_correspondence_follow(&matching->vertices, spline, target, matching->let_go, active);
    pc_summits_follow(&matching->summits, spline, target, active);
}

void pc_matching_suspect(uint8_t *suspect, const pc_matching *matching, const pc_tspline *spline,
                         const pc_target *target, double far) {
    const pc_correspondence *vertices = &matching->vertices;
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < matching->feet.face_count; f++)
        suspect[f] = !spline->mesh.face[f].ghost && !pc_footpoints_near(&matching->feet, spline, f, far);
    for (pc_index v = 0; v < vertices->count; v++) {
        const pc_index f = vertices->spot[v].face;
        if (f == PC_NONE || suspect[f]) continue;
        const pc_vec3 p = pc_tspline_point(spline, pc_correspondence_place(vertices, spline, v));
        suspect[f] = !(pc_distance(p, pc_vec3_at(target->mesh->position, v)) <= far);
    }
}

pc_status pc_matching_carry(pc_matching *matching, pc_context *ctx, const pc_tspline *refined,
                            const pc_target *target) {
    pc_status status = PC_OK;
    PC_TRY(pc_correspondence_carry(&matching->vertices, ctx, &refined->mesh));
    PC_TRY(pc_correspondence_carry(&matching->summits.places, ctx, &refined->mesh));
    PC_TRY(pc_footpoints_carry(&matching->feet, ctx, &refined->mesh));
    pc_matching_follow(matching, refined, target, NULL);
done:
    return status;
}
