#include "exactfit.h"
#include "cubic.h"
#include "memory.h"
#include <string.h>

static pc_vec3 nearest_on_sphere(pc_vec3 p) {
    return pc_unit(p);
}

static bool is_far_from_corners(pc_vec3 p) {
    double along = (fabs(p.x) + fabs(p.y) + fabs(p.z)) / sqrt(3) / pc_norm(p); /* cosine to the nearest */
    return along < cos(20 * PC_PI / 180);
}

static pc_vec3 nearest_on_torus(pc_vec3 p) {
    pc_vec3 ring = pc_scale(2, pc_unit((pc_vec3){p.x, p.y, 0}));
    return pc_add(ring, pc_unit(pc_sub(p, ring)));
}

const pc_exact_shape pc_exact_sphere = {"sphere", nearest_on_sphere, is_far_from_corners};
const pc_exact_shape pc_exact_torus = {"torus", nearest_on_torus, NULL};

enum { GRID = 9 };

static pc_vec3 offset_at(const pc_tspline *spline, const pc_exact_shape *shape, pc_index e, int i,
                         pc_surface_point *at) {
    const pc_element *element = spline->basis.element + e;
    double u = (double)(i % GRID) / (GRID - 1), v = (double)(i / GRID) / (GRID - 1); /* NOLINT */
    *at = pc_tspline_evaluate(
        spline, (pc_surface_place){e, element->low[0] + u * (element->high[0] - element->low[0]),
                                   element->low[1] + v * (element->high[1] - element->low[1])});
    return pc_sub(at->p, shape->nearest(at->p));
}

void pc_exact_measure(pc_exact_error *error, double *face_max, double *change, const pc_tspline *spline,
                      const pc_exact_shape *shape) {
    double sum = 0, area = 0;
    *error = (pc_exact_error){0};
    if (face_max) memset(face_max, 0, spline->mesh.face_count * sizeof *face_max);
    if (change) memset(change, 0, 2 * (size_t)spline->mesh.face_count * sizeof *change);
    for (pc_index e = 0; e < spline->basis.element_count; e++) {
        const pc_element *element = spline->basis.element + e;
        size_t f = element->face;
        double size = (element->high[0] - element->low[0]) * (element->high[1] - element->low[1]);
        pc_vec3 offset[GRID * GRID];
        for (int i = 0; i < GRID * GRID; i++) {
            pc_surface_point at;
            offset[i] = offset_at(spline, shape, e, i, &at);
            double d = pc_norm(offset[i]), part = size * pc_norm(pc_cross(at.s, at.t));
            error->max = fmax(error->max, d);
            if (!shape->is_away || shape->is_away(at.p)) error->away_max = fmax(error->away_max, d);
            if (face_max) face_max[f] = fmax(face_max[f], d);
            sum += part * d * d, area += part;
            if (change && i % GRID) change[2 * f] += pow(pc_distance(offset[i], offset[i - 1]), 2);
            if (change && i >= GRID) change[2 * f + 1] += pow(pc_distance(offset[i], offset[i - GRID]), 2);
        }
    }
    error->rms = sqrt(sum / area);
}

/* The normal equations, element by element: a small dense matrix each. */
typedef struct fitting {
    pc_tspline *spline;
    const pc_exact_shape *shape;
    size_t *start; /* per element: its matrix */
    double *matrix, *diagonal;
    double *r, *z, *p, *q; /* of conjugate gradients, 3 per vertex */
} fitting;

enum { GAUSS = 5 };
static const double gauss_at[GAUSS] = {0.04691007703066800, 0.23076534494715845, 0.5, 0.76923465505284155,
                                       0.95308992296933200};
static const double gauss_weight[GAUSS] = {0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                           0.23931433524968324, 0.11846344252809454};

/* Point i of an element: the 16 products of Bernstein polynomials, and its weight in a face. */
static double gauss_point(double b[16], pc_surface_place *place, const pc_tspline *spline, pc_index e,
                          int i) {
    const pc_element *element = spline->basis.element + e;
    const double *size = spline->mesh.face[element->face].size;
    double u = gauss_at[i % GAUSS], v = gauss_at[i / GAUSS], bu[4], bv[4], first[4], second[4];
    double width = element->high[0] - element->low[0], height = element->high[1] - element->low[1];
    pc_bernstein(bu, first, second, u);
    pc_bernstein(bv, first, second, v);
    for (int k = 0; k < 16; k++)
        b[k] = bu[k % 4] * bv[k / 4];
    *place = (pc_surface_place){e, element->low[0] + u * width, element->low[1] + v * height};
    return gauss_weight[i % GAUSS] * gauss_weight[i / GAUSS] * width / size[0] * height / size[1];
}

/* The functions of the element at that point. */
static void function_values(double *value, const pc_basis *basis, pc_index e, const double b[16]) {
    for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
        double c[16], sum = 0;
        pc_basis_coefficients(c, basis, e, k);
        for (int j = 0; j < 16; j++)
            sum += c[j] * b[j];
        value[k - basis->start[e]] = sum;
    }
}

