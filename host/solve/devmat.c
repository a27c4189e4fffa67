#include "devmat.h"
#include "eachrow.h"
#include "memory.h"
#include <string.h>

enum { WINDOW = 256, PART_STEP = 4096, TURN_SHIFT = 30 };
/* A part is kept below this whatever the device allows: large single buffers are what drivers get wrong. */
static const size_t largest_part = (size_t)1 << 30;

pc_status pc_row_order_make(pc_row_order *order, pc_context *ctx, const pc_blockmat *matrix) {
    enum { LONGEST = 64 };
    pc_status status = PC_OK;
    const pc_index n = matrix->row_count;
    *order = (pc_row_order){.count = n};
    PC_TRY(pc_new(&order->row, ctx, n));
    PC_TRY(pc_new(&order->place, ctx, n));
    for (pc_index window = 0; window < n; window += WINDOW) {
        /* Counting sort by length, longest first; equal rows keep their order. */
        pc_index end = n - window < WINDOW ? n : window + WINDOW;
        pc_index at[LONGEST + 2] = {0};
        for (pc_index i = window; i < end; i++) {
            pc_index length = matrix->start[i + 1] - matrix->start[i];
            if (length > LONGEST) length = LONGEST;
            order->place[i] = LONGEST - length;
            at[LONGEST - length + 1]++;
        }
        for (int k = 0; k <= LONGEST; k++)
            at[k + 1] += at[k];
        for (pc_index i = window; i < end; i++) {
            order->place[i] = window + at[order->place[i]]++;
            order->row[order->place[i]] = i;
        }
    }
done:
    if (status != PC_OK) pc_row_order_free(order, ctx);
    return status;
}

void pc_row_order_free(pc_row_order *order, pc_context *ctx) {
    pc_free(ctx, order->row);
    pc_free(ctx, order->place);
    *order = (pc_row_order){0};
}

/* What is being copied. */
typedef struct copying {
    const pc_blockmat *matrix;
    const pc_row_order *rows;
    const pc_row_order *columns;
    const pc_system *exact;
    pc_index slice_rows;
} copying;

static pc_index row_length(const copying *c, pc_index place) {
    if (place >= c->rows->count) return 0;
    pc_index row = c->rows->row[place];
    return c->matrix->start[row + 1] - c->matrix->start[row];
}

static pc_index slice_length(const copying *c, pc_index slice) {
    pc_index longest = 0;
    for (pc_index lane = 0; lane < c->slice_rows; lane++) {
        pc_index length = row_length(c, slice * c->slice_rows + lane);
        if (length > longest) longest = length;
    }
    return longest;
}

/* Where number k of the block in a lane goes within a slice's entry. */
PC_ALWAYS_INLINE size_t value_place(pc_block_form form, pc_index rows, pc_index lane, size_t k) {
    return form == PC_FORM_SCALAR ? lane : 2 * (rows * (k / 2) + lane) + k % 2;
}

/* Arrays of one part, where the device is to find them. */
typedef struct staged {
    pc_index *start;
    pc_index *column;
    float *value;
    double *exact;
} staged;

/* Entry k of a row, or padding, into its lane of a slice's entry. */
PC_ALWAYS_INLINE void stage_entry(pc_block_form form, const copying *c, staged *s, size_t to, pc_index lane,
                                  size_t e, bool padding) {
    const pc_blockmat *m = c->matrix;
    const size_t size = (size_t)pc_form_size(form);
    const size_t rows = c->slice_rows;
    pc_index *column = &s->column[to * rows + lane];
    if (padding) {
        /* It reads what its row reads anyway. */
        *column = e > 0 ? c->columns->place[m->column[e - 1]] : 0;
    } else {
        *column = c->columns->place[m->column[e]];
        if (form == PC_FORM_TURNED) *column |= (pc_index)m->turn[e] << TURN_SHIFT;
    }
    for (size_t u = 0; u < size; u++) {
        size_t at = to * rows * size + value_place(form, (pc_index)rows, lane, u);
        s->value[at] = padding ? 0 : m->value[size * e + u];
        if (c->exact) s->exact[at] = padding ? 0 : c->exact->value[size * e + u];
    }
}

