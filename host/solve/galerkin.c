#include "galerkin.h"
#include "blockalg.h"
#include "memory.h"
#include <omp.h>

/* A product that is made row by row: C = (1 - omega D^-1 A) B where `middle` is NULL, else C = A middle B, A
 * the transpose of B, with its diagonal apart: this one is symmetric, so that sums are made on and above the
 * diagonal only, and mirrored. */
typedef struct product {
    pc_blockmat *c;
    const pc_blockmat *a;
    const pc_blockmat *middle;
    const pc_blockmat *b;
    double omega;
    double *diagonal; /* what is on it, as many per row as pc_form_diagonal; NULL without `middle` */
    pc_index *reach;  /* per row of b: one more than its largest column; NULL without `middle` */
    pc_index *length; /* per row: its entries, but for the diagonal and those that are mirrored there */
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
    pc_index *below;  /* per row: entries that are mirrored there, then the place of the next one */
    chunk *head, *last;
    pc_status status;
} worker;

PC_ALWAYS_INLINE pc_index key_of(pc_block_form form, pc_index column, int turn) {
    return form == PC_FORM_TURNED ? 4 * column + (pc_index)turn : column;
}

PC_ALWAYS_INLINE pc_index column_of(pc_block_form form, pc_index key) {
    return form == PC_FORM_TURNED ? key / 4 : key;
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

/* Copies the row to the chunk. */
PC_ALWAYS_INLINE void put_row(pc_block_form form, const row *r, chunk *c, const product *p, pc_index i) {
    const size_t size = (size_t)pc_form_size(form);
    const size_t at = c->count;
    for (pc_index k = 0; k < r->count; k++)
        put_entry(form, c->key + at + k, c->value + size * (at + k), r, k);
    p->length[i] = r->count;
    c->count = at + r->count;
}

/* Copies `count` sorted entries to the chunk, the diagonal apart. */
PC_ALWAYS_INLINE void put_upper_row(pc_block_form form, const row *r, const worker *w, pc_index count,
                                    const product *p, pc_index i) {
    const size_t size = (size_t)pc_form_size(form);
    const size_t per_row = (size_t)pc_form_diagonal(form);
    chunk *c = w->last;
    size_t e = c->count;
    for (pc_index n = 0; n < count; n++) {
        const pc_index k = (pc_index)w->sorted[n];
        const pc_index column = column_of(form, r->list[k]);
        if (r->list[k] != key_of(form, i, 0)) {
            put_entry(form, c->key + e, c->value + size * e, r, k);
            w->below[column] += column > i;
            e++;
            continue;
        }
        for (size_t u = 0; u < per_row; u++)
            p->diagonal[per_row * i + u] = r->sum[size * k + 2 * u];
    }
    p->length[i] = (pc_index)(e - c->count);
    c->count = e;
}

/* The row's keys from `least` on in ascending order; how many they are. */
static pc_index sort_keys(uint64_t *sorted, const pc_index *list, pc_index keys, pc_index least) {
    static const pc_index gaps[] = {1750, 701, 301, 132, 57, 23, 10, 4, 1};
    pc_index count = 0;
    for (pc_index k = 0; k < keys; k++) {
        sorted[count] = (uint64_t)list[k] << 32 | k;
        count += list[k] >= least;
    }
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
    return count;
}

/* inner += v * row j of the square matrix a, whose exact numbers come without their scale */
PC_ALWAYS_INLINE void add_inner(pc_block_form form, bool exact, row *inner, const pc_blockmat *a,
                                const pc_blockval *v, pc_index j) {
    const size_t size = (size_t)pc_form_size(form);
    const size_t per_row = (size_t)pc_form_diagonal(form);
    double factor[4];
    for (size_t u = 0; u < size; u++)
        factor[u] = (u & 1) ? 0 : exact ? a->exact_diagonal[j] : (double)a->diagonal[per_row * j + u / 2];
    pc_blockval_add_product(form, sum_at(form, inner, key_of(form, j, v->turn)), v, factor);
    const size_t end = a->start[j + 1];
    for (size_t e = a->start[j]; e < end; e++) {
        for (size_t u = 0; u < size; u++)
            factor[u] = exact ? a->exact[size * e + u] : (double)a->value[size * e + u];
        const int turn = form == PC_FORM_TURNED ? (v->turn + a->turn[e]) & 3 : 0;
        pc_blockval_add_product(form, sum_at(form, inner, key_of(form, a->column[e], turn)), v, factor);
    }
}

/* row = row i of A middle B, from column i on; what it has before that is not complete */
PC_ALWAYS_INLINE void add_coarse_row(pc_block_form form, bool exact, row *r, row *inner, const product *p,
                                     pc_index i) {
    const size_t size = (size_t)pc_form_size(form);
    const double scale = exact ? p->middle->exact_scale : 1; /* a power of two */
    pc_blockval v;
    for (size_t e = p->a->start[i]; e < p->a->start[i + 1]; e++) {
        pc_blockval_load(form, &v, p->a, e);
        for (size_t u = 0; u < size; u++)
            v.v[u] *= scale;
        add_inner(form, exact, inner, p->middle, &v, p->a->column[e]);
    }
    for (pc_index k = 0; k < inner->count; k++) {
        const pc_index key = inner->list[k];
        if (p->reach[column_of(form, key)] <= i) continue;
        memcpy(v.v, inner->sum + size * k, size * sizeof *v.v);
        v.turn = form == PC_FORM_TURNED ? (int)(key & 3) : 0;
        add_row(form, r, p->b, &v, column_of(form, key));
    }
}

static bool has_room(worker *w, pc_context *ctx, size_t size, pc_index i, pc_index count) {
    return (w->last && w->last->count + count <= w->last->room) || next_chunk(w, ctx, size, i, count);
}

PC_ALWAYS_INLINE void fill_smooth(pc_block_form form, worker *w, pc_context *ctx, const product *p,
                                  pc_index from, pc_index to) {
    row r = w->space;
    for (pc_index i = from; i < to; i++) {
        if (p->b->start[i] < p->b->start[i + 1]) {
            add_square_row(form, &r, p->a, p->b, i);
            smooth_row(form, &r, p, i);
        }
        if (!has_room(w, ctx, (size_t)pc_form_size(form), i, r.count)) break;
        put_row(form, &r, w->last, p, i);
        clear_row(form, &r, key_count(form, p->b));
    }
}

PC_ALWAYS_INLINE void fill_coarse(pc_block_form form, bool exact, worker *w, pc_context *ctx,
                                  const product *p, pc_index from, pc_index to) {
    row r = w->space;
    row inner = w->inner;
    for (pc_index i = from; i < to; i++) {
        add_coarse_row(form, exact, &r, &inner, p, i);
        clear_row(form, &inner, key_count(form, p->middle));
        const pc_index upper = sort_keys(w->sorted, r.list, r.count, key_of(form, i, 0));
        if (!has_room(w, ctx, (size_t)pc_form_size(form), i, upper)) break;
        put_upper_row(form, &r, w, upper, p, i);
        clear_row(form, &r, key_count(form, p->b));
    }
}

PC_ALWAYS_INLINE void fill_rows(pc_block_form form, worker *w, pc_context *ctx, const product *p,
                                pc_index from, pc_index to) {
    if (!p->middle)
        fill_smooth(form, w, ctx, p, from, to);
    else if (p->middle->exact)
        fill_coarse(form, true, w, ctx, p, from, to);
    else
        fill_coarse(form, false, w, ctx, p, from, to);
}

/* Rows are cut into equal runs, one for each thread: where run t starts. */
static pc_index run_start(pc_index rows, int t, int threads) {
    return (pc_index)((size_t)rows * (size_t)t / (size_t)threads);
}

static pc_status fill(worker *workers, pc_context *ctx, const product *p, int threads) {
    const pc_index n = p->a->row_count;
    pc_status status = PC_OK;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int t = 0; t < threads; t++) {
        const pc_index from = run_start(n, t, threads);
        const pc_index to = run_start(n, t + 1, threads);
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
#pragma omp parallel for schedule(static) reduction(max : longest) if (m->row_count > PC_PARALLEL_ROWS)
    for (pc_index i = 0; i < m->row_count; i++) {
        const pc_index length = m->start[i + 1] - m->start[i];
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
        PC_TRY(pc_new(&workers[t].below, ctx, p->a->row_count));
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
        pc_free(ctx, workers[t].below);
        while (workers[t].head) {
            chunk *next = workers[t].head->next;
            pc_free(ctx, workers[t].head);
            workers[t].head = next;
        }
    }
    pc_free(ctx, workers);
}

/* Where rows start, each with what is mirrored there first, by threads as by rows. */
static void lay_out(pc_index *start, worker *workers, const product *p, int threads) {
    pc_index at = 0;
    for (pc_index i = 0; i < p->a->row_count; i++) {
        start[i] = at;
        for (int t = 0; p->middle && t < threads; t++) {
            const pc_index count = workers[t].below[i];
            workers[t].below[i] = at;
            at += count;
        }
        at += p->length[i];
    }
    start[p->a->row_count] = at;
}

/* Entries of a chunk from `at` on to their place. */
static void keep_entries(const pc_blockmat *c, size_t place, const chunk *from, size_t at, size_t count) {
    const size_t size = (size_t)pc_form_size(c->form);
    for (size_t k = 0; k < count; k++)
        c->column[place + k] = column_of(c->form, from->key[at + k]);
    for (size_t k = 0; c->turn && k < count; k++)
        c->turn[place + k] = (uint8_t)(from->key[at + k] % 4);
    memcpy(c->value + size * place, from->value + size * at, size * count * sizeof *from->value);
}

/* The chunks of a thread, whose rows end at `to`, to their places. */
static void keep_chunks(pc_context *ctx, worker *w, const product *p, pc_index to) {
    const pc_blockmat *c = p->c;
    while (w->head) {
        chunk *from = w->head;
        const pc_index end = from->next ? from->next->first : to;
        size_t at = 0;
        if (!p->middle) keep_entries(c, c->start[from->first], from, 0, from->count);
        for (pc_index i = from->first; p->middle && i < end; i++) {
            keep_entries(c, c->start[i + 1] - p->length[i], from, at, p->length[i]);
            at += p->length[i];
        }
        w->head = from->next;
        pc_free(ctx, from);
    }
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

/* Mirrors row i; `below` holds the next place of each row. */
PC_ALWAYS_INLINE void mirror_row(pc_block_form form, pc_blockmat *c, pc_index *below, pc_index length,
                                 pc_index i) {
    const size_t end = c->start[i + 1];
    size_t next;
    for (size_t e = end - length; e < end; e = next) {
        const pc_index column = c->column[e];
        for (next = e + 1; form == PC_FORM_TURNED && next < end && c->column[next] == column;)
            next++;
        if (column == i) continue;
        /* Turns 1 to 3 of a column ascend the other way when they are transposed. */
        const size_t first = form == PC_FORM_TURNED && c->turn[e] > 0 ? e : e + 1;
        for (size_t k = 0; k < next - e; k++) {
            const size_t from = e + k < first ? e : next - 1 - (k - (first - e));
            const size_t to = below[column]++;
            c->column[to] = i;
            transpose_entry(form, c, to, c, from);
        }
    }
}

static void mirror(const product *p, pc_index *below, pc_index from, pc_index to) {
    for (pc_index i = from; i < to; i++) {
        if (p->c->form == PC_FORM_SCALAR) mirror_row(PC_FORM_SCALAR, p->c, below, p->length[i], i);
        if (p->c->form == PC_FORM_COMPLEX) mirror_row(PC_FORM_COMPLEX, p->c, below, p->length[i], i);
        if (p->c->form == PC_FORM_TURNED) mirror_row(PC_FORM_TURNED, p->c, below, p->length[i], i);
    }
}

static size_t count_entries(const product *p, const worker *workers, int threads) {
    size_t entries = 0;
#pragma omp parallel for schedule(static) reduction(+ : entries) num_threads(threads)
    for (pc_index i = 0; i < p->a->row_count; i++) {
        entries += p->length[i];
        for (int t = 0; p->middle && t < threads; t++)
            entries += workers[t].below[i];
    }
    return entries;
}

static pc_status multiply(product *p, pc_context *ctx) {
    pc_status status = PC_OK;
    worker *workers = NULL;
    const pc_index n = p->a->row_count;
    const int threads = n > PC_PARALLEL_ROWS ? omp_get_max_threads() : 1;
    PC_TRY(pc_new(&workers, ctx, (size_t)threads));
    PC_TRY(pc_new(&p->length, ctx, n));
    PC_TRY(make_workers(workers, ctx, p, threads));
    PC_TRY(fill(workers, ctx, p, threads));
    PC_TRY(pc_blockmat_make(p->c, ctx, p->a->form, n, p->b->column_count, count_entries(p, workers, threads),
                            p->middle != NULL));
    lay_out(p->c->start, workers, p, threads);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int t = 0; t < threads; t++) {
        keep_chunks(ctx, &workers[t], p, run_start(n, t + 1, threads));
        if (p->middle) mirror(p, workers[t].below, run_start(n, t, threads), run_start(n, t + 1, threads));
    }
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

/* Entries of the rows [from, to) by columns. */
static void count_columns(pc_index *count, const pc_blockmat *p, pc_index from, pc_index to) {
    for (pc_index e = p->start[from]; e < p->start[to]; e++)
        count[p->column[e]]++;
}

/* From the runs' counts of each column to the places of their entries. */
static void place_columns(pc_index *start, pc_index *count, pc_index columns, int runs) {
    pc_index at = 0;
    for (pc_index c = 0; c < columns; c++) {
        start[c] = at;
        for (int t = 0; t < runs; t++) {
            const pc_index own = count[(size_t)columns * (size_t)t + c];
            count[(size_t)columns * (size_t)t + c] = at;
            at += own;
        }
    }
    start[columns] = at;
}

PC_ALWAYS_INLINE void transpose_row(pc_block_form form, pc_blockmat *r, pc_index *place, const pc_blockmat *p,
                                    pc_index i) {
    for (size_t e = p->start[i]; e < p->start[i + 1]; e++) {
        const size_t to = place[p->column[e]]++;
        r->column[to] = i;
        transpose_entry(form, r, to, p, e);
    }
}

static void transpose_rows(pc_blockmat *r, pc_index *place, const pc_blockmat *p, pc_index from,
                           pc_index to) {
    for (pc_index i = from; i < to; i++) {
        if (p->form == PC_FORM_SCALAR) transpose_row(PC_FORM_SCALAR, r, place, p, i);
        if (p->form == PC_FORM_COMPLEX) transpose_row(PC_FORM_COMPLEX, r, place, p, i);
        if (p->form == PC_FORM_TURNED) transpose_row(PC_FORM_TURNED, r, place, p, i);
    }
}

pc_status pc_galerkin_transpose(pc_blockmat *restriction, pc_context *ctx, const pc_blockmat *prolongator) {
    enum { MOST_RUNS = 16 };
    const pc_blockmat *p = prolongator;
    const pc_index n = p->row_count;
    const int threads = n > PC_PARALLEL_ROWS ? omp_get_max_threads() : 1;
    const int runs = threads < MOST_RUNS ? threads : MOST_RUNS;
    pc_status status = PC_OK;
    pc_index *place = NULL;
    *restriction = (pc_blockmat){0};
    PC_TRY(pc_new(&place, ctx, (size_t)runs * p->column_count));
    PC_TRY(pc_blockmat_make(restriction, ctx, p->form, p->column_count, n, p->start[n], false));
#pragma omp parallel for schedule(static) num_threads(runs)
    for (int t = 0; t < runs; t++)
        count_columns(place + (size_t)t * p->column_count, p, run_start(n, t, runs),
                      run_start(n, t + 1, runs));
    place_columns(restriction->start, place, p->column_count, runs);
#pragma omp parallel for schedule(static) num_threads(runs)
    for (int t = 0; t < runs; t++)
        transpose_rows(restriction, place + (size_t)t * p->column_count, p, run_start(n, t, runs),
                       run_start(n, t + 1, runs));
done:
    pc_free(ctx, place);
    if (status != PC_OK) pc_blockmat_free(restriction, ctx);
    return status;
}

void pc_galerkin_invert_diagonal(pc_blockmat *matrix) {
    const size_t n = matrix->row_count * (size_t)pc_form_diagonal(matrix->form);
    if (!matrix->inverse) return;
#pragma omp parallel for schedule(static) if (n > PC_PARALLEL_ROWS)
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

/* Per row one more than its largest column, 0 where it is empty. */
static pc_status find_reach(pc_index **reach, pc_context *ctx, const pc_blockmat *m) {
    const pc_status status = pc_resize(reach, ctx, m->row_count);
    if (status != PC_OK) return status;
#pragma omp parallel for schedule(static) if (m->row_count > PC_PARALLEL_ROWS)
    for (pc_index i = 0; i < m->row_count; i++) {
        pc_index most = 0;
        for (size_t e = m->start[i]; e < m->start[i + 1]; e++)
            most = m->column[e] >= most ? m->column[e] + 1 : most;
        (*reach)[i] = most;
    }
    return PC_OK;
}

pc_status pc_galerkin_coarse(pc_blockmat *coarse, pc_context *ctx, const pc_blockmat *restriction,
                             const pc_blockmat *matrix, const pc_blockmat *prolongator) {
    pc_status status = PC_OK;
    double *diagonal = NULL;
    product p = {.c = coarse, .a = restriction, .middle = matrix, .b = prolongator};
    *coarse = (pc_blockmat){0};
    PC_TRY(
        pc_new(&diagonal, ctx, (size_t)restriction->row_count * (size_t)pc_form_diagonal(restriction->form)));
    p.diagonal = diagonal;
    PC_TRY(find_reach(&p.reach, ctx, prolongator));
    PC_TRY(multiply(&p, ctx));
    put_diagonals(coarse, diagonal, restriction, matrix);
done:
    pc_free(ctx, diagonal);
    pc_free(ctx, p.reach);
    if (status != PC_OK) pc_blockmat_free(coarse, ctx);
    return status;
}