static pc_status make_matrices(fitting *f, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_basis *basis = &f->spline->basis;
    size_t most = 0, rows = basis->vertex_count;
    double *value = NULL;
    PC_TRY(pc_new(&f->start, ctx, (size_t)basis->element_count + 1));
    for (pc_index e = 0; e < basis->element_count; e++) {
        size_t n = basis->start[e + 1] - basis->start[e];
        f->start[e + 1] = f->start[e] + n * n;
        most = n > most ? n : most;
    }
    PC_TRY(pc_new(&f->matrix, ctx, f->start[basis->element_count]));
    PC_TRY(pc_new(&f->diagonal, ctx, rows));
    PC_TRY(pc_new(&value, ctx, most));
    for (pc_index e = 0; e < basis->element_count; e++) {
        size_t n = basis->start[e + 1] - basis->start[e];
        double *a = f->matrix + f->start[e], b[16];
        pc_surface_place place;
        for (int i = 0; i < GAUSS * GAUSS; i++) {
            double weight = gauss_point(b, &place, f->spline, e, i);
            function_values(value, basis, e, b);
            for (size_t k = 0; k < n * n; k++)
                a[k] += weight * value[k / n] * value[k % n];
        }
        for (size_t k = 0; k < n; k++)
            f->diagonal[basis->point[basis->start[e] + k]] += a[k * n + k];
    }
    PC_TRY(pc_new(&f->r, ctx, 3 * rows));
    PC_TRY(pc_new(&f->z, ctx, 3 * rows));
    PC_TRY(pc_new(&f->p, ctx, 3 * rows));
    PC_TRY(pc_new(&f->q, ctx, 3 * rows));
done:
    pc_free(ctx, value);
    return status;
}

static void free_fitting(fitting *f, pc_context *ctx) {
    pc_free(ctx, f->start);
    pc_free(ctx, f->matrix);
    pc_free(ctx, f->diagonal);
    pc_free(ctx, f->r);
    pc_free(ctx, f->z);
    pc_free(ctx, f->p);
    pc_free(ctx, f->q);
}

/* What pulls at the control points: the offsets to the nearest points of the shape. */
static pc_status pull(fitting *f, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_basis *basis = &f->spline->basis;
    double *value = NULL;
    PC_TRY(pc_new(&value, ctx, basis->vertex_count));
    memset(f->r, 0, 3 * sizeof(double) * basis->vertex_count);
    for (pc_index e = 0; e < basis->element_count; e++)
        for (int i = 0; i < GAUSS * GAUSS; i++) {
            pc_surface_place place;
            double b[16], weight = gauss_point(b, &place, f->spline, e, i);
            pc_vec3 p = pc_tspline_point(f->spline, place);
            pc_vec3 offset = pc_sub(f->shape->nearest(p), p);
            function_values(value, basis, e, b);
            for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
                size_t v = basis->point[k];
                double share = weight * value[k - basis->start[e]];
                pc_vec3_put(f->r, v, pc_madd(pc_vec3_at(f->r, v), share, offset));
            }
        }
done:
    pc_free(ctx, value);
    return status;
}

static void multiply(double *y, const fitting *f, const double *x) {
    const pc_basis *basis = &f->spline->basis;
    memset(y, 0, 3 * sizeof(double) * basis->vertex_count);
    for (pc_index e = 0; e < basis->element_count; e++) {
        const pc_index *point = basis->point + basis->start[e];
        size_t n = basis->start[e + 1] - basis->start[e];
        const double *a = f->matrix + f->start[e];
        for (size_t k = 0; k < n; k++) {
            pc_vec3 sum = {0, 0, 0};
            for (size_t l = 0; l < n; l++)
                sum = pc_madd(sum, a[k * n + l], pc_vec3_at(x, point[l]));
            pc_vec3_put(y, point[k], pc_add(pc_vec3_at(y, point[k]), sum));
        }
    }
}

static double dot(const double *a, const double *b, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += a[i] * b[i];
    return sum;
}

/* Conjugate gradients with the diagonal, all coordinates at once; moves the control points. */
static pc_status move(fitting *f, pc_context *ctx) {
    enum { MOST = 3000 };
    size_t count = 3 * (size_t)f->spline->mesh.vertex_count;
    double before = 0, first = 0;
    for (int i = 0; i < MOST; i++) {
        for (size_t k = 0; k < count; k++) /* corners of ghosts have no function */
            f->z[k] = f->diagonal[k / 3] > 0 ? f->r[k] / f->diagonal[k / 3] : 0;
        double now = dot(f->r, f->z, count);
        if (i == 0) first = now;
        if (now <= 1e-20 * first) return PC_OK;
        for (size_t k = 0; k < count; k++)
            f->p[k] = f->z[k] + (i ? now / before * f->p[k] : 0);
        multiply(f->q, f, f->p);
        double step = now / dot(f->p, f->q, count);
        for (size_t k = 0; k < count; k++) {
            f->spline->position[k] += step * f->p[k];
            f->r[k] -= step * f->q[k];
        }
        before = now;
    }
    return pc_fail(ctx, PC_E_NOCONV, "conjugate gradients: %d iterations were not enough", MOST);
}

pc_status pc_exact_fit(pc_tspline *spline, pc_context *ctx, const pc_exact_shape *shape) {
    enum { MOST = 30 };
    pc_status status = PC_OK;
    fitting f = {.spline = spline, .shape = shape};
    double before = INFINITY;
    PC_TRY(make_matrices(&f, ctx));
    for (int round = 0; round < MOST; round++) {
        pc_exact_error error;
        PC_TRY(pull(&f, ctx));
        PC_TRY(move(&f, ctx));
        pc_tspline_update(spline);
        pc_exact_measure(&error, NULL, NULL, spline, shape);
        if (fabs(error.rms - before) < 0.01 * error.rms) break;
        before = error.rms;
    }
done:
    free_fitting(&f, ctx);
    return status;
}
