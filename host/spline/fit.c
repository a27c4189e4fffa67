#include "fit.h"
#include "geometry.h"
#include "memory.h"
#include "region.h"
#include "samples.h"
#include "threefold.h"
#include <string.h>

enum { FIRST_ROUNDS = 3 };

/* A fit under way. */
typedef struct fitting {
    pc_tspline *spline;
    pc_fit_stats *stats;
    pc_matching *matching;
    pc_device *device;
    const pc_target *target;
    const pc_fit_options *options;
    pc_region own;           /* chosen here, where the options leave it open */
    const pc_region *region; /* what moves; empty: all */
    pc_energy energy;
    double *move; /* 3 per row */
    double least; /* largest distance in the best round */
    int vain;     /* rounds since then */
} fitting;

/* move = about A^-1 of the right-hand side, as good as the rest of the round deserves. */
static pc_status solve(fitting *f, pc_context *ctx) {
    enum { MOST_ITERATIONS = 4000 };
    const double relative = 1e-4,
                 enough = 1e4; /* of the right-hand side; times the goal, if it gets no better */
    const pc_energy *energy = &f->energy;
    const pc_index rows = energy->row_count;
    pc_status status = PC_OK;
    pc_threefold *solver = NULL;
    pc_threefold_stats solved = {0};
    const double extent = pc_box_diagonal(pc_box_of(f->spline->position, f->spline->mesh.vertex_count)) / 2;
    double square = 0, size[3] = {0}, goal[3], worst = 0;
    for (pc_index r = 0; r < rows; r++)
        square += energy->system.diagonal[r] * energy->system.diagonal[r];
    for (size_t i = 0; i < 3 * (size_t)rows; i++)
        size[i % 3] += energy->right[i] * energy->right[i];
    for (int k = 0; k < 3; k++)
        goal[k] = fmax(f->options->tolerance * extent * sqrt(square), relative * sqrt(size[k]));
    memset(f->move, 0, 3 * (size_t)rows * sizeof *f->move);
    PC_TRY(pc_threefold_make(&solver, ctx, f->device, &energy->system));
    status = pc_threefold_solve(solver, ctx, &solved, f->move, energy->right, goal, MOST_ITERATIONS);
    f->stats->iterations += solved.iterations;
    for (int k = 0; k < 3; k++)
        worst = fmax(worst, goal[k] > 0 ? solved.residual[k] / goal[k] : 0);
    if (status == PC_E_NOCONV && worst <= enough) {
        pc_context_clear_message(ctx);
        pc_log(ctx, PC_LOG_WARNING, "a fit went on from %.3g of the residual it wanted", worst);
        status = PC_OK;
    }
done:
    pc_threefold_free(solver, ctx);
    return status;
}

static void displace(fitting *f) {
    for (size_t r = 0; r < f->energy.row_count; r++)
        for (size_t k = 0; k < 3; k++)
            f->spline->position[3 * (size_t)f->energy.vertex[r] + k] += f->move[3 * r + k];
    pc_tspline_update_faces(f->spline, f->region->active);
}

/* Another round may bring the surface within the distance that is wanted: much is tried where little is
 * missing, because what refinement adds is more than that. */
static bool goes_on(fitting *f, double max) {
    enum { PATIENCE = 3, LONG_PATIENCE = 8 };
    const double good = 0.92, close = 2, hopeless = 4, worthwhile = 0.97, within = f->options->within;
    const int rounds = f->stats->rounds;
    f->stats->max = max;
    if (rounds == f->options->rounds) return false;
    if (!(within > 0) || rounds == 0) return true;
    f->vain = rounds == 1 || max < worthwhile * f->least ? 0 : f->vain + 1;
    if (f->vain == 0) f->least = max;
    if (rounds < FIRST_ROUNDS) return true;
    if (max <= good * within || max >= hopeless * within) return false;
    return f->vain < (f->least < close * within ? LONG_PATIENCE : PATIENCE);
}

/* A new part of the surface is chosen every few rounds; all of it moves where the fit is rough. */
static bool region_is_due(const fitting *f) {
    enum { PERIOD = 4 };
    const int first = f->options->rough ? FIRST_ROUNDS : 0, rounds = f->stats->rounds;
    return !f->options->region && f->options->within > 0 && rounds >= first && (rounds - first) % PERIOD == 0;
}

/* The system for what moves now; `far` is the largest distance per face, NULL to leave what moves as it is.
 */
static pc_status start_region(fitting *f, pc_context *ctx, const double *far) {
    const double limit = 0.8; /* of the distance that is wanted */
    pc_status status = PC_OK;
    pc_energy_free(&f->energy, ctx);
    pc_free(ctx, f->move), f->move = NULL;
    if (far) {
        pc_region_free(&f->own, ctx);
        PC_TRY(pc_region_make(&f->own, ctx, f->spline, far, limit * f->options->within));
    }
    PC_TRY(pc_energy_make(&f->energy, ctx, f->spline, f->region->free));
    f->energy.stiffness = f->options->stiffness;
    f->stats->moved = f->energy.row_count;
    PC_TRY(pc_new(&f->move, ctx, 3 * (size_t)f->stats->moved));
done:
    return status;
}

static pc_status one_round(bool *more, fitting *f, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_fit_options *options = f->options;
    pc_fit_stats *stats = f->stats;
    const double within = options->rough && stats->rounds == 0 ? 0 : options->within;
    const bool due = region_is_due(f);
    pc_samples samples = {0};
    pc_energy_facts facts;
    PC_TRY(pc_check_interrupt(ctx));
    PC_TRY(pc_samples_make(&samples, ctx, f->spline, f->target, f->matching, within,
                           due ? NULL : f->region->active));
    *more = goes_on(f, samples.max);
    if (!*more) goto done;
    if (due || stats->rounds == 0) PC_TRY(start_region(f, ctx, due ? samples.far : NULL));
    *more = stats->moved > 0;
    if (!*more) goto done;
    PC_TRY(
        pc_energy_fill(&f->energy, &facts, ctx, f->device, samples.sample, samples.count, options->fairness));
    stats->rms = facts.weight > 0 ? sqrt(facts.square / facts.weight) : 0;
    stats->samples = samples.count;
    PC_TRY(solve(f, ctx));
    displace(f);
    pc_matching_follow(f->matching, f->spline, f->target, f->region->active);
    stats->rounds++;
done:
    pc_samples_free(&samples, ctx);
    return status;
}

pc_status pc_fit(pc_tspline *spline, pc_fit_stats *stats, pc_context *ctx, pc_device *device,
                 const pc_target *target, pc_matching *matching, const pc_fit_options *options) {
    pc_status status = PC_OK;
    fitting f = {.spline = spline,
                 .stats = stats,
                 .matching = matching,
                 .device = device,
                 .target = target,
                 .options = options};
    f.region = options->region ? options->region : &f.own;
    *stats = (pc_fit_stats){0};
    for (bool more = true; more;)
        PC_TRY(one_round(&more, &f, ctx));
done:
    pc_region_free(&f.own, ctx);
    pc_energy_free(&f.energy, ctx);
    pc_free(ctx, f.move);
    return status;
}
