#include "galerkin.h"
#include "blockalg.h"
#include "memory.h"
#include <omp.h>

/* What a matrix product leaves in a row. */
typedef enum finish { KEEP, SMOOTH, SPLIT_DIAGONAL } finish;

typedef struct product {
    pc_blockmat *c;
    const pc_blockmat *a;
    const pc_blockmat *b;
    finish finish;
    double omega;
    double *diagonal; /* SPLIT_DIAGONAL: what is on it, as many per row as pc_form_diagonal */
} product;

/* A sparse row under construction. Its entries go by keys: the column, for TURNED 4 column + turn. slot[]
 * needs no clearing. Each thread has one, and works on a copy that the compiler can keep in registers. */
typedef struct row {
    pc_index *slot; /* per key: its place in list, if list agrees */
    pc_index *list; /* keys */
    pc_index *rank; /* places in the order of the keys */
    pc_index count;
    double *sum;
} row;

PC_ALWAYS_INLINE pc_index key_of(pc_block_form form, pc_index column, int turn) {
    return form == PC_FORM_TURNED ? 4 * column + (pc_index)turn : column;
}

PC_ALWAYS_INLINE void note_row(pc_block_form form, row *r, const pc_blockmat *b, pc_index j, int turn) {
    for (size_t f = b->start[j]; f < b->start[j + 1]; f++) {
        int whole = form == PC_FORM_TURNED ? (turn + b->turn[f]) & 3 : 0;
        pc_index key = key_of(form, b->column[f], whole);
        pc_index k = r->slot[key];
        if (k < r->count && r->list[k] == key) continue;
        r->slot[key] = r->count;
        r->list[r->count++] = key;
    }
}

/* Counts the entries of row i into start[i + 1]. */
PC_ALWAYS_INLINE void count_row(pc_block_form form, pc_index *start, const row *rows, const product *p,
                                pc_index i) {
    const pc_blockmat *a = p->a;
    row own = rows[omp_get_thread_num()];
    row *r = &own;
    if (p->finish != SMOOTH || p->b->start[i] < p->b->start[i + 1]) {
        if (a->diagonal) note_row(form, r, p->b, i, 0);
        for (size_t e = a->start[i]; e < a->start[i + 1]; e++)
            note_row(form, r, p->b, a->column[e], form == PC_FORM_TURNED ? a->turn[e] : 0);
    }
    pc_index n = r->count;
    if (p->finish == SPLIT_DIAGONAL) {
        pc_index k = r->slot[key_of(form, i, 0)];
        if (k < n && r->list[k] == key_of(form, i, 0)) n--;
    }
    start[i + 1] = n;
}

/* The place of a key in the row; its sum is zero where it is new. */
PC_ALWAYS_INLINE double *sum_at(pc_block_form form, row *r, pc_index key) {
    const size_t size = (size_t)pc_form_size(form);
    pc_index k = r->slot[key];
    if (k < r->count && r->list[k] == key) return r->sum + size * k;
    k = r->slot[key] = r->count++;
    r->list[k] = key;
    for (size_t u = 0; u < size; u++)
        r->sum[size * k + u] = 0;
    return r->sum + size * k;
}

/* row += v * row j of b */
PC_ALWAYS_INLINE void add_row(pc_block_form form, row *r, const pc_blockmat *b, const pc_blockval *v,
                              pc_index j) {
    const size_t size = (size_t)pc_form_size(form);
    for (size_t f = b->start[j]; f < b->start[j + 1]; f++) {
        double value[4];
        for (size_t u = 0; u < size; u++)
            value[u] = (double)b->value[size * f + u];
        int whole = form == PC_FORM_TURNED ? (v->turn + b->turn[f]) & 3 : 0;
        pc_blockval_add_product(form, sum_at(form, r, key_of(form, b->column[f], whole)), v, value);
    }
}

/* The diagonal block of row i as a stored block of the same form. */
PC_ALWAYS_INLINE void load_diagonal(pc_block_form form, pc_blockval *v, const pc_blockmat *a, pc_index i) {
    const size_t per_row = (size_t)pc_form_diagonal(form);
    v->turn = 0;
    for (size_t k = 0; k < (size_t)pc_form_size(form); k++)
        v->v[k] = (k & 1)             ? 0
                  : a->exact_diagonal ? a->exact_diagonal[i] * a->exact_scale
                                      : (double)a->diagonal[per_row * i + k / 2];
}

