#include "devsolve.h"
#include "devmat.h"
#include "memory.h"
#include <math.h>
#include <string.h>

extern const char pc_kernel_cycle[];
extern const char pc_kernel_conjugate[];

/* As in conjugate.cl and cycle.cl. */
enum { CHUNK_SLICES = 512, CHUNK = 4096, GROUP = 128 };
enum { SCALAR_PQ = 0, SCALAR_RR = 1, SCALAR_RZ = 2, SCALARS = 4 };
enum { APPLY, ADD, RESIDUAL, SMOOTH };

typedef struct devlevel {
    pc_row_order order;
    pc_devmat matrix, prolongator, restriction;
    pc_chebyshev chebyshev;
    size_t numbers;                 /* of a vector on the device */
    pc_buffer *x, *x_other, *d, *b; /* residuals go to x_other */
} devlevel;

struct pc_devsolve {
    pc_device *device;
    pc_shape shape;
    int width;
    int level_count;
    bool jacobi;
    double scale; /* of the hierarchy against the system */
    devlevel level[PC_MOST_LEVELS];
    pc_buffer *direct;
    pc_index direct_count;
    pc_buffer *diagonal; /* double */
    pc_buffer *x, *b, *r, *p, *q, *partial, *scalars;
    pc_kernel *cycle, *first, *solve_direct, *product, *begin, *step, *angle, *direction, *finish;
};

static pc_status get_kernels(pc_devsolve *s, pc_context *ctx, pc_block_form form) {
    static const char *const cycle[3] = {"cycle_scalar", "cycle_complex", "cycle_turned"};
    static const char *const product[3] = {"conjugate_scalar", "conjugate_complex", "conjugate_turned"};
    const struct {
        pc_kernel **kernel;
        const char *source, *name;
    } wanted[] = {
        {&s->cycle, pc_kernel_cycle, cycle[form]},
        {&s->first, pc_kernel_cycle, "cycle_first"},
        {&s->solve_direct, pc_kernel_cycle, "cycle_direct"},
        {&s->product, pc_kernel_conjugate, product[form]},
        {&s->begin, pc_kernel_conjugate, "conjugate_begin"},
        {&s->step, pc_kernel_conjugate, "conjugate_step"},
        {&s->angle, pc_kernel_conjugate, "conjugate_angle"},
        {&s->direction, pc_kernel_conjugate, "conjugate_direction"},
        {&s->finish, pc_kernel_conjugate, "conjugate_finish"},
    };
    pc_status status = PC_OK;
    for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++)
        PC_TRY(pc_kernel_get(wanted[k].kernel, ctx, s->device, wanted[k].source, wanted[k].name));
done:
    return status;
}

static pc_status make_level(pc_devsolve *s, pc_context *ctx, int k, const pc_level *host,
                            const pc_system *exact) {
    pc_status status = PC_OK;
    devlevel *level = &s->level[k];
    level->chebyshev = host->chebyshev;
    PC_TRY(
        pc_devmat_make(&level->matrix, ctx, s->device, &host->matrix, &level->order, &level->order, exact));
    level->numbers = pc_devmat_padded(&level->matrix) * (size_t)s->width;
    pc_buffer **vectors[4] = {&level->x, &level->x_other, &level->d, &level->b};
    for (int v = 0; v < 4; v++)
        PC_TRY(pc_buffer_zeroed(vectors[v], ctx, s->device, level->numbers * sizeof(float)));
    if (k + 1 < s->level_count) {
        PC_TRY(pc_devmat_make(&level->prolongator, ctx, s->device, &host->prolongator, &level->order,
                              &level[1].order, NULL));
        PC_TRY(pc_devmat_make(&level->restriction, ctx, s->device, &host->restriction, &level[1].order,
                              &level->order, NULL));
    }
done:
    return status;
}

