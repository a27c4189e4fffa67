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
    pc_index *length; /* per row: its entries, but for such a diagonal */
} product;

/* Entries of finished rows, by keys: the column, for TURNED 4 column + turn. */
typedef struct chunk {
    struct chunk *next;
    pc_index first; /* row */
    size_t count, room;
    pc_index *key;
    float *value;
} chunk;

/* A sparse row under construction. slot[] needs no clearing: what earlier rows left there is below `base`.
 * Never handed to a function that is not inlined: compilers then keep it in registers. */
typedef struct row {
    pc_index *slot; /* per key: base + place in the row */
    pc_index *list; /* keys */
    double *sum;    /* zero from `count` on */
    pc_index base, count;
} row;

/* What a thread works with: space for a row, and the rows that are finished. */
typedef struct worker {
    row space;
    chunk *head, *last;
    pc_status status;
} worker;

PC_ALWAYS_INLINE pc_index key_of(pc_block_form form, pc_index column, int turn) {
    return form == PC_FORM_TURNED ? 4 * column + (pc_index)turn : column;
}

/* The sum that goes by a key. Without branches: they would go either way as if by chance. */
PC_ALWAYS_INLINE double *sum_at(pc_block_form form, row *r, pc_index key) {
    const pc_index at = r->slot[key];
    const pc_index fresh = at < r->base;
    const pc_index place = (r->count & (0 - fresh)) | ((at - r->base) & (fresh - 1));
    r->slot[key] = r->base + place;
    r->list[place] = key;
    r->count += fresh;
    return r->sum + (size_t)pc_form_size(form) * place;
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

/* A chunk for row i, which has `count` entries, and for what follows. */
static bool next_chunk(worker *w, pc_context *ctx, size_t size, pc_index i, pc_index count, pc_index base) {
    enum { ROOM = 1 << 15 };
    const size_t room = count > ROOM ? count : ROOM;
    char *block = NULL;
    w->status = base < PC_NONE - room
                    ? pc_resize(&block, ctx, sizeof(chunk) + room * (size + 1) * sizeof(float))
                    : pc_fail(ctx, PC_E_MESH, "a multigrid level is beyond 32-bit offsets");
    if (!block) return false;
    chunk *c = (chunk *)(void *)block;
    *c = (chunk){.first = i, .room = room};
    c->key = (pc_index *)(void *)(block + sizeof *c);
    c->value = (float *)(void *)(c->key + room);
    if (w->last)
        w->last->next = c;
    else
        w->head = c;
    w->last = c;
    return true;
}

/* Moves the row to the chunk; its sums are zero again. */
PC_ALWAYS_INLINE void put_row(pc_block_form form, row *r, chunk *c, const product *p, pc_index i) {
    const size_t size = (size_t)pc_form_size(form);
    const size_t per_row = (size_t)pc_form_diagonal(form);
    const pc_index own = p->finish == SPLIT_DIAGONAL ? key_of(form, i, 0) : PC_NONE;
    size_t e = c->count;
    for (pc_index k = 0; k < r->count; k++) {
        const double *s = r->sum + size * k;
        c->key[e] = r->list[k];
        for (size_t u = 0; u < size; u++)
            c->value[size * e + u] = (float)s[u];
        if (r->list[k] != own) {
            e++;
            continue;
        }
        for (size_t u = 0; u < per_row; u++)
            p->diagonal[per_row * i + u] = s[2 * u];
    }
    memset(r->sum, 0, size * r->count * sizeof *r->sum);
    p->length[i] = (pc_index)(e - c->count);
    c->count = e;
    r->base += r->count;
    r->count = 0;
}

PC_ALWAYS_INLINE void fill_rows(pc_block_form form, worker *w, pc_context *ctx, const product *p,
                                pc_index from, pc_index to) {
    row r = w->space;
    for (pc_index i = from; i < to; i++) {
        row_values(form, &r, p, i);
        if (p->finish == SMOOTH && r.count > 0) smooth_row(form, &r, p, i);
        if ((!w->last || w->last->count + r.count > w->last->room) &&
            !next_chunk(w, ctx, (size_t)pc_form_size(form), i, r.count, r.base))
            break;
        put_row(form, &r, w->last, p, i);
    }
}

/* The rows in equal runs, one for each thread. */
static pc_status fill(worker *workers, pc_context *ctx, const product *p, int threads) {
    const size_t n = p->a->row_count;
    pc_status status = PC_OK;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int t = 0; t < threads; t++) {
        const pc_index from = (pc_index)(n * (size_t)t / (size_t)threads);
        const pc_index to = (pc_index)(n * ((size_t)t + 1) / (size_t)threads);
        if (p->a->form == PC_FORM_SCALAR) fill_rows(PC_FORM_SCALAR, &workers[t], ctx, p, from, to);
        if (p->a->form == PC_FORM_COMPLEX) fill_rows(PC_FORM_COMPLEX, &workers[t], ctx, p, from, to);
        if (p->a->form == PC_FORM_TURNED) fill_rows(PC_FORM_TURNED, &workers[t], ctx, p, from, to);
    }
    for (int t = 0; t < threads && status == PC_OK; t++)
        status = workers[t].status;
    return status;
}

