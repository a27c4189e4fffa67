#include "devsolve.h"
#include "devcycle.h"
#include "memory.h"
#include <math.h>
#include <string.h>

extern const char pc_kernel_conjugate[];

/* As in conjugate.cl. */
enum { CHUNK_SLICES = 512, CHUNK = 4096, GROUP = 128 };
enum { SCALAR_PQ = 0, SCALAR_RR = 1, SCALAR_RZ = 2, SCALARS = 4 };

/* What one member of a device holds; where the device computes alone it is the only one. */
struct pc_devsolve {
    pc_devsolve *next;  /* member */
    pc_devcycle *cycle; /* its own part */
    const pc_devlevel *finest;
    /* In doubles but for p and low. The cycle's b is the high part of the residual; q is one of its two x,
     * which may hold its answer until q is made. */
    pc_buffer *diagonal; /* scaled as the hierarchy is, as is what q gets */
    pc_buffer *x, *low, *p, *q, *partial, *scalars;
    pc_buffer *sums; /* the first member's: partial sums of all; NULL where there is but one */
    pc_kernel *product, *begin, *step, *angle, *direction, *finish;
};

static pc_status get_kernels(pc_devsolve *s, pc_context *ctx, pc_block_form form) {
    static const char *const product[3] = {"conjugate_scalar", "conjugate_complex", "conjugate_turned"};
    const struct {
        pc_kernel **kernel;
        const char *name;
    } wanted[] = {
        {&s->product, product[form]},           {&s->begin, "conjugate_begin"},
        {&s->step, "conjugate_step"},           {&s->angle, "conjugate_angle"},
        {&s->direction, "conjugate_direction"}, {&s->finish, "conjugate_finish"},
    };
    pc_status status = PC_OK;
    for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++)
        PC_TRY(pc_kernel_get(wanted[k].kernel, ctx, s->cycle->device, pc_kernel_conjugate, wanted[k].name));
done:
    return status;
}

static pc_status write_diagonal(pc_devsolve *s, pc_context *ctx, const double *diagonal) {
    const pc_row_order *order = &s->finest->order;
    double *space = NULL;
    pc_status status = pc_new(&space, ctx, order->count);
    if (status != PC_OK) return status;
#pragma omp parallel for schedule(static)
    for (pc_index place = 0; place < order->count; place++)
        space[place] = s->cycle->scale * diagonal[order->row[place]];
    status = pc_buffer_write(s->diagonal, ctx, 0, space, order->count * sizeof *space);
    pc_free(ctx, space);
    return status;
}

/* The vectors of conjugate gradients, the diagonal, and room for partial sums. */
static pc_status make_vectors(pc_devsolve *s, pc_context *ctx, const pc_system *system) {
    pc_status status = PC_OK;
    const pc_devlevel *level = s->finest;
    const size_t padded = pc_devmat_padded(&level->matrix);
    const size_t copies = (size_t)level->order.copies * (size_t)s->cycle->width;
    const size_t n = level->numbers;
    PC_TRY(pc_buffer_zeroed(&s->x, ctx, s->cycle->device, (n + copies) * sizeof(double)));
    PC_TRY(pc_buffer_zeroed(&s->p, ctx, s->cycle->device, (n + copies) * sizeof(float)));
    const size_t least = (n + copies) * sizeof(float);
    PC_TRY(pc_buffer_zeroed(&s->q, ctx, s->cycle->device,
                            n * sizeof(double) > least ? n * sizeof(double) : least));
    PC_TRY(pc_buffer_zeroed(&s->low, ctx, s->cycle->device, n * sizeof(float)));
    s->cycle->level[0].x_other = s->cycle->level[0].lent = s->q;
    PC_TRY(
        pc_buffer_zeroed(&s->partial, ctx, s->cycle->device, (level->numbers / GROUP + 1) * sizeof(double)));
    PC_TRY(pc_buffer_zeroed(&s->scalars, ctx, s->cycle->device, SCALARS * sizeof(double)));
    PC_TRY(pc_buffer_zeroed(&s->diagonal, ctx, s->cycle->device, padded * sizeof(double)));
    PC_TRY(write_diagonal(s, ctx, system->diagonal));
done:
    return status;
}

