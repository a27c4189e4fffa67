#include "intervals.h"
#include "memory.h"
#include "polygraph.h"
#include <math.h>
#include <string.h>

/* Elimination is dense: of more faces with sums of their own the rest is refused. */
enum { MOST_ROWS = 1500 };

/* One face's sums along s (0) or t (1): the sum of `value` times the chains' scales is 0. Scales are
 * intervals divided by what was wanted. */
typedef struct row {
    pc_index face;
    int direction;
    double *value; /* one per column */
    double force;  /* its multiplier */
    pc_index pivot;
} row;

typedef struct solving {
    const pc_polymesh *faces;
    const uint8_t *may_go;
    const double *wanted; /* per corner */
    pc_polygraph graph;
    uint8_t *side;                 /* per corner: 0..3, of the edge that leaves it */
    pc_index *parent;              /* per corner: trees of edges in fixed proportion */
    pc_index *column;              /* per corner that is a root: its number among those in rows, or PC_NONE */
    pc_index *chain;               /* per column: the root */
    double *weight, *scale, *push; /* per column: edges in the chain, the solution, the bound's multiplier */
    double *sum;                   /* per corner, scratch: of one row */
    row *rows;
    pc_index row_room, row_count, column_count;
} solving;

static pc_index root_of(solving *s, pc_index c) {
    pc_index twin = s->graph.twin[c];
    if (twin < c) c = twin;
    while (s->parent[c] != c)
        c = s->parent[c] = s->parent[s->parent[c]];
    return c;
}

static void join(solving *s, pc_index a, pc_index b) {
    a = root_of(s, a), b = root_of(s, b);
    if (a != b) s->parent[a > b ? a : b] = a < b ? a : b;
}

static bool is_flat(const solving *s, pc_index c) {
    return s->faces->corner_flat && s->faces->corner_flat[c];
}

/* Sides are counted from the first corner of the face that is not flat. */
static void number_sides(solving *s) {
    for (pc_index f = 0; f < s->faces->face_count; f++) {
        pc_index from = s->faces->start[f], count = s->faces->start[f + 1] - from, first = 0;
        uint8_t side = 3;
        while (is_flat(s, from + first))
            first++;
        for (pc_index i = 0; i < count; i++) {
            pc_index c = from + (first + i) % count;
            if (!is_flat(s, c)) side = (side + 1) & 3;
            s->side[c] = side;
        }
    }
}

/* The chains of one row and their coefficients in s->sum; how many there are. The caller clears the sums. */
static pc_index gather(solving *s, pc_index *chain, pc_index f, int direction) {
    pc_index from = s->faces->start[f], to = s->faces->start[f + 1], count = 0, left = 0;
    for (pc_index c = from; c < to; c++) {
        if ((s->side[c] & 1) != direction) continue;
        pc_index r = root_of(s, c), k = 0;
        while (k < count && chain[k] != r)
            k++;
        if (k == count) chain[count++] = r;
        s->sum[r] += s->side[c] < 2 ? s->wanted[c] : -s->wanted[c];
    }
    for (pc_index k = 0; k < count; k++)
        if (s->sum[chain[k]] != 0) chain[left++] = chain[k];
    return left;
}

static void clear(solving *s, pc_index f) {
    for (pc_index c = s->faces->start[f]; c < s->faces->start[f + 1]; c++)
        s->sum[root_of(s, c)] = 0;
}

/* Joins chains that a row makes equal; true where one did. */
static bool join_equal(solving *s, pc_index *chain) {
    bool joined = false;
    for (pc_index f = 0; f < s->faces->face_count; f++)
        for (int d = 0; d < 2; d++) {
            pc_index count = gather(s, chain, f, d);
            bool equal = count == 2 && s->sum[chain[0]] + s->sum[chain[1]] == 0;
            clear(s, f);
            if (!equal) continue;
            join(s, chain[0], chain[1]);
            joined = true;
        }
    return joined;
}