static size_t longest_row(const pc_blockmat *m) {
    pc_index longest = 0;
    for (pc_index i = 0; i < m->row_count; i++) {
        pc_index length = m->start[i + 1] - m->start[i];
        if (length > longest) longest = length;
    }
    return longest;
}

static pc_status make_workers(worker *workers, pc_context *ctx, const product *p, int threads) {
    const size_t keys = p->b->column_count * (p->a->form == PC_FORM_TURNED ? (size_t)4 : 1);
    const size_t most = (longest_row(p->a) + 1) * longest_row(p->b);
    const size_t room = 1 + (most < keys ? most : keys);
    pc_status status = PC_OK;
    for (int t = 0; t < threads; t++) {
        workers[t].space.base = 1;
        PC_TRY(pc_new(&workers[t].space.slot, ctx, keys));
        PC_TRY(pc_new(&workers[t].space.list, ctx, room));
        PC_TRY(pc_new(&workers[t].space.sum, ctx, room * (size_t)pc_form_size(p->a->form)));
    }
done:
    return status;
}

static void free_workers(worker *workers, pc_context *ctx, int threads) {
    for (int t = 0; workers && t < threads; t++) {
        pc_free(ctx, workers[t].space.slot);
        pc_free(ctx, workers[t].space.list);
        pc_free(ctx, workers[t].space.sum);
        while (workers[t].head) {
            chunk *next = workers[t].head->next;
            pc_free(ctx, workers[t].head);
            workers[t].head = next;
        }
    }
    pc_free(ctx, workers);
}

/* The chunks of a thread to their places. */
static void keep_chunks(pc_blockmat *c, pc_context *ctx, worker *w) {
    const size_t size = (size_t)pc_form_size(c->form);
    while (w->head) {
        chunk *from = w->head;
        const size_t to = c->start[from->first];
        for (size_t e = 0; e < from->count; e++)
            c->column[to + e] = c->form == PC_FORM_TURNED ? from->key[e] / 4 : from->key[e];
        for (size_t e = 0; c->turn && e < from->count; e++)
            c->turn[to + e] = (uint8_t)(from->key[e] % 4);
        memcpy(c->value + size * to, from->value, size * from->count * sizeof *from->value);
        w->head = from->next;
        pc_free(ctx, from);
    }
}
/* Entry e of a chunk, of row i, to its transposed place. */
PC_ALWAYS_INLINE void turn_entry(pc_block_form form, pc_blockmat *c, const chunk *from, size_t e,
                                 pc_index i) {
    const size_t size = (size_t)pc_form_size(form);
    const pc_index column = form == PC_FORM_TURNED ? from->key[e] / 4 : from->key[e];
    const size_t to = c->start[column]++;
    pc_blockval in, out;
    in.turn = form == PC_FORM_TURNED ? (int)(from->key[e] % 4) : 0;
    for (size_t k = 0; k < size; k++)
        in.v[k] = (double)from->value[size * e + k];
    pc_blockval_transpose(form, &out, &in);
    c->column[to] = i;
    if (form == PC_FORM_TURNED) c->turn[to] = (uint8_t)out.turn;
    for (size_t k = 0; k < size; k++)
        c->value[size * to + k] = (float)out.v[k];
}