pc_status pc_devsolve_set_diagonal(pc_devsolve *solve, pc_context *ctx, const double *diagonal,
                                   const pc_multigrid *multigrid) {
    pc_status status = PC_OK;
    PC_TRY(pc_devcycle_set_diagonal(solve->cycle, ctx, multigrid));
    for (pc_devsolve *m = solve; m; m = m->next)
        PC_TRY(write_diagonal(m, ctx, diagonal));
done:
    return status;
}

static pc_status make_member(pc_devsolve **solve, pc_context *ctx, pc_devcycle *cycle,
                             const pc_system *system) {
    pc_status status = pc_new(solve, ctx, 1);
    if (status != PC_OK) return status;
    (*solve)->cycle = cycle;
    (*solve)->finest = &cycle->level[0];
    PC_TRY(get_kernels(*solve, ctx, (pc_block_form)system->kind));
    PC_TRY(make_vectors(*solve, ctx, system));
done:
    return status;
}

pc_status pc_devsolve_make(pc_devsolve **solve, pc_context *ctx, pc_device *device, const pc_system *system,
                           pc_multigrid *multigrid, const pc_solver_options *options) {
    pc_status status = PC_OK;
    pc_devcycle *cycle = NULL;
    pc_devsolve *s = NULL;
    pc_devsolve **last = &s;
    size_t groups = 0;
    *solve = NULL;
    PC_TRY(pc_device_require_doubles(device, ctx, "the solver"));
    PC_TRY(pc_devcycle_make(&cycle, ctx, device, system, multigrid, options));
    for (pc_devcycle *m = cycle; m; m = m->next) {
        PC_TRY(make_member(last, ctx, m, system));
        groups += (*last)->finest->numbers / GROUP + 1;
        last = &(*last)->next;
    }
    if (s && s->next) PC_TRY(pc_buffer_zeroed(&s->sums, ctx, s->cycle->device, groups * sizeof(double)));
done:
    if (status == PC_OK) {
        *solve = s;
    } else {
        if (!s) pc_devcycle_free(cycle, ctx);
        pc_devsolve_free(s, ctx);
    }
    return status;
}

void pc_devsolve_free(pc_devsolve *solve, pc_context *ctx) {
    if (!solve) return;
    pc_devcycle_free(solve->cycle, ctx);
    while (solve) {
        pc_devsolve *next = solve->next;
        pc_buffer *buffers[8] = {solve->diagonal, solve->x,       solve->low,     solve->p,
                                 solve->q,        solve->partial, solve->scalars, solve->sums};
        for (int k = 0; k < 8; k++)
            pc_buffer_free(buffers[k], ctx);
        pc_free(ctx, solve);
        solve = next;
    }
}

/* What partial sums are of. */
typedef enum partials { OF_ROWS, OF_NUMBERS } partials;

static size_t partial_count(const pc_devsolve *s, partials of) {
    const bool chunks = s->cycle->shape == PC_SHAPE_CHUNK;
    const pc_devlevel *level = s->finest;
    const size_t n = of == OF_ROWS ? level->numbers / (size_t)s->cycle->width : level->numbers;
    const size_t per = !chunks         ? GROUP
                       : of == OF_ROWS ? CHUNK_SLICES * (size_t)level->matrix.slice_rows
                                       : CHUNK;
    return (n + per - 1) / per;
}

/* Adds the partial sums of all members into a scalar, which all get. */
static pc_status finish(pc_devsolve *s, pc_context *ctx, partials of, int slot) {
    const bool chunks = s->cycle->shape == PC_SHAPE_CHUNK;
    pc_exchange *exchange = s->cycle->exchange;
    const size_t per_row = of == OF_ROWS ? 1 : (size_t)s->cycle->width;
    pc_status status = PC_OK;
    pc_buffer *partial[PC_MOST_MEMBERS];
    pc_buffer *scalars[PC_MOST_MEMBERS];
    size_t counts[PC_MOST_MEMBERS];
    size_t count = 0;
    for (pc_devsolve *m = s; m; m = m->next) {
        partial[m->cycle->number] = m->partial;
        scalars[m->cycle->number] = m->scalars;
        counts[m->cycle->number] = partial_count(m, of);
        count += counts[m->cycle->number];
    }
    if (exchange)
        PC_TRY(pc_exchange_sums(exchange, ctx, s->sums, partial, counts,
                                per_row * (chunks ? 1 : PC_SHARE_BLOCK / GROUP)));
    PC_TRY(pc_kernel_run(ctx, s->finish, chunks ? 1 : GROUP, chunks ? 1 : GROUP,
                         (double)count * sizeof(double),
                         PC_ARGS(PC_BUF(exchange ? s->sums : s->partial), PC_BUF(s->scalars),
                                 PC_U32((uint32_t)count), PC_U32((uint32_t)slot))));
    if (exchange)
        PC_TRY(pc_exchange_tell(exchange, ctx, scalars, (size_t)slot * sizeof(double), sizeof(double)));
done:
    return status;
}

