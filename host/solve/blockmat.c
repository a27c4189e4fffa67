#include "blockmat.h"
#include "eachrow.h"
#include "memory.h"
#include <string.h>

pc_status pc_blockmat_make(pc_blockmat *matrix, pc_context *ctx, pc_block_form form, pc_index rows,
                           pc_index columns, size_t entries, bool square) {
    pc_status status = PC_OK;
    *matrix = (pc_blockmat){.form = form, .row_count = rows, .column_count = columns};
    if (entries >= PC_NONE)
        return pc_fail(ctx, PC_E_MESH, "a multigrid level of %zu couplings is beyond 32-bit offsets",
                       entries);
    PC_TRY(pc_new(&matrix->start, ctx, (size_t)rows + 1));
    /* Grown from nothing: these are the large ones, and whoever makes them fills them. */
    PC_TRY(pc_resize(&matrix->column, ctx, entries));
    PC_TRY(pc_resize(&matrix->value, ctx, entries * (size_t)pc_form_size(form)));
    if (form == PC_FORM_TURNED) PC_TRY(pc_resize(&matrix->turn, ctx, entries));
    if (square) {
        PC_TRY(pc_new(&matrix->diagonal, ctx, (size_t)rows * (size_t)pc_form_diagonal(form)));
        PC_TRY(pc_new(&matrix->inverse, ctx, (size_t)rows * (size_t)pc_form_diagonal(form)));
    }
done:
    if (status != PC_OK) pc_blockmat_free(matrix, ctx);
    return status;
}

pc_status pc_blockmat_borrow(pc_blockmat *matrix, pc_context *ctx, const pc_system *system) {
    const pc_index n = system->row_count;
    const pc_block_form form = (pc_block_form)system->kind;
    const size_t diagonals = n * (size_t)pc_form_diagonal(form);
    pc_status status = PC_OK;
    *matrix = (pc_blockmat){.form = form, .row_count = n, .column_count = n, .borrowed = true};
    matrix->start = system->start;
    matrix->column = system->column;
    matrix->turn = system->turn;
    PC_TRY(pc_resize(&matrix->value, ctx, system->start[n] * (size_t)pc_form_size(form)));
    PC_TRY(pc_resize(&matrix->diagonal, ctx, diagonals));
    PC_TRY(pc_resize(&matrix->inverse, ctx, diagonals));
done:
    if (status != PC_OK) pc_blockmat_free(matrix, ctx);
    return status;
}

void pc_blockmat_free_couplings(pc_blockmat *matrix, pc_context *ctx) {
    if (!matrix->borrowed) {
        pc_free(ctx, matrix->start);
        pc_free(ctx, matrix->column);
        pc_free(ctx, matrix->turn);
    }
    pc_free(ctx, matrix->value);
    matrix->borrowed = false;
    matrix->exact = matrix->exact_diagonal = NULL;
    matrix->start = matrix->column = NULL;
    matrix->value = NULL;
    matrix->turn = NULL;
}

void pc_blockmat_free(pc_blockmat *matrix, pc_context *ctx) {
    pc_blockmat_free_couplings(matrix, ctx);
    pc_free(ctx, matrix->diagonal);
    pc_free(ctx, matrix->inverse);
    *matrix = (pc_blockmat){0};
}

/* sum += B_e u */
PC_ALWAYS_INLINE void add_block(pc_block_form form, float *sum, const pc_blockmat *a, size_t e,
                                const float *u) {
    const float *v = a->value + (size_t)pc_form_size(form) * e;
    if (form == PC_FORM_SCALAR) {
        sum[0] += v[0] * u[0];
    } else if (form == PC_FORM_COMPLEX) {
        sum[0] += v[0] * u[0] - v[1] * u[1];
        sum[1] += v[0] * u[1] + v[1] * u[0];
    } else {
        int t = a->turn[e];
        int first = (t & 1) ? 2 : 0;
        float p = u[first];
        float q = u[2 - first];
        float p_im = t >= 2 ? -u[first + 1] : u[first + 1];
        float q_im = t == 1 || t == 2 ? -u[3 - first] : u[3 - first];
        sum[0] += v[0] * p - v[1] * p_im;
        sum[1] += v[0] * p_im + v[1] * p;
        sum[2] += v[2] * q - v[3] * q_im;
        sum[3] += v[2] * q_im + v[3] * q;
    }
}

/* B_e added to a dense matrix of n columns */
static void add_dense(double *out, size_t n, const pc_blockmat *a, size_t e) {
    const size_t w = (size_t)pc_form_width(a->form);
    for (size_t c = 0; c < w; c++) {
        float sum[4] = {0};
        float unit[4] = {0};
        unit[c] = 1;
        add_block(a->form, sum, a, e, unit);
        for (size_t r = 0; r < w; r++)
            out[r * n + c] += (double)sum[r];
    }
}

/* y = scale D x */
PC_ALWAYS_INLINE void times_diagonal(pc_block_form form, float *y, const float *diagonal, const float *x,
                                     float scale) {
    for (int r = 0; r < pc_form_width(form); r++)
        y[r] = scale * diagonal[r / 2] * x[r];
}

