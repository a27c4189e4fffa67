#include "fit.h"
#include "hostvec.h"
#include "memory.h"
#include "secants.h"
#include "threefold.h"
#include <string.h>
#include <stdlib.h>

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

/* A fit under way. */
typedef struct fitting {
    pc_tspline *spline;
    pc_fit_stats *stats;
    pc_matching *matching;
    pc_device *device;
    const pc_target *target;
    const pc_fit_options *options;
    pc_energy energy;
    pc_secants secants;
    double *pull, *move;
    double last;    /* energy where the last step began */
    double longest; /* plain step; where no data holds the surface, secants may lead anywhere */
} fitting;

/* move = about A^-1 pull, as good as the rest of the step deserves. */
static pc_status solve(fitting *f, pc_context *ctx) {
    enum { MOST_ITERATIONS = 4000 };
    const double relative = 1e-4,
                 enough = 1e4; /* of the right-hand side; times the goal, if it gets no better */
    const pc_energy *energy = &f->energy;
    const pc_index rows = energy->row_count;
    pc_status status = PC_OK;
    pc_threefold *solver = NULL;
    pc_threefold_stats solved = {0};
    double square = 0, size[3] = {0}, goal[3], worst = 0;
    for (pc_index r = 0; r < rows; r++)
        square += energy->system.diagonal[r] * energy->system.diagonal[r];
    for (size_t i = 0; i < 3 * (size_t)rows; i++)
        size[i % 3] += f->pull[i] * f->pull[i];
    for (int k = 0; k < 3; k++)
        goal[k] = fmax(f->options->tolerance * extent_of(f->spline) * sqrt(square), relative * sqrt(size[k]));
    memset(f->move, 0, 3 * (size_t)rows * sizeof *f->move);
    PC_TRY(pc_threefold_make(&solver, ctx, f->device, &energy->system));
    status = pc_threefold_solve(solver, ctx, &solved, f->move, f->pull, goal, MOST_ITERATIONS);
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

/* The farthest that a control point goes. */
static double reach_of(const fitting *f) {
    double reach = 0;
    for (size_t r = 0; r < f->energy.row_count; r++)
        reach = fmax(reach, pc_norm(pc_vec3_at(f->move, r)));
    return reach;
}

/* Adds `sign` times `move` to the free control points. */
static void displace(fitting *f, const double *move, double sign) {
    for (size_t r = 0; r < f->energy.row_count; r++)
        for (size_t k = 0; k < 3; k++)
            f->spline->position[3 * (size_t)f->energy.vertex[r] + k] += sign * move[3 * r + k];
}

/* One step down from where minus half the gradient is `right`: the places are taken as fixed, which gives A,
 * and what the last steps told about how they slide corrects it. */
static pc_status step(fitting *f, pc_context *ctx, const double *right) {
    pc_status status = PC_OK;
    const size_t bytes = f->secants.length * sizeof *right;
    memcpy(f->pull, right, bytes);
    pc_secants_before(&f->secants, f->pull);
    PC_TRY(solve(f, ctx));
    pc_secants_after(&f->secants, f->move);
    if (f->secants.count &&
        (!(pc_hostvec_dot(f->move, right, f->secants.length) > 0) || !(reach_of(f) <= f->longest))) {
        pc_secants_forget(&f->secants); /* not down: as if nothing had been learnt */
        memcpy(f->pull, right, bytes);
        PC_TRY(solve(f, ctx));
    }
    if (!f->secants.count) f->longest = fmax(f->longest, reach_of(f));
    displace(f, f->move, 1);
    memcpy(f->pull, right, bytes);
    pc_secants_take(&f->secants, f->move, f->pull);
done:
    return status;
}

/* Learns from the last step and takes the next one; a step that led up is taken back, and a plain one goes
 * from there. */
static pc_status descend(fitting *f, pc_context *ctx, double energy) {
    const double worse = 1.05; /* a little is lost where samples find no partner any more */
    pc_status status = PC_OK;
    if (f->secants.count && f->secants.has_last && !(energy <= worse * f->last)) {
        displace(f, f->secants.last_step, -1);
        pc_secants_forget(&f->secants);
        PC_TRY(step(f, ctx, f->secants.last_pull));
    } else {
        if (f->options->sliding) pc_secants_learn(&f->secants, f->energy.right);
        f->last = energy;
        PC_TRY(step(f, ctx, f->energy.right));
    }
    pc_tspline_update(f->spline);
done:
    return status;
}

/* Correspondence and step. */
static pc_status one_round(fitting *f, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_fit_options *options = f->options;
    pc_fit_stats *stats = f->stats;
    pc_samples samples = {0};
    pc_energy_facts facts;
    PC_TRY(pc_check_interrupt(ctx));
    PC_TRY(pc_samples_make(&samples, ctx, f->spline, f->target, f->matching, stats->rounds || options->warm ? options->goal : 0, getenv("UNFOLD") && options->warm && stats->rounds == 0));
    /* The first step moves places most; what comes later hardly changes the matrix. */
    PC_TRY(pc_energy_fill(&f->energy, &facts, ctx, f->device, samples.sample, samples.count,
                          options->fairness, samples.stiffness, !options->sliding || stats->rounds < 2));
    stats->rms = facts.weight > 0 ? sqrt(facts.square / facts.weight) : 0;
    stats->samples = samples.count;
    stats->refused = samples.refused;
    PC_TRY(descend(f, ctx, facts.square + facts.bending));
    pc_matching_follow(f->matching, f->spline, f->target);
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
    *stats = (pc_fit_stats){0};
    PC_TRY(pc_energy_make(&f.energy, ctx, spline, options->free));
    stats->moved = f.energy.row_count;
    PC_TRY(pc_new(&f.pull, ctx, 3 * (size_t)stats->moved));
    PC_TRY(pc_new(&f.move, ctx, 3 * (size_t)stats->moved));
    PC_TRY(pc_secants_make(&f.secants, ctx, 3 * (size_t)stats->moved));
    for (; stats->rounds < options->rounds; stats->rounds++)
        PC_TRY(one_round(&f, ctx));
done:
    pc_energy_free(&f.energy, ctx);
    pc_secants_free(&f.secants, ctx);
    pc_free(ctx, f.pull);
    pc_free(ctx, f.move);
    return status;
}