/* q = A v with one member's rows, and partial sums of v.q */
static pc_status outer_part(pc_devsolve *s, pc_context *ctx, const pc_devmat_part *part, const pc_buffer *v,
                            bool wide) {
    const bool chunks = s->cycle->shape == PC_SHAPE_CHUNK;
    const pc_devmat *m = &s->finest->matrix;
    const size_t entry =
        m->slice_rows * ((size_t)pc_form_size(m->form) * sizeof(double) + (part->narrow ? 2 : 4));
    const size_t items = chunks ? (part->slices + CHUNK_SLICES - 1) / CHUNK_SLICES
                                : (m->slice_rows * (size_t)part->slices + GROUP - 1) / GROUP * GROUP;
    double bytes = (double)part->entries * (double)entry + (double)part->slices * m->slice_rows *
                                                               ((wide ? 2.0 : 1.5) * s->cycle->width + 1) *
                                                               sizeof(double);
    return pc_kernel_run(ctx, s->product, items, chunks ? 1 : GROUP, bytes,
                         PC_ARGS(PC_BUF(part->start), PC_BUF(part->column), PC_BUF(part->value),
                                 PC_BUF(part->rest), PC_BUF(part->last ? part->last : part->rest),
                                 PC_BUF(part->exponent), PC_BUF(s->diagonal), PC_BUF(v), PC_BUF(s->q),
                                 PC_BUF(s->partial), PC_U32(part->first), PC_U32(part->slices),
                                 PC_U32(pc_devmat_storage(m, part)), PC_U32(wide)));
}

/* q = A p, and p.q; `of_x`: with x for p */
static pc_status outer_product(pc_devsolve *s, pc_context *ctx, bool of_x) {
    pc_status status = PC_OK;
    pc_exchange *exchange = s->cycle->exchange;
    const size_t width = (size_t)s->cycle->width;
    pc_buffer *vector[PC_MOST_MEMBERS];
    size_t first[PC_MOST_MEMBERS];
    for (pc_devsolve *m = s; m; m = m->next) {
        vector[m->cycle->number] = of_x ? m->x : m->p;
        first[m->cycle->number] = m->finest->numbers / width;
    }
    if (exchange)
        PC_TRY(pc_exchange_start(exchange, ctx, 0, vector, first,
                                 width * (of_x ? sizeof(double) : sizeof(float))));
    for (pc_devsolve *m = s; m; m = m->next) {
        const pc_devmat *a = &m->finest->matrix;
        for (int late = 0; late < 2; late++) {
            if (late && exchange) PC_TRY(pc_exchange_finish(exchange, ctx, m->cycle->number));
            for (int k = 0; k < a->part_count; k++)
                if (a->part[k].late == late)
                    PC_TRY(outer_part(m, ctx, &a->part[k], vector[m->cycle->number], of_x));
        }
    }
    PC_TRY(finish(s, ctx, OF_ROWS, SCALAR_PQ));
done:
    return status;
}

/* Runs a vector pass of one member, `words` words of 4 bytes per number. */
static pc_status pass(pc_devsolve *s, pc_context *ctx, pc_kernel *kernel, double words,
                      const pc_argument *arguments, size_t count) {
    const bool chunks = s->cycle->shape == PC_SHAPE_CHUNK;
    const size_t groups = partial_count(s, OF_NUMBERS);
    return pc_kernel_run(ctx, kernel, chunks ? groups : groups * GROUP, chunks ? 1 : GROUP,
                         4 * words * (double)s->finest->numbers, arguments, count);
}