static pc_status write_diagonal(pc_devsolve *s, pc_context *ctx, const double *diagonal) {
    const pc_row_order *order = &s->level[0].order;
    double *space = NULL;
    pc_status status = pc_new(&space, ctx, order->count);
    if (status != PC_OK) return status;
    for (pc_index place = 0; place < order->count; place++)
        space[place] = diagonal[order->row[place]];
    status = pc_buffer_write(s->diagonal, ctx, 0, space, order->count * sizeof *space);
    pc_free(ctx, space);
    return status;
}

/* The vectors of conjugate gradients, the diagonal, and room for partial sums. */
static pc_status make_vectors(pc_devsolve *s, pc_context *ctx, const pc_system *system) {
    pc_status status = PC_OK;
    const devlevel *level = &s->level[0];
    const size_t padded = pc_devmat_padded(&level->matrix);
    pc_buffer **vectors[5] = {&s->x, &s->b, &s->r, &s->p, &s->q};
    for (int v = 0; v < 5; v++)
        PC_TRY(pc_buffer_zeroed(vectors[v], ctx, s->device, level->numbers * sizeof(double)));
    PC_TRY(pc_buffer_zeroed(&s->partial, ctx, s->device, (level->numbers / GROUP + 1) * sizeof(double)));
    PC_TRY(pc_buffer_zeroed(&s->scalars, ctx, s->device, SCALARS * sizeof(double)));
    PC_TRY(pc_buffer_zeroed(&s->diagonal, ctx, s->device, padded * sizeof(double)));
    PC_TRY(write_diagonal(s, ctx, system->diagonal));
done:
    return status;
}

pc_status pc_devsolve_set_diagonal(pc_devsolve *solve, pc_context *ctx, const double *diagonal,
                                   const pc_multigrid *multigrid) {
    pc_status status = PC_OK;
    const size_t direct = (size_t)solve->direct_count * solve->direct_count * sizeof(float);
    for (int k = 0; k < solve->level_count; k++)
        PC_TRY(pc_devmat_set_diagonals(&solve->level[k].matrix, ctx, &multigrid->level[k].matrix,
                                       &solve->level[k].order));
    if (multigrid->inverse) PC_TRY(pc_buffer_write(solve->direct, ctx, 0, multigrid->inverse, direct));
    PC_TRY(write_diagonal(solve, ctx, diagonal));
done:
    return status;
}

pc_status pc_devsolve_make(pc_devsolve **solve, pc_context *ctx, pc_device *device, const pc_system *system,
                           pc_multigrid *multigrid) {
    pc_status status = PC_OK;
    pc_devsolve *s = NULL;
    *solve = NULL;
    PC_TRY(pc_device_require_doubles(device, ctx, "the solver"));
    PC_TRY(pc_new(&s, ctx, 1));
    s->device = device;
    s->shape = pc_device_shape(device);
    s->width = pc_block_width(system->kind);
    s->level_count = multigrid->level_count;
    s->jacobi = multigrid->finest_only;
    s->scale = multigrid->scale;
    PC_TRY(get_kernels(s, ctx, (pc_block_form)system->kind));
    for (int k = 0; k < s->level_count; k++)
        PC_TRY(pc_row_order_make(&s->level[k].order, ctx, &multigrid->level[k].matrix));
    if (multigrid->inverse) {
        /* The direct solve knows its level's own order only. */
        pc_row_order *order = &s->level[s->level_count - 1].order;
        s->direct_count = (pc_index)((size_t)order->count * (size_t)s->width);
        for (pc_index i = 0; i < order->count; i++)
            order->row[i] = order->place[i] = i;
    }
    for (int k = 0; k < s->level_count; k++) {
        PC_TRY(make_level(s, ctx, k, &multigrid->level[k], k == 0 ? system : NULL));
        pc_multigrid_free_couplings(multigrid, ctx, k);
    }
    if (multigrid->inverse)
        PC_TRY(pc_buffer_from(&s->direct, ctx, device, multigrid->inverse,
                              (size_t)s->direct_count * s->direct_count * sizeof(float)));
    PC_TRY(make_vectors(s, ctx, system));
done:
    if (status == PC_OK)
        *solve = s;
    else
        pc_devsolve_free(s, ctx);
    return status;
}

