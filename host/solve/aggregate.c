#include "aggregate.h"
#include "blockalg.h"
#include "memory.h"

/* A row with couplings below this share of its diagonal needs no coarse level. */
static const double ruled_by_diagonal = 0.2;

/* |B_e|^2; floats are good enough to compare by. */
PC_ALWAYS_INLINE float square_of(pc_block_form form, const pc_blockmat *a, size_t e) {
    const size_t n = (size_t)pc_form_size(form);
    float sum = 0;
    for (size_t k = 0; k < n; k++)
        sum += a->value[n * e + k] * a->value[n * e + k];
    return form == PC_FORM_TURNED ? 0.5F * sum : sum;
}

/* Cosine between A_ik A_kj and -A_ij, in units of |A_ij|; 0 where the quarter turns disagree (a singularity).
 */
PC_ALWAYS_INLINE double way_round(pc_block_form form, const pc_blockval *ik, const pc_blockval *kj,
                                  const pc_blockval *ij) {
    double moved[4] = {kj->v[0], kj->v[1], kj->v[2], kj->v[3]};
    double sum = 0;
    double size = sqrt(pc_blockval_square(form, ik) * pc_blockval_square(form, kj));
    if (form == PC_FORM_TURNED) {
        if (((ik->turn + kj->turn - ij->turn) & 3) != 0) return 0;
        pc_turn_diagonal(moved, ik->turn, kj->v);
    }
    for (int h = 0; h < (form == PC_FORM_TURNED ? 4 : 2); h += 2) {
        double re = ik->v[h] * moved[h] - ik->v[h + 1] * moved[h + 1];
        double im = ik->v[h] * moved[h + 1] + ik->v[h + 1] * moved[h];
        sum -= re * ij->v[h] + im * ij->v[h + 1];
    }
    return size > 0 ? sum / size : 0;
}

/* Whether the coupling e of row i repels: against the ways round by common neighbours it points backwards. So
 * do the negative weights of obtuse triangles; their rotation is right, their sign says nothing about frames.
 * Needs columns in ascending order. */
PC_ALWAYS_INLINE bool repels(pc_block_form form, const pc_blockmat *a, pc_index i, size_t e, double square) {
    pc_blockval ij;
    pc_blockval_load(form, &ij, a, e);
    if (form == PC_FORM_SCALAR) return ij.v[0] > 0;
    const pc_index j = a->column[e];
    double score = 0;
    size_t f = a->start[i];
    size_t g = a->start[j];
    while (f < a->start[i + 1] && g < a->start[j + 1]) {
        if (a->column[f] < a->column[g]) {
            f++;
        } else if (a->column[f] > a->column[g]) {
            g++;
        } else {
            pc_blockval ik;
            pc_blockval jk;
            pc_blockval kj;
            pc_blockval_load(form, &ik, a, f);
            pc_blockval_load(form, &jk, a, g);
            pc_blockval_transpose(form, &kj, &jk);
            double weight = fmin(pc_blockval_square(form, &ik), pc_blockval_square(form, &jk));
            /* In a triangle that closes backwards the smallest coupling is the one to blame. */
            if (weight >= square) score += sqrt(weight) * way_round(form, &ik, &kj, &ij);
            f++;
            g++;
        }
    }
    return score < 0;
}

PC_ALWAYS_INLINE void size_row(pc_block_form form, float *size, uint8_t *eligible, uint8_t *dominated,
                               const pc_blockmat *a, pc_index i) {
    const double rounding = 1e-5;
    double d = pc_blockmat_mean_diagonal(a, i);
    double total = 0;
    for (size_t e = a->start[i]; e < a->start[i + 1]; e++) {
        size[e] = a->column[e] == i ? 0 : sqrtf(square_of(form, a, e));
        total += (double)size[e];
    }
    eligible[i] = total > ruled_by_diagonal * d;
    dominated[i] = total > (1 + rounding) * d;
}

