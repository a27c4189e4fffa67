#include "galerkin.h"
#include "blockalg.h"
#include "memory.h"
#include <omp.h>

/* A product that is made row by row: C = (1 - omega D^-1 A) B where `middle` is NULL, else C = A middle B
 * with its diagonal apart. */
typedef struct product {
    pc_blockmat *c;
    const pc_blockmat *a;
    const pc_blockmat *middle;
    const pc_blockmat *b;
    double omega;
    double *diagonal; /* what is on it, as many per row as pc_form_diagonal; NULL without `middle` */
    pc_index *length; /* per row: its entries, but for the diagonal */
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

/* What a thread works with: space for a row of the product and for one of A middle, and the rows that are
 * finished. */
typedef struct worker {
    row space, inner;
    uint64_t *sorted; /* of the row's keys, with their places */
    chunk *head, *last;
    pc_status status;
} worker;

PC_ALWAYS_INLINE pc_index key_of(pc_block_form form, pc_index column, int turn) {
    return form == PC_FORM_TURNED ? 4 * column + (pc_index)turn : column;
}

static size_t key_count(pc_block_form form, const pc_blockmat *m) {
    return m->column_count * (form == PC_FORM_TURNED ? (size_t)4 : 1);
}

/* The sum that goes by a key. Without branches: they would go either way as if by chance. What earlier rows
 * left wraps around to large numbers. */
PC_ALWAYS_INLINE double *sum_at(pc_block_form form, row *r, pc_index key) {
    const pc_index at = r->slot[key] - r->base;
    const pc_index place = at < r->count ? at : r->count;
    r->slot[key] = r->base + place;
    r->list[place] = key;
    r->count += place == r->count;
    return r->sum + (size_t)pc_form_size(form) * place;
}

/* row += v * row j of b */
PC_ALWAYS_INLINE void add_row(pc_block_form form, row *r, const pc_blockmat *b, const pc_blockval *v,
                              pc_index j) {
    const size_t size = (size_t)pc_form_size(form);
    const size_t end = b->start[j + 1];
    for (size_t f = b->start[j]; f < end; f++) {
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

/* row += row i of the square matrix a times b */
PC_ALWAYS_INLINE void add_square_row(pc_block_form form, row *r, const pc_blockmat *a, const pc_blockmat *b,
                                     pc_index i) {
    pc_blockval v;
    load_diagonal(form, &v, a, i);
    add_row(form, r, b, &v, i);
    for (size_t e = a->start[i]; e < a->start[i + 1]; e++) {
        pc_blockval_load(form, &v, a, e);
        add_row(form, r, b, &v, a->column[e]);
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
static bool next_chunk(worker *w, pc_context *ctx, size_t size, pc_index i, pc_index count) {
    enum { ROOM = 1 << 18 };
    const size_t room = count > ROOM ? count : ROOM;
    char *block = NULL;
    w->status = pc_resize(&block, ctx, sizeof(chunk) + room * (size + 1) * sizeof(float));
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

/* The row is empty again. */
PC_ALWAYS_INLINE void clear_row(pc_block_form form, row *r, size_t keys) {
    memset(r->sum, 0, (size_t)pc_form_size(form) * r->count * sizeof *r->sum);
    r->base += r->count;
    r->count = 0;
    if (r->base < PC_NONE / 2) return;
    memset(r->slot, 0, keys * sizeof *r->slot);
    r->base = 1;
}

PC_ALWAYS_INLINE void put_entry(pc_block_form form, pc_index *key, float *value, const row *r, pc_index k) {
    const size_t size = (size_t)pc_form_size(form);
    *key = r->list[k];
    for (size_t u = 0; u < size; u++)
        value[u] = (float)r->sum[size * k + u];
}

/* Copies the row to the chunk, its diagonal apart. */
PC_ALWAYS_INLINE void put_row(pc_block_form form, const row *r, const uint64_t *sorted, chunk *c,
                              const product *p, pc_index i) {
    const size_t size = (size_t)pc_form_size(form);
    const size_t per_row = (size_t)pc_form_diagonal(form);
    const pc_index own = p->middle ? key_of(form, i, 0) : PC_NONE;
    size_t e = c->count;
    for (pc_index n = 0; n < r->count; n++) {
        const pc_index k = sorted ? (pc_index)sorted[n] : n;
        if (r->list[k] != own) {
            put_entry(form, c->key + e, c->value + size * e, r, k);
            e++;
            continue;
        }
        for (size_t u = 0; u < per_row; u++)
            p->diagonal[per_row * i + u] = r->sum[size * k + 2 * u];
    }
    p->length[i] = (pc_index)(e - c->count);
    c->count = e;
}

/* The row's keys in ascending order. */
static void sort_keys(uint64_t *sorted, const pc_index *list, pc_index count) {
    static const pc_index gaps[] = {1750, 701, 301, 132, 57, 23, 10, 4, 1};
    for (pc_index k = 0; k < count; k++)
        sorted[k] = (uint64_t)list[k] << 32 | k;
    for (size_t g = 0; g < sizeof gaps / sizeof *gaps; g++) {
        const pc_index gap = gaps[g];
        for (pc_index k = gap; k < count; k++) {
            const uint64_t now = sorted[k];
            pc_index at = k;
            for (; at >= gap && sorted[at - gap] > now; at -= gap)
                sorted[at] = sorted[at - gap];
            sorted[at] = now;
        }
    }
}

/* inner += v * row j of the square matrix a */
PC_ALWAYS_INLINE void add_inner(pc_block_form form, row *inner, const pc_blockmat *a, const pc_blockval *v,
                                pc_index j) {
    pc_blockval factor;
    load_diagonal(form, &factor, a, j);
    pc_blockval_add_product(form, sum_at(form, inner, key_of(form, j, v->turn)), v, factor.v);
    const size_t end = a->start[j + 1];
    for (size_t e = a->start[j]; e < end; e++) {
        pc_blockval_load(form, &factor, a, e);
        double *sum = sum_at(form, inner, key_of(form, a->column[e], (v->turn + factor.turn) & 3));
        pc_blockval_add_product(form, sum, v, factor.v);
    }
}

/* row = row i of A middle B */
PC_ALWAYS_INLINE void add_coarse_row(pc_block_form form, row *r, row *inner, const product *p, pc_index i) {
    const size_t size = (size_t)pc_form_size(form);
    pc_blockval v;
    for (size_t e = p->a->start[i]; e < p->a->start[i + 1]; e++) {
        pc_blockval_load(form, &v, p->a, e);
        add_inner(form, inner, p->middle, &v, p->a->column[e]);
    }
    for (pc_index k = 0; k < inner->count; k++) {
        const pc_index key = inner->list[k];
        memcpy(v.v, inner->sum + size * k, size * sizeof *v.v);
        v.turn = form == PC_FORM_TURNED ? (int)(key & 3) : 0;
        add_row(form, r, p->b, &v, form == PC_FORM_TURNED ? key / 4 : key);
    }
}

PC_ALWAYS_INLINE void fill_rows(pc_block_form form, worker *w, pc_context *ctx, const product *p,
                                pc_index from, pc_index to) {
    row r = w->space;
    row inner = w->inner;
    for (pc_index i = from; i < to; i++) {
        if (p->middle) {
            add_coarse_row(form, &r, &inner, p, i);
            clear_row(form, &inner, key_count(form, p->middle));
            sort_keys(w->sorted, r.list, r.count);
        } else if (p->b->start[i] < p->b->start[i + 1]) {
            add_square_row(form, &r, p->a, p->b, i);
            smooth_row(form, &r, p, i);
        }
        if ((!w->last || w->last->count + r.count > w->last->room) &&
            !next_chunk(w, ctx, (size_t)pc_form_size(form), i, r.count))
            break;
        put_row(form, &r, p->middle ? w->sorted : NULL, w->last, p, i);
        clear_row(form, &r, key_count(form, p->b));
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

/* What no sum of so many rows of b has more entries than. */
static size_t most_entries(size_t rows, const pc_blockmat *b) {
    const size_t keys = key_count(b->form, b);
    const size_t longest = longest_row(b) + 1;
    return 1 + (rows < keys / longest ? rows * longest : keys);
}

static pc_status make_row(row *r, pc_context *ctx, size_t room, const pc_blockmat *b) {
    pc_status status = PC_OK;
    r->base = 1;
    PC_TRY(pc_new(&r->slot, ctx, key_count(b->form, b)));
    PC_TRY(pc_new(&r->list, ctx, room));
    PC_TRY(pc_new(&r->sum, ctx, room * (size_t)pc_form_size(b->form)));
done:
    return status;
}

static pc_status make_workers(worker *workers, pc_context *ctx, const product *p, int threads) {
    const size_t longest = longest_row(p->a) + 1;
    const size_t inner = p->middle ? most_entries(longest, p->middle) : longest;
    const size_t room = most_entries(inner, p->b);
    pc_status status = PC_OK;
    for (int t = 0; t < threads; t++) {
        PC_TRY(make_row(&workers[t].space, ctx, room, p->b));
        if (!p->middle) continue;
        PC_TRY(make_row(&workers[t].inner, ctx, inner, p->middle));
        PC_TRY(pc_new(&workers[t].sorted, ctx, room));
    }
done:
    return status;
}

static void free_row(row *r, pc_context *ctx) {
    pc_free(ctx, r->slot);
    pc_free(ctx, r->list);
    pc_free(ctx, r->sum);
}

static void free_workers(worker *workers, pc_context *ctx, int threads) {
    for (int t = 0; workers && t < threads; t++) {
        free_row(&workers[t].space, ctx);
        free_row(&workers[t].inner, ctx);
        pc_free(ctx, workers[t].sorted);
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
    PC_TRY(pc_blockmat_make(p->c, ctx, p->a->form, n, p->b->column_count, entries, p->middle != NULL));
    memcpy(p->c->start + 1, p->length, n * sizeof *p->length);
    add_up(p->c->start, n);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int t = 0; t < threads; t++)
        keep_chunks(p->c, ctx, &workers[t]);
done:
    free_workers(workers, ctx, threads);
    pc_free(ctx, p->length);
    return status;
}

pc_status pc_galerkin_smooth(pc_blockmat *prolongator, pc_context *ctx, const pc_blockmat *matrix,
                             const pc_blockmat *tentative, double omega) {
    product p = {.c = prolongator, .a = matrix, .b = tentative, .omega = omega};
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
    if (!matrix->inverse) return;
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
    double *diagonal = NULL;
    *coarse = (pc_blockmat){0};
    PC_TRY(
        pc_new(&diagonal, ctx, (size_t)restriction->row_count * (size_t)pc_form_diagonal(restriction->form)));
    product p = {.c = coarse, .a = restriction, .middle = matrix, .b = prolongator, .diagonal = diagonal};
    PC_TRY(multiply(&p, ctx));
    put_diagonals(coarse, diagonal, restriction, matrix);
done:
    pc_free(ctx, diagonal);
    if (status != PC_OK) pc_blockmat_free(coarse, ctx);
    return status;
}
