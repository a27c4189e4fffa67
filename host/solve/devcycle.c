#include "devcycle.h"
#include "memory.h"

extern const char pc_kernel_cycle[];

/* As in cycle.cl. */
enum { APPLY, ADD, RESIDUAL, SMOOTH, SMOOTH_SECOND };
/* Rows of a level per member from which on it is worth spreading out, by shape. */
static const pc_index worth_rows[2] = {8192, 65536};

static pc_status get_kernels(pc_devcycle *s, pc_context *ctx, pc_block_form form) {
    static const char *const products[3] = {"cycle_scalar", "cycle_complex", "cycle_turned"};
    pc_status status = PC_OK;
    PC_TRY(pc_kernel_get(&s->product, ctx, s->device, pc_kernel_cycle, products[form]));
    PC_TRY(pc_kernel_get(&s->first, ctx, s->device, pc_kernel_cycle, "cycle_first"));
    PC_TRY(pc_kernel_get(&s->solve_direct, ctx, s->device, pc_kernel_cycle, "cycle_direct"));
done:
    return status;
}

static bool holds(const pc_devcycle *s, int level) {
    return s->number == 0 || level < s->spread;
}

/* Levels that a member has rows or copies of. */
static int levels_of(const pc_devcycle *s) {
    return s->number == 0 || s->spread == s->level_count ? s->level_count : s->spread + 1;
}

/* Room for rows and copies of a level; `b` for the rows that the member restricts, too. */
static pc_status make_level_vectors(pc_devcycle *s, pc_context *ctx, pc_devlevel *level, pc_index made) {
    pc_status status = PC_OK;
    const size_t slice = pc_devmat_slice_rows(s->device);
    const size_t most = level->order.count > made ? level->order.count : made;
    const size_t padded = (level->order.count + slice - 1) / slice * slice;
    const size_t row = (size_t)s->width * sizeof(float);
    level->numbers = padded * (size_t)s->width;
    /* One slice at least: rows without couplings read place 0. */
    const size_t read = padded + level->order.copies > slice ? padded + level->order.copies : slice;
    pc_buffer **vectors[3] = {&level->x, &level->b, &level->x_other};
    const size_t rows[3] = {read, (most + slice - 1) / slice * slice, read};
    for (int v = 0; v < (level == s->level ? 2 : 3); v++)
        PC_TRY(pc_buffer_zeroed(vectors[v], ctx, s->device, rows[v] * row));
done:
    return status;
}

/* To and from the next level. */
static pc_status make_transfers(pc_devcycle *s, pc_context *ctx, int k, const pc_level *host,
                                const pc_share_rows *next) {
    pc_status status = PC_OK;
    pc_devlevel *level = &s->level[k];
    /* Of the rows below, a member restricts its own, or those that it is told to. */
    const pc_row_order made =
        next && next->made ? (pc_row_order){next->made_count, next->made, NULL, 0} : level[1].order;
    PC_TRY(pc_devmat_make(&level->prolongator, ctx, s->device, &host->prolongator, &level->order,
                          &level[1].order, s->storage));
    PC_TRY(pc_devmat_make(&level->restriction, ctx, s->device, &host->restriction, &made, &level->order,
                          s->storage));
done:
    return status;
}

pc_status pc_devcycle_set_diagonal(pc_devcycle *cycle, pc_context *ctx, const pc_multigrid *multigrid) {
    pc_status status = PC_OK;
    const size_t direct = (size_t)cycle->direct_count * cycle->direct_count * sizeof(float);
    for (pc_devcycle *m = cycle; m; m = m->next)
        for (int k = 0; k < m->level_count && holds(m, k); k++)
            PC_TRY(pc_devmat_set_diagonals(&m->level[k].matrix, ctx, &multigrid->level[k].matrix,
                                           &m->level[k].order));
    if (multigrid->inverse) PC_TRY(pc_buffer_write(cycle->direct, ctx, 0, multigrid->inverse, direct));
done:
    return status;
}

static pc_status start_member(pc_devcycle **cycle, pc_context *ctx, pc_device *device, pc_block_kind kind,
                              const pc_multigrid *multigrid, pc_storage storage) {
    pc_devcycle *s = NULL;
    pc_status status = pc_new(cycle, ctx, 1);
    if (status != PC_OK) return status;
    s = *cycle;
    s->device = device;
    s->shape = pc_device_shape(device);
    s->width = pc_block_width(kind);
    s->level_count = s->spread = multigrid->level_count;
    s->jacobi = multigrid->finest_only;
    s->scale = multigrid->scale;
    s->storage = storage;
    return get_kernels(s, ctx, (pc_block_form)kind);
}