void pc_devsolve_free(pc_devsolve *solve, pc_context *ctx) {
    if (!solve) return;
    for (int k = 0; k < PC_MOST_LEVELS; k++) {
        devlevel *level = &solve->level[k];
        pc_row_order_free(&level->order, ctx);
        pc_devmat_free(&level->matrix, ctx);
        pc_devmat_free(&level->prolongator, ctx);
        pc_devmat_free(&level->restriction, ctx);
        pc_buffer *vectors[4] = {level->x, level->x_other, level->d, level->b};
        for (int v = 0; v < 4; v++)
            pc_buffer_free(vectors[v], ctx);
    }
    pc_buffer *buffers[9] = {solve->direct, solve->diagonal, solve->x,       solve->b,      solve->r,
                             solve->p,      solve->q,        solve->partial, solve->scalars};
    for (int k = 0; k < 9; k++)
        pc_buffer_free(buffers[k], ctx);
    pc_free(ctx, solve);
}

/* A product on a level; see the modes in cycle.cl. */
static pc_status product(pc_devsolve *s, pc_context *ctx, const pc_devmat *m, int mode, const pc_buffer *y,
                         const pc_buffer *x, const pc_buffer *b, const pc_buffer *d, float alpha,
                         float beta) {
    const size_t rows = m->slice_rows;
    const size_t entry = rows * ((size_t)pc_form_size(m->form) + 1) * sizeof(float);
    const size_t row = rows * (size_t)s->width * sizeof(float);
    static const int passes[4] = {2, 3, 3, 6};
    const pc_buffer *diagonal = m->diagonal ? m->diagonal : x;
    const pc_buffer *inverse = m->inverse ? m->inverse : x;
    for (int k = 0; k < m->part_count; k++) {
        const pc_devmat_part *part = &m->part[k];
        size_t per_item = 1;
        size_t items = part->slices * rows;
        if (s->shape == PC_SHAPE_CHUNK) {
            per_item = part->slices / 32;
            per_item = per_item < 1 ? 1 : per_item > 4096 / rows ? 4096 / rows : per_item;
            items = (part->slices + per_item - 1) / per_item;
        }
        double bytes =
            (double)part->entries * (double)entry + (double)part->slices * passes[mode] * (double)row;
        pc_status status = pc_kernel_run(
            ctx, s->cycle, items, s->shape == PC_SHAPE_CHUNK ? 1 : 0, bytes,
            PC_ARGS(PC_BUF(part->start), PC_BUF(part->column), PC_BUF(part->value), PC_BUF(diagonal),
                    PC_BUF(inverse), PC_BUF(x), PC_BUF(b ? b : x), PC_BUF(y), PC_BUF(d ? d : y),
                    PC_U32(part->first), PC_U32(part->slices), PC_U32((uint32_t)per_item),
                    PC_U32((uint32_t)mode), PC_F32(alpha), PC_F32(beta)));
        if (status != PC_OK) return status;
    }
    return PC_OK;
}

static pc_status smooth_first(pc_devsolve *s, pc_context *ctx, const devlevel *level, float beta) {
    const size_t rows = pc_devmat_padded(&level->matrix);
    const bool chunks = s->shape == PC_SHAPE_CHUNK;
    const size_t per_item = chunks ? 2048 : 1;
    return pc_kernel_run(ctx, s->first, (rows + per_item - 1) / per_item, chunks ? 1 : 0,
                         (double)rows * (3.0 * s->width + pc_form_diagonal(level->matrix.form)) *
                             sizeof(float),
                         PC_ARGS(PC_BUF(level->matrix.inverse), PC_BUF(level->b), PC_BUF(level->x),
                                 PC_BUF(level->d), PC_U32((uint32_t)rows), PC_U32((uint32_t)s->width),
                                 PC_U32((uint32_t)per_item), PC_F32(beta)));
}

