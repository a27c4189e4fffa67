#include "errors.h"
#include "deviation.h"
#include "memory.h"

enum { SAMPLES = 250000, MOST_PER_SIDE = 16, SCAN_SAMPLES = 100000, FACETS = 1000000, MOST_TOLERANCES = 6 };

/* The nearest point is on an edge or vertex of the scan's border. */
static bool is_on_border(const pc_target *target, const pc_bvh_hit *hit) {
    for (pc_index k = 0; k < 3; k++) {
        if (target->adjacency->twin[3 * hit->face + k] == PC_NONE && hit->weight[(k + 2) % 3] <= 0)
            return true;
        if (hit->weight[k] >= 1 &&
            target->adjacency->vertex_boundary[target->mesh->triangle[3 * (size_t)hit->face + k]])
            return true;
    }
    return false;
}

typedef struct measuring {
    pc_errors *errors;
    const pc_tspline *spline;
    const pc_target *target;
    double no_data; /* beyond a border and farther than this */
    float *area;    /* per square of each element */
} measuring;

static void measure_element(measuring *m, pc_index e) {
    const pc_element *element = m->spline->basis.element + e;
    const int n = m->errors->per_side, row = n + 1;
    float *distance = m->errors->distance + (size_t)e * (size_t)(row * row);
    float *area = m->area + (size_t)e * (size_t)(n * n);
    double size[2] = {element->high[0] - element->low[0], element->high[1] - element->low[1]};
    pc_vec3 line[2][MOST_PER_SIDE + 1];
    pc_index hint = PC_NONE;
    for (int k = 0; k < row * row; k++) {
        int i = k % row, j = k / row;
        pc_surface_place place = {e, element->low[0] + size[0] * i / n, element->low[1] + size[1] * j / n};
        pc_vec3 p = pc_tspline_point(m->spline, place);
        pc_bvh_hit hit = pc_bvh_closest(&m->target->tree, p, hint);
        hint = hit.face;
        bool known = hit.face != PC_NONE && !(hit.distance > m->no_data && is_on_border(m->target, &hit));
        distance[k] = known ? (float)hit.distance : NAN;
        line[j & 1][i] = p;
        if (i == 0 || j == 0) continue;
        pc_vec3 d1 = pc_sub(p, line[!(j & 1)][i - 1]), d2 = pc_sub(line[j & 1][i - 1], line[!(j & 1)][i]);
        area[(j - 1) * n + i - 1] = (float)(0.5 * pc_norm(pc_cross(d1, d2)));
    }
}

static size_t bin_of(const pc_errors *errors, double distance) {
    double x = PC_ERRORS_BINS * distance / errors->high;
    return x < PC_ERRORS_BINS - 1 ? x > 0 ? (size_t)x : 0 : PC_ERRORS_BINS - 1;
}

static void normalise(double *bins, double sum) {
    for (int k = 0; k < PC_ERRORS_BINS && sum > 0; k++)
        bins[k] /= sum;
}

/* Every square shares its area among its four corners. */
static pc_status count_surface(measuring *m, pc_context *ctx, double tolerance) {
    static const double fraction[PC_ERRORS_QUANTILES] = {0.5, 0.95, 0.99};
    pc_errors *errors = m->errors;
    pc_status status = PC_OK;
    const int n = errors->per_side, row = n + 1;
    const size_t squares = (size_t)errors->element_count * (size_t)(n * n);
    double *distance = NULL, *area = NULL, sum = 0, within = 0;
    size_t count = 0;
    PC_TRY(pc_new(&distance, ctx, 4 * squares));
    PC_TRY(pc_new(&area, ctx, 4 * squares));
    for (size_t i = 0; i < 4 * squares; i++) {
        const int k = (int)(i / 4 % (size_t)(n * n)), c = (int)(i % 4);
        const size_t at = i / 4 / (size_t)(n * n) * (size_t)(row * row);
        float d = errors->distance[at + (size_t)((k / n + c / 2) * row + k % n + c % 2)];
        if (isnan(d)) continue;
        distance[count] = (double)d, area[count] = (double)m->area[i / 4];
        errors->surface[bin_of(errors, distance[count])] += area[count];
        sum += area[count];
        within += tolerance > 0 && distance[count] > tolerance ? 0 : area[count];
        count++;
    }
    errors->within = sum > 0 ? within / sum : 1;
    normalise(errors->surface, sum);
    for (int q = 0; q < PC_ERRORS_QUANTILES; q++)
        errors->quantile[q] = pc_weighted_quantile(distance, area, count, fraction[q]);
done:
    pc_free(ctx, distance);
    pc_free(ctx, area);
    return status;
}

