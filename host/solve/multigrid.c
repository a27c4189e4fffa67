#include "multigrid.h"
#include "eachrow.h"
#include "galerkin.h"
#include "memory.h"
#include "random.h"
#include "smallmat.h"
#include <math.h>
#include <string.h>

/* Reals of a last level that is solved directly. */
enum { DIRECT = 320 };
enum { SUM_BLOCK = 4096 };
/* Share of the spectrum, from above, that smoothing covers. */
static const double smooth_from = 0.1;
static const double strong = 0.06;

static size_t reals(const pc_blockmat *a) {
    return (size_t)a->row_count * (size_t)pc_form_width(a->form);
}

static float hashed(size_t i) {
    return (float)(pc_hash64(i) >> 40) * 0x1p-23F - 1;
}

/* sum x_i y_i in fixed blocks, whose sums go by `partial` */
static double product_sum(const float *x, const float *y, double *partial, size_t n) {
    const size_t blocks = (n + SUM_BLOCK - 1) / SUM_BLOCK;
    double total = 0;
#pragma omp parallel for schedule(static) if (n > PC_PARALLEL_ROWS)
    for (size_t block = 0; block < blocks; block++) {
        const size_t end = (block + 1) * SUM_BLOCK < n ? (block + 1) * SUM_BLOCK : n;
        float sum = 0;
        for (size_t i = block * SUM_BLOCK; i < end; i++)
            sum += x[i] * y[i];
        partial[block] = (double)sum;
    }
    for (size_t block = 0; block < blocks; block++)
        total += partial[block];
    return total;
}

/* x^T D x */
static double weighted_square_sum(const float *x, const pc_blockmat *a) {
    const size_t diagonals = a->row_count * (size_t)pc_form_diagonal(a->form);
    double total = 0;
    if (a->form == PC_FORM_SCALAR) {
        for (size_t i = 0; i < diagonals; i++)
            total += (double)(a->diagonal[i] * x[i] * x[i]);
        return total;
    }
    for (size_t i = 0; i < diagonals; i++) {
        total += (double)(a->diagonal[i] * x[2 * i] * x[2 * i]);
        total += (double)(a->diagonal[i] * x[2 * i + 1] * x[2 * i + 1]);
    }
    return total;
}

/* y = D^-1 y */
static void divide(float *y, const pc_blockmat *a) {
    pc_blockmat_smooth_first(y, y, a, y, 1);
}

/* What no eigenvalue of D^-1 A exceeds (Gershgorin). Coupling sizes against the smaller diagonal of a row. */
static double largest_possible(const pc_blockmat *a) {
    const size_t width = (size_t)pc_form_size(a->form);
    const size_t per_row = (size_t)pc_form_diagonal(a->form);
    double largest = 0;
#pragma omp parallel for schedule(static) reduction(max : largest)
    for (pc_index i = 0; i < a->row_count; i++) {
        double sum[2] = {0, 0};
        for (size_t e = a->start[i]; e < a->start[i + 1]; e++) {
            for (size_t k = 0; k < width; k += 2) {
                float re = a->value[width * e + k];
                float im = width > 1 ? a->value[width * e + k + 1] : 0;
                sum[k / 2] += (double)sqrtf(re * re + im * im);
            }
        }
        for (size_t k = 0; k < per_row; k++) {
            double share = 1 + sum[k] / (double)a->diagonal[per_row * i + k];
            if (share > largest) largest = share;
        }
    }
    return largest;
}

/* The largest eigenvalue of a symmetric tridiagonal matrix, by bisection on the sign of its pivots. */
static double largest_of_tridiagonal(const double *diagonal, const double *beside, int n) {
    double low = 0;
    double high = 0;
    for (int i = 0; i < n; i++) {
        double reach = (i > 0 ? fabs(beside[i - 1]) : 0) + (i + 1 < n ? fabs(beside[i]) : 0);
        high = fmax(high, diagonal[i] + reach);
    }
    for (int step = 0; step < 40; step++) {
        double middle = 0.5 * (low + high);
        double pivot = 1;
        bool above = true;
        for (int i = 0; i < n && above; i++) {
            double b = i > 0 ? beside[i - 1] : 0;
            pivot = middle - diagonal[i] - b * b / pivot;
            above = pivot > 0;
        }
        if (above)
            high = middle;
        else
            low = middle;
    }
    return high;
}

