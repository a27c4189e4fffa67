#include "threefold_device.h"
#include "devmat.h"
#include "memory.h"
#include "multigrid.h"
#include <math.h>

extern const char pc_kernel_threefold[];

/* As in threefold.cl. */
enum { CHUNK_SLICES = 64, CHUNK_ROWS = 512, GROUP = 128, LANES = 4 };
enum { SLOT_DOT = 0, SLOT_SQUARE = 1, SLOT_ANGLE = 2, SLOT_GOAL = 4, SLOTS = 5 };

struct pc_threefold_device {
    pc_device *device;
    bool chunks;
    pc_row_order order;
    pc_devmat matrix;
    size_t rows; /* with padding */
    pc_buffer *diagonal, *x, *b, *r, *p, *q, *partial, *scalars;
    pc_kernel *product, *begin, *step, *turn, *finish;
};

static pc_status get_kernels(pc_threefold_device *s, pc_context *ctx) {
    const struct {
        pc_kernel **kernel;
        const char *name;
    } wanted[] = {{&s->product, "threefold_product"},
                  {&s->begin, "threefold_begin"},
                  {&s->step, "threefold_step"},
                  {&s->turn, "threefold_turn"},
                  {&s->finish, "threefold_finish"}};
    pc_status status = PC_OK;
    for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++)
        PC_TRY(pc_kernel_get(wanted[k].kernel, ctx, s->device, pc_kernel_threefold, wanted[k].name));
done:
    return status;
}

static pc_status make_vectors(pc_threefold_device *s, pc_context *ctx, const pc_system *system) {
    pc_status status = PC_OK;
    double *diagonal = NULL;
    pc_buffer **vectors[5] = {&s->x, &s->b, &s->r, &s->p, &s->q};
    for (int v = 0; v < 5; v++)
        PC_TRY(pc_buffer_zeroed(vectors[v], ctx, s->device, LANES * s->rows * sizeof(double)));
    PC_TRY(pc_buffer_zeroed(&s->partial, ctx, s->device, 2 * LANES * (s->rows / GROUP + 1) * sizeof(double)));
    PC_TRY(pc_buffer_zeroed(&s->scalars, ctx, s->device, SLOTS * LANES * sizeof(double)));
    PC_TRY(pc_new(&diagonal, ctx, s->rows));
    for (size_t place = 0; place < s->rows; place++)
        diagonal[place] = place < s->order.count ? system->diagonal[s->order.row[place]] : 1;
    PC_TRY(pc_buffer_from(&s->diagonal, ctx, s->device, diagonal, s->rows * sizeof *diagonal));
done:
    pc_free(ctx, diagonal);
    return status;
}

pc_status pc_threefold_device_make(pc_threefold_device **solver, pc_context *ctx, pc_device *device,
                                   const pc_system *system) {
    pc_status status = PC_OK;
    pc_threefold_device *s = NULL;
    pc_multigrid finest = {0};
    *solver = NULL;
    PC_TRY(pc_device_require_doubles(device, ctx, "the fit of a surface"));
    PC_TRY(pc_new(&s, ctx, 1));
    s->device = device;
    s->chunks = pc_device_shape(device) == PC_SHAPE_CHUNK;
    PC_TRY(get_kernels(s, ctx));
    PC_TRY(pc_multigrid_make_finest(&finest, ctx, system));
    const pc_blockmat *matrix = &finest.level[0].matrix;
    PC_TRY(pc_row_order_make(&s->order, ctx, matrix));
    PC_TRY(pc_devmat_make(&s->matrix, ctx, device, matrix, &s->order, &s->order, PC_STORE_DOUBLE));
    s->rows = pc_devmat_padded(&s->matrix);
    PC_TRY(make_vectors(s, ctx, system));
    *solver = s;
    s = NULL;
done:
    pc_multigrid_free(&finest, ctx);
    pc_threefold_device_free(s, ctx);
    return status;
}

void pc_threefold_device_free(pc_threefold_device *solver, pc_context *ctx) {
    if (!solver) return;
    pc_buffer *all[] = {solver->diagonal, solver->x, solver->b,       solver->r,
                        solver->p,        solver->q, solver->partial, solver->scalars};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++)
        pc_buffer_free(all[k], ctx);
    pc_devmat_free(&solver->matrix, ctx);
    pc_row_order_free(&solver->order, ctx);
    pc_free(ctx, solver);
}