/* A coupling that repels makes the diagonals of both its rows smaller than their couplings. */
PC_ALWAYS_INLINE void drop_weak(pc_block_form form, float *size, const uint8_t *dominated,
                                const pc_blockmat *a, double threshold, pc_index i) {
    double d = threshold * threshold * pc_blockmat_mean_diagonal(a, i);
    for (size_t e = a->start[i]; e < a->start[i + 1]; e++) {
        double square = (double)size[e] * (double)size[e];
        pc_index j = a->column[e];
        if (!(square > d * pc_blockmat_mean_diagonal(a, j)) ||
            (dominated[i] && dominated[j] && repels(form, a, i, e, square)))
            size[e] = 0;
    }
}

/* The sizes of strong couplings (0 for the others), and the rows that take part. */
static pc_status find_strong(float *size, uint8_t *eligible, pc_context *ctx, const pc_blockmat *a,
                             double threshold) {
    uint8_t *dominated = NULL;
    pc_status status = pc_new(&dominated, ctx, a->row_count);
    if (status != PC_OK) return status;
#define SIZE(form, i) size_row(form, size, eligible, dominated, a, i)
    PC_EACH_ROW(a->form, a->row_count, SIZE);
#undef SIZE
#define DROP(form, i) drop_weak(form, size, dominated, a, threshold, i)
    PC_EACH_ROW(a->form, a->row_count, DROP);
#undef DROP
    pc_free(ctx, dominated);
    return PC_OK;
}

/* Groups go by their roots' rows until they are numbered. */
static void take_row(pc_aggregates *g, pc_index row, pc_index root, pc_index via) {
    g->of[row] = root;
    g->via[row] = via;
}

static bool all_free(const pc_aggregates *g, const pc_blockmat *a, const float *size, pc_index row) {
    for (size_t e = a->start[row]; e < a->start[row + 1]; e++) {
        if (size[e] > 0 && g->of[a->column[e]] != PC_NONE) return false;
    }
    return true;
}

static void found_group(pc_aggregates *g, const pc_blockmat *a, const float *size, const uint8_t *eligible,
                        pc_index row) {
    take_row(g, row, row, row);
    for (size_t e = a->start[row]; e < a->start[row + 1]; e++) {
        pc_index j = a->column[e];
        if (size[e] > 0 && eligible[j] && g->of[j] == PC_NONE) take_row(g, j, row, row);
    }
}

/* Whether all strong neighbours of a row are among the rows [from, to). */
static bool lies_within(const pc_blockmat *a, const float *size, pc_index row, pc_index from, pc_index to) {
    for (size_t e = a->start[row]; e < a->start[row + 1]; e++) {
        if (size[e] > 0 && (a->column[e] < from || a->column[e] >= to)) return false;
    }
    return true;
}

/* Rows whose strong neighbours are all free found groups. Blocks of rows do so at the same time for the rows
 * that touch no other block; those are put off until all blocks are done. The blocks do not depend on the
 * threads. */
static void found_groups(pc_aggregates *g, const pc_blockmat *a, const float *size, const uint8_t *eligible) {
    enum { BLOCK = 16384 };
    const pc_index n = a->row_count;
    uint8_t *put_off = (uint8_t *)g->member;
#pragma omp parallel for schedule(static) if (n > BLOCK)
    for (pc_index from = 0; from < n; from += BLOCK) {
        pc_index to = n - from < BLOCK ? n : from + BLOCK;
        for (pc_index i = from; i < to; i++) {
            put_off[i] = eligible[i] && !lies_within(a, size, i, from, to);
            if (eligible[i] && !put_off[i] && g->of[i] == PC_NONE && all_free(g, a, size, i))
                found_group(g, a, size, eligible, i);
        }
    }
    for (pc_index i = 0; i < n; i++) {
        if (put_off[i] && g->of[i] == PC_NONE && all_free(g, a, size, i))
            found_group(g, a, size, eligible, i);
    }
}

