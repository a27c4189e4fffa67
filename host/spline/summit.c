#include "summit.h"
#include "memory.h"

/* Faces with a summit next to their farthest place. */
static void mark_known(uint8_t *known, const pc_summits *summits, const pc_footpoints *feet,
                       const pc_gauge *gauge) {
    for (pc_index i = 0; i < summits->places.count; i++) {
        const pc_spot *spot = summits->places.spot + i;
        const double *at = gauge->face[spot->face].at, *size = feet->size + 2 * (size_t)spot->face;
        known[spot->face] |= fabs(spot->at[0] - at[0]) * 2 * feet->per_side < size[0] &&
                             fabs(spot->at[1] - at[1]) * 2 * feet->per_side < size[1];
    }
}

pc_status pc_summits_find(pc_summits *summits, uint8_t *unseen, pc_context *ctx, const pc_tspline *spline,
                          const pc_footpoints *feet, const pc_gauge *gauge, double tolerance) {
    pc_status status = PC_OK;
    const double most = 1.5; /* what is farther away is folded, and a sample there keeps it so */
    const pc_index faces = gauge->face_count;
    pc_index count = summits->places.count;
    uint8_t *known = NULL;
    PC_TRY(pc_new(&known, ctx, faces));
    mark_known(known, summits, feet, gauge);
    for (pc_index f = 0; f < faces; f++) {
        unseen[f] = gauge->face[f].known && !known[f] && gauge->face[f].max > tolerance &&
                    gauge->face[f].max < most * tolerance && pc_footpoints_near(feet, spline, f, tolerance);
        count += unseen[f];
    }
    PC_TRY(pc_resize(&summits->places.spot, ctx, count));
    PC_TRY(pc_resize(&summits->foot, ctx, count));
    for (pc_index f = 0; f < faces; f++) {
        const pc_face_found *found = gauge->face + f;
        if (!unseen[f]) continue;
        summits->places.spot[summits->places.count] = (pc_spot){f, {found->at[0], found->at[1]}, 1, false};
        summits->foot[summits->places.count++] = (pc_foot){.triangle = found->triangle, .stress = 1};
    }
done:
    pc_free(ctx, known);
    return status;
}

void pc_summits_follow(pc_summits *summits, const pc_tspline *spline, const pc_target *target,
                       const uint8_t *active) {
    const double at_once = INFINITY; /* none is held */
#pragma omp parallel for schedule(dynamic, 64)
    for (pc_index i = 0; i < summits->places.count; i++) {
        if (active && !active[summits->places.spot[i].face]) continue;
        const pc_surface_place place = pc_correspondence_place(&summits->places, spline, i);
        const pc_surface_point x = pc_tspline_evaluate(spline, place);
        summits->foot[i] = pc_foot_follow(summits->foot + i, target, &x, at_once);
    }
}

void pc_summits_free(pc_summits *summits, pc_context *ctx) {
    pc_correspondence_free(&summits->places, ctx);
    pc_free(ctx, summits->foot);
    *summits = (pc_summits){0};
}
