#include "galerkin.h"
#include "blockalg.h"
#include "memory.h"
#include "smallmat.h"
#include <omp.h>

/* What a matrix product leaves in a row. */
typedef enum finish { KEEP, SMOOTH, SPLIT_DIAGONAL } finish;

typedef struct product {
    pc_blockmat *c;
    const pc_blockmat *a;
    const pc_blockmat *b;
    finish finish;
    double omega;
    double *diagonal; /* SPLIT_DIAGONAL: the block on it */
} product;

/* A sparse row under construction; slot[] needs no clearing. */
typedef struct row {
    pc_index *slot; /* per column of c: its place in list, if list agrees */
    pc_index *list;
    pc_index count;
    double *sum;
} row;

static inline pc_index place(row *r, pc_index column) {
    pc_index k = r->slot[column];
    if (k < r->count && r->list[k] == column) return k;
    r->slot[column] = r->count;
    r->list[r->count] = column;
    return r->count++;
}

static void row_pattern(row *r, const product *p, pc_index i) {
    const pc_blockmat *a = p->a;
    const pc_blockmat *b = p->b;
    r->count = 0;
    if (p->finish == SMOOTH && b->start[i] == b->start[i + 1]) return;
    if (a->diagonal) {
        for (size_t f = b->start[i]; f < b->start[i + 1]; f++)
            (void)place(r, b->column[f]);
    }
    for (size_t e = a->start[i]; e < a->start[i + 1]; e++) {
        pc_index j = a->column[e];
        for (size_t f = b->start[j]; f < b->start[j + 1]; f++)
            (void)place(r, b->column[f]);
    }
}

/* Columns of coarse rows ascend: set-up looks for common neighbours. */
static void sort_pattern(row *r) {
    for (pc_index k = 1; k < r->count; k++) {
        pc_index column = r->list[k];
        pc_index to = k;
        for (; to > 0 && r->list[to - 1] > column; to--)
            r->list[to] = r->list[to - 1];
        r->list[to] = column;
    }
    for (pc_index k = 0; k < r->count; k++)
        r->slot[r->list[k]] = k;
}

PC_ALWAYS_INLINE void add_row(pc_block_form form, row *r, const pc_blockmat *b, const pc_blockval *v,
                              pc_index j) {
    const size_t size = (size_t)pc_form_size(pc_form_coarse(form));
    for (size_t f = b->start[j]; f < b->start[j + 1]; f++)
        pc_blockval_add_product(form, r->sum + size * place(r, b->column[f]), v, b->value + size * f, 1);
}

/* The diagonal block of row i as a stored block of the same form. */
PC_ALWAYS_INLINE void load_diagonal(pc_block_form form, pc_blockval *v, const pc_blockmat *a, pc_index i) {
    const int n = pc_form_size(form);
    v->turn = 0;
    if (form == PC_FORM_DENSE) {
        for (int k = 0; k < 16; k++)
            v->v[k] = (double)a->diagonal[16 * (size_t)i + (size_t)k];
        return;
    }
    for (int k = 0; k < n; k++)
        v->v[k] = (k & 1)             ? 0
                  : a->exact_diagonal ? a->exact_diagonal[i] * a->exact_scale
                                      : (double)a->diagonal[i];
}

PC_ALWAYS_INLINE void row_values(pc_block_form form, row *r, const product *p, pc_index i) {
    const size_t size = (size_t)pc_form_size(pc_form_coarse(form));
    const pc_blockmat *a = p->a;
    pc_blockval v;
    row_pattern(r, p, i);
    if (p->finish == SPLIT_DIAGONAL) sort_pattern(r);
    memset(r->sum, 0, r->count * size * sizeof *r->sum);
    if (r->count == 0) return;
    if (a->diagonal) {
        load_diagonal(form, &v, a, i);
        add_row(form, r, p->b, &v, i);
    }
    for (size_t e = a->start[i]; e < a->start[i + 1]; e++) {
        pc_blockval_load(form, &v, a, e);
        add_row(form, r, p->b, &v, a->column[e]);
    }
}

/* sum := T_i - omega D_i^-1 sum */
PC_ALWAYS_INLINE void smooth_row(pc_block_form form, row *r, const product *p, pc_index i) {
    const size_t size = (size_t)pc_form_size(pc_form_coarse(form));
    for (pc_index k = 0; k < r->count; k++) {
        double *s = r->sum + size * k;
        if (form == PC_FORM_DENSE) {
            const float *d = p->a->inverse + 16 * (size_t)i;
            double t[16];
            for (int u = 0; u < 16; u++)
                t[u] = (double)d[u / 4 * 4] * s[u % 4] + (double)d[u / 4 * 4 + 1] * s[4 + u % 4] +
                       (double)d[u / 4 * 4 + 2] * s[8 + u % 4] + (double)d[u / 4 * 4 + 3] * s[12 + u % 4];
            for (int u = 0; u < 16; u++)
                s[u] = -p->omega * t[u];
        } else {
            double f = -p->omega * (double)p->a->inverse[i];
            for (size_t u = 0; u < size; u++)
                s[u] *= f;
        }
    }
    size_t own = p->b->start[i];
    double *s = r->sum + size * place(r, p->b->column[own]);
    for (size_t u = 0; u < size; u++)
        s[u] += (double)p->b->value[size * own + u];
}

