#include "fit.h"
#include "memory.h"
#include "threefold.h"

/* Half the diagonal of the box around the control points. */
static double extent_of(const pc_tspline *spline) {
    double low[3], high[3], square = 0;
    for (int k = 0; k < 3; k++)
        low[k] = high[k] = spline->position[k];
    for (size_t i = 0; i < 3 * (size_t)spline->mesh.vertex_count; i++) {
        low[i % 3] = fmin(low[i % 3], spline->position[i]);
        high[i % 3] = fmax(high[i % 3], spline->position[i]);
    }
    for (int k = 0; k < 3; k++)
        square += (high[k] - low[k]) * (high[k] - low[k]);
    return 0.5 * sqrt(square);
}

void pc_fit_reach(uint8_t *active, const pc_tspline *spline, const uint8_t *free) {
    const pc_basis *basis = &spline->basis;
    for (pc_index e = 0; e < basis->element_count; e++) {
        active[e] = !free;
        for (size_t k = basis->start[e]; free && k < basis->start[e + 1]; k++)
            active[e] |= free[basis->point[k]] != 0;
    }
}

/* Moves the free control points to the least energy; the residual goes down to `tolerance` of what the
 * diagonal makes of the model's size. */
static pc_status solve(pc_tspline *spline, pc_fit_stats *stats, double *farthest, pc_context *ctx,
                       pc_device *device, const pc_energy *energy, double tolerance) {
    enum { MOST_ITERATIONS = 4000 };
    const double enough = 1e4; /* times the goal, if it gets no better */
    pc_status status = PC_OK;
    pc_threefold *solver = NULL;
    pc_threefold_stats solved;
    double *move = NULL, square = 0;
    for (pc_index r = 0; r < energy->row_count; r++)
        square += energy->system.diagonal[r] * energy->system.diagonal[r];
    const double goal = tolerance * extent_of(spline) * sqrt(square);
    PC_TRY(pc_new(&move, ctx, 3 * (size_t)energy->row_count));
    PC_TRY(pc_threefold_make(&solver, ctx, device, &energy->system));
    status = pc_threefold_solve(solver, ctx, &solved, move, energy->right,
                                (const double[3]){goal, goal, goal}, MOST_ITERATIONS);
    stats->iterations += solved.iterations;
    const double worst = fmax(solved.residual[0], fmax(solved.residual[1], solved.residual[2]));
    if (status == PC_E_NOCONV && worst <= enough * goal) {
        pc_context_clear_message(ctx);
        pc_log(ctx, PC_LOG_WARNING, "a fit went on from %.3g of the residual it wanted", worst / goal);
        status = PC_OK;
    }
    PC_TRY(status);
    *farthest = 0;
    for (size_t r = 0; r < energy->row_count; r++) {
        *farthest = fmax(*farthest, pc_norm(pc_vec3_at(move, r)));
        for (size_t k = 0; k < 3; k++)
            spline->position[3 * (size_t)energy->vertex[r] + k] += move[3 * r + k];
    }
done:
    pc_threefold_free(solver, ctx);
    pc_free(ctx, move);
    return status;
}

/* One correspondence and one solve. */
static pc_status round_of(pc_tspline *spline, pc_fit_stats *stats, double *farthest, pc_energy *energy,
                          pc_hints *hints, pc_track *track, pc_context *ctx, pc_device *device,
                          const pc_target *target, const pc_fit_options *options,
                          const pc_samples_options *sampling) {
    pc_status status = PC_OK;
    pc_samples samples = {0};
    pc_energy_facts facts;
    PC_TRY(pc_check_interrupt(ctx));
    PC_TRY(pc_samples_make(&samples, hints, track, ctx, spline, target, sampling));
    PC_TRY(pc_energy_fill(energy, &facts, ctx, device, samples.sample, samples.count, options->fairness,
                          samples.stiffness));
    stats->rms = facts.weight > 0 ? sqrt(facts.square / facts.weight) : 0;
    stats->samples = samples.count;
    stats->refused = samples.refused;
    stats->flipped = samples.flipped;
    PC_TRY(solve(spline, stats, farthest, ctx, device, energy, options->tolerance));
    pc_tspline_update(spline);
done:
    pc_samples_free(&samples, ctx);
    return status;
}

pc_status pc_fit(pc_tspline *spline, pc_fit_stats *stats, pc_track *track, pc_context *ctx, pc_device *device,
                 const pc_target *target, const pc_fit_options *options) {
    pc_status status = PC_OK;
    pc_energy energy = {0};
    pc_hints hints = {0};
    pc_track own = {0};
    uint8_t *active = NULL;
    double farthest = INFINITY;
    *stats = (pc_fit_stats){0};
    if (!track) PC_TRY(pc_target_track(&own, ctx, target));
    PC_TRY(pc_new(&active, ctx, spline->basis.element_count));
    pc_fit_reach(active, spline, options->free);
    PC_TRY(pc_energy_make(&energy, ctx, spline, options->free));
    stats->moved = energy.row_count;
    for (; stats->rounds < options->rounds && farthest > options->settled; stats->rounds++) {
        const pc_samples_options sampling = {options->flat && stats->rounds == 0, options->per_side,
                                             options->free ? active : NULL};
        PC_TRY(round_of(spline, stats, &farthest, &energy, &hints, track ? track : &own, ctx, device, target,
                        options, &sampling));
    }
done:
    pc_energy_free(&energy, ctx);
    pc_hints_free(&hints, ctx);
    pc_track_free(&own, ctx);
    pc_free(ctx, active);
    return status;
}