static pc_status ask_scan(pc_nearest **nearest, size_t *count, pc_context *ctx, const pc_tspline *spline,
                          const pc_target *target) {
    pc_status status = PC_OK;
    const pc_mesh *mesh = target->mesh;
    pc_facets facets = {0};
    double *point = NULL;
    size_t step = mesh->vertex_count / SCAN_SAMPLES + 1;
    *count = 0;
    PC_TRY(pc_new(&point, ctx, 3 * (mesh->vertex_count / step + 1)));
    for (size_t v = 0; v < mesh->vertex_count; v += step)
        if (target->adjacency->vertex_half[v] != PC_NONE)
            pc_vec3_put(point, (*count)++, pc_vec3_at(mesh->position, v));
    PC_TRY(pc_new(nearest, ctx, *count));
    int facets_per_side = (int)sqrt((double)FACETS / (spline->basis.element_count + 1.0));
    facets_per_side = facets_per_side > 3 ? 3 : facets_per_side < 1 ? 1 : facets_per_side;
    PC_TRY(pc_facets_make(&facets, ctx, spline, facets_per_side, false));
    pc_nearest_all(*nearest, spline, &facets, point, *count);
done:
    pc_facets_free(&facets, ctx);
    pc_free(ctx, point);
    return status;
}

static double largest(const pc_errors *errors, const pc_nearest *nearest, size_t count, double least) {
    const size_t row = (size_t)errors->per_side + 1;
    for (size_t i = 0; i < errors->element_count * row * row; i++)
        least = fmax(least, (double)errors->distance[i]); /* which passes over NaN */
    for (size_t i = 0; i < count; i++)
        if (nearest[i].place.element != PC_NONE) least = fmax(least, nearest[i].distance);
    return least;
}

pc_status pc_errors_make(pc_errors *errors, pc_context *ctx, const pc_tspline *spline,
                         const pc_target *target, double tolerance, double reached) {
    pc_status status = PC_OK;
    const pc_index elements = spline->basis.element_count;
    pc_nearest *nearest = NULL;
    double side = sqrt((double)SAMPLES / (elements + 1.0));
    *errors = (pc_errors){.element_count = elements,
                          .per_side = side >= MOST_PER_SIDE ? MOST_PER_SIDE
                                      : side > 2            ? (int)side
                                                            : 2};
    const size_t squares = (size_t)errors->per_side * (size_t)errors->per_side;
    const size_t samples = squares + 2 * (size_t)errors->per_side + 1;
    measuring m = {errors, spline, target, tolerance > 0 ? tolerance : 1e-3 * target->diagonal, NULL};
    PC_TRY(pc_new(&errors->distance, ctx, elements * samples));
    PC_TRY(pc_new(&m.area, ctx, elements * squares));
#pragma omp parallel for schedule(dynamic, 64)
    for (pc_index e = 0; e < elements; e++)
        measure_element(&m, e);
    PC_TRY(ask_scan(&nearest, &errors->scan_count, ctx, spline, target));
    errors->largest = largest(errors, nearest, errors->scan_count, reached);
    errors->high = fmax(errors->largest, tolerance);
    if (tolerance > 0) errors->high = fmin(errors->high, MOST_TOLERANCES * tolerance);
    if (!(errors->high > 0)) errors->high = target->diagonal > 0 ? 1e-3 * target->diagonal : 1;
    PC_TRY(count_surface(&m, ctx, tolerance));
    for (size_t i = 0; i < errors->scan_count; i++)
        errors->scan[bin_of(errors, nearest[i].distance)] += 1;
    normalise(errors->scan, (double)errors->scan_count);
done:
    pc_free(ctx, nearest);
    pc_free(ctx, m.area);
    if (status != PC_OK) pc_errors_free(errors, ctx);
    return status;
}

void pc_errors_free(pc_errors *errors, pc_context *ctx) {
    pc_free(ctx, errors->distance);
    *errors = (pc_errors){0};
}

float pc_errors_at(const pc_errors *errors, pc_index element, double u, double v) {
    const int n = errors->per_side, row = n + 1;
    double x = fmin(fmax(u, 0), 1) * n, y = fmin(fmax(v, 0), 1) * n;
    int i = x < n ? (int)x : n - 1, j = y < n ? (int)y : n - 1;
    const float *d = errors->distance + (size_t)element * (size_t)(row * row) + j * row + i;
    float p = (float)(x - i), q = (float)(y - j);
    return (1 - q) * ((1 - p) * d[0] + p * d[1]) + q * ((1 - p) * d[row] + p * d[row + 1]);
}
