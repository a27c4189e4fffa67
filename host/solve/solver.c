/* Preconditioned conjugate gradients: the host's, and the choice between host and device. */
#include "solver.h"
#include "clock.h"
#include "devsolve.h"
#include "hostvec.h"
#include "memory.h"
#include "multigrid.h"
#include <math.h>
#include <string.h>

struct pc_solver {
    pc_device *device;
    pc_solver_options options;
    pc_block_kind kind;
    pc_index row_count;
    pc_index entry_count;
    double setup_seconds;
    pc_multigrid multigrid; /* on a device only its groups and diagonals are kept here */
    pc_devsolve *devsolve;  /* NULL on the host */
    pc_system system;       /* a copy; host only, as all below */
    bool has_cycle;
    float *first_diagonal; /* without a hierarchy: that of the last make or update */
    double *r, *z, *p, *q;
};

static size_t unknowns(const pc_solver *s) {
    return (size_t)s->row_count * (size_t)pc_block_width(s->kind);
}

static pc_status check_diagonal(pc_context *ctx, const pc_system *system) {
    for (pc_index i = 0; i < system->row_count; i++) {
        if (!(system->diagonal[i] > 0) || !isfinite(system->diagonal[i]))
            return pc_fail(ctx, PC_E_BUG, "system row %u: diagonal %g", i, system->diagonal[i]);
    }
    return PC_OK;
}

static pc_status copy_system(pc_system *to, pc_context *ctx, const pc_system *from) {
    size_t entries = from->start[from->row_count];
    pc_system_free(to, ctx);
    pc_status status = pc_system_make(to, ctx, from->kind, from->row_count, entries);
    if (status != PC_OK) return status;
    memcpy(to->start, from->start, ((size_t)from->row_count + 1) * sizeof *to->start);
    memcpy(to->column, from->column, entries * sizeof *to->column);
    memcpy(to->diagonal, from->diagonal, from->row_count * sizeof *to->diagonal);
    memcpy(to->value, from->value, entries * (size_t)pc_block_width(from->kind) * sizeof *to->value);
    if (to->turn) memcpy(to->turn, from->turn, entries);
    return PC_OK;
}

/* Set-up for values; the groups of rows are reused where there are some. */
static pc_status take_values(pc_solver *s, pc_context *ctx, const pc_system *system) {
    pc_status status = PC_OK;
    const bool multigrid = s->options.preconditioner == PC_PRECONDITION_MULTIGRID;
    s->has_cycle = false;
    pc_devsolve_free(s->devsolve, ctx);
    s->devsolve = NULL;
    PC_TRY(check_diagonal(ctx, system));
    if (pc_device_is_host(s->device)) {
        PC_TRY(copy_system(&s->system, ctx, system));
        system = &s->system;
        for (pc_index i = 0; i < s->row_count && !multigrid; i++)
            s->first_diagonal[i] = (float)system->diagonal[i];
    }
    if (multigrid) {
        PC_TRY(pc_multigrid_update(&s->multigrid, ctx, system));
    } else if (!pc_device_is_host(s->device)) {
        pc_multigrid_free(&s->multigrid, ctx);
        PC_TRY(pc_multigrid_make_finest(&s->multigrid, ctx, system));
    }
    if (pc_device_is_host(s->device)) {
        if (multigrid) PC_TRY(pc_multigrid_make_vectors(&s->multigrid, ctx));
        s->has_cycle = multigrid;
    } else {
        PC_TRY(pc_devsolve_make(&s->devsolve, ctx, s->device, system, &s->multigrid, &s->options));
    }
done:
    return status;
}

pc_status pc_solver_make(pc_solver **solver, pc_context *ctx, pc_device *device, const pc_system *system,
                         const pc_solver_options *options) {
    static const pc_solver_options defaults = PC_SOLVER_DEFAULTS;
    pc_status status = PC_OK;
    pc_solver *s = NULL;
    double begin = pc_clock_wall();
    *solver = NULL;
    PC_TRY(pc_new(&s, ctx, 1));
    s->device = device;
    s->options = options ? *options : defaults;
    s->kind = system->kind;
    s->row_count = system->row_count;
    s->entry_count = system->start[system->row_count];
    if (pc_device_is_host(device)) {
        PC_TRY(pc_new(&s->first_diagonal, ctx, s->row_count));
        double **vectors[4] = {&s->r, &s->z, &s->p, &s->q};
        for (int v = 0; v < 4; v++)
            PC_TRY(pc_new(vectors[v], ctx, unknowns(s)));
    }
    PC_TRY(take_values(s, ctx, system));
    s->setup_seconds = pc_clock_wall() - begin;
done:
    if (status == PC_OK)
        *solver = s;
    else
        pc_solver_free(s, ctx);
    return status;
}

pc_status pc_solver_update(pc_solver *solver, pc_context *ctx, const pc_system *system) {
    double begin = pc_clock_wall();
    if (system->kind != solver->kind || system->row_count != solver->row_count ||
        system->start[system->row_count] != solver->entry_count)
        return pc_fail(ctx, PC_E_BUG, "a solver was given values for another graph");
    pc_status status = take_values(solver, ctx, system);
    solver->setup_seconds = pc_clock_wall() - begin;
    return status;
}

