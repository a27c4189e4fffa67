#include "newton.h"
#include "hostvec.h"
#include "memory.h"
#include "solver.h"
#include <math.h>
#include <string.h>

enum { GRAIN = 4096, MOST_PRODUCTS = 40, PATIENCE = 3 };
static const double INNER_TOLERANCE = 0.1; /* of the preconditioner's solves */

/* ---- F and its derivatives ---- */

static double square(const double *u) {
    return u[0] * u[0] + u[1] * u[1];
}

static double penalty(const double *strength, const double *x, pc_index rows) {
    double sum = 0;
    for (size_t k = 0; k < 2 * (size_t)rows; k++) {
        double off = square(x + 2 * k) - 1;
        sum += strength[k / 2] * off * off;
    }
    return sum;
}

double pc_newton_gradient(double *gradient, const pc_system *system, const double *strength,
                          const double *x) {
    const size_t n = 4 * (size_t)system->row_count;
    pc_system_apply(gradient, system, x);
    double value = pc_hostvec_dot(gradient, x, n) + penalty(strength, x, system->row_count);
#pragma omp parallel for schedule(static, GRAIN)
    for (size_t k = 0; k < n / 2; k++) {
        const double *u = x + 2 * k;
        double pull = 4 * strength[k / 2] * (square(u) - 1), *g = gradient + 2 * k;
        g[0] = 2 * g[0] + pull * u[0], g[1] = 2 * g[1] + pull * u[1];
    }
    return value;
}

void pc_newton_hessian(double *y, const pc_system *system, const double *strength, const double *x,
                       const double *p) {
    pc_system_apply(y, system, p);
#pragma omp parallel for schedule(static, GRAIN)
    for (size_t k = 0; k < 2 * (size_t)system->row_count; k++) {
        const double *u = x + 2 * k, *v = p + 2 * k;
        double pull = 4 * strength[k / 2] * (square(u) - 1);
        double along = 8 * strength[k / 2] * (u[0] * v[0] + u[1] * v[1]), *w = y + 2 * k;
        w[0] = 2 * w[0] + pull * v[0] + along * u[0], w[1] = 2 * w[1] + pull * v[1] + along * u[1];
    }
}

/* ---- the way along a direction ---- */

/* F(x + tau d) - F(x) = c[1] tau + c[2] tau^2 + c[3] tau^3 + c[4] tau^4; ad = A d. */
static void quartic(double c[5], const double *strength, const double *gradient, const double *x,
                    const double *d, const double *ad, pc_index rows) {
    const size_t n = 4 * (size_t)rows;
    c[0] = 0, c[1] = pc_hostvec_dot(gradient, d, n), c[2] = pc_hostvec_dot(d, ad, n), c[3] = c[4] = 0;
    for (size_t k = 0; k < n / 2; k++) {
        const double *u = x + 2 * k, *v = d + 2 * k;
        double off = square(u) - 1, along = u[0] * v[0] + u[1] * v[1], length = square(v);
        c[2] += strength[k / 2] * (4 * along * along + 2 * off * length);
        c[3] += strength[k / 2] * 4 * along * length;
        c[4] += strength[k / 2] * length * length;
    }
}

/* The first minimum for tau > 0, where c[1] < 0. */
static double way_along(const double c[5]) {
    enum { DOUBLINGS = 60, HALVINGS = 60 };
    double low = 0, high = 1;
    for (int k = 0; k < DOUBLINGS; k++) {
        if (c[1] + high * (2 * c[2] + high * (3 * c[3] + high * 4 * c[4])) > 0) break;
        low = high, high *= 2;
    }
    for (int k = 0; k < HALVINGS; k++) {
        double tau = 0.5 * (low + high);
        if (c[1] + tau * (2 * c[2] + tau * (3 * c[3] + tau * 4 * c[4])) > 0)
            high = tau;
        else
            low = tau;
    }
    return 0.5 * (low + high);
}

/* ---- Newton's steps ---- */

typedef struct newton {
    pc_context *ctx;
    const pc_system *system;
    const double *strength;
    pc_solver *solver; /* for A + strength: half of F'' in the mean of its directions */
    pc_newton_stats *stats;
    double *x;
    double *gradient, *d, *r, *r_old, *z, *p, *q;
} newton;

static pc_status make_vectors(newton *s) {
    double **vectors[] = {&s->gradient, &s->d, &s->r, &s->r_old, &s->z, &s->p, &s->q};
    for (size_t k = 0; k < sizeof vectors / sizeof vectors[0]; k++) {
        pc_status status = pc_new(vectors[k], s->ctx, 4 * (size_t)s->system->row_count);
        if (status != PC_OK) return status;
    }
    return PC_OK;
}

static pc_status make_solver(newton *s, pc_device *device) {
    pc_status status = PC_OK;
    const pc_solver_options options = PC_SOLVER_DEFAULTS;
    pc_system shifted = *s->system; /* borrows all but the diagonal */
    PC_TRY(pc_new(&shifted.diagonal, s->ctx, s->system->row_count));
    for (pc_index i = 0; i < s->system->row_count; i++)
        shifted.diagonal[i] = s->system->diagonal[i] + s->strength[i];
    PC_TRY(pc_solver_make(&s->solver, s->ctx, device, &shifted, &options));
done:
    pc_free(s->ctx, shifted.diagonal);
    return status;
}