static pc_status read_norm(double *norm, pc_devsolve *s, pc_context *ctx) {
    double square = 0;
    pc_status status = pc_buffer_read(&square, ctx, s->scalars, SCALAR_RR * sizeof square, sizeof square);
    *norm = sqrt(square);
    return status;
}

/* Rows that go over at a time. */
enum { SENT_ROWS = 1 << 15 };

/* A member's rows of a vector in the user's order, to its own order. */
static pc_status send(pc_devsolve *s, pc_context *ctx, const pc_buffer *to, double *space,
                      const double *from) {
    const size_t w = (size_t)s->cycle->width;
    const pc_row_order *order = &s->finest->order;
    pc_status status = PC_OK;
    for (pc_index at = 0; at < order->count; at += SENT_ROWS) {
        const pc_index count = order->count - at < SENT_ROWS ? order->count - at : SENT_ROWS;
#pragma omp parallel for schedule(static)
        for (pc_index k = 0; k < count; k++)
            memcpy(space + w * k, from + w * order->row[at + k], w * sizeof *from);
        PC_TRY(pc_buffer_write(to, ctx, w * at * sizeof *from, space, w * count * sizeof *from));
    }
done:
    return status;
}

/* And back. */
static pc_status fetch(pc_devsolve *s, pc_context *ctx, double *to, double *space, const pc_buffer *from) {
    const size_t w = (size_t)s->cycle->width;
    const pc_row_order *order = &s->finest->order;
    pc_status status = PC_OK;
    for (pc_index at = 0; at < order->count; at += SENT_ROWS) {
        const pc_index count = order->count - at < SENT_ROWS ? order->count - at : SENT_ROWS;
        PC_TRY(pc_buffer_read(space, ctx, from, w * at * sizeof *to, w * count * sizeof *to));
#pragma omp parallel for schedule(static)
        for (pc_index k = 0; k < count; k++)
            memcpy(to + w * order->row[at + k], space + w * k, w * sizeof *to);
    }
done:
    return status;
}

/* A step towards r = b - A x, what q holds taken `scale` times; sums of r.r. */
static pc_status add_to_residual(pc_devsolve *s, pc_context *ctx, bool at_start, double scale) {
    pc_status status = PC_OK;
    for (pc_devsolve *m = s; m; m = m->next)
        PC_TRY(pass(m, ctx, m->begin, at_start ? 4 : 6,
                    PC_ARGS(PC_BUF(m->finest->b), PC_BUF(m->low), PC_BUF(m->q), PC_BUF(m->partial),
                            PC_U32((uint32_t)m->finest->numbers), PC_U32(at_start), PC_F64(scale))));
done:
    return status;
}

/* r = b - A x in units of `unit`, and its norm. */
static pc_status begin(pc_devsolve *s, pc_context *ctx, double *norm, const double *b, double *space,
                       double unit) {
    pc_status status = PC_OK;
    for (pc_devsolve *m = s; m; m = m->next)
        PC_TRY(send(m, ctx, m->q, space, b));
    PC_TRY(add_to_residual(s, ctx, true, 1 / unit));
    PC_TRY(outer_product(s, ctx, true));
    PC_TRY(add_to_residual(s, ctx, false, 1 / (unit * s->cycle->scale)));
    PC_TRY(finish(s, ctx, OF_NUMBERS, SCALAR_RR));
    PC_TRY(read_norm(norm, s, ctx));
    *norm *= unit;
done:
    return status;
}