/* Edges that leave a vertex of other than four quarters. */
static pc_status join_stars(solving *s, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index *quarters = NULL, *first = NULL;
    uint8_t *border = NULL;
    const pc_polymesh *p = s->faces;
    PC_TRY(pc_new(&quarters, ctx, p->vertex_count));
    PC_TRY(pc_new(&border, ctx, p->vertex_count));
    PC_TRY(pc_new(&first, ctx, p->vertex_count));
    memset(first, 0xff, p->vertex_count * sizeof *first);
    for (pc_index c = 0; c < s->graph.corner_count; c++) {
        quarters[p->corner[c]] += is_flat(s, c) ? 2 : 1;
        if (s->graph.twin[c] == PC_NONE) {
            pc_index f = s->graph.face[c];
            border[p->corner[c]] = border[p->corner[pc_polymesh_next(p, f, c)]] = 1;
        }
    }
    for (pc_index c = 0; c < s->graph.corner_count; c++) {
        pc_index v = p->corner[c];
        if (quarters[v] == 4 || border[v]) continue;
        if (first[v] == PC_NONE)
            first[v] = c;
        else
            join(s, c, first[v]);
    }
done:
    pc_free(ctx, quarters);
    pc_free(ctx, border);
    pc_free(ctx, first);
    return status;
}

/* What cannot be zero with positive scales. */
static bool is_hopeless(const solving *s, const pc_index *chain, pc_index count) {
    bool plus = false, minus = false;
    for (pc_index k = 0; k < count; k++) {
        plus = plus || s->sum[chain[k]] > 0;
        minus = minus || s->sum[chain[k]] < 0;
    }
    return !plus || !minus;
}

static pc_status refuse(solving *s, uint8_t *refused, pc_intervals_stats *stats, pc_context *ctx,
                        pc_index f) {
    if (!s->may_go[f])
        return pc_fail(ctx, PC_E_BUG, "opposite sides of face %u cannot have the same knot intervals", f);
    stats->refused += !refused[f];
    refused[f] = 1;
    return PC_OK;
}

/* Counts rows (`fill` false), then writes them. */
static pc_status list_rows(solving *s, uint8_t *refused, pc_intervals_stats *stats, pc_context *ctx,
                           pc_index *chain, bool fill) {
    pc_status status = PC_OK;
    s->row_count = 0;
    for (pc_index f = 0; f < s->faces->face_count; f++)
        for (int d = 0; d < 2; d++) {
            pc_index count = gather(s, chain, f, d);
            bool hopeless = count && is_hopeless(s, chain, count);
            if (count && !hopeless && s->row_count < MOST_ROWS && !refused[f]) {
                for (pc_index k = 0; k < count && !fill; k++)
                    if (s->column[chain[k]] == PC_NONE) s->column[chain[k]] = s->column_count++;
                for (pc_index k = 0; k < count && fill; k++)
                    s->rows[s->row_count].value[s->column[chain[k]]] = s->sum[chain[k]];
                if (fill) s->rows[s->row_count].face = f, s->rows[s->row_count].direction = d;
                s->row_count++;
            } else if (count && !refused[f]) {
                status = refuse(s, refused, stats, ctx, f);
            }
            clear(s, f);
            PC_TRY(status);
        }
done:
    return status;
}

static pc_status make_rows(solving *s, uint8_t *refused, pc_intervals_stats *stats, pc_context *ctx,
                           pc_index *chain) {
    pc_status status = PC_OK;
    memset(s->column, 0xff, s->graph.corner_count * sizeof *s->column);
    PC_TRY(list_rows(s, refused, stats, ctx, chain, false));
    s->row_room = s->row_count;
    PC_TRY(pc_new(&s->rows, ctx, (size_t)s->row_room));
    PC_TRY(pc_new(&s->weight, ctx, (size_t)s->column_count));
    PC_TRY(pc_new(&s->scale, ctx, (size_t)s->column_count));
    PC_TRY(pc_new(&s->push, ctx, (size_t)s->column_count));
    for (pc_index r = 0; r < s->row_room; r++)
        PC_TRY(pc_new(&s->rows[r].value, ctx, (size_t)s->column_count));
    PC_TRY(list_rows(s, refused, stats, ctx, chain, true));
    for (pc_index c = 0; c < s->graph.corner_count; c++) {
        pc_index r = root_of(s, c);
        stats->chains += r == c;
        if (s->column[r] != PC_NONE && !(s->graph.twin[c] < c)) s->weight[s->column[r]]++;
    }
    for (pc_index k = 0; k < s->column_count; k++)
        s->scale[k] = 1;
done:
    return status;
}

