#include "convexmap.h"
#include "memory.h"
#include <complex.h>
#include <math.h>
#include <string.h>

/* Both coordinates are one complex number: the matrix is the same for both. */
typedef double complex number;

pc_status pc_convexmap_make(pc_convexmap *map, pc_context *ctx, pc_index count, size_t entries) {
    pc_status status = PC_OK;
    *map = (pc_convexmap){.count = count};
    PC_TRY(pc_new(&map->start, ctx, (size_t)count + 1));
    PC_TRY(pc_new(&map->column, ctx, entries));
    PC_TRY(pc_new(&map->weight, ctx, entries));
done:
    if (status != PC_OK) pc_convexmap_free(map, ctx);
    return status;
}

void pc_convexmap_free(pc_convexmap *map, pc_context *ctx) {
    pc_free(ctx, map->start);
    pc_free(ctx, map->column);
    pc_free(ctx, map->weight);
    *map = (pc_convexmap){0};
}

/* A solution of (1 - W) x = b under way, W the weights, and the factors of an incomplete LU of 1 - W. */
typedef struct solving {
    const pc_convexmap *map;
    double *factor; /* per entry */
    double *pivot;  /* per row, its inverse */
    number *x, *r, *shadow, *p, *v, *y, *z, *t;
} solving;

/* The pattern stays that of the matrix: what falls outside is dropped. `place` is scratch, per row. */
static void factorise(solving *s, size_t *place) {
    const pc_convexmap *m = s->map;
    const size_t none = SIZE_MAX;
    for (pc_index i = 0; i < m->count; i++)
        place[i] = none;
    for (pc_index i = 0; i < m->count; i++) {
        double diagonal = 1;
        for (size_t e = m->start[i]; e < m->start[i + 1]; e++) {
            s->factor[e] = -m->weight[e];
            place[m->column[e]] = e;
        }
        for (size_t e = m->start[i]; e < m->start[i + 1] && m->column[e] < i; e++) {
            const pc_index k = m->column[e];
            s->factor[e] *= s->pivot[k];
            for (size_t f = m->start[k]; f < m->start[k + 1]; f++) {
                const pc_index j = m->column[f];
                if (j == i) diagonal -= s->factor[e] * s->factor[f];
                if (j > k && place[j] != none) s->factor[place[j]] -= s->factor[e] * s->factor[f];
            }
        }
        s->pivot[i] = 1 / diagonal;
        for (size_t e = m->start[i]; e < m->start[i + 1]; e++)
            place[m->column[e]] = none;
    }
}

/* y = (LU)^-1 r */
static void precondition(number *y, const solving *s, const number *r) {
    const pc_convexmap *m = s->map;
    for (pc_index i = 0; i < m->count; i++) {
        y[i] = r[i];
        for (size_t e = m->start[i]; e < m->start[i + 1] && m->column[e] < i; e++)
            y[i] -= s->factor[e] * y[m->column[e]];
    }
    for (pc_index i = m->count; i-- > 0;) {
        for (size_t e = m->start[i + 1]; e-- > m->start[i] && m->column[e] > i;)
            y[i] -= s->factor[e] * y[m->column[e]];
        y[i] *= s->pivot[i];
    }
}

/* y = (1 - W) x */
static void apply(number *y, const solving *s, const number *x) {
    const pc_convexmap *m = s->map;
    for (pc_index i = 0; i < m->count; i++) {
        y[i] = x[i];
        for (size_t e = m->start[i]; e < m->start[i + 1]; e++)
            y[i] -= m->weight[e] * x[m->column[e]];
    }
}

static number dot(const number *a, const number *b, pc_index n) {
    number sum = 0;
    for (pc_index i = 0; i < n; i++)
        sum += conj(a[i]) * b[i];
    return sum;
}

static double largest(const number *r, pc_index n) {
    double square = 0;
    for (pc_index i = 0; i < n; i++)
        square = fmax(square, creal(r[i]) * creal(r[i]) + cimag(r[i]) * cimag(r[i]));
    return sqrt(square);
}