/* Vectors of Lanczos' method. */
typedef struct lanczos {
    float *x, *y, *before;
    double *partial;
} lanczos;

static pc_status start_lanczos(lanczos *l, pc_context *ctx, const pc_blockmat *a) {
    const size_t n = reals(a);
    pc_status status = PC_OK;
    PC_TRY(pc_resize(&l->x, ctx, n));
    PC_TRY(pc_resize(&l->y, ctx, n));
    PC_TRY(pc_new(&l->before, ctx, n));
    PC_TRY(pc_resize(&l->partial, ctx, n / SUM_BLOCK + 1));
#pragma omp parallel for schedule(static) if (n > PC_PARALLEL_ROWS)
    for (size_t i = 0; i < n; i++)
        l->x[i] = hashed(i);
    const double norm = sqrt(weighted_square_sum(l->x, a));
#pragma omp parallel for schedule(static) if (n > PC_PARALLEL_ROWS)
    for (size_t i = 0; i < n; i++)
        l->x[i] = (float)((double)l->x[i] / norm);
done:
    return status;
}

static void free_lanczos(const lanczos *l, pc_context *ctx) {
    pc_free(ctx, l->x);
    pc_free(ctx, l->y);
    pc_free(ctx, l->before);
    pc_free(ctx, l->partial);
}

/* A row of the tridiagonal matrix, after the number beside the one before. */
static void step_lanczos(const lanczos *l, const pc_blockmat *a, double *diagonal, double *beside,
                         double last) {
    const size_t n = reals(a);
    pc_blockmat_apply(l->y, a, l->x);
    const double own = product_sum(l->x, l->y, l->partial, n);
    divide(l->y, a);
#pragma omp parallel for schedule(static) if (n > PC_PARALLEL_ROWS)
    for (size_t i = 0; i < n; i++)
        l->y[i] -= (float)(own * (double)l->x[i] + last * (double)l->before[i]);
    const double norm = sqrt(weighted_square_sum(l->y, a));
    *diagonal = own;
    *beside = norm;
    if (!(norm > 1e-6)) return;
#pragma omp parallel for schedule(static) if (n > PC_PARALLEL_ROWS)
    for (size_t i = 0; i < n; i++) {
        l->before[i] = l->x[i];
        l->x[i] = (float)((double)l->y[i] / norm);
    }
}

/* A little above the largest eigenvalue of D^-1 A. Rows that outweigh their couplings tell well enough; else
 * Lanczos' method in the scalar product of D finds outliers that a power iteration of the same length would
 * not see. */
static pc_status find_largest(double *largest, pc_context *ctx, const pc_blockmat *a) {
    enum { ITERATIONS = 7 };
    const double enough = 2.01;
    double diagonal[ITERATIONS];
    double beside[ITERATIONS];
    lanczos l = {0};
    int count = 0;
    pc_status status = PC_OK;
    const double bound = largest_possible(a);
    *largest = bound;
    if (bound <= enough) return PC_OK;
    PC_TRY(start_lanczos(&l, ctx, a));
    for (bool more = true; more && count < ITERATIONS; count++) {
        step_lanczos(&l, a, &diagonal[count], &beside[count], count > 0 ? beside[count - 1] : 0);
        more = beside[count] > 1e-6;
    }
    const double found = 1.05 * largest_of_tridiagonal(diagonal, beside, count);
    if (isfinite(found) && found > 1 && found < bound) *largest = found;
done:
    free_lanczos(&l, ctx);
    return status;
}

/* Chebyshev polynomials over [smooth_from, 1] * largest (Adams, Brezina, Hu, Tuminaro 2003). */
static void choose_steps(pc_level *level) {
    double high = level->largest;
    double low = smooth_from * high;
    double theta = 0.5 * (high + low);
    double delta = 0.5 * (high - low);
    double rho = delta / theta;
    level->chebyshev.alpha[0] = 0;
    level->chebyshev.beta[0] = (float)(1 / theta);
    for (int k = 1; k < PC_SMOOTH_STEPS; k++) {
        double next = 1 / (2 * theta / delta - rho);
        level->chebyshev.alpha[k] = (float)(next * rho);
        level->chebyshev.beta[k] = (float)(2 * next / delta);
        rho = next;
    }
}