static pc_status smooth(pc_devsolve *s, pc_context *ctx, devlevel *level, int from) {
    pc_status status = PC_OK;
    for (int k = from; k < PC_SMOOTH_STEPS; k++) {
        PC_TRY(product(s, ctx, &level->matrix, SMOOTH, level->x_other, level->x, level->b, level->d,
                       level->chebyshev.alpha[k], level->chebyshev.beta[k]));
        pc_buffer *x = level->x;
        level->x = level->x_other;
        level->x_other = x;
    }
done:
    return status;
}

static pc_status solve_last(pc_devsolve *s, pc_context *ctx, devlevel *level) {
    enum { SWEEPS = 4 };
    pc_status status = PC_OK;
    const double n = s->direct_count;
    if (s->direct)
        return pc_kernel_run(
            ctx, s->solve_direct, s->direct_count, 0, n * n * sizeof(float),
            PC_ARGS(PC_BUF(s->direct), PC_BUF(level->b), PC_BUF(level->x), PC_U32(s->direct_count)));
    PC_TRY(smooth_first(s, ctx, level, level->chebyshev.beta[0]));
    PC_TRY(smooth(s, ctx, level, 1));
    for (int sweep = 1; sweep < SWEEPS; sweep++)
        PC_TRY(smooth(s, ctx, level, 0));
done:
    return status;
}

/* level[0].x = about (scale A)^-1 level[0].b */
static pc_status cycle(pc_devsolve *s, pc_context *ctx) {
    pc_status status = PC_OK;
    const int last = s->level_count - 1;
    if (s->jacobi) return smooth_first(s, ctx, &s->level[0], 1);
    for (int k = 0; k < last; k++) {
        devlevel *level = &s->level[k];
        PC_TRY(smooth_first(s, ctx, level, level->chebyshev.beta[0]));
        PC_TRY(smooth(s, ctx, level, 1));
        PC_TRY(product(s, ctx, &level->matrix, RESIDUAL, level->x_other, level->x, level->b, NULL, 0, 0));
        PC_TRY(product(s, ctx, &level->restriction, APPLY, level[1].b, level->x_other, NULL, NULL, 0, 0));
    }
    PC_TRY(solve_last(s, ctx, &s->level[last]));
    for (int k = last - 1; k >= 0; k--) {
        devlevel *level = &s->level[k];
        PC_TRY(product(s, ctx, &level->prolongator, ADD, level->x, level[1].x, NULL, NULL, 0, 0));
        PC_TRY(smooth(s, ctx, level, 0));
    }
done:
    return status;
}

/* Adds `count` partial sums into a scalar. */
static pc_status finish(pc_devsolve *s, pc_context *ctx, size_t count, int slot) {
    const bool chunks = s->shape == PC_SHAPE_CHUNK;
    return pc_kernel_run(
        ctx, s->finish, chunks ? 1 : GROUP, chunks ? 1 : GROUP, (double)count * sizeof(double),
        PC_ARGS(PC_BUF(s->partial), PC_BUF(s->scalars), PC_U32((uint32_t)count), PC_U32((uint32_t)slot)));
}

/* q = A p, and p.q */
static pc_status outer_product(pc_devsolve *s, pc_context *ctx, const pc_buffer *q, const pc_buffer *p) {
    const bool chunks = s->shape == PC_SHAPE_CHUNK;
    const pc_devmat *m = &s->level[0].matrix;
    const size_t entry = m->slice_rows * ((size_t)pc_form_size(m->form) * sizeof(double) + sizeof(pc_index));
    pc_status status = PC_OK;
    for (int k = 0; k < m->part_count; k++) {
        const pc_devmat_part *part = &m->part[k];
        size_t items = chunks ? (part->slices + CHUNK_SLICES - 1) / CHUNK_SLICES
                              : (m->slice_rows * (size_t)part->slices + GROUP - 1) / GROUP * GROUP;
        double bytes = (double)part->entries * (double)entry +
                       (double)part->slices * m->slice_rows * (2.0 * s->width + 1) * sizeof(double);
        PC_TRY(pc_kernel_run(ctx, s->product, items, chunks ? 1 : GROUP, bytes,
                             PC_ARGS(PC_BUF(part->start), PC_BUF(part->column), PC_BUF(part->exact),
                                     PC_BUF(s->diagonal), PC_BUF(p), PC_BUF(q), PC_BUF(s->partial),
                                     PC_U32(part->first), PC_U32(part->slices))));
    }
    size_t rows = pc_devmat_padded(m);
    status = finish(s, ctx,
                    chunks ? (m->slice_count + CHUNK_SLICES - 1) / CHUNK_SLICES : (rows + GROUP - 1) / GROUP,
                    SCALAR_PQ);
done:
    return status;
}