/* The strongest neighbour that is in a group, PC_NONE if none. */
static pc_index strongest(const pc_blockmat *a, const float *size, const pc_index *of, pc_index row) {
    pc_index best = PC_NONE;
    float best_size = 0;
    for (size_t e = a->start[row]; e < a->start[row + 1]; e++) {
        if (size[e] > best_size && of[a->column[e]] != PC_NONE) {
            best = a->column[e];
            best_size = size[e];
        }
    }
    return best;
}

/* From roots' rows to numbers in the order of the roots. */
static void number_groups(pc_aggregates *g) {
    pc_index *number = g->member;
    for (pc_index i = 0; i < g->row_count; i++) {
        if (g->of[i] == i) number[i] = g->count++;
    }
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < g->row_count; i++) {
        if (g->of[i] != PC_NONE) g->of[i] = number[g->of[i]];
    }
}

static void group_rows(pc_aggregates *g, const pc_blockmat *a, const float *size, const uint8_t *eligible) {
    pc_index *joined = g->member;
    found_groups(g, a, size, eligible);
    /* Left over rows join the group of their strongest neighbour; frames then come from rows of the first
     * pass only. */
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < a->row_count; i++) {
        joined[i] = PC_NONE;
        if (eligible[i] && g->of[i] == PC_NONE) joined[i] = strongest(a, size, g->of, i);
    }
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < a->row_count; i++) {
        if (joined[i] != PC_NONE) take_row(g, i, g->of[joined[i]], joined[i]);
    }
    for (pc_index i = 0; i < a->row_count; i++) {
        if (eligible[i] && g->of[i] == PC_NONE) found_group(g, a, size, eligible, i);
    }
    number_groups(g);
}

static void list_members(pc_aggregates *g) {
    for (pc_index i = 0; i < g->row_count; i++) {
        if (g->of[i] != PC_NONE) g->start[g->of[i] + 1]++;
    }
    for (pc_index group = 0; group < g->count; group++)
        g->start[group + 1] += g->start[group];
    const pc_index total = g->start[g->count];
    for (pc_index i = g->row_count; i-- > 0;) {
        if (g->of[i] != PC_NONE) g->member[--g->start[g->of[i] + 1]] = i;
    }
    /* Each offset has moved from its group's end to its start, one place too far right. */
    for (pc_index group = 0; group < g->count; group++)
        g->start[group] = g->start[group + 1];
    g->start[g->count] = total;
}

pc_status pc_aggregates_list(pc_aggregates *aggregates, pc_context *ctx) {
    pc_status status = PC_OK;
    if (aggregates->start) return PC_OK;
    if (!aggregates->member) PC_TRY(pc_new(&aggregates->member, ctx, aggregates->row_count));
    PC_TRY(pc_new(&aggregates->start, ctx, (size_t)aggregates->count + 1));
    list_members(aggregates);
done:
    return status;
}

void pc_aggregates_unlist(pc_aggregates *aggregates, pc_context *ctx) {
    pc_free(ctx, aggregates->start);
    pc_free(ctx, aggregates->member);
    aggregates->start = aggregates->member = NULL;
}

pc_status pc_aggregates_make(pc_aggregates *aggregates, pc_context *ctx, const pc_blockmat *matrix,
                             double threshold) {
    pc_status status = PC_OK;
    float *size = NULL;
    uint8_t *eligible = NULL;
    pc_index n = matrix->row_count;
    *aggregates = (pc_aggregates){.row_count = n};
    PC_TRY(pc_new(&aggregates->of, ctx, n));
    PC_TRY(pc_new(&aggregates->via, ctx, n));
    PC_TRY(pc_new(&aggregates->member, ctx, n));
    PC_TRY(pc_resize(&size, ctx, matrix->start[n]));
    PC_TRY(pc_new(&eligible, ctx, n));
    memset(aggregates->of, 0xff, n * sizeof *aggregates->of);
    memset(aggregates->via, 0xff, n * sizeof *aggregates->via);
    PC_TRY(find_strong(size, eligible, ctx, matrix, threshold));
    group_rows(aggregates, matrix, size, eligible);
    PC_TRY(pc_aggregates_list(aggregates, ctx));
done:
    pc_free(ctx, size);
    pc_free(ctx, eligible);
    if (status != PC_OK) pc_aggregates_free(aggregates, ctx);
    return status;
}

