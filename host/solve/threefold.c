#include "threefold.h"
#include "memory.h"
#include "threefold_device.h"
#include <math.h>
#include <string.h>

/* Rows of a block, whose sum is one number whoever computes it; vectors hold four numbers per row, the last
 * one 0. */
enum { BLOCK = 1024, LANES = 4, PARALLEL = 2048 };

struct pc_threefold {
    const pc_system *system;     /* host only, as all below */
    pc_threefold_device *device; /* NULL on the host */
    size_t blocks;
    double *x, *r, *p, *q;
    double *partial; /* 2 x LANES per block */
};

pc_status pc_threefold_make(pc_threefold **solver, pc_context *ctx, pc_device *device,
                            const pc_system *system) {
    pc_status status = PC_OK;
    pc_threefold *s = NULL;
    const size_t rows = system->row_count;
    *solver = NULL;
    PC_TRY(pc_new(&s, ctx, 1));
    s->system = system;
    s->blocks = (rows + BLOCK - 1) / BLOCK;
    if (pc_device_is_host(device)) {
        double **vectors[4] = {&s->x, &s->r, &s->p, &s->q};
        for (int v = 0; v < 4; v++)
            PC_TRY(pc_new(vectors[v], ctx, LANES * rows));
        PC_TRY(pc_new(&s->partial, ctx, 2 * LANES * s->blocks));
    } else {
        PC_TRY(pc_threefold_device_make(&s->device, ctx, device, system));
    }
    *solver = s;
    s = NULL;
done:
    pc_threefold_free(s, ctx);
    return status;
}

void pc_threefold_free(pc_threefold *solver, pc_context *ctx) {
    if (!solver) return;
    pc_threefold_device_free(solver->device, ctx);
    pc_free(ctx, solver->x);
    pc_free(ctx, solver->r);
    pc_free(ctx, solver->p);
    pc_free(ctx, solver->q);
    pc_free(ctx, solver->partial);
    pc_free(ctx, solver);
}

/* CALL(block, from, to) for all blocks of rows. */
#define EACH_BLOCK(s, CALL)                                                                                  \
    do {                                                                                                     \
        const size_t rows_in_all = (s)->system->row_count;                                                   \
        _Pragma("omp parallel for schedule(static) if (rows_in_all > PARALLEL)") for (size_t block = 0;      \
                                                                                      block < (s)->blocks;   \
                                                                                      block++) {             \
            size_t to = (block + 1) * BLOCK < rows_in_all ? (block + 1) * BLOCK : rows_in_all;               \
            CALL(block, block *BLOCK, to);                                                                   \
        }                                                                                                    \
    } while (0)

/* The sums of the blocks' partial sums, LANES numbers from `offset` on. */
static void add_partials(double sum[LANES], const pc_threefold *s, int offset) {
    memset(sum, 0, LANES * sizeof *sum);
    for (size_t block = 0; block < s->blocks; block++)
        for (int k = 0; k < LANES; k++)
            sum[k] += s->partial[2 * LANES * block + (size_t)(offset + k)];
}

/* q = A p and the sums of p.q over rows [from,to). */
static void multiply(const pc_threefold *s, double *partial, size_t from, size_t to) {
    const pc_system *a = s->system;
    double dot[LANES] = {0};
    for (size_t i = from; i < to; i++) {
        const double *own = s->p + LANES * i;
        double sum[LANES];
        for (int k = 0; k < LANES; k++)
            sum[k] = a->diagonal[i] * own[k];
        for (size_t e = a->start[i]; e < a->start[i + 1]; e++) {
            const double value = a->value[e], *other = s->p + LANES * (size_t)a->column[e];
            for (int k = 0; k < LANES; k++)
                sum[k] += value * other[k];
        }
        for (int k = 0; k < LANES; k++) {
            s->q[LANES * i + (size_t)k] = sum[k];
            dot[k] += sum[k] * own[k];
        }
    }
    memcpy(partial, dot, sizeof dot);
}

/* x += alpha p, r -= alpha q; sums of r.r and r.D^-1 r */
static void step(const pc_threefold *s, double *partial, const double *alpha, size_t from, size_t to) {
    double square[LANES] = {0}, angle[LANES] = {0};
    for (size_t i = from; i < to; i++) {
        const double inverse = 1 / s->system->diagonal[i];
        for (size_t k = 0; k < LANES; k++) {
            const size_t at = LANES * i + k;
            const double r = s->r[at] - alpha[k] * s->q[at];
            s->x[at] += alpha[k] * s->p[at];
            s->r[at] = r;
            square[k] += r * r;
            angle[k] += r * r * inverse;
        }
    }
    memcpy(partial, square, sizeof square);
    memcpy(partial + LANES, angle, sizeof angle);
}