/* sum = (A x)_i */
PC_ALWAYS_INLINE void row_times(pc_block_form form, float *sum, const pc_blockmat *a, pc_index i,
                                const float *x) {
    if (a->diagonal)
        times_diagonal(form, sum, a->diagonal + (size_t)pc_form_diagonal(form) * i,
                       x + (size_t)pc_form_width(form) * i, 1);
    else
        memset(sum, 0, 4 * sizeof *sum);
    for (size_t e = a->start[i]; e < a->start[i + 1]; e++)
        add_block(form, sum, a, e, x + (size_t)pc_form_width(form) * a->column[e]);
}

/* What becomes of a product: y = sum, y += sum, y = b - sum. */
typedef enum use { STORE, ADD, SUBTRACT } use;

PC_ALWAYS_INLINE void apply_row(pc_block_form form, float *y, const pc_blockmat *a, const float *x,
                                const float *b, use use_of, pc_index i) {
    const int w = pc_form_width(form);
    float sum[4];
    size_t at = (size_t)w * i;
    row_times(form, sum, a, i, x);
    for (int k = 0; k < w; k++) {
        float *to = &y[at + (size_t)k];
        *to = use_of == STORE ? sum[k] : use_of == ADD ? *to + sum[k] : b[at + (size_t)k] - sum[k];
    }
}

PC_ALWAYS_INLINE void smooth_row(pc_block_form form, float *x_new, float *d, const pc_blockmat *a,
                                 const float *b, const float *x, float alpha, float beta, pc_index i) {
    const int w = pc_form_width(form);
    float r[4];
    float step[4];
    size_t at = (size_t)w * i;
    row_times(form, r, a, i, x);
    for (int k = 0; k < w; k++)
        r[k] = b[at + (size_t)k] - r[k];
    times_diagonal(form, step, a->inverse + (size_t)pc_form_diagonal(form) * i, r, beta);
    if (alpha != 0) {
        for (int k = 0; k < w; k++)
            step[k] += alpha * d[at + (size_t)k];
    }
    for (int k = 0; k < w; k++) {
        d[at + (size_t)k] = step[k];
        x_new[at + (size_t)k] = x[at + (size_t)k] + step[k];
    }
}

PC_ALWAYS_INLINE void first_row(pc_block_form form, float *x, float *d, const pc_blockmat *a, const float *b,
                                float beta, pc_index i) {
    const int w = pc_form_width(form);
    float step[4];
    size_t at = (size_t)w * i;
    times_diagonal(form, step, a->inverse + (size_t)pc_form_diagonal(form) * i, b + at, beta);
    for (int k = 0; k < w; k++)
        d[at + (size_t)k] = x[at + (size_t)k] = step[k];
}

void pc_blockmat_dense(double *out, const pc_blockmat *matrix) {
    const size_t w = (size_t)pc_form_width(matrix->form);
    const size_t n = w * matrix->column_count;
    memset(out, 0, w * matrix->row_count * n * sizeof *out);
    for (pc_index i = 0; i < matrix->row_count; i++) {
        for (size_t r = 0; matrix->diagonal && r < w; r++)
            out[(w * i + r) * n + w * i + r] =
                (double)matrix->diagonal[(size_t)pc_form_diagonal(matrix->form) * i + r / 2];
        for (size_t e = matrix->start[i]; e < matrix->start[i + 1]; e++)
            add_dense(out + w * i * n + w * matrix->column[e], n, matrix, e);
    }
}

void pc_blockmat_apply(float *y, const pc_blockmat *matrix, const float *x) {
#define ROW(form, i) apply_row(form, y, matrix, x, NULL, STORE, i)
    PC_EACH_ROW(matrix->form, matrix->row_count, ROW);
#undef ROW
}

void pc_blockmat_add(float *y, const pc_blockmat *transfer, const float *x) {
#define ROW(form, i) apply_row(form, y, transfer, x, NULL, ADD, i)
    PC_EACH_ROW(transfer->form, transfer->row_count, ROW);
#undef ROW
}

void pc_blockmat_residual(float *r, const pc_blockmat *matrix, const float *b, const float *x) {
#define ROW(form, i) apply_row(form, r, matrix, x, b, SUBTRACT, i)
    PC_EACH_ROW(matrix->form, matrix->row_count, ROW);
#undef ROW
}

void pc_blockmat_smooth(float *x_new, float *d, const pc_blockmat *matrix, const float *b, const float *x,
                        float alpha, float beta) {
#define ROW(form, i) smooth_row(form, x_new, d, matrix, b, x, alpha, beta, i)
    PC_EACH_ROW(matrix->form, matrix->row_count, ROW);
#undef ROW
}

void pc_blockmat_smooth_first(float *x, float *d, const pc_blockmat *matrix, const float *b, float beta) {
#define ROW(form, i) first_row(form, x, d, matrix, b, beta, i)
    PC_EACH_ROW(matrix->form, matrix->row_count, ROW);
#undef ROW
}
