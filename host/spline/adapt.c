#include "adapt.h"
#include "insertion.h"
#include "memory.h"
#include <stdlib.h>

static int descending(const void *x, const void *y) {
    double a = *(const double *)x, b = *(const double *)y;
    return (a < b) - (a > b);
}

/* The error above which faces are refined now: others may profit from that. */
static pc_status threshold(double *limit, pc_context *ctx, const pc_face_error *error, size_t faces,
                           const pc_adapt_options *options) {
    pc_status status = PC_OK;
    double *max = NULL;
    size_t most = (size_t)ceil(options->portion * (double)faces);
    PC_TRY(pc_new(&max, ctx, faces));
    for (size_t f = 0; f < faces; f++)
        max[f] = error[f].max;
    qsort(max, faces, sizeof *max, descending);
    *limit = most < faces ? fmax(options->tolerance, max[most]) : options->tolerance;
done:
    pc_free(ctx, max);
    return status;
}

/* Faces over the limit, and which way to halve them. */
static pc_index choose(uint8_t *wish, const pc_tspline *spline, const pc_face_error *error, double limit,
                       double anisotropy) {
    pc_index chosen = 0;
    for (pc_index f = 0; f < spline->mesh.face_count; f++) {
        const double *change = error[f].change;
        wish[f] = 0;
        if (!(error[f].max > limit)) continue;
        wish[f] = change[0] > anisotropy * change[1]   ? PC_HALVE_S
                  : change[1] > anisotropy * change[0] ? PC_HALVE_T
                                                       : PC_HALVE_S | PC_HALVE_T;
        chosen++;
    }
    return chosen;
}

pc_status pc_adapt(pc_tspline *spline, pc_adapt_stats *stats, pc_context *ctx, pc_device *device,
                   const pc_target *target, const pc_adapt_options *options) {
    pc_status status = PC_OK;
    pc_fit_options fit = options->fit;
    pc_face_error *error = NULL;
    pc_correspondence correspondence = {0};
    uint8_t *wish = NULL;
    double least = INFINITY;
    int vain = 0;
    *stats = (pc_adapt_stats){.first_points = spline->mesh.vertex_count};
    PC_TRY(pc_correspondence_make(&correspondence, ctx, spline, target, true));
    for (stats->rounds = 0;; stats->rounds++) {
        pc_closure_stats closed;
        double limit;
        PC_TRY(pc_fit(spline, &stats->fit, ctx, device, target, &correspondence, &fit));
        PC_TRY(pc_new(&error, ctx, spline->mesh.face_count));
        PC_TRY(pc_correspondence_follow(&correspondence, ctx, spline, target));
        PC_TRY(pc_accuracy_measure(&stats->accuracy, error, ctx, spline, target, &correspondence,
                                   options->per_side));
        if (stats->rounds == 0) stats->first_max = stats->accuracy.max;
        pc_log(ctx, PC_LOG_DEBUG,
               "spline: %u control points, %u T-junctions, max %g to the surface, %g to the scan, mean %g; "
               "%zu samples, %zu refused, %u triangles torn",
               spline->mesh.vertex_count, stats->junctions, stats->accuracy.scan_max,
               stats->accuracy.surface_max, stats->accuracy.scan_mean, stats->fit.samples, stats->fit.refused,
               correspondence.torn_triangles);
        if (stats->accuracy.max <= options->tolerance || stats->rounds == options->max_rounds) break;
        vain = stats->accuracy.max < least ? 0 : vain + 1;
        least = fmin(least, stats->accuracy.max);
        if (vain == options->patience) break;
        if (options->max_points && spline->mesh.vertex_count >= options->max_points) break;
        PC_TRY(pc_new(&wish, ctx, spline->mesh.face_count));
        PC_TRY(threshold(&limit, ctx, error, spline->mesh.face_count, options));
        if (!choose(wish, spline, error, limit, options->anisotropy)) break;
        PC_TRY(pc_insertion_refine(spline, &closed, ctx, wish));
        stats->junctions = closed.junctions;
        PC_TRY(pc_correspondence_carry(&correspondence, ctx, &spline->mesh));
        pc_free(ctx, error), error = NULL;
        pc_free(ctx, wish), wish = NULL;
    }
    if (stats->accuracy.max > options->tolerance)
        status = pc_fail(ctx, PC_E_NOCONV, "the surface of %u control points is %g from the scan, not %g",
                         spline->mesh.vertex_count, stats->accuracy.max, options->tolerance);
done:
    pc_correspondence_free(&correspondence, ctx);
    pc_free(ctx, error);
    pc_free(ctx, wish);
    return status;
}
