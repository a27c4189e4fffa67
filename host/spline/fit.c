#include "fit.h"
#include "memory.h"
#include "solver.h"

/* One coordinate after the other with the same matrix, from the present control points. */
static pc_status solve(pc_tspline *spline, pc_fit_stats *stats, pc_context *ctx, pc_device *device,
                       const pc_system *system, const double *right, double tolerance) {
    pc_status status = PC_OK;
    pc_solver *solver = NULL;
    pc_solver_options options = {PC_PRECONDITION_JACOBI, 4000};
    pc_solver_stats solved;
    size_t rows = system->row_count;
    double *x = NULL;
    PC_TRY(pc_new(&x, ctx, rows));
    PC_TRY(pc_solver_make(&solver, ctx, device, system, &options));
    for (size_t k = 0; k < 3; k++) {
        for (size_t v = 0; v < rows; v++)
            x[v] = spline->position[3 * v + k];
        PC_TRY(pc_solver_approach(solver, ctx, x, right + k * rows, tolerance, 1e-4, &solved));
        stats->iterations += solved.iterations;
        for (size_t v = 0; v < rows; v++)
            spline->position[3 * v + k] = x[v];
    }
done:
    pc_solver_free(solver, ctx);
    pc_free(ctx, x);
    return status;
}

static double rms_of(const pc_tspline *spline, const pc_samples *samples) {
    double sum = 0, weight = 0;
    for (size_t i = 0; i < samples->count; i++) {
        const pc_sample *s = samples->sample + i;
        double d = pc_distance(pc_tspline_point(spline, s->place), s->target);
        sum += s->weight * d * d;
        weight += s->weight;
    }
    return weight > 0 ? sqrt(sum / weight) : 0;
}

pc_status pc_fit(pc_tspline *spline, pc_fit_stats *stats, pc_context *ctx, pc_device *device,
                 const pc_target *target, pc_correspondence *correspondence, const pc_fit_options *options) {
    pc_status status = PC_OK;
    pc_samples samples = {0};
    pc_system system = {0};
    double *right = NULL;
    *stats = (pc_fit_stats){0};
    for (int round = 0; round < options->rounds; round++) {
        PC_TRY(pc_check_interrupt(ctx));
        if (round > 0) PC_TRY(pc_correspondence_follow(correspondence, ctx, spline, target));
        PC_TRY(pc_samples_make(&samples, ctx, spline, target, correspondence, options->per_side));
        PC_TRY(pc_energy_assemble(&system, &right, ctx, spline, samples.sample, samples.count,
                                  options->fairness, samples.stiffness));
        stats->rms = rms_of(spline, &samples);
        stats->samples = samples.count;
        stats->refused = samples.refused;
        stats->torn = correspondence->torn_triangles;
        PC_TRY(solve(spline, stats, ctx, device, &system, right, options->tolerance));
        pc_tspline_update(spline);
        pc_samples_free(&samples, ctx);
        pc_system_free(&system, ctx);
        pc_free(ctx, right), right = NULL;
    }
done:
    pc_samples_free(&samples, ctx);
    pc_system_free(&system, ctx);
    pc_free(ctx, right);
    return status;
}
