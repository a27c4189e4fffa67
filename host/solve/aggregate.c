#include "aggregate.h"
#include "blockalg.h"
#include "memory.h"
#include "smallmat.h"

/* A row with couplings below this share of its diagonal needs no coarse level. */
static const double ruled_by_diagonal = 0.2;

static double mean_diagonal(const pc_blockmat *a, pc_index i) {
    if (a->form != PC_FORM_DENSE) return (double)a->diagonal[i];
    const float *d = a->diagonal + 16 * (size_t)i;
    return 0.25 * ((double)d[0] + (double)d[5] + (double)d[10] + (double)d[15]);
}

PC_ALWAYS_INLINE double square_of(pc_block_form form, const pc_blockmat *a, size_t e) {
    pc_blockval b;
    pc_blockval_load(form, &b, a, e);
    return pc_blockval_square(form, &b);
}

/* Cosine between A_ik A_kj and -A_ij, in units of |A_ij|; 0 where the quarter turns disagree (a singularity).
 */
PC_ALWAYS_INLINE double way_round(pc_block_form form, const pc_blockval *ik, const pc_blockval *kj,
                                  const pc_blockval *ij) {
    double moved[4] = {kj->v[0], kj->v[1], kj->v[2], kj->v[3]};
    double sum = 0;
    double size = sqrt(pc_blockval_square(form, ik) * pc_blockval_square(form, kj));
    if (form == PC_FORM_DENSE) {
        for (int r = 0; r < 16; r++) {
            const double *row = ik->v + r / 4 * 4;
            const double *column = kj->v + r % 4;
            sum -= 0.25 * ij->v[r] *
                   (row[0] * column[0] + row[1] * column[4] + row[2] * column[8] + row[3] * column[12]);
        }
        return size > 0 ? sum / size : 0;
    }
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

PC_ALWAYS_INLINE void find_strong_row(pc_block_form form, float *size, uint8_t *eligible,
                                      const pc_blockmat *a, double threshold, pc_index i) {
    double d = mean_diagonal(a, i);
    double total = 0;
    for (size_t e = a->start[i]; e < a->start[i + 1]; e++) {
        double square = square_of(form, a, e);
        double of_j = mean_diagonal(a, a->column[e]);
        bool is_strong = square > threshold * threshold * d * of_j && !repels(form, a, i, e, square);
        total += sqrt(square);
        size[e] = is_strong ? (float)sqrt(square) : 0;
    }
    eligible[i] = total > ruled_by_diagonal * d;
}

/* The sizes of strong couplings (0 for the others), and the rows that take part. */
static void find_strong(float *size, uint8_t *eligible, const pc_blockmat *a, double threshold) {
#define ROW(form, i) find_strong_row(form, size, eligible, a, threshold, i)
    PC_EACH_ROW(a->form, a->row_count, ROW);
#undef ROW
}

static void take_row(pc_aggregates *g, pc_index row, pc_index group, pc_index via) {
    g->of[row] = group;
    g->via[row] = via;
}

/* The strongest neighbour for which `accept` holds, PC_NONE if none. */
static pc_index strongest(const pc_blockmat *a, const float *size, const pc_index *of, pc_index row,
                          pc_index below) {
    pc_index best = PC_NONE;
    float best_size = 0;
    for (size_t e = a->start[row]; e < a->start[row + 1]; e++) {
        if (size[e] > best_size && of[a->column[e]] < below) {
            best = a->column[e];
            best_size = size[e];
        }
    }
    return best;
}

static bool all_free(const pc_aggregates *g, const pc_blockmat *a, const float *size, pc_index row) {
    for (size_t e = a->start[row]; e < a->start[row + 1]; e++) {
        if (size[e] > 0 && g->of[a->column[e]] != PC_NONE) return false;
    }
    return true;
}

static void found_group(pc_aggregates *g, const pc_blockmat *a, const float *size, const uint8_t *eligible,
                        pc_index row) {
    take_row(g, row, g->count, row);
    for (size_t e = a->start[row]; e < a->start[row + 1]; e++) {
        pc_index j = a->column[e];
        if (size[e] > 0 && eligible[j] && g->of[j] == PC_NONE) take_row(g, j, g->count, row);
    }
    g->count++;
}

static void group_rows(pc_aggregates *g, const pc_blockmat *a, const float *size, const uint8_t *eligible) {
    for (pc_index i = 0; i < a->row_count; i++) {
        if (eligible[i] && g->of[i] == PC_NONE && all_free(g, a, size, i))
            found_group(g, a, size, eligible, i);
    }
    /* Left over rows join the group of their strongest neighbour; frames then come from rows of the first
     * pass only. */
    pc_index first_pass = g->count;
    pc_index *joined = g->member;
    for (pc_index i = 0; i < a->row_count; i++) {
        joined[i] = PC_NONE;
        if (eligible[i] && g->of[i] == PC_NONE) joined[i] = strongest(a, size, g->of, i, first_pass);
    }
    for (pc_index i = 0; i < a->row_count; i++) {
        if (joined[i] != PC_NONE) take_row(g, i, g->of[joined[i]], joined[i]);
    }
    for (pc_index i = 0; i < a->row_count; i++) {
        if (eligible[i] && g->of[i] == PC_NONE) found_group(g, a, size, eligible, i);
    }
}

static void list_members(pc_aggregates *g) {
    for (pc_index i = 0; i < g->row_count; i++) {
        if (g->of[i] != PC_NONE) g->start[g->of[i] + 1]++;
    }
    for (pc_index group = 0; group < g->count; group++)
        g->start[group + 1] += g->start[group];
    for (pc_index i = g->row_count; i-- > 0;) {
        if (g->of[i] != PC_NONE) g->member[--g->start[g->of[i] + 1]] = i;
    }
    /* Each offset has moved from its group's end to its start, one place too far right. */
    for (pc_index group = 0; group < g->count; group++)
        g->start[group] = g->start[group + 1];
    g->start[g->count] = 0;
    for (pc_index i = 0; i < g->row_count; i++)
        g->start[g->count] += g->of[i] != PC_NONE;
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
    PC_TRY(pc_new(&size, ctx, matrix->start[n]));
    PC_TRY(pc_new(&eligible, ctx, n));
    memset(aggregates->of, 0xff, n * sizeof *aggregates->of);
    memset(aggregates->via, 0xff, n * sizeof *aggregates->via);
    find_strong(size, eligible, matrix, threshold);
    group_rows(aggregates, matrix, size, eligible);
    PC_TRY(pc_new(&aggregates->start, ctx, (size_t)aggregates->count + 1));
    list_members(aggregates);
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

/* Frames while they are found: orthogonal blocks in the matrix' own form. */
typedef struct frames {
    float *value;
    uint8_t *turn; /* TURNED only */
} frames;

static void unit_pair(double *v) {
    double n = sqrt(v[0] * v[0] + v[1] * v[1]);
    if (n > 0) {
        v[0] /= n;
        v[1] /= n;
    } else {
        v[0] = 1;
        v[1] = 0;
    }
}

static void identity_frame(pc_block_form form, const frames *f, pc_index i) {
    const int n = pc_form_size(form);
    float *v = f->value + (size_t)n * i;
    for (int k = 0; k < n; k++)
        v[k] = form == PC_FORM_DENSE ? k % 5 == 0 : form == PC_FORM_SCALAR ? 1 : (k & 1) == 0;
    if (f->turn) f->turn[i] = 0;
}

/* out = a * frame of row j, with a's signs changed. For TURNED, the product's turn is returned. */
PC_ALWAYS_INLINE int carried(pc_block_form form, double *out, const pc_blockval *a, const frames *f,
                             pc_index j) {
    const int n = pc_form_size(form);
    const float *from = f->value + (size_t)n * j;
    memset(out, 0, 16 * sizeof *out);
    if (form == PC_FORM_TURNED) {
        double in[4] = {(double)from[0], (double)from[1], (double)from[2], (double)from[3]};
        double moved[4];
        pc_turn_diagonal(moved, a->turn, in);
        for (int half = 0; half < 4; half += 2) {
            out[half] = -(a->v[half] * moved[half] - a->v[half + 1] * moved[half + 1]);
            out[half + 1] = -(a->v[half] * moved[half + 1] + a->v[half + 1] * moved[half]);
        }
        return (a->turn + f->turn[j]) & 3;
    }
    pc_blockval_add_product(form, out, a, from, -1);
    return 0;
}

PC_ALWAYS_INLINE void put_frame(pc_block_form form, const frames *f, pc_index i, double *m, int turn) {
    const int n = pc_form_size(form);
    double q[16];
    if (form == PC_FORM_DENSE) {
        (void)pc_smallmat_polar4(q, m);
        m = q;
    } else {
        for (int half = 0; half < n; half += 2)
            unit_pair(m + half);
    }
    for (int k = 0; k < n; k++)
        f->value[(size_t)n * i + (size_t)k] = (float)m[k];
    if (form == PC_FORM_TURNED) f->turn[i] = (uint8_t)turn;
}

static size_t entry_of(const pc_blockmat *a, pc_index i, pc_index j) {
    size_t e = a->start[i];
    while (a->column[e] != j)
        e++;
    return e;
}

/* Hands row i its frame from row via[i]. */
PC_ALWAYS_INLINE void carry(pc_block_form form, const frames *f, const pc_blockmat *a, pc_index i,
                            pc_index via) {
    pc_blockval b;
    double out[16];
    pc_blockval_load(form, &b, a, entry_of(a, i, via));
    int turn = carried(form, out, &b, f, via);
    put_frame(form, f, i, out, turn);
}

/* Best frame of row i with those of its group held: the polar factor of -sum A_ij T_j. Around a singularity
 * the turns disagree; TURNED then keeps its own and hears only who agrees. */
PC_ALWAYS_INLINE void relax_row(pc_block_form form, const frames *f, const pc_blockmat *a,
                                const pc_aggregates *g, pc_index i) {
    const int n = pc_form_size(form);
    double sum[16] = {0};
    double size = 0;
    for (size_t e = a->start[i]; e < a->start[i + 1]; e++) {
        pc_index j = a->column[e];
        if (g->of[j] != g->of[i]) continue;
        pc_blockval b;
        double out[16];
        pc_blockval_load(form, &b, a, e);
        int turn = carried(form, out, &b, f, j);
        if (form == PC_FORM_TURNED && turn != f->turn[i]) continue;
        size += sqrt(pc_blockval_square(form, &b));
        for (int k = 0; k < n; k++)
            sum[k] += out[k];
    }
    double square = 0;
    for (int k = 0; k < n; k++)
        square += sum[k] * sum[k];
    if (square <= 1e-4 * size * size) return;
    put_frame(form, f, i, sum, form == PC_FORM_TURNED ? f->turn[i] : 0);
}

/* Frames of all rows of a group. */
PC_ALWAYS_INLINE void transport(pc_block_form form, const frames *f, const pc_blockmat *a,
                                const pc_aggregates *g, pc_index group) {
    enum { SWEEPS = 2 };
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
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        for (pc_index k = 0; k < size; k++)
            relax_row(form, f, a, g, member[k]);
    }
}

pc_status pc_aggregates_transport(pc_blockmat *tentative, pc_context *ctx, const pc_aggregates *aggregates,
                                  const pc_blockmat *matrix) {
    pc_status status = PC_OK;
    const pc_block_form form = matrix->form;
    const size_t size = (size_t)pc_form_size(form);
    frames f = {0};
    *tentative = (pc_blockmat){0};
    PC_TRY(pc_new(&f.value, ctx, size * matrix->row_count));
    if (form == PC_FORM_TURNED) PC_TRY(pc_new(&f.turn, ctx, matrix->row_count));
#define GROUP(form_of, group) transport(form_of, &f, matrix, aggregates, group)
    PC_EACH_ROW(form, aggregates->count, GROUP);
#undef GROUP
    PC_TRY(pc_blockmat_make(tentative, ctx, pc_form_coarse(form), matrix->row_count, aggregates->count,
                            aggregates->start[aggregates->count], false));
    pc_index e = 0;
    const size_t coarse = (size_t)pc_form_size(tentative->form);
    for (pc_index i = 0; i < matrix->row_count; i++) {
        tentative->start[i] = e;
        if (aggregates->of[i] == PC_NONE) continue;
        tentative->column[e] = aggregates->of[i];
        if (form == PC_FORM_TURNED)
            pc_turned_dense(tentative->value + coarse * e, f.value + size * i, f.turn[i]);
        else
            memcpy(tentative->value + coarse * e, f.value + size * i, size * sizeof(float));
        e++;
    }
    tentative->start[matrix->row_count] = e;
done:
    pc_free(ctx, f.value);
    pc_free(ctx, f.turn);
    if (status != PC_OK) pc_blockmat_free(tentative, ctx);
    return status;
}