static pc_status finest(pc_multigrid *mg, pc_context *ctx, const pc_system *system) {
    const pc_index n = system->row_count;
    const size_t entries = system->start[n];
    pc_blockmat *a = &mg->level[0].matrix;
    const pc_block_form form = (pc_block_form)system->kind;
    pc_status status = PC_OK;
    if (n * (size_t)pc_form_width(form) > DIRECT) {
        PC_TRY(pc_blockmat_borrow(a, ctx, system));
    } else {
        /* Its inverse may be asked for when the system is gone. */
        PC_TRY(pc_blockmat_make(a, ctx, form, n, n, entries, true));
        memcpy(a->start, system->start, ((size_t)n + 1) * sizeof *a->start);
        memcpy(a->column, system->column, entries * sizeof *a->column);
        if (a->turn) memcpy(a->turn, system->turn, entries);
    }
    double total = 0;
    for (pc_index i = 0; i < n; i++)
        total += system->diagonal[i];
    /* A power of two, so that scaled doubles are exact. */
    mg->scale = n > 0 ? ldexp(1, -ilogb(total / n)) : 1;
#pragma omp parallel for schedule(static)
    for (size_t k = 0; k < entries * (size_t)pc_form_size(form); k++)
        a->value[k] = (float)(mg->scale * system->value[k]);
    const size_t per_row = (size_t)pc_form_diagonal(form);
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < n; i++)
        for (size_t k = 0; k < per_row; k++)
            a->diagonal[per_row * i + k] = (float)(mg->scale * system->diagonal[i]);
    a->exact = system->value;
    a->exact_diagonal = system->diagonal;
    a->exact_scale = mg->scale;
    pc_galerkin_invert_diagonal(a);
done:
    return status;
}

/* The next level from level k; groups are made where there are none. `*last` where coarsening ends here. */
static pc_status coarsen(pc_multigrid *mg, pc_context *ctx, int k, bool *last) {
    pc_status status = PC_OK;
    pc_level *fine = &mg->level[k];
    pc_blockmat tentative = {0};
    PC_TRY(find_largest(&fine->largest, ctx, &fine->matrix));
    choose_steps(fine);
    *last = k + 1 == PC_MOST_LEVELS || reals(&fine->matrix) <= DIRECT;
    if (*last) goto done;
    if (fine->aggregates.of)
        PC_TRY(pc_aggregates_list(&fine->aggregates, ctx));
    else
        PC_TRY(pc_aggregates_make(&fine->aggregates, ctx, &fine->matrix, strong * pow(0.5, k)));
    *last = fine->aggregates.count == 0 || fine->aggregates.count > 0.9 * fine->matrix.row_count;
    if (*last) goto done;
    PC_TRY(pc_aggregates_transport(&tentative, ctx, &fine->aggregates, &fine->matrix));
    PC_TRY(pc_galerkin_smooth(&fine->prolongator, ctx, &fine->matrix, &tentative, 4.0 / (3 * fine->largest)));
    PC_TRY(pc_galerkin_transpose(&fine->restriction, ctx, &fine->prolongator));
    PC_TRY(pc_galerkin_coarse(&fine[1].matrix, ctx, &fine->restriction, &fine->matrix, &fine->prolongator));
done:
    pc_blockmat_free(&tentative, ctx);
    return status;
}

/* The dense inverse of the last level, if it is small. */
static pc_status invert_last(pc_multigrid *mg, pc_context *ctx) {
    const pc_blockmat *a = &mg->level[mg->level_count - 1].matrix;
    const size_t n = reals(a);
    pc_status status = PC_OK;
    double *m = NULL;
    if (n > DIRECT) return PC_OK;
    PC_TRY(pc_new(&m, ctx, n * n));
    PC_TRY(pc_new(&mg->inverse, ctx, n * n));
    pc_blockmat_dense(m, a);
    PC_TRY(pc_smallmat_invert(m, ctx, n));
    for (size_t k = 0; k < n * n; k++)
        mg->inverse[k] = (float)m[k];
done:
    pc_free(ctx, m);
    return status;
}

/* Nothing has changed the diagonal before. */
static pc_status keep_first_diagonal(pc_level *level, pc_context *ctx) {
    if (level->first_diagonal) return PC_OK;
    pc_status status = pc_new(&level->first_diagonal, ctx, level->matrix.row_count);
    for (pc_index i = 0; status == PC_OK && i < level->matrix.row_count; i++)
        level->first_diagonal[i] = (float)pc_blockmat_mean_diagonal(&level->matrix, i);
    return status;
}

