#include "accuracy.h"
#include "memory.h"
#include <string.h>

enum { MOST_PER_SIDE = 24 };

/* How far p is from the scan; -1 past the scan's border. */
static double distance_at(const pc_target *target, pc_vec3 p, pc_bvh_hit *hit) {
    *hit = pc_bvh_closest(&target->tree, p, hit->face);
    return hit->face == PC_NONE || pc_target_on_border(target, hit->face, hit->weight) ? -1 : hit->distance;
}

/* A place (s, t) of the face at hand that is as far as that. */
static void note(pc_face_found *m, double distance, double s, double t, pc_index triangle) {
    if (!(distance > m->max)) return;
    m->max = distance;
    m->at[0] = s, m->at[1] = t;
    m->triangle = triangle;
}

/* What is between a place on the surface and the scan; zero past the scan's border. */
static pc_vec3 take(pc_face_found *m, const pc_tspline *spline, const pc_target *target,
                    pc_surface_place place, pc_bvh_hit *hit) {
    const pc_vec3 p = pc_tspline_point(spline, place);
    const double distance = distance_at(target, p, hit);
    m->samples++;
    if (distance < 0) {
        m->beyond++;
        return (pc_vec3){0, 0, 0};
    }
    note(m, distance, place.s, place.t, hit->face);
    m->sum += distance;
    return pc_sub(p, hit->point);
}

/* Uphill from a sample at (s, t) of face f, whose neighbours on the grid are no farther off: in steps of half
 * the grid's, then of a quarter and so on. The sums keep to the grid. */
static void climb(pc_face_found *m, const pc_tspline *spline, const pc_target *target, pc_index f, double s,
                  double t, double distance, const double spacing[2]) {
    enum { HALVINGS = 3, MOST_STEPS = 4 };
    const double *size = spline->mesh.face[f].size;
    pc_bvh_hit hit = {.face = PC_NONE};
    double step[2] = {spacing[0], spacing[1]};
    pc_index triangle = PC_NONE; /* below the summit, once it is higher than the sample */
    for (int k = 0; k < HALVINGS; k++) {
        step[0] /= 2, step[1] /= 2;
        for (int n = 0; n < MOST_STEPS; n++) {
            double best = distance, at[2] = {s, t};
            pc_index below = triangle;
            for (int way = 0; way < 8; way++) {
                const int i = way < 4 ? way : way + 1; /* of the 3 x 3 around, but the middle */
                const double u = fmin(fmax(s + (i % 3 - 1) * step[0], 0), size[0]); /* NOLINT */
                const double v = fmin(fmax(t + (i / 3 - 1) * step[1], 0), size[1]); /* NOLINT */
                const double d =
                    distance_at(target, pc_tspline_point(spline, pc_tspline_place(spline, f, u, v)), &hit);
                if (d > best) best = d, at[0] = u, at[1] = v, below = hit.face;
            }
            if (!(best > distance)) break;
            distance = best, s = at[0], t = at[1], triangle = below;
        }
    }
    if (triangle != PC_NONE) note(m, distance, s, t, triangle);
}

/* Whether no neighbour of sample i on the grid is farther from the scan. */
static bool is_summit(const double *distance, int i, int n) {
    for (int r = -1; r <= 1; r++)
        for (int c = -1; c <= 1; c++) {
            const int column = i % n + c, row = i / n + r;
            if (column < 0 || column >= n || row < 0 || row >= n) continue;
            if (distance[row * n + column] > distance[i]) return false;
        }
    return true;
}

/* Elements beside extraordinary vertices are smaller than the grid's squares, and bend more. */
static void measure_irregular(pc_face_found *m, const pc_tspline *spline, const pc_target *target, pc_index f,
                              pc_bvh_hit *hit, double near) {
    enum { SIDE = 3 };
    const pc_basis *basis = &spline->basis;
    for (pc_index e = basis->face_start[f]; e < basis->face_start[f + 1]; e++) {
        const pc_element *element = basis->element + e;
        const double spacing[2] = {(element->high[0] - element->low[0]) / SIDE,
                                   (element->high[1] - element->low[1]) / SIDE};
        double distance[SIDE * SIDE];
        if (!element->irregular) continue;
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double u = (i % SIDE + 0.5) / SIDE, v = ((double)(i / SIDE) + 0.5) / SIDE; /* NOLINT */
            distance[i] = pc_norm(take(m, spline, target, pc_element_place(basis, e, u, v), hit));
        }
        for (int i = 0; i < SIDE * SIDE; i++)
            if (distance[i] > near && is_summit(distance, i, SIDE))
                climb(m, spline, target, f, element->low[0] + (i % SIDE + 0.5) * spacing[0],
                      element->low[1] + ((double)(i / SIDE) + 0.5) * spacing[1], distance[i], /* NOLINT */
                      spacing);
    }
}