/* Least squares by rows and bounds in turn, each exact with its multiplier (Hildreth 1957). The largest
 * violation at the end. */
static double balance(solving *s, double least) {
    enum { SWEEPS = 4000 };
    double worst = 0;
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        worst = 0;
        for (pc_index r = 0; r < s->row_count; r++) {
            row *at = s->rows + r;
            double sum = 0, square = 0;
            for (pc_index k = 0; k < s->column_count; k++) {
                sum += at->value[k] * s->scale[k];
                square += at->value[k] * at->value[k] / s->weight[k];
            }
            at->force -= sum / square;
            for (pc_index k = 0; k < s->column_count; k++)
                s->scale[k] -= sum / square * at->value[k] / s->weight[k];
            worst = fmax(worst, fabs(sum));
        }
        for (pc_index k = 0; k < s->column_count; k++) {
            double push = fmax(0, s->push[k] + s->weight[k] * (least - s->scale[k]));
            worst = fmax(worst, least - s->scale[k]);
            s->scale[k] += (push - s->push[k]) / s->weight[k];
            s->push[k] = push;
        }
        if (worst < 1e-6) break;
    }
    return worst;
}

static bool is_power_of_two(double x) {
    int exponent;
    return fabs(frexp(x, &exponent)) == 0.5;
}

/* Every row gets a chain of its own, which no other row has, with a coefficient that divides exactly. */
static pc_status eliminate(solving *s, uint8_t *refused, pc_intervals_stats *stats, pc_context *ctx) {
    for (pc_index r = 0; r < s->row_count; r++) {
        row *at = s->rows + r;
        bool empty = true;
        at->pivot = PC_NONE;
        for (pc_index k = 0; k < s->column_count; k++) {
            double x = at->value[k];
            empty = empty && x == 0;
            if (x == 0 || !is_power_of_two(x)) continue;
            if (at->pivot == PC_NONE || fabs(x) > fabs(at->value[at->pivot])) at->pivot = k;
        }
        if (empty) continue; /* follows from the others */
        if (at->pivot == PC_NONE) {
            pc_status status = refuse(s, refused, stats, ctx, at->face);
            if (status != PC_OK) return status;
            continue;
        }
        for (pc_index o = 0; o < s->row_count; o++) {
            double share = o == r ? 0 : s->rows[o].value[at->pivot] / at->value[at->pivot];
            for (pc_index k = 0; k < s->column_count && share != 0; k++)
                s->rows[o].value[k] -= share * at->value[k];
        }
    }
    return PC_OK;
}

/* The solution in binary fractions of 2^-digits: free chains are rounded, those of rows follow. False where
 * one falls below the bound. */
static bool round_scales(solving *s, double *rounded, double least, int digits) {
    for (pc_index k = 0; k < s->column_count; k++)
        rounded[k] = ldexp(rint(ldexp(s->scale[k], digits)), -digits);
    for (pc_index r = 0; r < s->row_count; r++)
        if (s->rows[r].pivot != PC_NONE) rounded[s->rows[r].pivot] = 0;
    for (pc_index r = 0; r < s->row_count; r++) {
        const row *at = s->rows + r;
        double sum = 0;
        if (at->pivot == PC_NONE) continue;
        for (pc_index k = 0; k < s->column_count; k++)
            if (k != at->pivot) sum += at->value[k] * rounded[k];
        rounded[at->pivot] = -sum / at->value[at->pivot];
    }
    for (pc_index k = 0; k < s->column_count; k++)
        if (!(rounded[k] >= least)) return false;
    return true;
}