/* Adds `count` pairs of partial sums into the scalars at `slot` and `second`. */
static pc_status finish(pc_threefold_device *s, pc_context *ctx, size_t count, int slot, int second) {
    return pc_kernel_run(ctx, s->finish, s->chunks ? 1 : GROUP, s->chunks ? 1 : GROUP,
                         (double)count * 2 * LANES * sizeof(double),
                         PC_ARGS(PC_BUF(s->partial), PC_BUF(s->scalars), PC_U32((uint32_t)count),
                                 PC_U32((uint32_t)slot), PC_U32((uint32_t)second)));
}

/* q = A p; sums of p.q */
static pc_status multiply(pc_threefold_device *s, pc_context *ctx, const pc_buffer *p) {
    pc_status status = PC_OK;
    const pc_devmat *m = &s->matrix;
    for (int k = 0; k < m->part_count; k++) {
        const pc_devmat_part *part = &m->part[k];
        const size_t rows = (size_t)m->slice_rows * part->slices;
        const size_t items =
            s->chunks ? (part->slices + CHUNK_SLICES - 1) / CHUNK_SLICES : (rows + GROUP - 1) / GROUP * GROUP;
        const double bytes = (double)part->entries * (double)m->slice_rows * 12 + (double)rows * 9 * 8;
        PC_TRY(pc_kernel_run(ctx, s->product, items, s->chunks ? 1 : GROUP, bytes,
                             PC_ARGS(PC_BUF(part->start), PC_BUF(part->column), PC_BUF(part->value),
                                     PC_BUF(s->diagonal), PC_BUF(p), PC_BUF(s->q), PC_BUF(s->partial),
                                     PC_U32(part->first), PC_U32(part->slices))));
    }
    const size_t count =
        s->chunks ? (m->slice_count + CHUNK_SLICES - 1) / CHUNK_SLICES : (s->rows + GROUP - 1) / GROUP;
    PC_TRY(finish(s, ctx, count, SLOT_DOT, SLOT_DOT));
done:
    return status;
}

/* A pass over the vectors, `numbers` doubles per row. */
static pc_status pass(pc_threefold_device *s, pc_context *ctx, pc_kernel *kernel, double numbers,
                      const pc_argument *arguments, size_t count) {
    const size_t per = s->chunks ? CHUNK_ROWS : GROUP, parts = (s->rows + per - 1) / per;
    return pc_kernel_run(ctx, kernel, s->chunks ? parts : parts * GROUP, s->chunks ? 1 : GROUP,
                         8 * numbers * (double)s->rows, arguments, count);
}

static size_t pass_parts(const pc_threefold_device *s) {
    const size_t per = s->chunks ? CHUNK_ROWS : GROUP;
    return (s->rows + per - 1) / per;
}

static pc_status read_square(double square[LANES], pc_threefold_device *s, pc_context *ctx) {
    return pc_buffer_read(square, ctx, s->scalars, SLOT_SQUARE * LANES * sizeof *square,
                          LANES * sizeof *square);
}

/* r = b - A x and its sums. */
static pc_status restart(pc_threefold_device *s, pc_context *ctx, double square[LANES]) {
    pc_status status = PC_OK;
    PC_TRY(multiply(s, ctx, s->x));
    PC_TRY(pass(s, ctx, s->begin, 3 * LANES + 1,
                PC_ARGS(PC_BUF(s->r), PC_BUF(s->b), PC_BUF(s->q), PC_BUF(s->diagonal), PC_BUF(s->partial),
                        PC_U32((uint32_t)s->rows))));
    PC_TRY(finish(s, ctx, pass_parts(s), SLOT_SQUARE, SLOT_ANGLE));
    PC_TRY(read_square(square, s, ctx));
done:
    return status;
}

