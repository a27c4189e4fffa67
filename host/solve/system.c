#include "system.h"
#include "memory.h"
#include <math.h>
#include <string.h>

pc_status pc_system_make(pc_system *system, pc_context *ctx, pc_block_kind kind, pc_index row_count,
                         size_t entry_count) {
    pc_status status = PC_OK;
    *system = (pc_system){.kind = kind, .row_count = row_count};
    if (entry_count >= PC_NONE || (size_t)row_count >= (PC_NONE >> 2))
        return pc_fail(ctx, PC_E_MESH, "a system of %u rows and %zu couplings is beyond 32-bit offsets",
                       row_count, entry_count);
    PC_TRY(pc_new(&system->start, ctx, (size_t)row_count + 1));
    PC_TRY(pc_new(&system->column, ctx, entry_count));
    PC_TRY(pc_new(&system->diagonal, ctx, row_count));
    PC_TRY(pc_new(&system->value, ctx, entry_count * (size_t)pc_block_width(kind)));
    if (kind == PC_BLOCK_TURNED) PC_TRY(pc_new(&system->turn, ctx, entry_count));
done:
    if (status != PC_OK) pc_system_free(system, ctx);
    return status;
}

void pc_system_free_couplings(pc_system *system, pc_context *ctx) {
    pc_free(ctx, system->start);
    pc_free(ctx, system->column);
    pc_free(ctx, system->value);
    pc_free(ctx, system->turn);
    system->start = system->column = NULL;
    system->value = NULL;
    system->turn = NULL;
}

void pc_system_free(pc_system *system, pc_context *ctx) {
    if (!system) return;
    pc_system_free_couplings(system, ctx);
    pc_free(ctx, system->diagonal);
    *system = (pc_system){0};
}

void pc_system_block(double out[16], const pc_system *s, size_t e) {
    const double *v = s->value + e * (size_t)pc_block_width(s->kind);
    memset(out, 0, 16 * sizeof *out);
    if (s->kind == PC_BLOCK_SCALAR) {
        out[0] = v[0];
    } else if (s->kind == PC_BLOCK_COMPLEX) {
        out[0] = out[3] = v[0];
        out[1] = -v[1];
        out[2] = v[1];
    } else {
        /* What M^t puts first and second, and whether it conjugates it. */
        static const int from[4][2] = {{0, 1}, {1, 0}, {0, 1}, {1, 0}};
        static const int conjugate[4][2] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
        for (int half = 0; half < 2; half++) {
            int t = s->turn[e] & 3;
            double re = v[2 * half];
            double im = v[2 * half + 1];
            double sign = conjugate[t][half] ? -1 : 1;
            double *rows = out + (ptrdiff_t)8 * half + (ptrdiff_t)2 * from[t][half];
            rows[0] = re;
            rows[1] = -sign * im;
            rows[4] = im;
            rows[5] = sign * re;
        }
    }
}

static size_t find_entry(const pc_system *s, pc_index row, pc_index column) {
    size_t low = s->start[row];
    size_t high = s->start[row + 1];
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (s->column[middle] < column)
            low = middle + 1;
        else
            high = middle;
    }
    return low < s->start[row + 1] && s->column[low] == column ? low : SIZE_MAX;
}