PC_ALWAYS_INLINE void put_row(pc_block_form form, const row *r, const product *p, pc_index i) {
    const size_t size = (size_t)pc_form_size(pc_form_coarse(form));
    size_t e = p->c->start[i];
    for (pc_index k = 0; k < r->count; k++) {
        const double *s = r->sum + size * k;
        if (p->finish == SPLIT_DIAGONAL && r->list[k] == i) {
            memcpy(p->diagonal + size * i, s, size * sizeof *s);
            continue;
        }
        p->c->column[e] = r->list[k];
        for (size_t u = 0; u < size; u++)
            p->c->value[size * e + u] = (float)s[u];
        e++;
    }
}

PC_ALWAYS_INLINE void fill_row(pc_block_form form, row *rows, const product *p, pc_index i) {
    row *r = &rows[omp_get_thread_num()];
    row_values(form, r, p, i);
    if (p->finish == SMOOTH && r->count > 0) smooth_row(form, r, p, i);
    put_row(form, r, p, i);
}

/* Row sizes into start[]; returns the largest row. */
static pc_index count_rows(pc_index *start, row *rows, const product *p) {
    pc_index largest = 0;
#pragma omp parallel for schedule(static) reduction(max : largest)
    for (pc_index i = 0; i < p->a->row_count; i++) {
        row *r = &rows[omp_get_thread_num()];
        row_pattern(r, p, i);
        pc_index n = r->count;
        if (n > largest) largest = n;
        if (p->finish == SPLIT_DIAGONAL && r->slot[i] < n && r->list[r->slot[i]] == i) n--;
        start[i + 1] = n;
    }
    return largest;
}

static pc_status multiply(product *p, pc_context *ctx) {
    pc_status status = PC_OK;
    row *rows = NULL;
    pc_index *start = NULL;
    const int threads = omp_get_max_threads();
    const pc_index n = p->a->row_count;
    const pc_block_form form = pc_form_coarse(p->a->form);
    size_t entries = 0;
    PC_TRY(pc_new(&rows, ctx, (size_t)threads));
    PC_TRY(pc_new(&start, ctx, (size_t)n + 1));
    for (int t = 0; t < threads; t++) {
        PC_TRY(pc_new(&rows[t].slot, ctx, p->b->column_count));
        PC_TRY(pc_new(&rows[t].list, ctx, p->b->column_count));
    }
    pc_index largest = count_rows(start, rows, p);
    for (pc_index i = 0; i < n; i++)
        entries += start[i + 1];
    PC_TRY(pc_blockmat_make(p->c, ctx, form, n, p->b->column_count, entries, p->finish == SPLIT_DIAGONAL));
    for (pc_index i = 0; i < n; i++)
        p->c->start[i + 1] = p->c->start[i] + start[i + 1];
    for (int t = 0; t < threads; t++)
        PC_TRY(pc_new(&rows[t].sum, ctx, (size_t)largest * (size_t)pc_form_size(form)));
#define ROW(form_of, i) fill_row(form_of, rows, p, i)
    PC_EACH_ROW(p->a->form, n, ROW);
#undef ROW
done:
    for (int t = 0; rows && t < threads; t++) {
        pc_free(ctx, rows[t].slot);
        pc_free(ctx, rows[t].list);
        pc_free(ctx, rows[t].sum);
    }
    pc_free(ctx, rows);
    pc_free(ctx, start);
    return status;
}

pc_status pc_galerkin_smooth(pc_blockmat *prolongator, pc_context *ctx, const pc_blockmat *matrix,
                             const pc_blockmat *tentative, double omega) {
    product p = {.c = prolongator, .a = matrix, .b = tentative, .finish = SMOOTH, .omega = omega};
    *prolongator = (pc_blockmat){0};
    return multiply(&p, ctx);
}