/* z = about (A + strength)^-1 r */
static pc_status precondition(newton *s) {
    pc_solver_stats solved;
    memset(s->z, 0, 4 * (size_t)s->system->row_count * sizeof *s->z);
    pc_status status = pc_solver_approach(s->solver, s->ctx, s->z, s->r, INNER_TOLERANCE, 1, &solved);
    s->stats->iterations += solved.iterations;
    s->stats->seconds_in_solver += solved.solve_seconds;
    return status;
}

/* d with F'' d = -F' to the relative residual `forcing`, or as far as F'' curves upwards. The preconditioner
 * is a solve of its own and changes from one product to the next: the directions' formula is the flexible
 * one. */
static pc_status find_direction(newton *s, double forcing) {
    pc_status status = PC_OK;
    const size_t n = 4 * (size_t)s->system->row_count;
    double rho = 0, goal = 0;
    memset(s->d, 0, n * sizeof *s->d);
    for (size_t k = 0; k < n; k++)
        s->r[k] = -s->gradient[k];
    goal = forcing * sqrt(pc_hostvec_dot(s->r, s->r, n));
    for (int product = 0; product < MOST_PRODUCTS; product++) {
        PC_TRY(precondition(s));
        double rho_new = pc_hostvec_dot(s->r, s->z, n);
        double kept = product ? pc_hostvec_dot(s->r_old, s->z, n) : 0;
        if (!(rho_new > 0)) break;
        pc_hostvec_direction(s->p, s->z, product ? (rho_new - kept) / rho : 0, n);
        rho = rho_new;
        pc_newton_hessian(s->q, s->system, s->strength, s->x, s->p);
        s->stats->products++;
        double curvature = pc_hostvec_dot(s->p, s->q, n);
        if (!(curvature > 0)) {
            if (product == 0) memcpy(s->d, s->p, n * sizeof *s->d);
            break;
        }
        memcpy(s->r_old, s->r, n * sizeof *s->r);
        if (sqrt(pc_hostvec_step(s->d, s->r, s->p, s->q, pc_hostvec_dot(s->p, s->r, n) / curvature, n)) <=
            goal)
            break;
        PC_TRY(pc_check_interrupt(s->ctx));
    }
done:
    return status;
}

static pc_status step_along(newton *s) {
    const size_t n = 4 * (size_t)s->system->row_count;
    double c[5];
    pc_system_apply(s->q, s->system, s->d);
    quartic(c, s->strength, s->gradient, s->x, s->d, s->q, s->system->row_count);
    if (!(c[1] < 0)) return pc_fail(s->ctx, PC_E_BUG, "Newton's direction does not lead down: %g", c[1]);
    double way = way_along(c);
#pragma omp parallel for schedule(static, GRAIN)
    for (size_t k = 0; k < n; k++)
        s->x[k] += way * s->d[k];
    pc_log(s->ctx, PC_LOG_DEBUG, "newton: F %.9g, gradient %.2e, %u products, %u iterations, way %.3g",
           s->stats->value, s->stats->gradient, s->stats->products, s->stats->iterations, way);
    return PC_OK;
}

pc_status pc_newton_solve(double *x, pc_newton_stats *stats, pc_context *ctx, pc_device *device,
                          const pc_system *system, const double *strength, const pc_newton_options *options) {
    pc_status status = PC_OK;
    const size_t n = 4 * (size_t)system->row_count;
    newton s = {.ctx = ctx, .system = system, .strength = strength, .stats = stats, .x = x};
    double first = 0, before = 0;
    int idle = 0; /* steps in a row that gained next to nothing */
    *stats = (pc_newton_stats){0};
    if (n == 0) return PC_OK;
    PC_TRY(make_vectors(&s));
    PC_TRY(make_solver(&s, device));
    for (int step = 0;; step++) {
        stats->value = pc_newton_gradient(s.gradient, system, strength, x);
        stats->gradient = sqrt(pc_hostvec_dot(s.gradient, s.gradient, n) / (double)n);
        if (step == 0) first = stats->gradient;
        if (stats->gradient <= options->tolerance || step == options->most_steps) break;
        idle = step && before - stats->value < options->least_gain * before ? idle + 1 : 0;
        if (idle == PATIENCE) break;
        before = stats->value;
        PC_TRY(find_direction(&s, fmin(0.3, sqrt(stats->gradient / first))));
        PC_TRY(step_along(&s));
        stats->steps++;
        pc_progress(ctx, (step + 1.0) / options->most_steps);
    }
done:;
    double *vectors[] = {s.gradient, s.d, s.r, s.r_old, s.z, s.p, s.q};
    for (size_t k = 0; k < sizeof vectors / sizeof vectors[0]; k++)
        pc_free(ctx, vectors[k]);
    pc_solver_free(s.solver, ctx);
    return status;
}