void pc_aggregates_free(pc_aggregates *aggregates, pc_context *ctx) {
    pc_free(ctx, aggregates->of);
    pc_free(ctx, aggregates->via);
    pc_free(ctx, aggregates->start);
    pc_free(ctx, aggregates->member);
    *aggregates = (pc_aggregates){0};
}

/* Frames while they are found: orthogonal blocks in the matrix' own form. In float: they only have to be near
 * to what they stand for. */
typedef struct frames {
    float *value;
    uint8_t *turn; /* TURNED only */
} frames;

static void identity_frame(pc_block_form form, const frames *f, pc_index i) {
    const int n = pc_form_size(form);
    float *v = f->value + (size_t)n * i;
    for (int k = 0; k < n; k++)
        v[k] = (k & 1) == 0;
    if (f->turn) f->turn[i] = 0;
}

/* sum -= B_e * frame of row j; for TURNED the product's turn is the sum of both. */
PC_ALWAYS_INLINE void add_carried(pc_block_form form, float *sum, const pc_blockmat *a, size_t e,
                                  const frames *f, pc_index j) {
    const size_t n = (size_t)pc_form_size(form);
    const float *v = a->value + n * e;
    float u[4] = {0};
    memcpy(u, f->value + n * j, n * sizeof *u);
    if (form == PC_FORM_TURNED && a->turn[e] != 0) {
        const double in[4] = {(double)u[0], (double)u[1], (double)u[2], (double)u[3]};
        double out[4];
        pc_turn_diagonal(out, a->turn[e], in);
        for (int k = 0; k < 4; k++)
            u[k] = (float)out[k];
    }
    for (size_t h = 0; h < n; h += 2) {
        sum[h] -= v[h] * u[h] - v[h + 1] * u[h + 1];
        sum[h + 1] -= v[h] * u[h + 1] + v[h + 1] * u[h];
    }
}

/* The frame of row i nearest to m. */
PC_ALWAYS_INLINE void put_frame(pc_block_form form, const frames *f, pc_index i, const float *m) {
    const int n = pc_form_size(form);
    float *v = f->value + (size_t)n * i;
    for (int h = 0; h < n; h += 2) {
        float size = sqrtf(m[h] * m[h] + m[h + 1] * m[h + 1]);
        v[h] = size > 0 ? m[h] / size : 1;
        v[h + 1] = size > 0 ? m[h + 1] / size : 0;
    }
}

/* Hands row i its frame from row via[i], by the largest of their couplings. */
PC_ALWAYS_INLINE void carry(pc_block_form form, const frames *f, const pc_blockmat *a, pc_index i,
                            pc_index via) {
    float largest = -1;
    size_t best = SIZE_MAX;
    float m[4] = {0};
    for (size_t e = a->start[i]; e < a->start[i + 1]; e++) {
        if (a->column[e] != via) continue;
        float square = square_of(form, a, e);
        if (square > largest) best = e;
        largest = fmaxf(largest, square);
    }
    if (best != SIZE_MAX) add_carried(form, m, a, best, f, via);
    put_frame(form, f, i, m);
    if (form == PC_FORM_TURNED && best != SIZE_MAX) f->turn[i] = (a->turn[best] + f->turn[via]) & 3;
}

/* Best frame of row i with those of its group held: the polar factor of -sum A_ij T_j. Around a singularity,
 * and where the root was reached by weak couplings, the turns disagree; then those win whose couplings weigh
 * most. */