PC_ALWAYS_INLINE void stage_slice(pc_block_form form, const copying *c, staged *s, pc_index slice,
                                  pc_index at, pc_index length) {
    for (pc_index lane = 0; lane < c->slice_rows; lane++) {
        pc_index place = slice * c->slice_rows + lane;
        pc_index own = row_length(c, place);
        size_t from = own > 0 ? c->matrix->start[c->rows->row[place]] : 0;
        for (pc_index k = 0; k < own; k++)
            stage_entry(form, c, s, (size_t)at + k, lane, from + k, false);
        for (pc_index k = own; k < length; k++)
            stage_entry(form, c, s, (size_t)at + k, lane, own > 0 ? from + own : 0, true);
    }
}

/* Keeps the first failure. */
static void unmap(pc_status *status, pc_context *ctx, const pc_buffer *buffer, void *at) {
    pc_status unmapped = buffer ? pc_buffer_unmap(buffer, ctx, at) : PC_OK;
    if (*status == PC_OK) *status = unmapped;
}

static pc_status upload_part(pc_devmat_part *part, pc_context *ctx, pc_device *device, const copying *c) {
    pc_status status = PC_OK;
    staged s = {0};
    const size_t numbers = part->entries * c->slice_rows * (size_t)pc_form_size(c->matrix->form);
    PC_TRY(pc_buffer_make(&part->start, ctx, device, ((size_t)part->slices + 1) * sizeof *s.start));
    PC_TRY(pc_buffer_make(&part->column, ctx, device, part->entries * c->slice_rows * sizeof *s.column));
    PC_TRY(pc_buffer_make(&part->value, ctx, device, numbers * sizeof *s.value));
    if (c->exact) PC_TRY(pc_buffer_make(&part->exact, ctx, device, numbers * sizeof *s.exact));
    PC_TRY(pc_buffer_map(&s.start, ctx, part->start));
    PC_TRY(pc_buffer_map(&s.column, ctx, part->column));
    PC_TRY(pc_buffer_map(&s.value, ctx, part->value));
    if (c->exact) PC_TRY(pc_buffer_map(&s.exact, ctx, part->exact));
    s.start[0] = 0;
    for (pc_index k = 0; k < part->slices; k++)
        s.start[k + 1] = s.start[k] + slice_length(c, part->first + k);
#define SLICE(form, k) stage_slice(form, c, &s, part->first + (k), s.start[k], s.start[(k) + 1] - s.start[k])
    PC_EACH_ROW(c->matrix->form, part->slices, SLICE);
#undef SLICE
done:
    unmap(&status, ctx, part->start, s.start);
    unmap(&status, ctx, part->column, s.column);
    unmap(&status, ctx, part->value, s.value);
    unmap(&status, ctx, part->exact, s.exact);
    return status;
}

/* Do rows of the slices [from, to) have columns that are copies? */
static bool reads_copies(const copying *c, pc_index from, pc_index to) {
    if (c->columns->copies == 0) return false;
    const pc_index end = to * c->slice_rows < c->rows->count ? to * c->slice_rows : c->rows->count;
    for (pc_index place = from * c->slice_rows; place < end; place++) {
        const pc_index row = c->rows->row[place];
        for (pc_index e = c->matrix->start[row]; e < c->matrix->start[row + 1]; e++)
            if (c->columns->place[c->matrix->column[e]] >= c->columns->count) return true;
    }
    return false;
}

/* Cuts the slices so that no buffer of a part is over the cap, and that parts are late or not. Counts only
 * where `part` is NULL. */
