#include "devmat.h"
#include "eachrow.h"
#include "memory.h"
#include <math.h>
#include <string.h>

enum { WINDOW = 256, PART_STEP = 4096, TURN_SHIFT = 30, NARROW_TURN_SHIFT = 14 };
/* A part is kept below this whatever the device allows: large single buffers are what drivers get wrong. */
static const size_t largest_part = (size_t)1 << 30;

pc_status pc_row_order_make(pc_row_order *order, pc_context *ctx, const pc_blockmat *matrix) {
    enum { LONGEST = 64 };
    pc_status status = PC_OK;
    const pc_index n = matrix->row_count;
    *order = (pc_row_order){.count = n};
    PC_TRY(pc_new(&order->row, ctx, n));
    PC_TRY(pc_new(&order->place, ctx, n));
#pragma omp parallel for schedule(static) if (n > PC_PARALLEL_ROWS)
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
    pc_index slice_rows;
    pc_storage storage;
    pc_index *longest; /* row per slice */
} copying;

static pc_index row_length(const copying *c, pc_index place) {
    if (place >= c->rows->count) return 0;
    pc_index row = c->rows->row[place];
    return c->matrix->start[row + 1] - c->matrix->start[row];
}

static void find_longest(const copying *c, pc_index slices) {
#pragma omp parallel for schedule(static) if (slices > PC_PARALLEL_ROWS)
    for (pc_index slice = 0; slice < slices; slice++) {
        pc_index longest = 0;
        for (pc_index lane = 0; lane < c->slice_rows; lane++) {
            const pc_index length = row_length(c, slice * c->slice_rows + lane);
            if (length > longest) longest = length;
        }
        c->longest[slice] = longest;
    }
}

/* Arrays of one part, where the device is to find them. */
typedef struct staged {
    pc_index *start;
    pc_index *least; /* columns of slices, where they are narrow, else NULL */
    void *column;
    void *value;
    int32_t *rest;
    uint16_t *last;
    uint8_t *exponent;
} staged;

static uint32_t bits_of(float f) {
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    return bits;
}

/* The half nearest to f, |f| <= 1. */
static float nearest_half(uint16_t *half, float f) {
    const uint32_t sign = bits_of(f) & 0x80000000U;
    uint32_t size = bits_of(f) ^ sign;
    if (size < 0x38800000U) {
        /* Below 2^-14 halves are multiples of 2^-24, as floats from 1/2 on are. */
        const float moved = fabsf(f) + 0.5F;
        *half = (uint16_t)(sign >> 16 | (bits_of(moved) - bits_of(0.5F)));
        return sign ? 0.5F - moved : moved - 0.5F;
    }
    size = (size + 0xfff + (size >> 13 & 1)) & ~0x1fffU;
    *half = (uint16_t)(sign >> 16 | (size - 0x38000000U) >> 13);
    size |= sign;
    memcpy(&f, &size, sizeof f);
    return f;
}

/* What numbers become is a constant where they are staged, so that loops over them have no branches. */
typedef struct manner {
    pc_block_form form;
    pc_storage storage;
    bool exact; /* all digits of doubles */
} manner;

PC_ALWAYS_INLINE void stage_number(manner how, const staged *s, size_t at, double v) {
    const bool half = how.storage == PC_STORE_HALF;
    if (how.storage == PC_STORE_DOUBLE) {
        ((double *)s->value)[at] = v;
        return;
    }
    float near = (float)v;
    if (half)
        near = nearest_half((uint16_t *)s->value + at, near);
    else
        ((float *)s->value)[at] = near;
    if (!how.exact) return;
    const long long units = llrint((v - (double)near) * (half ? 0x1p58 : 0x1p55));
    s->rest[at] = (int32_t)(half ? units >> 16 : units);
    if (half) s->last[at] = (uint16_t)(units & 0xffff);
}

/* But for the scale of exact ones. */
PC_ALWAYS_INLINE double number_of(manner how, const pc_blockmat *m, size_t at) {
    return how.exact ? m->exact[at] : (double)m->value[at];
}