/* Samples on a grid, at the corners of its squares too, and uphill from them where they find more than
 * `near`; the residuals' changes from one to the next. */
static pc_face_found measure_face(const pc_tspline *spline, const pc_target *target, pc_index f, int n,
                                  double near) {
    pc_face_found m = {.known = true};
    pc_vec3 residual[MOST_PER_SIDE * MOST_PER_SIDE];
    double distance[MOST_PER_SIDE * MOST_PER_SIDE];
    const double *size = spline->mesh.face[f].size, spacing[2] = {size[0] / (n - 1), size[1] / (n - 1)};
    pc_bvh_hit hit = {.face = PC_NONE};
    for (int i = 0; i < n * n; i++) {
        double s = (i % n) * spacing[0], t = (i / n) * spacing[1]; /* NOLINT */
        residual[i] = take(&m, spline, target, pc_tspline_place(spline, f, s, t), &hit);
        distance[i] = pc_norm(residual[i]);
    }
    for (int i = 0; i < n * n; i++) {
        const double s = (i % n) * spacing[0], t = (i / n) * spacing[1]; /* NOLINT */
        if (distance[i] > near && is_summit(distance, i, n))
            climb(&m, spline, target, f, s, t, distance[i], spacing);
    }
    measure_irregular(&m, spline, target, f, &hit, near);
    for (int i = 0; i < n * n; i++) {
        if (i % n + 1 < n) m.change[0] += pow(pc_distance(residual[i + 1], residual[i]), 2);
        if (i / n + 1 < n) m.change[1] += pow(pc_distance(residual[i + n], residual[i]), 2);
    }
    return m;
}

static void measure_faces(pc_gauge *gauge, const pc_tspline *spline, const pc_target *target, int per_side,
                          double near, const uint8_t *wanted) {
#pragma omp parallel for schedule(dynamic, 16)
    for (pc_index f = 0; f < gauge->face_count; f++)
        if (!gauge->face[f].known && !spline->mesh.face[f].ghost && (!wanted || wanted[f]))
            gauge->face[f] = measure_face(spline, target, f, per_side, near);
}

static double farthest(const pc_gauge *gauge) {
    double far = 0;
    for (pc_index f = 0; f < gauge->face_count; f++)
        if (gauge->face[f].known) far = fmax(far, gauge->face[f].max);
    return far;
}

/* `scan_max` is known already. */
static pc_status measure_surface(pc_accuracy *accuracy, pc_face_error *error, pc_context *ctx,
                                 const pc_tspline *spline, const pc_target *target, int per_side,
                                 const pc_accuracy_options *options) {
    pc_status status = PC_OK;
    pc_gauge own = {0}, *gauge = options->gauge ? options->gauge : &own;
    const pc_index faces = spline->mesh.face_count;
    size_t samples = 0;
    PC_TRY(pc_gauge_update(gauge, ctx, spline));
    measure_faces(gauge, spline, target, per_side, options->near, options->suspect);
    if (options->suspect && fmax(accuracy->scan_max, farthest(gauge)) <= options->enough)
        measure_faces(gauge, spline, target, per_side, options->near, NULL);
    for (pc_index f = 0; f < faces; f++) {
        const pc_face_found *found = gauge->face + f;
        if (spline->mesh.face[f].ghost || !found->known) continue;
        samples += found->samples - found->beyond;
        accuracy->surface_max = fmax(accuracy->surface_max, found->max);
        accuracy->surface_mean += found->sum;
        accuracy->beyond += found->beyond;
        if (!error) continue;
        error[f].max = fmax(error[f].max, found->max);
        memcpy(error[f].change, found->change, sizeof error[f].change);
    }
    if (samples) accuracy->surface_mean /= (double)samples;
    accuracy->samples += samples;
done:
    pc_gauge_free(&own, ctx);
    return status;
}

/* One vertex of the scan. */
typedef struct reached {
    double distance; /* INFINITY: to no face */
    pc_index face;   /* that it counts for */
} reached;