/* The mean diagonals of a level become those of the first time plus `change`. */
static void raise_diagonal(pc_level *level, const double *change) {
    pc_blockmat *a = &level->matrix;
    const size_t per_row = (size_t)pc_form_diagonal(a->form);
#pragma omp parallel for schedule(static)
    for (pc_index i = 0; i < a->row_count; i++) {
        double wanted = (double)level->first_diagonal[i] + change[i];
        float more = (float)(wanted - pc_blockmat_mean_diagonal(a, i));
        for (size_t k = 0; k < per_row; k++)
            a->diagonal[per_row * i + k] += more;
    }
    pc_galerkin_invert_diagonal(a);
}

double pc_multigrid_first_diagonal(const pc_multigrid *multigrid, pc_index i) {
    const pc_level *level = multigrid->level;
    return (level->first_diagonal ? (double)level->first_diagonal[i]
                                  : pc_blockmat_mean_diagonal(&level->matrix, i)) /
           multigrid->scale;
}

pc_status pc_multigrid_set_diagonal(pc_multigrid *multigrid, pc_context *ctx, const double *diagonal) {
    pc_status status = PC_OK;
    double *change = NULL;
    double *coarse = NULL;
    pc_index n = multigrid->level[0].matrix.row_count;
    PC_TRY(pc_new(&change, ctx, n));
    for (pc_index i = 0; i < n; i++)
        change[i] = multigrid->scale * (diagonal[i] - pc_multigrid_first_diagonal(multigrid, i));
    for (int k = 0; k < multigrid->level_count; k++) {
        pc_level *level = &multigrid->level[k];
        PC_TRY(keep_first_diagonal(level, ctx));
        raise_diagonal(level, change);
        if (k + 1 == multigrid->level_count) break;
        PC_TRY(pc_new(&coarse, ctx, level->aggregates.count));
        for (pc_index i = 0; i < level->matrix.row_count; i++)
            if (level->aggregates.of[i] != PC_NONE) coarse[level->aggregates.of[i]] += change[i];
        pc_free(ctx, change);
        change = coarse;
        coarse = NULL;
    }
    pc_free(ctx, multigrid->inverse);
    multigrid->inverse = NULL;
    if (!multigrid->finest_only) PC_TRY(invert_last(multigrid, ctx));
done:
    pc_free(ctx, change);
    return status;
}

static pc_status build(pc_multigrid *mg, pc_context *ctx, const pc_system *system) {
    pc_status status = PC_OK;
    bool last = false;
    PC_TRY(finest(mg, ctx, system));
    for (mg->level_count = 1; !last; mg->level_count += !last) {
        PC_TRY(pc_check_interrupt(ctx));
        PC_TRY(coarsen(mg, ctx, mg->level_count - 1, &last));
    }
    PC_TRY(invert_last(mg, ctx));
    for (int k = 0; k < mg->level_count; k++)
        pc_log(ctx, PC_LOG_DEBUG, "multigrid level %d: %u rows, %u couplings, largest eigenvalue %.3f", k,
               mg->level[k].matrix.row_count, mg->level[k].matrix.start[mg->level[k].matrix.row_count],
               mg->level[k].largest);
done:
    if (status != PC_OK) pc_multigrid_free(mg, ctx);
    return status;
}

pc_status pc_multigrid_make(pc_multigrid *multigrid, pc_context *ctx, const pc_system *system) {
    *multigrid = (pc_multigrid){0};
    return build(multigrid, ctx, system);
}

pc_status pc_multigrid_make_finest(pc_multigrid *multigrid, pc_context *ctx, const pc_system *system) {
    *multigrid = (pc_multigrid){.level_count = 1, .finest_only = true};
    pc_status status = finest(multigrid, ctx, system);
    if (status != PC_OK) pc_multigrid_free(multigrid, ctx);
    return status;
}