/* One iteration; the scalars of alpha and beta stay on the device. */
static pc_status iteration(pc_devsolve *s, pc_context *ctx, pc_index number, double unit) {
    pc_status status = PC_OK;
    const uint32_t slot = SCALAR_RZ + number % 2;
    PC_TRY(pc_devcycle_run(s->cycle, ctx));
    for (pc_devsolve *m = s; m; m = m->next)
        PC_TRY(pass(m, ctx, m->angle, 2,
                    PC_ARGS(PC_BUF(m->finest->b), PC_BUF(m->finest->x), PC_BUF(m->partial),
                            PC_U32((uint32_t)m->finest->numbers))));
    PC_TRY(finish(s, ctx, OF_NUMBERS, (int)slot));
    for (pc_devsolve *m = s; m; m = m->next)
        PC_TRY(pass(m, ctx, m->direction, number == 0 ? 2 : 3,
                    PC_ARGS(PC_BUF(m->p), PC_BUF(m->finest->x), PC_BUF(m->scalars),
                            PC_U32((uint32_t)m->finest->numbers), PC_U32(slot), PC_U32(number == 0))));
    PC_TRY(outer_product(s, ctx, false));
    for (pc_devsolve *m = s; m; m = m->next)
        PC_TRY(pass(m, ctx, m->step, 11,
                    PC_ARGS(PC_BUF(m->x), PC_BUF(m->finest->b), PC_BUF(m->low), PC_BUF(m->p), PC_BUF(m->q),
                            PC_BUF(m->partial), PC_BUF(m->scalars), PC_U32((uint32_t)m->finest->numbers),
                            PC_U32(slot), PC_F64(unit * s->cycle->scale))));
    PC_TRY(finish(s, ctx, OF_NUMBERS, SCALAR_RR));
done:
    return status;
}

/* Iterates until |r| <= goal; the true residual is found anew at each restart. */
static pc_status run(pc_devsolve *s, pc_context *ctx, const double *b, double *space, double tolerance,
                     double b_norm, pc_index max_iterations, pc_solver_stats *stats) {
    enum { RESTARTS = 5 };
    pc_status status = PC_OK;
    for (int restart = 0; restart < RESTARTS; restart++) {
        double norm = 0;
        /* The unit only has to be of the residual's size: floats are happy over many decades. */
        PC_TRY(begin(s, ctx, &norm, b, space, b_norm));
        double unit = norm;
        stats->residual = norm / b_norm;
        if (stats->residual <= tolerance || stats->iterations >= max_iterations) break;
        if (unit < 1e-3 * b_norm || unit > 1e3 * b_norm)
            PC_TRY(begin(s, ctx, &norm, b, space, unit));
        else
            unit = b_norm;
        for (pc_index k = 0; norm > tolerance * b_norm && stats->iterations < max_iterations; k++) {
            PC_TRY(pc_check_interrupt(ctx));
            PC_TRY(iteration(s, ctx, k, unit));
            PC_TRY(read_norm(&norm, s, ctx));
            norm *= unit;
            stats->iterations++;
            if (!isfinite(norm))
                return pc_fail(ctx, PC_E_NOCONV, "a solve broke down on '%s'",
                               pc_device_name(s->cycle->device));
        }
    }
done:
    return status;
}

pc_status pc_devsolve_run(pc_devsolve *solve, pc_context *ctx, double *x, const double *b, double tolerance,
                          pc_index max_iterations, pc_solver_stats *stats) {
    pc_status status = PC_OK;
    double *space = NULL;
    double square = 0;
    const size_t width = (size_t)solve->cycle->width;
    size_t n = 0;
    for (const pc_devsolve *m = solve; m; m = m->next)
        n += m->finest->order.count * width;
    for (size_t i = 0; i < n; i++)
        square += b[i] * b[i];
    if (!isfinite(square)) return pc_fail(ctx, PC_E_BUG, "a right-hand side is not finite");
    if (square == 0) {
        memset(x, 0, n * sizeof *x);
        return PC_OK;
    }
    PC_TRY(pc_new(&space, ctx, SENT_ROWS * (size_t)solve->cycle->width));
    for (pc_devsolve *m = solve; m; m = m->next)
        PC_TRY(send(m, ctx, m->x, space, x));
    PC_TRY(run(solve, ctx, b, space, tolerance, sqrt(square), max_iterations, stats));
    for (pc_devsolve *m = solve; m; m = m->next)
        PC_TRY(fetch(m, ctx, x, space, m->x));
    if (!(stats->residual <= tolerance))
        status = pc_fail(ctx, PC_E_NOCONV,
                         "a solve stopped at the relative residual %.3g after %u iterations; asked: %.3g",
                         stats->residual, stats->iterations, tolerance);
done:
    pc_free(ctx, space);
    return status;
}