/* 2^power, |power| < 1023 */
static double power_of_two(int power) {
    const uint64_t bits = (uint64_t)(power + 1023) << 52;
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* Without its sign: the larger number has the larger bits. */
PC_ALWAYS_INLINE uint64_t size_bits(manner how, const pc_blockmat *m, size_t at) {
    uint64_t bits;
    if (!how.exact) return bits_of(m->value[at]) & 0x7fffffffU;
    memcpy(&bits, &m->exact[at], sizeof bits);
    return bits & ~((uint64_t)1 << 63);
}

/* What the stored numbers of a row are to be multiplied by: one over their unit, whose exponent goes to the
 * device: the least power of two above them all. */
PC_ALWAYS_INLINE double unit_of_row(manner how, const pc_blockmat *m, uint8_t *exponent, size_t from,
                                    pc_index entries) {
    const size_t size = (size_t)pc_form_size(how.form);
    uint64_t largest = 0;
    uint64_t scale;
    memcpy(&scale, &m->exact_scale, sizeof scale);
    const int scale_power = (int)(scale >> 52) - 1023;
    for (size_t at = size * from; at < size * (from + entries); at++) {
        const uint64_t bits = size_bits(how, m, at);
        largest = bits > largest ? bits : largest;
    }
    int power = !how.exact ? (int)(largest >> 23) - 126 : (int)(largest >> 52) - 1022 + scale_power;
    power = largest == 0 ? 0 : power < -125 ? -125 : power > 126 ? 126 : power;
    *exponent = (uint8_t)(power + 127);
    if (how.storage == PC_STORE_DOUBLE) return 1;
    return how.exact ? power_of_two(-power) * m->exact_scale : power_of_two(-power);
}

/* Entry e of the matrix into its lane of entry `to` of a slice; padding reads what its row reads anyway. */
PC_ALWAYS_INLINE void stage_entry(manner how, const copying *c, const staged *s, pc_index least, size_t to,
                                  pc_index lane, size_t e, double unit, bool padding) {
    const pc_blockmat *m = c->matrix;
    const size_t size = (size_t)pc_form_size(how.form);
    const size_t rows = c->slice_rows;
    const pc_index column = c->columns->place[m->column[e]];
    const pc_index turn = how.form == PC_FORM_TURNED && !padding ? m->turn[e] : 0;
    if (s->least)
        ((uint16_t *)s->column)[to * rows + lane] = (uint16_t)((column - least) | turn << NARROW_TURN_SHIFT);
    else
        ((pc_index *)s->column)[to * rows + lane] = column | turn << TURN_SHIFT;
    for (size_t u = 0; u < size; u++)
        stage_number(how, s, (to * rows + lane) * size + u,
                     padding ? 0 : unit * number_of(how, m, size * e + u));
}

/* Padding of a row without entries. */
PC_ALWAYS_INLINE void stage_nothing(manner how, const copying *c, const staged *s, size_t to, pc_index lane) {
    const size_t rows = c->slice_rows;
    const size_t size = (size_t)pc_form_size(how.form);
    if (s->least)
        ((uint16_t *)s->column)[to * rows + lane] = 0;
    else
        ((pc_index *)s->column)[to * rows + lane] = 0;
    for (size_t u = 0; u < size; u++)
        stage_number(how, s, (to * rows + lane) * size + u, 0);
}

PC_ALWAYS_INLINE void stage_slice(manner how, const copying *c, const staged *s, pc_index first, pc_index k) {
    const size_t at = s->start[k];
    const size_t length = s->start[k + 1] - at;
    const pc_index least = s->least ? s->least[k] : 0;
    for (pc_index lane = 0; lane < c->slice_rows; lane++) {
        const pc_index place = (first + k) * c->slice_rows + lane;
        const pc_index own = row_length(c, place);
        const size_t from = own > 0 ? c->matrix->start[c->rows->row[place]] : 0;
        const double unit =
            unit_of_row(how, c->matrix, &s->exponent[(size_t)k * c->slice_rows + lane], from, own);
        for (size_t n = 0; n < own; n++)
            stage_entry(how, c, s, least, at + n, lane, from + n, unit, false);
        for (size_t n = own; n < length; n++) {
            if (own > 0)
                stage_entry(how, c, s, least, at + n, lane, from + own - 1, 0, true);
            else
                stage_nothing(how, c, s, at + n, lane);
        }
    }
}

static void stage_slices(const copying *c, const staged *s, const pc_devmat_part *part) {
    const pc_storage storage = c->storage;
    const bool exact = c->matrix->exact != NULL;
#define HALF_EXACT(form, k)  stage_slice((manner){form, PC_STORE_HALF, true}, c, s, part->first, k)
#define HALF_ALONE(form, k)  stage_slice((manner){form, PC_STORE_HALF, false}, c, s, part->first, k)
#define FLOAT_EXACT(form, k) stage_slice((manner){form, PC_STORE_FLOAT, true}, c, s, part->first, k)
#define FLOAT_ALONE(form, k) stage_slice((manner){form, PC_STORE_FLOAT, false}, c, s, part->first, k)
#define DOUBLES(form, k)     stage_slice((manner){form, PC_STORE_DOUBLE, true}, c, s, part->first, k)
    if (storage == PC_STORE_HALF && exact) PC_EACH_ROW(c->matrix->form, part->slices, HALF_EXACT);
    if (storage == PC_STORE_HALF && !exact) PC_EACH_ROW(c->matrix->form, part->slices, HALF_ALONE);
    if (storage == PC_STORE_FLOAT && exact) PC_EACH_ROW(c->matrix->form, part->slices, FLOAT_EXACT);
    if (storage == PC_STORE_FLOAT && !exact) PC_EACH_ROW(c->matrix->form, part->slices, FLOAT_ALONE);
    if (storage == PC_STORE_DOUBLE && exact) PC_EACH_ROW(c->matrix->form, part->slices, DOUBLES);
#undef HALF_EXACT
#undef HALF_ALONE
#undef FLOAT_EXACT
#undef FLOAT_ALONE
#undef DOUBLES
}

/* The least column of a slice, and how far its columns reach beyond it. */
static void slice_columns(pc_index *least, pc_index *reach, const copying *c, pc_index slice) {
    pc_index low = PC_NONE;
    pc_index high = 0;
    for (pc_index lane = 0; lane < c->slice_rows; lane++) {
        const pc_index place = slice * c->slice_rows + lane;
        const pc_index own = row_length(c, place);
        const pc_index *column = own > 0 ? c->matrix->column + c->matrix->start[c->rows->row[place]] : NULL;
        for (pc_index n = 0; n < own; n++) {
            const pc_index at = c->columns->place[column[n]];
            if (at < low) low = at;
            if (at > high) high = at;
        }
    }
    *least = low == PC_NONE ? 0 : low;
    *reach = low == PC_NONE ? 0 : high - low;
}

/* Where slices start, and the least columns after that. */
static pc_status upload_starts(pc_devmat_part *part, pc_context *ctx, pc_device *device, const copying *c,
                               staged *s) {
    const pc_index slices = part->slices;
    pc_status status = PC_OK;
    pc_index widest = 0;
    PC_TRY(pc_buffer_make(&part->start, ctx, device, (2 * (size_t)slices + 1) * sizeof *s->start));
    PC_TRY(pc_buffer_map(&s->start, ctx, part->start));
    pc_index *least = s->start + slices + 1;
#pragma omp parallel for schedule(static) reduction(max : widest) if (slices > PC_PARALLEL_ROWS)
    for (pc_index k = 0; k < slices; k++) {
        pc_index reach;
        s->start[k + 1] = c->longest[part->first + k];
        slice_columns(&least[k], &reach, c, part->first + k);
        if (reach > widest) widest = reach;
    }
    s->start[0] = 0;
    for (pc_index k = 0; k < slices; k++)
        s->start[k + 1] += s->start[k];
    part->narrow = c->storage != PC_STORE_DOUBLE &&
                   widest < (c->matrix->form == PC_FORM_TURNED ? 1U << NARROW_TURN_SHIFT : 1U << 16);
    if (part->narrow) s->least = least;
done:
    return status;
}

/* Keeps the first failure. */
static void unmap(pc_status *status, pc_context *ctx, const pc_buffer *buffer, void *at) {
    pc_status unmapped = buffer ? pc_buffer_unmap(buffer, ctx, at) : PC_OK;
    if (*status == PC_OK) *status = unmapped;
}

static pc_status upload_part(pc_devmat_part *part, pc_context *ctx, pc_device *device, const copying *c) {
    pc_status status = PC_OK;
    staged s = {0};
    const size_t places = part->entries * c->slice_rows;
    const size_t numbers = places * (size_t)pc_form_size(c->matrix->form);
    static const size_t size[3] = {4, 2, 8};
    const bool rest = c->matrix->exact && c->storage != PC_STORE_DOUBLE;
    PC_TRY(upload_starts(part, ctx, device, c, &s));
    PC_TRY(pc_buffer_make(&part->column, ctx, device, places * (part->narrow ? 2 : 4)));
    PC_TRY(pc_buffer_make(&part->value, ctx, device, numbers * size[c->storage]));
    PC_TRY(pc_buffer_make(&part->exponent, ctx, device, (size_t)part->slices * c->slice_rows));
    if (rest) PC_TRY(pc_buffer_make(&part->rest, ctx, device, numbers * sizeof *s.rest));
    if (rest && c->storage == PC_STORE_HALF)
        PC_TRY(pc_buffer_make(&part->last, ctx, device, numbers * sizeof *s.last));
    PC_TRY(pc_buffer_map(&s.column, ctx, part->column));
    PC_TRY(pc_buffer_map(&s.value, ctx, part->value));
    PC_TRY(pc_buffer_map(&s.exponent, ctx, part->exponent));
    if (part->rest) PC_TRY(pc_buffer_map(&s.rest, ctx, part->rest));
    if (part->last) PC_TRY(pc_buffer_map(&s.last, ctx, part->last));
    stage_slices(c, &s, part);
done:
    unmap(&status, ctx, part->start, s.start);
    unmap(&status, ctx, part->column, s.column);
    unmap(&status, ctx, part->value, s.value);
    unmap(&status, ctx, part->exponent, s.exponent);
    unmap(&status, ctx, part->rest, s.rest);
    unmap(&status, ctx, part->last, s.last);
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
    const size_t bytes = c->slice_rows * (size_t)pc_form_size(c->matrix->form) *
                         (c->storage == PC_STORE_DOUBLE ? sizeof(double) : sizeof(float));
    pc_devmat_part now = {0};
    int count = 0;
    const pc_index wide = PART_STEP / c->slice_rows;
    for (pc_index step = 0; step < slices; step += wide) {
        pc_index end = slices - step < wide ? slices : step + wide;
        size_t entries = 0;
        for (pc_index s = step; s < end; s++)
            entries += c->longest[s];
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

pc_status pc_devmat_set_diagonals(pc_devmat *out, pc_context *ctx, const pc_blockmat *matrix,
                                  const pc_row_order *rows) {
    pc_status status = PC_OK;
    const size_t size = (size_t)pc_form_diagonal(out->form);
    const pc_index padded = (pc_index)pc_devmat_padded(out);
    float *space = NULL;
    PC_TRY(pc_buffer_map(&space, ctx, out->diagonal));
#pragma omp parallel for schedule(static)
    for (pc_index place = 0; place < padded; place++)
        for (size_t k = 0; k < size; k++)
            space[size * place + k] = place < rows->count ? matrix->diagonal[size * rows->row[place] + k] : 1;
    PC_TRY(pc_buffer_unmap(out->diagonal, ctx, space));
done:
    return status;
}

pc_status pc_devmat_make(pc_devmat *out, pc_context *ctx, pc_device *device, const pc_blockmat *matrix,
                         const pc_row_order *rows, const pc_row_order *columns, pc_storage storage) {
    pc_status status = PC_OK;
    copying c = {matrix, rows, columns, pc_devmat_slice_rows(device), storage, NULL};
    size_t cap = pc_device_allocation_cap(device);
    if (cap > largest_part) cap = largest_part;
    *out = (pc_devmat){
        .form = matrix->form, .storage = storage, .row_count = rows->count, .slice_rows = c.slice_rows};
    out->slice_count = (rows->count + c.slice_rows - 1) / c.slice_rows;
    if (storage == PC_STORE_DOUBLE && !matrix->exact)
        return pc_fail(ctx, PC_E_BUG, "a matrix without doubles was to be stored in doubles");
    PC_TRY(pc_resize(&c.longest, ctx, out->slice_count));
    find_longest(&c, out->slice_count);
    int count = cut_parts(NULL, &c, out->slice_count, cap);
    PC_TRY(pc_new(&out->part, ctx, (size_t)count));
    out->part_count = count;
    (void)cut_parts(out->part, &c, out->slice_count, cap);
    for (int p = 0; p < count; p++)
        PC_TRY(upload_part(&out->part[p], ctx, device, &c));
    if (matrix->diagonal) {
        PC_TRY(pc_buffer_make(&out->diagonal, ctx, device,
                              pc_devmat_padded(out) * (size_t)pc_form_diagonal(out->form) * sizeof(float)));
        PC_TRY(pc_devmat_set_diagonals(out, ctx, matrix, rows));
    }
done:
    pc_free(ctx, c.longest);
    if (status != PC_OK) pc_devmat_free(out, ctx);
    return status;
}

void pc_devmat_free(pc_devmat *matrix, pc_context *ctx) {
    for (int p = 0; p < matrix->part_count; p++) {
        const pc_devmat_part *part = &matrix->part[p];
        pc_buffer *buffers[6] = {part->start, part->column, part->value,
                                 part->rest,  part->last,   part->exponent};
        for (int k = 0; k < 6; k++)
            pc_buffer_free(buffers[k], ctx);
    }
    pc_free(ctx, matrix->part);
    pc_buffer_free(matrix->diagonal, ctx);
    *matrix = (pc_devmat){0};
}