PC_ALWAYS_INLINE void row_values(pc_block_form form, row *r, const product *p, pc_index i) {
    const pc_blockmat *a = p->a;
    pc_blockval v;
    if (p->finish == SMOOTH && p->b->start[i] == p->b->start[i + 1]) return;
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
    const size_t size = (size_t)pc_form_size(form);
    const float *inverse = p->a->inverse + (size_t)pc_form_diagonal(form) * i;
    for (size_t u = 0; u < size * r->count; u++)
        r->sum[u] *= -p->omega * (double)inverse[form == PC_FORM_TURNED ? u % 4 / 2 : 0];
    for (size_t f = p->b->start[i]; f < p->b->start[i + 1]; f++) {
        int turn = form == PC_FORM_TURNED ? p->b->turn[f] : 0;
        double *s = sum_at(form, r, key_of(form, p->b->column[f], turn));
        for (size_t u = 0; u < size; u++)
            s[u] += (double)p->b->value[size * f + u];
    }
}

/* Ranks the entries by key: set-up looks for common neighbours of coarse rows. */
static void rank_row(const row *r) {
    for (pc_index k = 0; k < r->count; k++) {
        pc_index to = k;
        for (; to > 0 && r->list[r->rank[to - 1]] > r->list[k]; to--)
            r->rank[to] = r->rank[to - 1];
        r->rank[to] = k;
    }
}

PC_ALWAYS_INLINE void put_row(pc_block_form form, const row *r, const product *p, pc_index i) {
    const size_t size = (size_t)pc_form_size(form);
    const size_t per_row = (size_t)pc_form_diagonal(form);
    size_t e = p->c->start[i];
    if (p->finish == SPLIT_DIAGONAL) rank_row(r);
    for (pc_index at = 0; at < r->count; at++) {
        pc_index k = p->finish == SPLIT_DIAGONAL ? r->rank[at] : at;
        const double *s = r->sum + size * k;
        if (p->finish == SPLIT_DIAGONAL && r->list[k] == key_of(form, i, 0)) {
            for (size_t u = 0; u < per_row; u++)
                p->diagonal[per_row * i + u] = s[2 * u];
            continue;
        }
        p->c->column[e] = form == PC_FORM_TURNED ? r->list[k] / 4 : r->list[k];
        if (form == PC_FORM_TURNED) p->c->turn[e] = (uint8_t)(r->list[k] % 4);
        for (size_t u = 0; u < size; u++)
            p->c->value[size * e + u] = (float)s[u];
        e++;
    }
}

PC_ALWAYS_INLINE void fill_row(pc_block_form form, const row *rows, const product *p, pc_index i) {
    row own = rows[omp_get_thread_num()];
    row *r = &own;
    row_values(form, r, p, i);
    if (p->finish == SMOOTH && r->count > 0) smooth_row(form, r, p, i);
    put_row(form, r, p, i);
}

static pc_status make_rows(row *rows, pc_context *ctx, const product *p, int threads) {
    const size_t keys = p->b->column_count * (p->a->form == PC_FORM_TURNED ? (size_t)4 : 1);
    pc_status status = PC_OK;
    for (int t = 0; t < threads; t++) {
        PC_TRY(pc_new(&rows[t].slot, ctx, keys));
        PC_TRY(pc_new(&rows[t].list, ctx, keys));
    }
done:
    return status;
}

static void free_rows(row *rows, pc_context *ctx, int threads) {
    for (int t = 0; rows && t < threads; t++) {
        pc_free(ctx, rows[t].slot);
        pc_free(ctx, rows[t].list);
        pc_free(ctx, rows[t].rank);
        pc_free(ctx, rows[t].sum);
    }
    pc_free(ctx, rows);
}