static pc_status check_row(const pc_system *s, pc_context *ctx, pc_index row) {
    if (!(s->diagonal[row] > 0) || !isfinite(s->diagonal[row]))
        return pc_fail(ctx, PC_E_BUG, "system row %u: diagonal %g", row, s->diagonal[row]);
    for (size_t e = s->start[row]; e < s->start[row + 1]; e++) {
        pc_index column = s->column[e];
        if (column >= s->row_count || column == row || (e > s->start[row] && column <= s->column[e - 1]))
            return pc_fail(ctx, PC_E_BUG, "system row %u: column %u is out of place", row, column);
        if (s->kind == PC_BLOCK_TURNED && s->turn[e] > 3)
            return pc_fail(ctx, PC_E_BUG, "system row %u: turn %d", row, s->turn[e]);
        size_t back = find_entry(s, column, row);
        if (back == SIZE_MAX)
            return pc_fail(ctx, PC_E_BUG, "system entry (%u,%u) has no entry (%u,%u)", row, column, column,
                           row);
        int w = pc_block_width(s->kind);
        double a[16];
        double b[16];
        pc_system_block(a, s, e);
        pc_system_block(b, s, back);
        double size = 0;
        for (int i = 0; i < w * w; i++)
            size += fabs(a[i]);
        if (!isfinite(size)) return pc_fail(ctx, PC_E_BUG, "system entry (%u,%u) is not finite", row, column);
        for (int i = 0; i < w * w; i++) {
            if (fabs(a[i] - b[i % w * w + i / w]) > 1e-9 * size)
                return pc_fail(ctx, PC_E_BUG, "system entries (%u,%u) and (%u,%u) are not transposes", row,
                               column, column, row);
        }
    }
    return PC_OK;
}

pc_status pc_system_check(const pc_system *system, pc_context *ctx) {
    if (system->start[0] != 0) return pc_fail(ctx, PC_E_BUG, "the first system row does not start at 0");
    for (pc_index row = 0; row < system->row_count; row++) {
        if (system->start[row + 1] < system->start[row])
            return pc_fail(ctx, PC_E_BUG, "system row %u ends before it starts", row);
    }
    for (pc_index row = 0; row < system->row_count; row++) {
        pc_status status = check_row(system, ctx, row);
        if (status != PC_OK) return status;
    }
    return PC_OK;
}

static void apply_scalar(double *y, const pc_system *s, const double *x) {
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < s->row_count; i++) {
        double sum = s->diagonal[i] * x[i];
        for (size_t e = s->start[i]; e < s->start[i + 1]; e++)
            sum += s->value[e] * x[s->column[e]];
        y[i] = sum;
    }
}

static void apply_complex(double *y, const pc_system *s, const double *x) {
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < s->row_count; i++) {
        double re = s->diagonal[i] * x[2 * (size_t)i];
        double im = s->diagonal[i] * x[2 * (size_t)i + 1];
        for (size_t e = s->start[i]; e < s->start[i + 1]; e++) {
            const double *v = s->value + 2 * e;
            const double *u = x + 2 * (size_t)s->column[e];
            re += v[0] * u[0] - v[1] * u[1];
            im += v[0] * u[1] + v[1] * u[0];
        }
        y[2 * (size_t)i] = re;
        y[2 * (size_t)i + 1] = im;
    }
}

static void apply_turned(double *y, const pc_system *s, const double *x) {
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < s->row_count; i++) {
        double sum[4];
        for (int k = 0; k < 4; k++)
            sum[k] = s->diagonal[i] * x[4 * (size_t)i + (size_t)k];
        for (size_t e = s->start[i]; e < s->start[i + 1]; e++) {
            const double *v = s->value + 4 * e;
            const double *u = x + 4 * (size_t)s->column[e];
            int t = s->turn[e];
            /* M^t swaps U and V for odd t; it conjugates the first from t = 2 on, the second for t = 1, 2. */
            size_t first = (t & 1) ? 2 : 0;
            double p_im = t >= 2 ? -u[first + 1] : u[first + 1];
            double q_im = t == 1 || t == 2 ? -u[3 - first] : u[3 - first];
            double p = u[first];
            double q = u[2 - first];
            sum[0] += v[0] * p - v[1] * p_im;
            sum[1] += v[0] * p_im + v[1] * p;
            sum[2] += v[2] * q - v[3] * q_im;
            sum[3] += v[2] * q_im + v[3] * q;
        }
        memcpy(y + 4 * (size_t)i, sum, sizeof sum);
    }
}

void pc_system_apply(double *y, const pc_system *system, const double *x) {
    switch (system->kind) {
    case PC_BLOCK_SCALAR:
        apply_scalar(y, system, x);
        break;
    case PC_BLOCK_COMPLEX:
        apply_complex(y, system, x);
        break;
    case PC_BLOCK_TURNED:
        apply_turned(y, system, x);
        break;
    }
}