/* Runs a vector pass, `numbers` words of 4 bytes per number, and adds its partial sums (slot < 0: it has
 * none). */
static pc_status pass(pc_devsolve *s, pc_context *ctx, pc_kernel *kernel, double words, int slot,
                      const pc_argument *arguments, size_t count) {
    const bool chunks = s->shape == PC_SHAPE_CHUNK;
    const size_t n = s->level[0].numbers;
    const size_t per = chunks ? CHUNK : GROUP;
    const size_t partials = (n + per - 1) / per;
    pc_status status = pc_kernel_run(ctx, kernel, chunks ? partials : partials * GROUP, chunks ? 1 : GROUP,
                                     4 * words * (double)n, arguments, count);
    if (status == PC_OK && slot >= 0) status = finish(s, ctx, partials, slot);
    return status;
}

static pc_status read_norm(double *norm, pc_devsolve *s, pc_context *ctx) {
    double square = 0;
    pc_status status = pc_buffer_read(&square, ctx, s->scalars, SCALAR_RR * sizeof square, sizeof square);
    *norm = sqrt(square);
    return status;
}

/* r = b - A x and its norm; the cycle will see r / `unit`. */
static pc_status begin(pc_devsolve *s, pc_context *ctx, double *norm, double unit) {
    pc_status status = PC_OK;
    const uint32_t n = (uint32_t)s->level[0].numbers;
    PC_TRY(outer_product(s, ctx, s->q, s->x));
    PC_TRY(pass(s, ctx, s->begin, 7, SCALAR_RR,
                PC_ARGS(PC_BUF(s->r), PC_BUF(s->level[0].b), PC_BUF(s->b), PC_BUF(s->q), PC_BUF(s->partial),
                        PC_U32(n), PC_F64(1 / unit))));
    PC_TRY(read_norm(norm, s, ctx));
done:
    return status;
}

/* One iteration; the scalars of alpha and beta stay on the device. */
static pc_status iteration(pc_devsolve *s, pc_context *ctx, pc_index number, double unit) {
    pc_status status = PC_OK;
    const uint32_t n = (uint32_t)s->level[0].numbers;
    const uint32_t slot = SCALAR_RZ + number % 2;
    const double z_scale = unit * s->scale;
    PC_TRY(cycle(s, ctx));
    const pc_buffer *z = s->level[0].x;
    PC_TRY(pass(s, ctx, s->angle, 3, (int)slot,
                PC_ARGS(PC_BUF(s->r), PC_BUF(z), PC_BUF(s->partial), PC_U32(n), PC_F64(z_scale))));
    PC_TRY(pass(s, ctx, s->direction, number == 0 ? 3 : 5, -1,
                PC_ARGS(PC_BUF(s->p), PC_BUF(z), PC_BUF(s->scalars), PC_U32(n), PC_U32(slot),
                        PC_U32(number == 0), PC_F64(z_scale))));
    PC_TRY(outer_product(s, ctx, s->q, s->p));
    PC_TRY(pass(s, ctx, s->step, 13, SCALAR_RR,
                PC_ARGS(PC_BUF(s->x), PC_BUF(s->r), PC_BUF(s->level[0].b), PC_BUF(s->p), PC_BUF(s->q),
                        PC_BUF(s->partial), PC_BUF(s->scalars), PC_U32(n), PC_U32(slot), PC_F64(1 / unit))));
done:
    return status;
}