static pc_status multiply(product *p, pc_context *ctx) {
    pc_status status = PC_OK;
    row *rows = NULL;
    pc_index *start = NULL;
    const int threads = omp_get_max_threads();
    const pc_index n = p->a->row_count;
    const pc_block_form form = p->a->form;
    size_t entries = 0, largest = 0;
    PC_TRY(pc_new(&rows, ctx, (size_t)threads));
    PC_TRY(pc_new(&start, ctx, (size_t)n + 1));
    PC_TRY(make_rows(rows, ctx, p, threads));
#define COUNT(form_of, i) count_row(form_of, start, rows, p, i)
    PC_EACH_ROW(form, n, COUNT);
#undef COUNT
    for (pc_index i = 0; i < n; i++) {
        entries += start[i + 1];
        if (start[i + 1] >= largest) largest = start[i + 1] + (size_t)1;
    }
    PC_TRY(pc_blockmat_make(p->c, ctx, form, n, p->b->column_count, entries, p->finish == SPLIT_DIAGONAL));
    for (pc_index i = 0; i < n; i++)
        p->c->start[i + 1] = p->c->start[i] + start[i + 1];
    for (int t = 0; t < threads; t++) {
        PC_TRY(pc_new(&rows[t].sum, ctx, largest * (size_t)pc_form_size(form)));
        PC_TRY(pc_new(&rows[t].rank, ctx, largest));
    }
#define ROW(form_of, i) fill_row(form_of, rows, p, i)
    PC_EACH_ROW(form, n, ROW);
#undef ROW
done:
    free_rows(rows, ctx, threads);
    pc_free(ctx, start);
    return status;
}

pc_status pc_galerkin_smooth(pc_blockmat *prolongator, pc_context *ctx, const pc_blockmat *matrix,
                             const pc_blockmat *tentative, double omega) {
    product p = {.c = prolongator, .a = matrix, .b = tentative, .finish = SMOOTH, .omega = omega};
    *prolongator = (pc_blockmat){0};
    return multiply(&p, ctx);
}

PC_ALWAYS_INLINE void transpose_entry(pc_block_form form, pc_blockmat *r, size_t to, const pc_blockmat *p,
                                      size_t from) {
    pc_blockval in;
    pc_blockval out;
    pc_blockval_load(form, &in, p, from);
    pc_blockval_transpose(form, &out, &in);
    for (size_t k = 0; k < (size_t)pc_form_size(form); k++)
        r->value[(size_t)pc_form_size(form) * to + k] = (float)out.v[k];
    if (form == PC_FORM_TURNED) r->turn[to] = (uint8_t)out.turn;
}

pc_status pc_galerkin_transpose(pc_blockmat *restriction, pc_context *ctx, const pc_blockmat *prolongator) {
    const pc_blockmat *p = prolongator;
    const pc_block_form form = p->form;
    const size_t entries = p->start[p->row_count];
    pc_status status = PC_OK;
    pc_index *source = NULL;
    *restriction = (pc_blockmat){0};
    PC_TRY(pc_resize(&source, ctx, entries));
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
#define ENTRY(form_of, e) transpose_entry(form_of, r, e, p, source[e])
    PC_EACH_ROW(form, (pc_index)entries, ENTRY);
#undef ENTRY
done:
    pc_free(ctx, source);
    if (status != PC_OK) pc_blockmat_free(restriction, ctx);
    return status;
}

void pc_galerkin_invert_diagonal(pc_blockmat *matrix) {
    const size_t n = matrix->row_count * (size_t)pc_form_diagonal(matrix->form);
    for (size_t i = 0; i < n; i++)
        matrix->inverse[i] = 1 / matrix->diagonal[i];
}

/* What the diagonal of coarse row i would be without cancellation: sum |R_Ii|^2 d_i. */
static void uncancelled(double total[2], const pc_blockmat *r, const pc_blockmat *a, pc_index i) {
    const size_t size = (size_t)pc_form_size(r->form);
    total[0] = total[1] = 0;
    for (size_t e = r->start[i]; e < r->start[i + 1]; e++) {
        double d = pc_blockmat_mean_diagonal(a, r->column[e]);
        for (size_t k = 0; k < size; k++)
            total[k / 2] += d * (double)r->value[size * e + k] * (double)r->value[size * e + k];
    }
}

static void put_diagonals(pc_blockmat *c, const double *diagonal, const pc_blockmat *r,
                          const pc_blockmat *a) {
    const double rounding = 1e-7;
    const size_t per_row = (size_t)pc_form_diagonal(c->form);
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < c->row_count; i++) {
        double whole[2];
        uncancelled(whole, r, a, i);
        for (size_t k = 0; k < per_row; k++)
            c->diagonal[per_row * i + k] = (float)fmax(diagonal[per_row * i + k], rounding * whole[k]);
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
    PC_TRY(
        pc_new(&diagonal, ctx, (size_t)restriction->row_count * (size_t)pc_form_diagonal(restriction->form)));
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