/* From s->x on, whose residual is s->r; stops where the recurrence says that it is done or cannot go on. */
static pc_status iterate(solving *s, pc_context *ctx, double tolerance) {
    enum { MOST_STEPS = 400 };
    const pc_index n = s->map->count;
    number before = 1, alpha = 1, omega = 1;
    memcpy(s->shadow, s->r, n * sizeof *s->r);
    memset(s->p, 0, n * sizeof *s->p);
    memset(s->v, 0, n * sizeof *s->v);
    for (int step = 0; step < MOST_STEPS; step++) {
        const pc_status status = pc_check_interrupt(ctx);
        if (status != PC_OK) return status;
        const number now = dot(s->shadow, s->r, n), beta = now / before * (alpha / omega);
        for (pc_index i = 0; i < n; i++)
            s->p[i] = s->r[i] + beta * (s->p[i] - omega * s->v[i]);
        precondition(s->y, s, s->p);
        apply(s->v, s, s->y);
        alpha = now / dot(s->shadow, s->v, n);
        if (!isfinite(cabs(alpha))) return PC_OK;
        for (pc_index i = 0; i < n; i++) {
            s->x[i] += alpha * s->y[i];
            s->r[i] -= alpha * s->v[i];
        }
        if (largest(s->r, n) <= tolerance) return PC_OK;
        precondition(s->z, s, s->r);
        apply(s->t, s, s->z);
        omega = dot(s->t, s->r, n) / dot(s->t, s->t, n);
        if (!isfinite(cabs(omega))) return PC_OK;
        for (pc_index i = 0; i < n; i++) {
            s->x[i] += omega * s->z[i];
            s->r[i] -= omega * s->t[i];
        }
        if (largest(s->r, n) <= tolerance) return PC_OK;
        before = now;
    }
    return PC_OK;
}

static pc_status make_room(solving *s, pc_context *ctx) {
    pc_status status = PC_OK;
    number **vector[] = {&s->x, &s->r, &s->shadow, &s->p, &s->v, &s->y, &s->z, &s->t};
    for (size_t k = 0; k < sizeof vector / sizeof vector[0]; k++)
        PC_TRY(pc_new(vector[k], ctx, s->map->count));
    PC_TRY(pc_new(&s->factor, ctx, s->map->start[s->map->count]));
    PC_TRY(pc_new(&s->pivot, ctx, s->map->count));
done:
    return status;
}

static void drop(solving *s, pc_context *ctx) {
    number *vector[] = {s->x, s->r, s->shadow, s->p, s->v, s->y, s->z, s->t};
    for (size_t k = 0; k < sizeof vector / sizeof vector[0]; k++)
        pc_free(ctx, vector[k]);
    pc_free(ctx, s->factor);
    pc_free(ctx, s->pivot);
}

pc_status pc_convexmap_solve(double *x, pc_context *ctx, const pc_convexmap *map, double tolerance) {
    enum { STARTS = 10 };
    pc_status status = PC_OK;
    const pc_index n = map->count;
    solving s = {.map = map};
    size_t *place = NULL;
    double least = INFINITY;
    PC_TRY(make_room(&s, ctx));
    PC_TRY(pc_new(&place, ctx, n));
    factorise(&s, place);
    for (pc_index i = 0; i < n; i++)
        s.x[i] = x[2 * (size_t)i] + I * x[2 * (size_t)i + 1];
    for (int start = 0; start < STARTS && least > tolerance; start++) {
        apply(s.r, &s, s.x);
        for (pc_index i = 0; i < n; i++) /* fixed points have no row: nothing is missing there */
            s.r[i] = map->start[i] < map->start[i + 1] ? -s.r[i] : 0;
        const double residual = largest(s.r, n);
        if (!(residual < least)) break;
        least = residual;
        for (pc_index i = 0; i < n; i++)
            x[2 * (size_t)i] = creal(s.x[i]), x[2 * (size_t)i + 1] = cimag(s.x[i]);
        if (least > tolerance) PC_TRY(iterate(&s, ctx, 0.5 * tolerance));
    }
    if (!(least <= tolerance))
        PC_TRY(
            pc_fail(ctx, PC_E_NOCONV, "points are up to %.3g from their means, not %.3g", least, tolerance));
done:
    drop(&s, ctx);
    pc_free(ctx, place);
    return status;
}