/* Vectors in the user's order to the device's and back. */
static pc_status send(pc_devsolve *s, pc_context *ctx, const pc_buffer *to, double *scratch,
                      const double *from) {
    const size_t w = (size_t)s->width;
    const pc_row_order *order = &s->level[0].order;
#pragma omp parallel for schedule(static)
    for (pc_index place = 0; place < order->count; place++)
        memcpy(scratch + w * place, from + w * order->row[place], w * sizeof *from);
    return pc_buffer_write(to, ctx, 0, scratch, w * order->count * sizeof *from);
}

static pc_status fetch(pc_devsolve *s, pc_context *ctx, double *to, double *scratch, const pc_buffer *from) {
    const size_t w = (size_t)s->width;
    const pc_row_order *order = &s->level[0].order;
    pc_status status = pc_buffer_read(scratch, ctx, from, 0, w * order->count * sizeof *to);
#pragma omp parallel for schedule(static)
    for (pc_index row = 0; row < order->count; row++)
        memcpy(to + w * row, scratch + w * order->place[row], w * sizeof *to);
    return status;
}

/* Iterates until |r| <= goal; the true residual is found anew at each restart. */
static pc_status run(pc_devsolve *s, pc_context *ctx, double tolerance, double b_norm,
                     pc_index max_iterations, pc_solver_stats *stats) {
    enum { RESTARTS = 5 };
    pc_status status = PC_OK;
    for (int restart = 0; restart < RESTARTS; restart++) {
        double norm = 0;
        /* The unit only has to be of the residual's size: floats are happy over many decades. */
        PC_TRY(begin(s, ctx, &norm, b_norm));
        double unit = norm;
        stats->residual = norm / b_norm;
        if (stats->residual <= tolerance || stats->iterations >= max_iterations) break;
        if (unit < 1e-3 * b_norm || unit > 1e3 * b_norm)
            PC_TRY(begin(s, ctx, &norm, unit));
        else
            unit = b_norm;
        for (pc_index k = 0; norm > tolerance * b_norm && stats->iterations < max_iterations; k++) {
            PC_TRY(pc_check_interrupt(ctx));
            PC_TRY(iteration(s, ctx, k, unit));
            PC_TRY(read_norm(&norm, s, ctx));
            stats->iterations++;
            if (!isfinite(norm))
                return pc_fail(ctx, PC_E_NOCONV, "a solve broke down on '%s'", pc_device_name(s->device));
        }
    }
done:
    return status;
}

pc_status pc_devsolve_run(pc_devsolve *solve, pc_context *ctx, double *x, const double *b, double tolerance,
                          pc_index max_iterations, pc_solver_stats *stats) {
    pc_status status = PC_OK;
    double *scratch = NULL;
    double square = 0;
    const size_t n = (size_t)solve->level[0].order.count * (size_t)solve->width;
    for (size_t i = 0; i < n; i++)
        square += b[i] * b[i];
    if (!isfinite(square)) return pc_fail(ctx, PC_E_BUG, "a right-hand side is not finite");
    if (square == 0) {
        memset(x, 0, n * sizeof *x);
        return PC_OK;
    }
    PC_TRY(pc_new(&scratch, ctx, n));
    PC_TRY(send(solve, ctx, solve->b, scratch, b));
    PC_TRY(send(solve, ctx, solve->x, scratch, x));
    PC_TRY(run(solve, ctx, tolerance, sqrt(square), max_iterations, stats));
    PC_TRY(fetch(solve, ctx, x, scratch, solve->x));
    if (!(stats->residual <= tolerance))
        status = pc_fail(ctx, PC_E_NOCONV,
                         "a solve stopped at the relative residual %.3g after %u iterations; asked: %.3g",
                         stats->residual, stats->iterations, tolerance);
done:
    pc_free(ctx, scratch);
    return status;
}