PC_ALWAYS_INLINE void turn_chunks(pc_block_form form, pc_blockmat *c, pc_context *ctx, const product *p,
                                  worker *w) {
    while (w->head) {
        chunk *from = w->head;
        pc_index i = from->first;
        for (size_t e = 0; e < from->count; i++)
            for (size_t end = e + p->length[i]; e < end; e++)
                turn_entry(form, c, from, e, i);
        w->head = from->next;
        pc_free(ctx, from);
    }
}

/* Offsets from the numbers of entries that stand one place further on. */
static void add_up(pc_index *start, pc_index rows) {
    for (pc_index i = 0; i < rows; i++)
        start[i + 1] += start[i];
}

/* After each offset has run to the next one. */
static void run_back(pc_index *start, pc_index rows) {
    for (pc_index i = rows; i > 0; i--)
        start[i] = start[i - 1];
    start[0] = 0;
}

/* The transpose of what was found. For a symmetric product it is the product, and has its columns in order.
 */
static void keep_transposed(pc_context *ctx, const product *p, worker *workers, int threads) {
    pc_blockmat *c = p->c;
    const pc_index per_column = c->form == PC_FORM_TURNED ? 4 : 1;
    for (int t = 0; t < threads; t++)
        for (const chunk *from = workers[t].head; from; from = from->next)
            for (size_t e = 0; e < from->count; e++)
                c->start[from->key[e] / per_column + 1]++;
    add_up(c->start, c->row_count);
    for (int t = 0; t < threads; t++) {
        if (c->form == PC_FORM_SCALAR) turn_chunks(PC_FORM_SCALAR, c, ctx, p, &workers[t]);
        if (c->form == PC_FORM_COMPLEX) turn_chunks(PC_FORM_COMPLEX, c, ctx, p, &workers[t]);
        if (c->form == PC_FORM_TURNED) turn_chunks(PC_FORM_TURNED, c, ctx, p, &workers[t]);
    }
    run_back(c->start, c->row_count);
}

static pc_status multiply(product *p, pc_context *ctx) {
    pc_status status = PC_OK;
    worker *workers = NULL;
    const pc_index n = p->a->row_count;
    const int threads = n > PC_PARALLEL_ROWS ? omp_get_max_threads() : 1;
    size_t entries = 0;
    PC_TRY(pc_new(&workers, ctx, (size_t)threads));
    PC_TRY(pc_new(&p->length, ctx, n));
    PC_TRY(make_workers(workers, ctx, p, threads));
    PC_TRY(fill(workers, ctx, p, threads));
    for (pc_index i = 0; i < n; i++)
        entries += p->length[i];
    PC_TRY(
        pc_blockmat_make(p->c, ctx, p->a->form, n, p->b->column_count, entries, p->finish == SPLIT_DIAGONAL));
    if (p->finish == SPLIT_DIAGONAL) {
        keep_transposed(ctx, p, workers, threads);
    } else {
        memcpy(p->c->start + 1, p->length, n * sizeof *p->length);
        add_up(p->c->start, n);
#pragma omp parallel for schedule(static) num_threads(threads)
        for (int t = 0; t < threads; t++)
            keep_chunks(p->c, ctx, &workers[t]);
    }
done:
    free_workers(workers, ctx, threads);
    pc_free(ctx, p->length);
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
    add_up(r->start, p->column_count);
    for (pc_index i = 0; i < p->row_count; i++) {
        for (pc_index e = p->start[i]; e < p->start[i + 1]; e++) {
            pc_index to = r->start[p->column[e]]++;
            r->column[to] = i;
            source[to] = e;
        }
    }
    run_back(r->start, p->column_count);
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