static int cut_parts(pc_devmat_part *part, const copying *c, pc_index slices, size_t cap) {
    const size_t unit = (c->exact ? sizeof(double) : sizeof(float)) * (size_t)pc_form_size(c->matrix->form);
    const size_t bytes = c->slice_rows * (unit > sizeof(pc_index) ? unit : sizeof(pc_index));
    pc_devmat_part now = {0};
    int count = 0;
    const pc_index wide = PART_STEP / c->slice_rows;
    for (pc_index step = 0; step < slices; step += wide) {
        pc_index end = slices - step < wide ? slices : step + wide;
        size_t entries = 0;
        for (pc_index s = step; s < end; s++)
            entries += slice_length(c, s);
        const bool late = reads_copies(c, step, end);
        if (now.slices > 0 && ((now.entries + entries) * bytes > cap || late != now.late)) {
            if (part) part[count] = now;
            count++;
            now = (pc_devmat_part){.first = step};
        }
        now.late = late;
        now.slices += end - step;
        now.entries += entries;
    }
    if (part) part[count] = now;
    return count + 1;
}

/* `from` in the order of the device, by way of `space`. */
static pc_status write_diagonal(const pc_buffer *to, pc_context *ctx, const float *from, float *space,
                                const pc_row_order *rows, size_t size) {
#pragma omp parallel for schedule(static)
    for (pc_index place = 0; place < rows->count; place++)
        memcpy(space + size * place, from + size * rows->row[place], size * sizeof *from);
    return pc_buffer_write(to, ctx, 0, space, size * rows->count * sizeof *space);
}

pc_status pc_devmat_set_diagonals(pc_devmat *out, pc_context *ctx, const pc_blockmat *matrix,
                                  const pc_row_order *rows) {
    pc_status status = PC_OK;
    const size_t size = (size_t)pc_form_diagonal(out->form);
    float *space = NULL;
    PC_TRY(pc_new(&space, ctx, size * rows->count));
    PC_TRY(write_diagonal(out->diagonal, ctx, matrix->diagonal, space, rows, size));
    PC_TRY(write_diagonal(out->inverse, ctx, matrix->inverse, space, rows, size));
done:
    pc_free(ctx, space);
    return status;
}

static pc_status upload_diagonals(pc_devmat *out, pc_context *ctx, pc_device *device, const copying *c) {
    pc_status status = PC_OK;
    const size_t bytes = pc_devmat_padded(out) * (size_t)pc_form_diagonal(out->form) * sizeof(float);
    PC_TRY(pc_buffer_zeroed(&out->diagonal, ctx, device, bytes));
    PC_TRY(pc_buffer_zeroed(&out->inverse, ctx, device, bytes));
    PC_TRY(pc_devmat_set_diagonals(out, ctx, c->matrix, c->rows));
done:
    return status;
}

pc_status pc_devmat_make(pc_devmat *out, pc_context *ctx, pc_device *device, const pc_blockmat *matrix,
                         const pc_row_order *rows, const pc_row_order *columns, const pc_system *exact) {
    pc_status status = PC_OK;
    copying c = {matrix, rows, columns, exact, pc_devmat_slice_rows(device)};
    size_t cap = pc_device_allocation_cap(device);
    if (cap > largest_part) cap = largest_part;
    *out = (pc_devmat){.form = matrix->form, .row_count = rows->count, .slice_rows = c.slice_rows};
    out->slice_count = (rows->count + c.slice_rows - 1) / c.slice_rows;
    int count = cut_parts(NULL, &c, out->slice_count, cap);
    PC_TRY(pc_new(&out->part, ctx, (size_t)count));
    out->part_count = count;
    (void)cut_parts(out->part, &c, out->slice_count, cap);
    for (int p = 0; p < count; p++)
        PC_TRY(upload_part(&out->part[p], ctx, device, &c));
    if (matrix->diagonal) PC_TRY(upload_diagonals(out, ctx, device, &c));
done:
    if (status != PC_OK) pc_devmat_free(out, ctx);
    return status;
}

void pc_devmat_free(pc_devmat *matrix, pc_context *ctx) {
    for (int p = 0; p < matrix->part_count; p++) {
        pc_buffer_free(matrix->part[p].start, ctx);
        pc_buffer_free(matrix->part[p].column, ctx);
        pc_buffer_free(matrix->part[p].value, ctx);
        pc_buffer_free(matrix->part[p].exact, ctx);
    }
    pc_free(ctx, matrix->part);
    pc_buffer_free(matrix->diagonal, ctx);
    pc_buffer_free(matrix->inverse, ctx);
    *matrix = (pc_devmat){0};
}