/* One iteration; all scalars stay on the device. `number` counts from the last restart. */
static pc_status iteration(pc_threefold_device *s, pc_context *ctx, pc_index number) {
    pc_status status = PC_OK;
    const uint32_t rows = (uint32_t)s->rows, slot = SLOT_ANGLE + number % 2;
    PC_TRY(pass(s, ctx, s->turn, 3 * LANES + 1,
                PC_ARGS(PC_BUF(s->p), PC_BUF(s->r), PC_BUF(s->diagonal), PC_BUF(s->scalars), PC_U32(rows),
                        PC_U32(slot), PC_U32(number == 0))));
    PC_TRY(multiply(s, ctx, s->p));
    PC_TRY(pass(s, ctx, s->step, 6 * LANES + 1,
                PC_ARGS(PC_BUF(s->x), PC_BUF(s->r), PC_BUF(s->p), PC_BUF(s->q), PC_BUF(s->diagonal),
                        PC_BUF(s->partial), PC_BUF(s->scalars), PC_U32(rows), PC_U32(slot))));
    PC_TRY(finish(s, ctx, pass_parts(s), SLOT_SQUARE, SLOT_ANGLE + (int)(number + 1) % 2));
done:
    return status;
}

static bool all_reached(const double square[LANES], const double goal2[LANES]) {
    return square[0] <= goal2[0] && square[1] <= goal2[1] && square[2] <= goal2[2];
}

static pc_status run(pc_threefold_device *s, pc_context *ctx, pc_threefold_stats *stats,
                     const double goal2[LANES], pc_index most) {
    enum { RESTARTS = 5, LOOK = 4 /* iterations between looks at the residual, which wait for the device */ };
    pc_status status = PC_OK;
    double square[LANES];
    for (int attempt = 0;; attempt++) {
        PC_TRY(restart(s, ctx, square));
        if (all_reached(square, goal2) || attempt == RESTARTS || stats->iterations >= most) break;
        for (pc_index k = 0; !all_reached(square, goal2) && stats->iterations < most; k++) {
            PC_TRY(pc_check_interrupt(ctx));
            PC_TRY(iteration(s, ctx, k));
            stats->iterations++;
            if (k % LOOK == LOOK - 1) PC_TRY(read_square(square, s, ctx));
            if (!isfinite(square[0] + square[1] + square[2]))
                return pc_fail(ctx, PC_E_NOCONV, "a solve broke down on '%s'", pc_device_name(s->device));
        }
    }
    for (int k = 0; k < 3; k++)
        stats->residual[k] = sqrt(square[k]);
done:
    return status;
}

/* 3 numbers per row in the user's order to LANES in the device's. */
static pc_status send(pc_threefold_device *s, pc_context *ctx, const pc_buffer *to, double *scratch,
                      const double *from) {
#pragma omp parallel for schedule(static)
    for (pc_index place = 0; place < s->order.count; place++)
        for (size_t k = 0; k < 3; k++)
            scratch[LANES * (size_t)place + k] = from[3 * (size_t)s->order.row[place] + k];
    return pc_buffer_write(to, ctx, 0, scratch, LANES * s->rows * sizeof *scratch);
}

pc_status pc_threefold_device_run(pc_threefold_device *solver, pc_context *ctx, pc_threefold_stats *stats,
                                  double *x, const double *b, const double goal[3], pc_index most) {
    pc_status status = PC_OK;
    double *scratch = NULL, goal2[LANES] = {goal[0] * goal[0], goal[1] * goal[1], goal[2] * goal[2], 0};
    PC_TRY(pc_new(&scratch, ctx, LANES * solver->rows));
    PC_TRY(pc_buffer_write(solver->scalars, ctx, SLOT_GOAL * sizeof goal2, goal2, sizeof goal2));
    PC_TRY(send(solver, ctx, solver->b, scratch, b));
    PC_TRY(send(solver, ctx, solver->x, scratch, x));
    PC_TRY(run(solver, ctx, stats, goal2, most));
    PC_TRY(pc_buffer_read(scratch, ctx, solver->x, 0, LANES * solver->rows * sizeof *scratch));
#pragma omp parallel for schedule(static)
    for (pc_index row = 0; row < solver->order.count; row++)
        for (size_t k = 0; k < 3; k++)
            x[3 * (size_t)row + k] = scratch[LANES * (size_t)solver->order.place[row] + k];
done:
    pc_free(ctx, scratch);
    return status;
}