pc_status pc_galerkin_transpose(pc_blockmat *restriction, pc_context *ctx, const pc_blockmat *prolongator) {
    const pc_blockmat *p = prolongator;
    const pc_block_form form = p->form;
    const size_t size = (size_t)pc_form_size(form);
    const size_t entries = p->start[p->row_count];
    pc_status status = PC_OK;
    pc_index *source = NULL;
    *restriction = (pc_blockmat){0};
    PC_TRY(pc_new(&source, ctx, entries));
    PC_TRY(pc_blockmat_make(restriction, ctx, form, p->column_count, p->row_count, entries, false));
    pc_blockmat *r = restriction;
    for (size_t e = 0; e < entries; e++)
        r->start[p->column[e] + 1]++;
    for (pc_index c = 0; c < p->column_count; c++)
        r->start[c + 1] += r->start[c];
    for (pc_index i = 0; i < p->row_count; i++) {
        for (pc_index e = p->start[i]; e < p->start[i + 1]; e++) {
            pc_index to = r->start[p->column[e]]++;
            r->column[to] = i;
            source[to] = e;
        }
    }
    for (pc_index c = p->column_count; c > 0; c--)
        r->start[c] = r->start[c - 1];
    r->start[0] = 0;
#pragma omp parallel for schedule(static)
    for (size_t e = 0; e < entries; e++) {
        const float *from = p->value + size * source[e];
        float *to = r->value + size * e;
        if (form == PC_FORM_DENSE) {
            for (int k = 0; k < 16; k++)
                to[k] = from[k % 4 * 4 + k / 4];
        } else {
            to[0] = from[0];
            if (form == PC_FORM_COMPLEX) to[1] = -from[1];
        }
    }
done:
    pc_free(ctx, source);
    if (status != PC_OK) pc_blockmat_free(restriction, ctx);
    return status;
}

void pc_galerkin_invert_diagonal(pc_blockmat *matrix) {
    const double least = 1e-6;
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < matrix->row_count; i++) {
        if (matrix->form == PC_FORM_DENSE) {
            double m[16];
            double inverse[16];
            for (int k = 0; k < 16; k++)
                m[k] = (double)matrix->diagonal[16 * (size_t)i + (size_t)k];
            pc_smallmat_inverse4(inverse, m, least);
            for (int k = 0; k < 16; k++)
                matrix->inverse[16 * (size_t)i + (size_t)k] = (float)inverse[k];
        } else {
            matrix->inverse[i] = 1 / matrix->diagonal[i];
        }
    }
}

/* What the diagonal of coarse row i would be without cancellation: sum |R_Ii|^2 d_i. */
static double uncancelled(const pc_blockmat *r, const pc_blockmat *a, pc_index i) {
    const size_t size = (size_t)pc_form_size(r->form);
    double total = 0;
    for (size_t e = r->start[i]; e < r->start[i + 1]; e++) {
        double square = 0;
        for (size_t k = 0; k < size; k++)
            square += (double)r->value[size * e + k] * (double)r->value[size * e + k];
        size_t d = (size_t)pc_form_diagonal(a->form) * r->column[e];
        total += (r->form == PC_FORM_DENSE ? 0.25 : 1) * square * (double)a->diagonal[d];
    }
    return total;
}

static void put_diagonals(pc_blockmat *c, const double *diagonal, const pc_blockmat *r,
                          const pc_blockmat *a) {
    const double rounding = 1e-7;
    const size_t size = (size_t)pc_form_size(c->form);
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < c->row_count; i++) {
        const double *d = diagonal + size * i;
        double mean = c->form == PC_FORM_DENSE ? 0.25 * (d[0] + d[5] + d[10] + d[15]) : d[0];
        double least = rounding * uncancelled(r, a, i);
        double raise = mean < least ? least - mean : 0;
        if (c->form == PC_FORM_DENSE) {
            float *to = c->diagonal + 16 * (size_t)i;
            for (int k = 0; k < 16; k++)
                to[k] = (float)(0.5 * (d[k] + d[k % 4 * 4 + k / 4]) + (k % 5 == 0 ? raise : 0));
        } else {
            c->diagonal[i] = (float)(mean + raise);
        }
    }
    pc_galerkin_invert_diagonal(c);
}

pc_status pc_galerkin_coarse(pc_blockmat *coarse, pc_context *ctx, const pc_blockmat *restriction,
                             const pc_blockmat *matrix, const pc_blockmat *prolongator) {
    pc_status status = PC_OK;
    pc_blockmat ap = {0};
    double *diagonal = NULL;
    *coarse = (pc_blockmat){0};
    product first = {.c = &ap, .a = matrix, .b = prolongator, .finish = KEEP};
    PC_TRY(multiply(&first, ctx));
    PC_TRY(pc_new(&diagonal, ctx, (size_t)restriction->row_count * (size_t)pc_form_size(restriction->form)));
    product second = {
        .c = coarse, .a = restriction, .b = &ap, .finish = SPLIT_DIAGONAL, .diagonal = diagonal};
    PC_TRY(multiply(&second, ctx));
    put_diagonals(coarse, diagonal, restriction, matrix);
done:
    pc_blockmat_free(&ap, ctx);
    pc_free(ctx, diagonal);
    if (status != PC_OK) pc_blockmat_free(coarse, ctx);
    return status;
}