/* p = D^-1 r + beta p */
static void turn(const pc_threefold *s, const double *beta, size_t from, size_t to) {
    for (size_t i = from; i < to; i++) {
        const double inverse = 1 / s->system->diagonal[i];
        for (size_t k = 0; k < LANES; k++)
            s->p[LANES * i + k] = inverse * s->r[LANES * i + k] + beta[k] * s->p[LANES * i + k];
    }
}

static void multiply_all(pc_threefold *s, double dot[LANES]) {
#define CALL(block, from, to) multiply(s, s->partial + 2 * LANES * (block), from, to)
    EACH_BLOCK(s, CALL);
#undef CALL
    add_partials(dot, s, 0);
}

static void step_all(pc_threefold *s, double square[LANES], double angle[LANES], const double alpha[LANES]) {
#define CALL(block, from, to) step(s, s->partial + 2 * LANES * (block), alpha, from, to)
    EACH_BLOCK(s, CALL);
#undef CALL
    add_partials(square, s, 0);
    add_partials(angle, s, LANES);
}

static void turn_all(pc_threefold *s, const double beta[LANES]) {
#define CALL(block, from, to) turn(s, beta, from, to)
    EACH_BLOCK(s, CALL);
#undef CALL
}

/* r = b - A x, by way of p. */
static void restart(pc_threefold *s, double square[LANES], double angle[LANES], const double *b) {
    static const double none[LANES] = {0};
    double unused[LANES];
    const size_t rows = s->system->row_count;
    memcpy(s->p, s->x, LANES * rows * sizeof *s->p);
    multiply_all(s, unused);
    for (size_t i = 0; i < rows; i++)
        for (size_t k = 0; k < 3; k++)
            s->r[LANES * i + k] = b[3 * i + k] - s->q[LANES * i + k];
    memset(s->p, 0, LANES * rows * sizeof *s->p);
    step_all(s, square, angle, none);
}

/* Until the recurrence's residuals are small enough. */
static pc_status iterate(pc_threefold *s, pc_context *ctx, double square[LANES], double angle[LANES],
                         const double goal2[LANES], pc_index most, pc_index *iterations) {
    double before[LANES] = {0};
    while (*iterations < most) {
        double dot[LANES], alpha[LANES] = {0}, beta[LANES] = {0};
        bool going = false;
        pc_status status = pc_check_interrupt(ctx);
        if (status != PC_OK) return status;
        for (int k = 0; k < 3; k++)
            if (square[k] > goal2[k]) {
                going = true;
                beta[k] = before[k] > 0 ? angle[k] / before[k] : 0;
            }
        if (!going) break;
        turn_all(s, beta);
        multiply_all(s, dot);
        for (int k = 0; k < 3; k++)
            if (square[k] > goal2[k] && dot[k] > 0) alpha[k] = angle[k] / dot[k];
        memcpy(before, angle, sizeof before);
        step_all(s, square, angle, alpha);
        (*iterations)++;
    }
    return PC_OK;
}

static pc_status solve_on_host(pc_threefold *s, pc_context *ctx, pc_threefold_stats *stats, double *x,
                               const double *b, const double goal[3], pc_index most) {
    enum { RESTARTS = 5 };
    pc_status status = PC_OK;
    const size_t rows = s->system->row_count;
    double square[LANES], angle[LANES], goal2[LANES] = {0};
    for (int k = 0; k < 3; k++)
        goal2[k] = goal[k] * goal[k];
    for (size_t i = 0; i < rows; i++)
        memcpy(s->x + LANES * i, x + 3 * i, 3 * sizeof *x);
    for (int attempt = 0;; attempt++) {
        /* The true residual: the recurrence drifts from it over many iterations. */
        restart(s, square, angle, b);
        const bool done = square[0] <= goal2[0] && square[1] <= goal2[1] && square[2] <= goal2[2];
        if (done || attempt == RESTARTS || stats->iterations >= most) break;
        PC_TRY(iterate(s, ctx, square, angle, goal2, most, &stats->iterations));
    }
    for (size_t i = 0; i < rows; i++)
        memcpy(x + 3 * i, s->x + LANES * i, 3 * sizeof *x);
    for (int k = 0; k < 3; k++)
        stats->residual[k] = sqrt(square[k]);
done:
    return status;
}

pc_status pc_threefold_solve(pc_threefold *solver, pc_context *ctx, pc_threefold_stats *stats, double *x,
                             const double *b, const double goal[3], pc_index most) {
    pc_status status = PC_OK;
    *stats = (pc_threefold_stats){0};
    if (solver->system->row_count == 0) return PC_OK;
    PC_TRY(solver->device ? pc_threefold_device_run(solver->device, ctx, stats, x, b, goal, most)
                          : solve_on_host(solver, ctx, stats, x, b, goal, most));
    for (int k = 0; k < 3; k++)
        if (!(stats->residual[k] <= goal[k]))
            return pc_fail(
                ctx, PC_E_NOCONV,
                "column %d of a solve stopped at the residual %.3g after %u iterations; asked: %.3g", k,
                stats->residual[k], stats->iterations, goal[k]);
done:
    return status;
}