PC_ALWAYS_INLINE void relax_row(pc_block_form form, const frames *f, const pc_blockmat *a,
                                const pc_aggregates *g, pc_index i) {
    const size_t n = (size_t)pc_form_size(form);
    const pc_index own = g->of[i];
    float sum[4][4] = {{0}};
    float squares[4] = {0};
    float count[4] = {0};
    for (size_t e = a->start[i]; e < a->start[i + 1]; e++) {
        const pc_index j = a->column[e];
        if (g->of[j] != own || j == i) continue;
        const int turn = form == PC_FORM_TURNED ? (a->turn[e] + f->turn[j]) & 3 : 0;
        add_carried(form, sum[turn], a, e, f, j);
        count[turn]++;
        squares[turn] += square_of(form, a, e);
    }
    int best = form == PC_FORM_TURNED ? f->turn[i] : 0;
    float most = 0;
    for (int t = 0; t < (form == PC_FORM_TURNED ? 4 : 1); t++) {
        const int turn = (best + t) & 3;
        float square = 0;
        for (size_t k = 0; k < n; k++)
            square += sum[turn][k] * sum[turn][k];
        /* What cancels says nothing. */
        if (square <= most || square <= 1e-4F * count[turn] * squares[turn]) continue;
        most = square;
        put_frame(form, f, i, sum[turn]);
        if (form == PC_FORM_TURNED) f->turn[i] = (uint8_t)turn;
    }
}

/* Frames of all rows of a group. */
PC_ALWAYS_INLINE void transport(pc_block_form form, const frames *f, const pc_blockmat *a,
                                const pc_aggregates *g, pc_index group) {
    const pc_index *member = g->member + g->start[group];
    pc_index size = g->start[group + 1] - g->start[group];
    pc_index root = PC_NONE;
    for (pc_index k = 0; k < size; k++) {
        if (g->via[member[k]] == member[k]) root = member[k];
        if (form == PC_FORM_SCALAR) identity_frame(form, f, member[k]);
    }
    if (form == PC_FORM_SCALAR) return;
    identity_frame(form, f, root);
    for (pc_index k = 0; k < size; k++) {
        if (member[k] != root && g->via[member[k]] == root) carry(form, f, a, member[k], root);
    }
    for (pc_index k = 0; k < size; k++) {
        if (g->via[member[k]] != root) carry(form, f, a, member[k], g->via[member[k]]);
    }
    for (pc_index k = 0; k < size; k++)
        relax_row(form, f, a, g, member[k]);
}

pc_status pc_aggregates_transport(pc_blockmat *tentative, pc_context *ctx, const pc_aggregates *aggregates,
                                  const pc_blockmat *matrix) {
    pc_status status = PC_OK;
    const pc_block_form form = matrix->form;
    const size_t size = (size_t)pc_form_size(form);
    frames f = {0};
    *tentative = (pc_blockmat){0};
    PC_TRY(pc_resize(&f.value, ctx, size * matrix->row_count));
    if (form == PC_FORM_TURNED) PC_TRY(pc_new(&f.turn, ctx, matrix->row_count));
#define GROUP(form_of, group) transport(form_of, &f, matrix, aggregates, group)
    PC_EACH_ROW(form, aggregates->count, GROUP);
#undef GROUP
    PC_TRY(pc_blockmat_make(tentative, ctx, form, matrix->row_count, aggregates->count,
                            aggregates->start[aggregates->count], false));
    for (pc_index i = 0; i < matrix->row_count; i++)
        tentative->start[i + 1] = tentative->start[i] + (aggregates->of[i] != PC_NONE);
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < matrix->row_count; i++) {
        const size_t e = tentative->start[i];
        if (aggregates->of[i] == PC_NONE) continue;
        tentative->column[e] = aggregates->of[i];
        if (tentative->turn) tentative->turn[e] = f.turn[i];
        memcpy(tentative->value + size * e, f.value + size * i, size * sizeof(float));
    }
done:
    pc_free(ctx, f.value);
    pc_free(ctx, f.turn);
    if (status != PC_OK) pc_blockmat_free(tentative, ctx);
    return status;
}