pc_status pc_solver_set_diagonal(pc_solver *solver, pc_context *ctx, const double *diagonal) {
    pc_status status = PC_OK;
    const double rounding = 1e-7;
    const bool has_levels = solver->devsolve || solver->has_cycle;
    double begin = pc_clock_wall();
    for (pc_index i = 0; i < solver->row_count; i++) {
        const double first = has_levels ? pc_multigrid_first_diagonal(&solver->multigrid, i)
                                        : (double)solver->first_diagonal[i];
        if (!(diagonal[i] >= first * (1 - rounding)) || !isfinite(diagonal[i]))
            return pc_fail(ctx, PC_E_BUG, "system row %u: the diagonal falls from %g to %g", i, first,
                           diagonal[i]);
    }
    if (has_levels) PC_TRY(pc_multigrid_set_diagonal(&solver->multigrid, ctx, diagonal));
    if (solver->devsolve)
        PC_TRY(pc_devsolve_set_diagonal(solver->devsolve, ctx, diagonal, &solver->multigrid));
    else
        memcpy(solver->system.diagonal, diagonal, solver->row_count * sizeof *diagonal);
    solver->setup_seconds = pc_clock_wall() - begin;
done:
    return status;
}

void pc_solver_free(pc_solver *solver, pc_context *ctx) {
    if (!solver) return;
    pc_devsolve_free(solver->devsolve, ctx);
    pc_multigrid_free(&solver->multigrid, ctx);
    pc_system_free(&solver->system, ctx);
    pc_free(ctx, solver->first_diagonal);
    pc_free(ctx, solver->r);
    pc_free(ctx, solver->z);
    pc_free(ctx, solver->p);
    pc_free(ctx, solver->q);
    pc_free(ctx, solver);
}

/* z = about A^-1 r; r.z. `norm` is |r|: the cycle gets r/|r|, so that floats never run out of range. */
static double precondition(pc_solver *s, double norm) {
    size_t n = unknowns(s);
    if (!s->has_cycle)
        return pc_hostvec_jacobi(s->z, s->r, s->system.diagonal, s->system.row_count,
                                 pc_block_width(s->system.kind));
    pc_hostvec_narrow(s->multigrid.level[0].b, s->r, 1 / norm, n);
    pc_multigrid_cycle(&s->multigrid);
    pc_hostvec_widen(s->z, s->multigrid.level[0].x, norm * s->multigrid.scale, n);
    return pc_hostvec_dot(s->z, s->r, n);
}

/* Runs until the recurrence's |r| falls to `goal`. Returns the residual norm in `*norm`. */
static pc_status iterate(pc_solver *s, pc_context *ctx, double *x, double goal, double *norm, pc_index *its) {
    size_t n = unknowns(s);
    double rho_old = 0;
    while (*norm > goal && *its < s->options.max_iterations) {
        pc_status status = pc_check_interrupt(ctx);
        if (status != PC_OK) return status;
        double rho = precondition(s, *norm);
        pc_hostvec_direction(s->p, s->z, rho_old > 0 ? rho / rho_old : 0, n);
        pc_system_apply(s->q, &s->system, s->p);
        double curvature = pc_hostvec_dot(s->p, s->q, n);
        if (!(curvature > 0) || !isfinite(curvature)) break;
        *norm = sqrt(pc_hostvec_step(x, s->r, s->p, s->q, rho / curvature, n));
        rho_old = rho;
        (*its)++;
    }
    return PC_OK;
}

static pc_status solve_host(pc_solver *s, pc_context *ctx, double *x, const double *b, double tolerance,
                            pc_solver_stats *stats) {
    enum { RESTARTS = 5 };
    size_t n = unknowns(s);
    double b_norm = sqrt(pc_hostvec_dot(b, b, n));
    if (!isfinite(b_norm)) return pc_fail(ctx, PC_E_BUG, "a right-hand side is not finite");
    if (b_norm == 0) {
        memset(x, 0, n * sizeof *x);
        return PC_OK;
    }
    for (int restart = 0; restart < RESTARTS; restart++) {
        /* The true residual: the recurrence drifts from it over many iterations. */
        pc_system_apply(s->r, &s->system, x);
        double norm = sqrt(pc_hostvec_residual(s->r, b, n));
        stats->residual = norm / b_norm;
        if (stats->residual <= tolerance || stats->iterations >= s->options.max_iterations) break;
        memset(s->p, 0, n * sizeof *s->p);
        pc_status status = iterate(s, ctx, x, tolerance * b_norm, &norm, &stats->iterations);
        if (status != PC_OK) return status;
    }
    if (stats->residual <= tolerance) return PC_OK;
    return pc_fail(ctx, PC_E_NOCONV,
                   "a solve stopped at the relative residual %.3g after %u iterations; asked: %.3g",
                   stats->residual, stats->iterations, tolerance);
}

pc_status pc_solver_solve(pc_solver *solver, pc_context *ctx, double *x, const double *b, double tolerance,
                          pc_solver_stats *stats) {
    pc_solver_stats own;
    if (!stats) stats = &own;
    *stats = (pc_solver_stats){.setup_seconds = solver->setup_seconds};
    double begin = pc_clock_wall();
    pc_status status = PC_OK;
    if (solver->row_count > 0) {
        status = solver->devsolve ? pc_devsolve_run(solver->devsolve, ctx, x, b, tolerance,
                                                    solver->options.max_iterations, stats)
                                  : solve_host(solver, ctx, x, b, tolerance, stats);
    }
    stats->solve_seconds = pc_clock_wall() - begin;
    return status;
}

pc_status pc_solver_approach(pc_solver *solver, pc_context *ctx, double *x, const double *b, double tolerance,
                             double worst, pc_solver_stats *stats) {
    pc_solver_stats own;
    if (!stats) stats = &own;
    pc_status status = pc_solver_solve(solver, ctx, x, b, tolerance, stats);
    if (status != PC_E_NOCONV || !(stats->residual <= worst)) return status;
    pc_context_clear_message(ctx);
    pc_log(ctx, PC_LOG_WARNING,
           "a solve went on from the relative residual %.3g after %u iterations; asked: %.3g",
           stats->residual, stats->iterations, tolerance);
    return PC_OK;
}