/* The coarsest fractions that do: few different knots make few slivers. */
static pc_status settle(solving *s, pc_context *ctx, double least) {
    enum { FEWEST = 2, MOST = 16 };
    pc_status status = PC_OK;
    double *rounded = NULL;
    bool good = false;
    PC_TRY(pc_new(&rounded, ctx, (size_t)s->column_count));
    for (int digits = FEWEST; digits <= MOST && !good; digits++)
        good = round_scales(s, rounded, least, digits);
    if (!good) PC_TRY(pc_fail(ctx, PC_E_BUG, "no binary fractions near the knot intervals"));
    memcpy(s->scale, rounded, s->column_count * sizeof *rounded);
done:
    pc_free(ctx, rounded);
    return status;
}

/* The face whose sums pull hardest, of those that may go. */
static pc_index hardest(const solving *s) {
    pc_index best = PC_NONE;
    double most = -1;
    for (pc_index r = 0; r < s->row_count; r++)
        if (s->may_go[s->rows[r].face] && fabs(s->rows[r].force) > most)
            most = fabs(s->rows[r].force), best = s->rows[r].face;
    return best;
}

static pc_status solve(double *interval, solving *s, uint8_t *refused, pc_intervals_stats *stats,
                       pc_context *ctx, double least) {
    pc_status status = PC_OK;
    const double tolerance = 1e-3;
    if (s->row_count && balance(s, least) > tolerance) {
        pc_index f = hardest(s);
        return refuse(s, refused, stats, ctx, f == PC_NONE ? s->rows[0].face : f);
    }
    PC_TRY(eliminate(s, refused, stats, ctx));
    if (stats->refused) return PC_OK;
    PC_TRY(settle(s, ctx, least / 2));
    for (pc_index k = 0; k < s->column_count; k++)
        stats->changed += s->scale[k] != 1;
    for (pc_index c = 0; c < s->graph.corner_count; c++) {
        pc_index k = s->column[root_of(s, c)];
        if (k != PC_NONE) interval[c] *= s->scale[k];
    }
done:
    return status;
}

pc_status pc_intervals_solve(double *interval, uint8_t *refused, pc_intervals_stats *stats, pc_context *ctx,
                             const pc_polymesh *faces, const uint8_t *may_go, double least) {
    pc_status status = PC_OK;
    solving s = {.faces = faces, .may_go = may_go, .wanted = interval};
    pc_index *chain = NULL;
    size_t corners = faces->start[faces->face_count];
    *stats = (pc_intervals_stats){0};
    PC_TRY(pc_polygraph_of_polymesh(&s.graph, ctx, faces));
    PC_TRY(pc_new(&s.side, ctx, corners));
    PC_TRY(pc_new(&s.parent, ctx, corners));
    PC_TRY(pc_new(&s.column, ctx, corners));
    PC_TRY(pc_new(&s.sum, ctx, corners));
    PC_TRY(pc_new(&chain, ctx, corners));
    for (pc_index c = 0; c < corners; c++)
        s.parent[c] = c;
    number_sides(&s);
    while (join_equal(&s, chain)) {
    }
    PC_TRY(join_stars(&s, ctx));
    while (join_equal(&s, chain)) {
    }
    PC_TRY(make_rows(&s, refused, stats, ctx, chain));
    stats->rows = s.row_count;
    if (!stats->refused) PC_TRY(solve(interval, &s, refused, stats, ctx, least));
done:
    for (pc_index r = 0; s.rows && r < s.row_room; r++)
        pc_free(ctx, s.rows[r].value);
    pc_polygraph_free(&s.graph, ctx);
    pc_free(ctx, s.side);
    pc_free(ctx, s.parent);
    pc_free(ctx, s.column);
    pc_free(ctx, s.sum);
    pc_free(ctx, s.weight);
    pc_free(ctx, s.scale);
    pc_free(ctx, s.push);
    pc_free(ctx, s.rows);
    pc_free(ctx, chain);
    return status;
}