void pc_multigrid_free_values(pc_multigrid *multigrid, pc_context *ctx) {
    for (int k = 0; k < PC_MOST_LEVELS; k++) {
        pc_level *level = &multigrid->level[k];
        pc_blockmat_free(&level->matrix, ctx);
        pc_blockmat_free(&level->prolongator, ctx);
        pc_blockmat_free(&level->restriction, ctx);
        float **vectors[5] = {&level->x, &level->x_other, &level->d, &level->b, &level->first_diagonal};
        for (int v = 0; v < 5; v++) {
            pc_free(ctx, *vectors[v]);
            *vectors[v] = NULL;
        }
    }
    pc_free(ctx, multigrid->inverse);
    multigrid->inverse = NULL;
}

void pc_multigrid_free_transfers(pc_multigrid *multigrid, pc_context *ctx, int level) {
    pc_blockmat_free(&multigrid->level[level].prolongator, ctx);
    pc_blockmat_free(&multigrid->level[level].restriction, ctx);
}

void pc_multigrid_free_couplings(pc_multigrid *multigrid, pc_context *ctx, int level) {
    pc_level *l = &multigrid->level[level];
    pc_multigrid_free_transfers(multigrid, ctx, level);
    pc_aggregates_unlist(&l->aggregates, ctx);
    pc_free(ctx, l->matrix.inverse);
    l->matrix.inverse = NULL;
    l->matrix.exact = l->matrix.exact_diagonal = NULL;
    if (level + 1 < multigrid->level_count || l->matrix.borrowed) pc_blockmat_free_couplings(&l->matrix, ctx);
}

pc_status pc_multigrid_update(pc_multigrid *multigrid, pc_context *ctx, const pc_system *system) {
    pc_multigrid_free_values(multigrid, ctx);
    return build(multigrid, ctx, system);
}

void pc_multigrid_free(pc_multigrid *multigrid, pc_context *ctx) {
    pc_multigrid_free_values(multigrid, ctx);
    for (int k = 0; k < PC_MOST_LEVELS; k++)
        pc_aggregates_free(&multigrid->level[k].aggregates, ctx);
    *multigrid = (pc_multigrid){0};
}

pc_status pc_multigrid_make_vectors(pc_multigrid *multigrid, pc_context *ctx) {
    pc_status status = PC_OK;
    for (int k = 0; k < multigrid->level_count; k++) {
        pc_level *level = &multigrid->level[k];
        float **vectors[4] = {&level->x, &level->x_other, &level->d, &level->b};
        for (int v = 0; v < 4; v++) {
            if (!*vectors[v]) PC_TRY(pc_new(vectors[v], ctx, reals(&level->matrix)));
        }
    }
done:
    return status;
}

static void swap_x(pc_level *level) {
    float *x = level->x;
    level->x = level->x_other;
    level->x_other = x;
}

static void smooth(pc_level *level, int from) {
    for (int step = from; step < PC_SMOOTH_STEPS; step++) {
        pc_blockmat_smooth(level->x_other, level->d, &level->matrix, level->b, level->x,
                           level->chebyshev.alpha[step], level->chebyshev.beta[step]);
        swap_x(level);
    }
}

static void solve_last(const pc_multigrid *mg, pc_level *level) {
    enum { SWEEPS = 4 };
    size_t n = reals(&level->matrix);
    if (!mg->inverse) {
        pc_blockmat_smooth_first(level->x, level->d, &level->matrix, level->b, level->chebyshev.beta[0]);
        smooth(level, 1);
        for (int sweep = 1; sweep < SWEEPS; sweep++)
            smooth(level, 0);
        return;
    }
    for (size_t i = 0; i < n; i++) {
        float sum = 0;
        for (size_t k = 0; k < n; k++)
            sum += mg->inverse[i * n + k] * level->b[k];
        level->x[i] = sum;
    }
}

static void descend(pc_level *level) {
    pc_blockmat_smooth_first(level->x, level->d, &level->matrix, level->b, level->chebyshev.beta[0]);
    smooth(level, 1);
    pc_blockmat_residual(level->x_other, &level->matrix, level->b, level->x);
    pc_blockmat_apply(level[1].b, &level->restriction, level->x_other);
}

static void ascend(pc_level *level) {
    pc_blockmat_add(level->x, &level->prolongator, level[1].x);
    smooth(level, 0);
}

void pc_multigrid_cycle(pc_multigrid *multigrid) {
    int last = multigrid->level_count - 1;
    for (int k = 0; k < last; k++)
        descend(&multigrid->level[k]);
    solve_last(multigrid, &multigrid->level[last]);
    for (int k = last - 1; k >= 0; k--)
        ascend(&multigrid->level[k]);
}
