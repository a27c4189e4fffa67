#include "devsolve.h"
#include "exchange.h"
#include "memory.h"
#include <math.h>
#include <string.h>

extern const char pc_kernel_cycle[];
extern const char pc_kernel_conjugate[];

/* As in conjugate.cl and cycle.cl. */
enum { CHUNK_SLICES = 512, CHUNK = 4096, GROUP = 128 };
enum { SCALAR_PQ = 0, SCALAR_RR = 1, SCALAR_RZ = 2, SCALARS = 4 };
enum { APPLY, ADD, RESIDUAL, SMOOTH };
/* Rows of a level per member from which on it is worth spreading out, by shape. */
static const pc_index worth_rows[2] = {8192, 65536};

typedef struct devlevel {
    pc_row_order order;
    pc_devmat matrix, prolongator, restriction;
    pc_chebyshev chebyshev;
    size_t numbers;                 /* of a vector on the device, without copies */
    pc_buffer *x, *x_other, *d, *b; /* residuals go to x_other */
} devlevel;

/* What one member of a device holds: all of the first levels' rows that are its own (share.h), and the first
 * one the levels below too. Where the device computes alone it is the only one. */
struct pc_devsolve {
    pc_devsolve *next; /* member */
    int number;
    pc_exchange *exchange; /* the first member's too; NULL where there is but one */
    int spread;            /* levels that all have rows of */
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
    pc_buffer *sums; /* the first member's: partial sums of all; `partial` where there is but one */
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

static bool holds(const pc_devsolve *s, int level) {
    return s->number == 0 || level < s->spread;
}

/* Levels that a member has rows or copies of. */
static int levels_of(const pc_devsolve *s) {
    return s->number == 0 || s->spread == s->level_count ? s->level_count : s->spread + 1;
}

/* Room for rows and copies of a level; `b` for the rows that the member restricts, too. */
static pc_status make_level_vectors(pc_devsolve *s, pc_context *ctx, devlevel *level, pc_index made) {
    pc_status status = PC_OK;
    const size_t slice = pc_devmat_slice_rows(s->device);
    const size_t most = level->order.count > made ? level->order.count : made;
    const size_t padded = (level->order.count + slice - 1) / slice * slice;
    const size_t row = (size_t)s->width * sizeof(float);
    level->numbers = padded * (size_t)s->width;
    /* One slice at least: rows without couplings read place 0. */
    const size_t read = padded + level->order.copies > slice ? padded + level->order.copies : slice;
    pc_buffer **vectors[4] = {&level->x, &level->x_other, &level->d, &level->b};
    const size_t rows[4] = {read, read, padded, (most + slice - 1) / slice * slice};
    for (int v = 0; v < 4; v++)
        PC_TRY(pc_buffer_zeroed(vectors[v], ctx, s->device, rows[v] * row));
done:
    return status;
}

static pc_status make_level(pc_devsolve *s, pc_context *ctx, int k, const pc_level *host,
                            const pc_share_rows *next, const pc_system *exact) {
    pc_status status = PC_OK;
    devlevel *level = &s->level[k];
    level->chebyshev = host->chebyshev;
    PC_TRY(
        pc_devmat_make(&level->matrix, ctx, s->device, &host->matrix, &level->order, &level->order, exact));
    if (k + 1 < s->level_count) {
        /* Of the rows below, a member restricts its own, or those that it is told to. */
        const pc_row_order made =
            next && next->made ? (pc_row_order){next->made_count, next->made, NULL, 0} : level[1].order;
        PC_TRY(pc_devmat_make(&level->prolongator, ctx, s->device, &host->prolongator, &level->order,
                              &level[1].order, NULL));
        PC_TRY(pc_devmat_make(&level->restriction, ctx, s->device, &host->restriction, &made, &level->order,
                              NULL));
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
    const size_t copies = (size_t)level->order.copies * (size_t)s->width;
    pc_buffer **vectors[5] = {&s->x, &s->p, &s->b, &s->r, &s->q};
    for (int v = 0; v < 5; v++)
        PC_TRY(pc_buffer_zeroed(vectors[v], ctx, s->device,
                                (level->numbers + (v < 2 ? copies : 0)) * sizeof(double)));
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
    for (pc_devsolve *m = solve; m; m = m->next) {
        for (int k = 0; k < m->level_count && holds(m, k); k++)
            PC_TRY(pc_devmat_set_diagonals(&m->level[k].matrix, ctx, &multigrid->level[k].matrix,
                                           &m->level[k].order));
        PC_TRY(write_diagonal(m, ctx, diagonal));
    }
    if (multigrid->inverse) PC_TRY(pc_buffer_write(solve->direct, ctx, 0, multigrid->inverse, direct));
done:
    return status;
}

static pc_status start_member(pc_devsolve **solve, pc_context *ctx, pc_device *device, pc_block_kind kind,
                              const pc_multigrid *multigrid) {
    pc_devsolve *s = NULL;
    pc_status status = pc_new(solve, ctx, 1);
    if (status != PC_OK) return status;
    s = *solve;
    s->device = device;
    s->shape = pc_device_shape(device);
    s->width = pc_block_width(kind);
    s->level_count = s->spread = multigrid->level_count;
    s->jacobi = multigrid->finest_only;
    s->scale = multigrid->scale;
    return get_kernels(s, ctx, (pc_block_form)kind);
}

static pc_status make_orders(pc_devsolve *s, pc_context *ctx, const pc_multigrid *multigrid) {
    pc_status status = PC_OK;
    for (int k = 0; k < s->level_count; k++)
        PC_TRY(pc_row_order_make(&s->level[k].order, ctx, &multigrid->level[k].matrix));
    if (multigrid->inverse) {
        /* The direct solve knows its level's own order only. */
        pc_row_order *order = &s->level[s->level_count - 1].order;
        s->direct_count = (pc_index)((size_t)order->count * (size_t)s->width);
        for (pc_index i = 0; i < order->count; i++)
            order->row[i] = order->place[i] = i;
    }
done:
    return status;
}

/* Other members get their rows and the first one keeps its own. */
static pc_status spread_out(pc_devsolve *s, pc_context *ctx, pc_device *device, pc_share *share,
                            pc_block_kind kind, const pc_multigrid *multigrid, pc_index least) {
    pc_status status = PC_OK;
    const pc_row_order *whole[PC_MOST_LEVELS];
    pc_devsolve *m = s;
    for (int k = 0; k < s->level_count; k++)
        whole[k] = &s->level[k].order;
    PC_TRY(pc_share_make(share, ctx, multigrid, whole, pc_device_member_count(device),
                         pc_devmat_slice_rows(s->device), least));
    PC_TRY(pc_exchange_make(&s->exchange, ctx, device, share, (size_t)s->width * sizeof(double)));
    for (int number = 0; number < share->member_count; number++) {
        if (number > 0) {
            PC_TRY(start_member(&m->next, ctx, pc_device_member(device, number), kind, multigrid));
            m = m->next;
        }
        m->number = number;
        m->exchange = s->exchange;
        m->spread = share->spread;
        for (int k = 0; k < share->level_count; k++) {
            pc_row_order *own = &pc_share_of(share, k, number)->order;
            pc_row_order_free(&m->level[k].order, ctx);
            m->level[k].order = *own;
            *own = (pc_row_order){0};
        }
    }
done:
    return status;
}

/* One member's part of a level. */
static pc_status fill_level(pc_devsolve *s, pc_context *ctx, int k, const pc_level *host,
                            const pc_share *share, const pc_system *system) {
    pc_status status = PC_OK;
    const bool shared = share->rows != NULL;
    pc_share_rows *rows = shared && k < share->level_count ? pc_share_of(share, k, s->number) : NULL;
    const pc_share_rows *next =
        shared && k + 1 < share->level_count ? pc_share_of(share, k + 1, s->number) : NULL;
    if (k >= levels_of(s)) return PC_OK;
    PC_TRY(make_level_vectors(s, ctx, &s->level[k], rows ? rows->made_count : 0));
    if (holds(s, k)) PC_TRY(make_level(s, ctx, k, host, next, k == 0 ? system : NULL));
    /* Matrices are read by columns; from now on only rows are looked up. */
    pc_free(ctx, s->level[k].order.place);
    s->level[k].order.place = NULL;
done:
    return status;
}

pc_status pc_devsolve_make(pc_devsolve **solve, pc_context *ctx, pc_device *device, const pc_system *system,
                           pc_multigrid *multigrid, pc_index spread_rows) {
    pc_status status = PC_OK;
    pc_devsolve *s = NULL;
    pc_share share = {0};
    const uint64_t members = (uint64_t)pc_device_member_count(device);
    const pc_index least = spread_rows > 0 ? spread_rows : worth_rows[pc_device_shape(device)];
    const bool spread = members > 1 && system->row_count >= members * least;
    *solve = NULL;
    PC_TRY(pc_device_require_doubles(device, ctx, "the solver"));
    PC_TRY(start_member(&s, ctx, spread ? pc_device_member(device, 0) : device, system->kind, multigrid));
    PC_TRY(make_orders(s, ctx, multigrid));
    if (spread) PC_TRY(spread_out(s, ctx, device, &share, system->kind, multigrid, least));
    for (int k = 0; k < s->level_count; k++) {
        for (pc_devsolve *m = s; m; m = m->next)
            PC_TRY(fill_level(m, ctx, k, &multigrid->level[k], &share, system));
        pc_multigrid_free_couplings(multigrid, ctx, k);
    }
    if (multigrid->inverse)
        PC_TRY(pc_buffer_from(&s->direct, ctx, s->device, multigrid->inverse,
                              (size_t)s->direct_count * s->direct_count * sizeof(float)));
    for (pc_devsolve *m = s; m; m = m->next)
        PC_TRY(make_vectors(m, ctx, system));
    if (spread)
        PC_TRY(pc_buffer_zeroed(&s->sums, ctx, s->device,
                                ((size_t)system->row_count * (size_t)s->width / GROUP + GROUP) *
                                    sizeof(double)));
done:
    pc_share_free(&share, ctx);
    if (status == PC_OK)
        *solve = s;
    else
        pc_devsolve_free(s, ctx);
    return status;
}

static void free_member(pc_devsolve *s, pc_context *ctx) {
    for (int k = 0; k < PC_MOST_LEVELS; k++) {
        devlevel *level = &s->level[k];
        pc_row_order_free(&level->order, ctx);
        pc_devmat_free(&level->matrix, ctx);
        pc_devmat_free(&level->prolongator, ctx);
        pc_devmat_free(&level->restriction, ctx);
        pc_buffer *vectors[4] = {level->x, level->x_other, level->d, level->b};
        for (int v = 0; v < 4; v++)
            pc_buffer_free(vectors[v], ctx);
    }
    pc_buffer *buffers[10] = {s->direct, s->diagonal, s->x,       s->b,       s->r,
                              s->p,      s->q,        s->partial, s->scalars, s->sums};
    for (int k = 0; k < 10; k++)
        pc_buffer_free(buffers[k], ctx);
    pc_free(ctx, s);
}

void pc_devsolve_free(pc_devsolve *solve, pc_context *ctx) {
    if (!solve) return;
    pc_exchange_free(solve->exchange, ctx);
    while (solve) {
        pc_devsolve *next = solve->next;
        free_member(solve, ctx);
        solve = next;
    }
}

/* What a product reads and writes; see the modes in cycle.cl. */
typedef struct operands {
    const pc_buffer *y, *x, *b, *d;
    float alpha, beta;
} operands;

static pc_status product_part(pc_devsolve *s, pc_context *ctx, const pc_devmat *m, const pc_devmat_part *part,
                              int mode, const operands *o) {
    const size_t rows = m->slice_rows;
    const size_t entry = rows * ((size_t)pc_form_size(m->form) + 1) * sizeof(float);
    const size_t row = rows * (size_t)s->width * sizeof(float);
    static const int passes[4] = {2, 3, 3, 6};
    size_t per_item = 1;
    size_t items = part->slices * rows;
    if (s->shape == PC_SHAPE_CHUNK) {
        per_item = part->slices / 32;
        per_item = per_item < 1 ? 1 : per_item > 4096 / rows ? 4096 / rows : per_item;
        items = (part->slices + per_item - 1) / per_item;
    }
    double bytes = (double)part->entries * (double)entry + (double)part->slices * passes[mode] * (double)row;
    return pc_kernel_run(ctx, s->cycle, items, s->shape == PC_SHAPE_CHUNK ? 1 : 0, bytes,
                         PC_ARGS(PC_BUF(part->start), PC_BUF(part->column), PC_BUF(part->value),
                                 PC_BUF(m->diagonal ? m->diagonal : o->x),
                                 PC_BUF(m->inverse ? m->inverse : o->x), PC_BUF(o->x),
                                 PC_BUF(o->b ? o->b : o->x), PC_BUF(o->y), PC_BUF(o->d ? o->d : o->y),
                                 PC_U32(part->first), PC_U32(part->slices), PC_U32((uint32_t)per_item),
                                 PC_U32((uint32_t)mode), PC_F32(o->alpha), PC_F32(o->beta)));
}

/* Late launches come after the copies that they read. */
static pc_status wait_for_copies(pc_devsolve *s, pc_context *ctx, bool late) {
    return late && s->exchange ? pc_exchange_finish(s->exchange, ctx, s->number) : PC_OK;
}

/* A product with one member's rows of a level. */
static pc_status product(pc_devsolve *s, pc_context *ctx, const pc_devmat *m, int mode, operands o) {
    pc_status status = PC_OK;
    for (int late = 0; late < 2; late++) {
        PC_TRY(wait_for_copies(s, ctx, late));
        for (int k = 0; k < m->part_count; k++)
            if (m->part[k].late == late) PC_TRY(product_part(s, ctx, m, &m->part[k], mode, &o));
    }
done:
    return status;
}

/* Starts to fill the copies in a vector of a level: x, or the residual in x_other. */
static pc_status exchange(pc_devsolve *s, pc_context *ctx, int k, bool residual) {
    pc_buffer *vector[PC_MOST_MEMBERS];
    size_t first[PC_MOST_MEMBERS];
    const size_t width = (size_t)s->width;
    if (!s->exchange || k > s->spread) return PC_OK;
    for (pc_devsolve *m = s; m; m = m->next) {
        vector[m->number] = residual ? m->level[k].x_other : m->level[k].x;
        first[m->number] = m->level[k].numbers / width;
    }
    return pc_exchange_start(s->exchange, ctx, k, vector, first, width * sizeof(float));
}

/* The next member with rows of a level. */
static pc_devsolve *next_on(pc_devsolve *m, int level) {
    return level < m->spread ? m->next : NULL;
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

static pc_status smooth(pc_devsolve *s, pc_context *ctx, int level, int from) {
    pc_status status = PC_OK;
    for (int k = from; k < PC_SMOOTH_STEPS; k++) {
        PC_TRY(exchange(s, ctx, level, false));
        for (pc_devsolve *m = s; m; m = next_on(m, level)) {
            devlevel *l = &m->level[level];
            PC_TRY(product(
                m, ctx, &l->matrix, SMOOTH,
                (operands){l->x_other, l->x, l->b, l->d, l->chebyshev.alpha[k], l->chebyshev.beta[k]}));
            pc_buffer *x = l->x;
            l->x = l->x_other;
            l->x_other = x;
        }
    }
done:
    return status;
}

/* From x = 0. */
static pc_status smooth_from_zero(pc_devsolve *s, pc_context *ctx, int level) {
    pc_status status = PC_OK;
    for (pc_devsolve *m = s; m; m = next_on(m, level))
        PC_TRY(smooth_first(m, ctx, &m->level[level], m->level[level].chebyshev.beta[0]));
    PC_TRY(smooth(s, ctx, level, 1));
done:
    return status;
}

static pc_status solve_last(pc_devsolve *s, pc_context *ctx) {
    enum { SWEEPS = 4 };
    pc_status status = PC_OK;
    const int last = s->level_count - 1;
    const devlevel *level = &s->level[last];
    const double n = s->direct_count;
    if (s->direct)
        return pc_kernel_run(
            ctx, s->solve_direct, s->direct_count, 0, n * n * sizeof(float),
            PC_ARGS(PC_BUF(s->direct), PC_BUF(level->b), PC_BUF(level->x), PC_U32(s->direct_count)));
    PC_TRY(smooth_from_zero(s, ctx, last));
    for (int sweep = 1; sweep < SWEEPS; sweep++)
        PC_TRY(smooth(s, ctx, last, 0));
done:
    return status;
}

/* The residual of level k becomes the right-hand side of the next one. */
static pc_status restrict_residual(pc_devsolve *s, pc_context *ctx, int k) {
    pc_status status = PC_OK;
    pc_buffer *made[PC_MOST_MEMBERS];
    PC_TRY(exchange(s, ctx, k, false));
    for (pc_devsolve *m = s; m; m = next_on(m, k))
        PC_TRY(product(m, ctx, &m->level[k].matrix, RESIDUAL,
                       (operands){m->level[k].x_other, m->level[k].x, m->level[k].b, NULL, 0, 0}));
    PC_TRY(exchange(s, ctx, k, true));
    for (pc_devsolve *m = s; m; m = next_on(m, k)) {
        made[m->number] = m->level[k + 1].b;
        PC_TRY(product(m, ctx, &m->level[k].restriction, APPLY,
                       (operands){made[m->number], m->level[k].x_other, NULL, NULL, 0, 0}));
    }
    if (s->exchange && k + 1 == s->spread)
        PC_TRY(
            pc_exchange_gather(s->exchange, ctx, s->level[k + 1].b, made, (size_t)s->width * sizeof(float)));
done:
    return status;
}

/* level[0].x = about (scale A)^-1 level[0].b */
static pc_status cycle(pc_devsolve *s, pc_context *ctx) {
    pc_status status = PC_OK;
    const int last = s->level_count - 1;
    if (s->jacobi) {
        for (pc_devsolve *m = s; m; m = m->next)
            PC_TRY(smooth_first(m, ctx, &m->level[0], 1));
        return PC_OK;
    }
    for (int k = 0; k < last; k++) {
        PC_TRY(smooth_from_zero(s, ctx, k));
        PC_TRY(restrict_residual(s, ctx, k));
    }
    PC_TRY(solve_last(s, ctx));
    for (int k = last - 1; k >= 0; k--) {
        if (k < s->spread) PC_TRY(exchange(s, ctx, k + 1, false));
        for (pc_devsolve *m = s; m; m = next_on(m, k))
            PC_TRY(product(m, ctx, &m->level[k].prolongator, ADD,
                           (operands){m->level[k].x, m->level[k + 1].x, NULL, NULL, 0, 0}));
        PC_TRY(smooth(s, ctx, k, 0));
    }
done:
    return status;
}

/* What partial sums are of. */
typedef enum partials { OF_ROWS, OF_NUMBERS } partials;

static size_t partial_count(const pc_devsolve *s, partials of) {
    const bool chunks = s->shape == PC_SHAPE_CHUNK;
    const devlevel *level = &s->level[0];
    const size_t n = of == OF_ROWS ? level->numbers / (size_t)s->width : level->numbers;
    const size_t per = !chunks         ? GROUP
                       : of == OF_ROWS ? CHUNK_SLICES * (size_t)level->matrix.slice_rows
                                       : CHUNK;
    return (n + per - 1) / per;
}

/* Adds the partial sums of all members into a scalar, which all get. */
static pc_status finish(pc_devsolve *s, pc_context *ctx, partials of, int slot) {
    const bool chunks = s->shape == PC_SHAPE_CHUNK;
    pc_status status = PC_OK;
    pc_buffer *partial[PC_MOST_MEMBERS];
    pc_buffer *scalars[PC_MOST_MEMBERS];
    size_t counts[PC_MOST_MEMBERS];
    size_t count = 0;
    for (pc_devsolve *m = s; m; m = m->next) {
        partial[m->number] = m->partial;
        scalars[m->number] = m->scalars;
        counts[m->number] = partial_count(m, of);
        count += counts[m->number];
    }
    if (s->exchange) {
        const size_t per_block =
            (chunks ? 1 : PC_SHARE_BLOCK / GROUP) * (of == OF_ROWS ? 1 : (size_t)s->width);
        PC_TRY(pc_exchange_sums(s->exchange, ctx, s->sums, partial, counts, per_block));
    }
    PC_TRY(pc_kernel_run(ctx, s->finish, chunks ? 1 : GROUP, chunks ? 1 : GROUP,
                         (double)count * sizeof(double),
                         PC_ARGS(PC_BUF(s->exchange ? s->sums : s->partial), PC_BUF(s->scalars),
                                 PC_U32((uint32_t)count), PC_U32((uint32_t)slot))));
    if (s->exchange)
        PC_TRY(pc_exchange_tell(s->exchange, ctx, scalars, (size_t)slot * sizeof(double), sizeof(double)));
done:
    return status;
}

/* q = A v with one member's rows, and partial sums of v.q */
static pc_status outer_part(pc_devsolve *s, pc_context *ctx, const pc_devmat_part *part, const pc_buffer *v) {
    const bool chunks = s->shape == PC_SHAPE_CHUNK;
    const pc_devmat *m = &s->level[0].matrix;
    const size_t entry = m->slice_rows * ((size_t)pc_form_size(m->form) * sizeof(double) + sizeof(pc_index));
    const size_t items = chunks ? (part->slices + CHUNK_SLICES - 1) / CHUNK_SLICES
                                : (m->slice_rows * (size_t)part->slices + GROUP - 1) / GROUP * GROUP;
    double bytes = (double)part->entries * (double)entry +
                   (double)part->slices * m->slice_rows * (2.0 * s->width + 1) * sizeof(double);
    return pc_kernel_run(ctx, s->product, items, chunks ? 1 : GROUP, bytes,
                         PC_ARGS(PC_BUF(part->start), PC_BUF(part->column), PC_BUF(part->exact),
                                 PC_BUF(s->diagonal), PC_BUF(v), PC_BUF(s->q), PC_BUF(s->partial),
                                 PC_U32(part->first), PC_U32(part->slices)));
}

/* q = A p, and p.q; `of_x`: with x for p */
static pc_status outer_product(pc_devsolve *s, pc_context *ctx, bool of_x) {
    pc_status status = PC_OK;
    pc_buffer *vector[PC_MOST_MEMBERS];
    size_t first[PC_MOST_MEMBERS];
    for (pc_devsolve *m = s; m; m = m->next) {
        vector[m->number] = of_x ? m->x : m->p;
        first[m->number] = m->level[0].numbers / (size_t)s->width;
    }
    if (s->exchange)
        PC_TRY(pc_exchange_start(s->exchange, ctx, 0, vector, first, (size_t)s->width * sizeof(double)));
    for (pc_devsolve *m = s; m; m = m->next) {
        const pc_devmat *a = &m->level[0].matrix;
        for (int late = 0; late < 2; late++) {
            PC_TRY(wait_for_copies(m, ctx, late));
            for (int k = 0; k < a->part_count; k++)
                if (a->part[k].late == late) PC_TRY(outer_part(m, ctx, &a->part[k], vector[m->number]));
        }
    }
    PC_TRY(finish(s, ctx, OF_ROWS, SCALAR_PQ));
done:
    return status;
}

/* Runs a vector pass of one member, `words` words of 4 bytes per number. */
static pc_status pass(pc_devsolve *s, pc_context *ctx, pc_kernel *kernel, double words,
                      const pc_argument *arguments, size_t count) {
    const bool chunks = s->shape == PC_SHAPE_CHUNK;
    const size_t groups = partial_count(s, OF_NUMBERS);
    return pc_kernel_run(ctx, kernel, chunks ? groups : groups * GROUP, chunks ? 1 : GROUP,
                         4 * words * (double)s->level[0].numbers, arguments, count);
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
    PC_TRY(outer_product(s, ctx, true));
    for (pc_devsolve *m = s; m; m = m->next)
        PC_TRY(pass(m, ctx, m->begin, 7,
                    PC_ARGS(PC_BUF(m->r), PC_BUF(m->level[0].b), PC_BUF(m->b), PC_BUF(m->q),
                            PC_BUF(m->partial), PC_U32((uint32_t)m->level[0].numbers), PC_F64(1 / unit))));
    PC_TRY(finish(s, ctx, OF_NUMBERS, SCALAR_RR));
    PC_TRY(read_norm(norm, s, ctx));
done:
    return status;
}

/* One iteration; the scalars of alpha and beta stay on the device. */
static pc_status iteration(pc_devsolve *s, pc_context *ctx, pc_index number, double unit) {
    pc_status status = PC_OK;
    const uint32_t slot = SCALAR_RZ + number % 2;
    const double z_scale = unit * s->scale;
    PC_TRY(cycle(s, ctx));
    for (pc_devsolve *m = s; m; m = m->next)
        PC_TRY(pass(m, ctx, m->angle, 3,
                    PC_ARGS(PC_BUF(m->r), PC_BUF(m->level[0].x), PC_BUF(m->partial),
                            PC_U32((uint32_t)m->level[0].numbers), PC_F64(z_scale))));
    PC_TRY(finish(s, ctx, OF_NUMBERS, (int)slot));
    for (pc_devsolve *m = s; m; m = m->next)
        PC_TRY(pass(m, ctx, m->direction, number == 0 ? 3 : 5,
                    PC_ARGS(PC_BUF(m->p), PC_BUF(m->level[0].x), PC_BUF(m->scalars),
                            PC_U32((uint32_t)m->level[0].numbers), PC_U32(slot), PC_U32(number == 0),
                            PC_F64(z_scale))));
    PC_TRY(outer_product(s, ctx, false));
    for (pc_devsolve *m = s; m; m = m->next)
        PC_TRY(pass(m, ctx, m->step, 13,
                    PC_ARGS(PC_BUF(m->x), PC_BUF(m->r), PC_BUF(m->level[0].b), PC_BUF(m->p), PC_BUF(m->q),
                            PC_BUF(m->partial), PC_BUF(m->scalars), PC_U32((uint32_t)m->level[0].numbers),
                            PC_U32(slot), PC_F64(1 / unit))));
    PC_TRY(finish(s, ctx, OF_NUMBERS, SCALAR_RR));
done:
    return status;
}

/* A member's rows of vectors in the user's order, to its own order and back. */
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
    for (pc_index place = 0; place < order->count; place++)
        memcpy(to + w * order->row[place], scratch + w * place, w * sizeof *to);
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
    size_t n = 0;
    for (const pc_devsolve *m = solve; m; m = m->next)
        n += (size_t)m->level[0].order.count * (size_t)m->width;
    for (size_t i = 0; i < n; i++)
        square += b[i] * b[i];
    if (!isfinite(square)) return pc_fail(ctx, PC_E_BUG, "a right-hand side is not finite");
    if (square == 0) {
        memset(x, 0, n * sizeof *x);
        return PC_OK;
    }
    PC_TRY(pc_new(&scratch, ctx, n));
    for (pc_devsolve *m = solve; m; m = m->next) {
        PC_TRY(send(m, ctx, m->b, scratch, b));
        PC_TRY(send(m, ctx, m->x, scratch, x));
    }
    PC_TRY(run(solve, ctx, tolerance, sqrt(square), max_iterations, stats));
    for (pc_devsolve *m = solve; m; m = m->next)
        PC_TRY(fetch(m, ctx, x, scratch, m->x));
    if (!(stats->residual <= tolerance))
        status = pc_fail(ctx, PC_E_NOCONV,
                         "a solve stopped at the relative residual %.3g after %u iterations; asked: %.3g",
                         stats->residual, stats->iterations, tolerance);
done:
    pc_free(ctx, scratch);
    return status;
}