static pc_status make_orders(pc_devcycle *s, pc_context *ctx, const pc_multigrid *multigrid) {
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
static pc_status spread_out(pc_devcycle *s, pc_context *ctx, pc_device *device, pc_share *share,
                            pc_block_kind kind, const pc_multigrid *multigrid, pc_index least) {
    pc_status status = PC_OK;
    const pc_row_order *whole[PC_MOST_LEVELS];
    pc_devcycle *m = s;
    for (int k = 0; k < s->level_count; k++)
        whole[k] = &s->level[k].order;
    PC_TRY(pc_share_make(share, ctx, multigrid, whole, pc_device_member_count(device),
                         pc_devmat_slice_rows(s->device), least));
    PC_TRY(pc_exchange_make(&s->exchange, ctx, device, share, (size_t)s->width * sizeof(double)));
    for (int number = 0; number < share->member_count; number++) {
        if (number > 0) {
            PC_TRY(
                start_member(&m->next, ctx, pc_device_member(device, number), kind, multigrid, s->storage));
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

static pc_share_rows *rows_of(const pc_share *share, int level, int member) {
    return share->rows && level < share->level_count ? pc_share_of(share, level, member) : NULL;
}

/* Matrices of a level on all members. What the host has of it goes as soon as it can. */
static pc_status fill_level(pc_devcycle *s, pc_context *ctx, int k, pc_multigrid *multigrid,
                            const pc_share *share) {
    pc_status status = PC_OK;
    const pc_level *host = &multigrid->level[k];
    for (pc_devcycle *m = s; m && k + 1 < s->level_count; m = m->next)
        if (holds(m, k)) PC_TRY(make_transfers(m, ctx, k, host, rows_of(share, k + 1, m->number)));
    pc_multigrid_free_transfers(multigrid, ctx, k);
    for (pc_devcycle *m = s; m; m = m->next) {
        pc_devlevel *level = &m->level[k];
        level->chebyshev = host->chebyshev;
        if (holds(m, k))
            PC_TRY(pc_devmat_make(&level->matrix, ctx, m->device, &host->matrix, &level->order, &level->order,
                                  m->storage));
    }
    pc_multigrid_free_couplings(multigrid, ctx, k);
done:
    return status;
}

/* From the last level up: the finest, the largest, then finds the others' matrices gone from the host. */
static pc_status fill(pc_devcycle *s, pc_context *ctx, pc_multigrid *multigrid, const pc_share *share) {
    pc_status status = PC_OK;
    if (multigrid->level[0].matrix.borrowed) {
        pc_free(ctx, multigrid->level[0].matrix.value);
        multigrid->level[0].matrix.value = NULL;
    }
    for (int k = s->level_count - 1; k >= 0; k--)
        PC_TRY(fill_level(s, ctx, k, multigrid, share));
    for (pc_devcycle *m = s; m; m = m->next) {
        for (int k = 0; k < levels_of(m); k++) {
            const pc_share_rows *rows = rows_of(share, k, m->number);
            PC_TRY(make_level_vectors(m, ctx, &m->level[k], rows ? rows->made_count : 0));
            /* Matrices are read by columns; from now on only rows are looked up. */
            pc_free(ctx, m->level[k].order.place);
            m->level[k].order.place = NULL;
        }
    }
done:
    return status;
}

pc_status pc_devcycle_make(pc_devcycle **cycle, pc_context *ctx, pc_device *device, const pc_system *system,
                           pc_multigrid *multigrid, const pc_solver_options *options) {
    pc_status status = PC_OK;
    pc_devcycle *s = NULL;
    pc_share share = {0};
    const uint64_t members = (uint64_t)pc_device_member_count(device);
    const pc_index least =
        options->spread_rows > 0 ? options->spread_rows : worth_rows[pc_device_shape(device)];
    const bool spread = members > 1 && system->row_count >= members * least;
    *cycle = NULL;
    PC_TRY(start_member(&s, ctx, spread ? pc_device_member(device, 0) : device, system->kind, multigrid,
                        options->half ? PC_STORE_HALF : PC_STORE_FLOAT));
    PC_TRY(make_orders(s, ctx, multigrid));
    if (spread) PC_TRY(spread_out(s, ctx, device, &share, system->kind, multigrid, least));
    PC_TRY(fill(s, ctx, multigrid, &share));
    if (multigrid->inverse)
        PC_TRY(pc_buffer_from(&s->direct, ctx, s->device, multigrid->inverse,
                              (size_t)s->direct_count * s->direct_count * sizeof(float)));
done:
    pc_share_free(&share, ctx);
    if (status == PC_OK)
        *cycle = s;
    else
        pc_devcycle_free(s, ctx);
    return status;
}

static void free_member(pc_devcycle *s, pc_context *ctx) {
    for (int k = 0; k < PC_MOST_LEVELS; k++) {
        pc_devlevel *level = &s->level[k];
        pc_row_order_free(&level->order, ctx);
        pc_devmat_free(&level->matrix, ctx);
        pc_devmat_free(&level->prolongator, ctx);
        pc_devmat_free(&level->restriction, ctx);
        pc_buffer *vectors[3] = {level->x, level->x_other, level->b};
        for (int v = 0; v < 3; v++)
            if (vectors[v] != level->lent) pc_buffer_free(vectors[v], ctx);
    }
    pc_buffer_free(s->direct, ctx);
    pc_free(ctx, s);
}

void pc_devcycle_free(pc_devcycle *cycle, pc_context *ctx) {
    if (!cycle) return;
    pc_exchange_free(cycle->exchange, ctx);
    while (cycle) {
        pc_devcycle *next = cycle->next;
        free_member(cycle, ctx);
        cycle = next;
    }
}

/* What a product reads and writes; see the modes in cycle.cl. */
typedef struct operands {
    const pc_buffer *y, *x, *b;
    float alpha, beta;
} operands;

/* Vectors that a product reads and writes. */
static int passes(int mode, float alpha) {
    if (mode < SMOOTH) return mode == APPLY ? 2 : 3;
    return mode == SMOOTH && alpha != 0 ? 4 : 3;
}

static pc_status product_part(pc_devcycle *s, pc_context *ctx, const pc_devmat *m, const pc_devmat_part *part,
                              int mode, const operands *o) {
    const size_t rows = m->slice_rows;
    const size_t entry = rows * ((size_t)pc_form_size(m->form) * (m->storage == PC_STORE_HALF ? 2 : 4) +
                                 (part->narrow ? 2 : 4));
    const size_t row = rows * (size_t)s->width * sizeof(float);
    size_t per_item = 1;
    size_t items = part->slices * rows;
    if (s->shape == PC_SHAPE_CHUNK) {
        per_item = part->slices / 32;
        per_item = per_item < 1 ? 1 : per_item > 4096 / rows ? 4096 / rows : per_item;
        items = (part->slices + per_item - 1) / per_item;
    }
    double bytes = (double)part->entries * (double)entry +
                   (double)part->slices * (passes(mode, o->alpha) * (double)row + (double)rows);
    if (mode >= RESIDUAL)
        bytes += (double)part->slices * (double)rows * pc_form_diagonal(m->form) * (double)sizeof(float);
    return pc_kernel_run(ctx, s->product, items, pc_chunk_group(s->device), bytes,
                         PC_ARGS(PC_BUF(part->start), PC_BUF(part->column), PC_BUF(part->value),
                                 PC_BUF(part->exponent), PC_BUF(m->diagonal ? m->diagonal : o->x),
                                 PC_BUF(o->x), PC_BUF(o->b ? o->b : o->x), PC_BUF(o->y), PC_U32(part->first),
                                 PC_U32(part->slices), PC_U32((uint32_t)per_item),
                                 PC_U32(pc_devmat_storage(m, part)), PC_U32((uint32_t)mode), PC_F32(o->alpha),
                                 PC_F32(o->beta)));
}

/* A product with one member's rows of a level. */
static pc_status product(pc_devcycle *s, pc_context *ctx, const pc_devmat *m, int mode, operands o) {
    pc_status status = PC_OK;
    for (int late = 0; late < 2; late++) {
        if (late && s->exchange) PC_TRY(pc_exchange_finish(s->exchange, ctx, s->number));
        for (int k = 0; k < m->part_count; k++)
            if (m->part[k].late == late) PC_TRY(product_part(s, ctx, m, &m->part[k], mode, &o));
    }
done:
    return status;
}

/* Starts to fill the copies in a vector of a level (x, or the residual in x_other). */
static pc_status exchange(pc_devcycle *s, pc_context *ctx, int k, bool residual) {
    pc_buffer *vector[PC_MOST_MEMBERS];
    size_t first[PC_MOST_MEMBERS];
    const size_t width = (size_t)s->width;
    if (!s->exchange) return PC_OK;
    for (pc_devcycle *m = s; m; m = m->next) {
        vector[m->number] = residual ? m->level[k].x_other : m->level[k].x;
        first[m->number] = m->level[k].numbers / width;
    }
    return pc_exchange_start(s->exchange, ctx, k, vector, first, width * sizeof(float));
}

/* The next member with rows of a level. */
static pc_devcycle *next_on(pc_devcycle *m, int level) {
    return level < m->spread ? m->next : NULL;
}

static pc_status smooth_first(pc_devcycle *s, pc_context *ctx, const pc_devlevel *level, float beta) {
    const size_t rows = pc_devmat_padded(&level->matrix);
    const size_t per_item = s->shape == PC_SHAPE_CHUNK ? 2048 : 1;
    return pc_kernel_run(
        ctx, s->first, (rows + per_item - 1) / per_item, pc_chunk_group(s->device),
        (double)rows * (2.0 * s->width + pc_form_diagonal(level->matrix.form)) * sizeof(float),
        PC_ARGS(PC_BUF(level->matrix.diagonal), PC_BUF(level->b), PC_BUF(level->x), PC_U32((uint32_t)rows),
                PC_U32((uint32_t)s->width), PC_U32((uint32_t)per_item), PC_F32(beta)));
}

/* Steps after the first one, which left what it did in x, or all of them. */
static pc_status smooth(pc_devcycle *s, pc_context *ctx, int level, bool after_first) {
    pc_status status = PC_OK;
    for (int k = after_first; k < PC_SMOOTH_STEPS; k++) {
        const int mode = after_first && k == 1 ? SMOOTH_SECOND : SMOOTH;
        if (level < s->spread) PC_TRY(exchange(s, ctx, level, false));
        for (pc_devcycle *m = s; m; m = next_on(m, level)) {
            pc_devlevel *l = &m->level[level];
            PC_TRY(product(m, ctx, &l->matrix, mode,
                           (operands){l->x_other, l->x, l->b, l->chebyshev.alpha[k], l->chebyshev.beta[k]}));
            pc_buffer *x = l->x;
            l->x = l->x_other;
            l->x_other = x;
        }
    }
done:
    return status;
}

/* From x = 0. */
static pc_status smooth_from_zero(pc_devcycle *s, pc_context *ctx, int level) {
    pc_status status = PC_OK;
    for (pc_devcycle *m = s; m; m = next_on(m, level))
        PC_TRY(smooth_first(m, ctx, &m->level[level], m->level[level].chebyshev.beta[0]));
    PC_TRY(smooth(s, ctx, level, true));
done:
    return status;
}

static pc_status solve_last(pc_devcycle *s, pc_context *ctx) {
    enum { SWEEPS = 4 };
    pc_status status = PC_OK;
    const int last = s->level_count - 1;
    const pc_devlevel *level = &s->level[last];
    const double n = s->direct_count;
    if (s->direct)
        return pc_kernel_run(
            ctx, s->solve_direct, s->direct_count, 0, n * n * sizeof(float),
            PC_ARGS(PC_BUF(s->direct), PC_BUF(level->b), PC_BUF(level->x), PC_U32(s->direct_count)));
    PC_TRY(smooth_from_zero(s, ctx, last));
    for (int sweep = 1; sweep < SWEEPS; sweep++)
        PC_TRY(smooth(s, ctx, last, false));
done:
    return status;
}

/* The residual of level k becomes the right-hand side of the next one. */
static pc_status restrict_residual(pc_devcycle *s, pc_context *ctx, int k) {
    pc_status status = PC_OK;
    pc_buffer *made[PC_MOST_MEMBERS];
    if (k < s->spread) PC_TRY(exchange(s, ctx, k, false));
    for (pc_devcycle *m = s; m; m = next_on(m, k))
        PC_TRY(product(m, ctx, &m->level[k].matrix, RESIDUAL,
                       (operands){m->level[k].x_other, m->level[k].x, m->level[k].b, 0, 0}));
    if (k < s->spread) PC_TRY(exchange(s, ctx, k, true));
    for (pc_devcycle *m = s; m; m = next_on(m, k)) {
        made[m->number] = m->level[k + 1].b;
        PC_TRY(product(m, ctx, &m->level[k].restriction, APPLY,
                       (operands){made[m->number], m->level[k].x_other, NULL, 0, 0}));
    }
    if (s->exchange && k + 1 == s->spread)
        PC_TRY(
            pc_exchange_gather(s->exchange, ctx, s->level[k + 1].b, made, (size_t)s->width * sizeof(float)));
done:
    return status;
}

pc_status pc_devcycle_run(pc_devcycle *cycle, pc_context *ctx) {
    pc_devcycle *s = cycle;
    pc_status status = PC_OK;
    const int last = s->level_count - 1;
    if (s->jacobi) {
        for (pc_devcycle *m = s; m; m = m->next)
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
        for (pc_devcycle *m = s; m; m = next_on(m, k))
            PC_TRY(product(m, ctx, &m->level[k].prolongator, ADD,
                           (operands){m->level[k].x, m->level[k + 1].x, NULL, 0, 0}));
        PC_TRY(smooth(s, ctx, k, false));
    }
done:
    return status;
}