/* How far the vertices are from their places. */
static void ask_places(reached *vertex, const pc_tspline *spline, const pc_target *target,
                       const pc_correspondence *places) {
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < target->mesh->vertex_count; v++) {
        vertex[v] = (reached){INFINITY, PC_NONE};
        if (!places || places->spot[v].face == PC_NONE) continue;
        const pc_vec3 p = pc_tspline_point(spline, pc_correspondence_place(places, spline, v));
        vertex[v] = (reached){pc_distance(p, pc_vec3_at(target->mesh->position, v)), places->spot[v].face};
    }
}

/* The nearest points of the whole surface, for `count` vertices that are listed. */
static pc_status ask_surface(reached *vertex, pc_context *ctx, const pc_tspline *spline,
                             const pc_target *target, const pc_index *list, pc_index count) {
    pc_status status = PC_OK;
    pc_facets facets = {0};
    pc_nearest *nearest = NULL;
    double *point = NULL, reach = 0;
    PC_TRY(pc_new(&point, ctx, 3 * (size_t)count));
    PC_TRY(pc_new(&nearest, ctx, count));
    for (pc_index i = 0; i < count; i++) {
        pc_vec3_put(point, i, pc_vec3_at(target->mesh->position, list[i]));
        reach = fmax(reach, vertex[list[i]].distance);
    }
    PC_TRY(pc_facets_make_near(&facets, ctx, spline, 4, point, count, reach));
    pc_nearest_all(nearest, spline, &facets, point, count);
    for (pc_index i = 0; i < count; i++) {
        reached *to = vertex + list[i];
        if (nearest[i].place.element == PC_NONE) continue;
        to->distance = fmin(to->distance, nearest[i].distance);
        if (to->face == PC_NONE) to->face = spline->basis.element[nearest[i].place.element].face;
    }
done:
    pc_facets_free(&facets, ctx);
    pc_free(ctx, nearest);
    pc_free(ctx, point);
    return status;
}

static pc_status measure_scan(pc_accuracy *accuracy, pc_face_error *error, pc_context *ctx,
                              const pc_tspline *spline, const pc_target *target,
                              const pc_accuracy_options *options) {
    pc_status status = PC_OK;
    const pc_index count = target->mesh->vertex_count;
    reached *vertex = NULL;
    pc_index *far = NULL, far_count = 0;
    size_t used = 0;
    PC_TRY(pc_new(&vertex, ctx, count));
    PC_TRY(pc_new(&far, ctx, count));
    ask_places(vertex, spline, target, options->places);
    for (pc_index v = 0; v < count; v++)
        if (target->adjacency->vertex_half[v] != PC_NONE &&
            (vertex[v].face == PC_NONE || !(vertex[v].distance <= options->near)))
            far[far_count++] = v;
    if (far_count) PC_TRY(ask_surface(vertex, ctx, spline, target, far, far_count));
    for (pc_index v = 0; v < count; v++) {
        if (target->adjacency->vertex_half[v] == PC_NONE || vertex[v].face == PC_NONE) continue;
        used++;
        accuracy->scan_mean += vertex[v].distance;
        accuracy->scan_max = fmax(accuracy->scan_max, vertex[v].distance);
        if (error) error[vertex[v].face].max = fmax(error[vertex[v].face].max, vertex[v].distance);
    }
    if (used) accuracy->scan_mean /= (double)used;
    accuracy->samples += used;
done:
    pc_free(ctx, vertex);
    pc_free(ctx, far);
    return status;
}

pc_status pc_accuracy_measure(pc_accuracy *accuracy, pc_face_error *error, pc_context *ctx,
                              const pc_tspline *spline, const pc_target *target,
                              const pc_accuracy_options *options) {
    pc_status status = PC_OK;
    const int per_side = options->per_side < 2               ? 2
                         : options->per_side > MOST_PER_SIDE ? MOST_PER_SIDE
                                                             : options->per_side;
    *accuracy = (pc_accuracy){0};
    for (pc_index f = 0; error && f < spline->mesh.face_count; f++)
        error[f] = (pc_face_error){0};
    PC_TRY(measure_scan(accuracy, error, ctx, spline, target, options));
    PC_TRY(measure_surface(accuracy, error, ctx, spline, target, per_side, options));
    accuracy->max = fmax(accuracy->scan_max, accuracy->surface_max);
done:
    return status;
}
