#include "accuracy.h"
#include "memory.h"

enum { MOST_PER_SIDE = 24 };

/* One face of the surface. */
typedef struct measured {
    double max, sum;
    size_t samples, beyond;
} measured;

/* How far p is from the scan; -1 past the scan's border. */
static double distance_at(const pc_target *target, pc_vec3 p, pc_bvh_hit *hit) {
    *hit = pc_bvh_closest(&target->tree, p, hit->face);
    return hit->face == PC_NONE || pc_target_on_border(target, hit->face, hit->weight) ? -1 : hit->distance;
}

/* What is between p and the scan; zero past the scan's border. */
static pc_vec3 take(measured *m, const pc_target *target, pc_vec3 p, pc_bvh_hit *hit) {
    const double distance = distance_at(target, p, hit);
    m->samples++;
    if (distance < 0) {
        m->beyond++;
        return (pc_vec3){0, 0, 0};
    }
    m->max = fmax(m->max, distance);
    m->sum += distance;
    return pc_sub(p, hit->point);
}

/* Elements beside extraordinary vertices are smaller than the grid's squares, and bend more. */
static void measure_irregular(measured *m, const pc_tspline *spline, const pc_target *target, pc_index f,
                              pc_bvh_hit *hit) {
    enum { SIDE = 3 };
    const pc_basis *basis = &spline->basis;
    for (pc_index e = basis->face_start[f]; e < basis->face_start[f + 1]; e++) {
        if (!basis->element[e].irregular) continue;
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double u = (i % SIDE + 0.5) / SIDE, v = ((double)(i / SIDE) + 0.5) / SIDE; /* NOLINT */
            (void)take(m, target, pc_tspline_point(spline, pc_element_place(basis, e, u, v)), hit);
        }
    }
}

/* Uphill from a sample at (s, t) of face f, whose neighbours on the grid are no farther off: in steps of half
 * the grid's, then of a quarter and so on. The sums keep to the grid. */
static void climb(measured *m, const pc_tspline *spline, const pc_target *target, pc_index f, double s,
                  double t, double distance, const double spacing[2]) {
    enum { HALVINGS = 3, MOST_STEPS = 4 };
    const double *size = spline->mesh.face[f].size;
    pc_bvh_hit hit = {.face = PC_NONE};
    double step[2] = {spacing[0], spacing[1]};
    for (int k = 0; k < HALVINGS; k++) {
        step[0] /= 2, step[1] /= 2;
        for (int n = 0; n < MOST_STEPS; n++) {
            double best = distance, at[2] = {s, t};
            for (int way = 0; way < 8; way++) {
                const int i = way < 4 ? way : way + 1; /* of the 3 x 3 around, but the middle */
                const double u = fmin(fmax(s + (i % 3 - 1) * step[0], 0), size[0]); /* NOLINT */
                const double v = fmin(fmax(t + (i / 3 - 1) * step[1], 0), size[1]); /* NOLINT */
                const double d =
                    distance_at(target, pc_tspline_point(spline, pc_tspline_place(spline, f, u, v)), &hit);
                if (d > best) best = d, at[0] = u, at[1] = v;
            }
            if (!(best > distance)) break;
            distance = best, s = at[0], t = at[1];
        }
    }
    m->max = fmax(m->max, distance);
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

/* Samples on a grid, at the corners of its squares too, and uphill from them where they find more than
 * `near`; the residuals' changes from one to the next. */
static measured measure_face(pc_face_error *error, const pc_tspline *spline, const pc_target *target,
                             pc_index f, int n, double near) {
    measured m = {0};
    pc_vec3 residual[MOST_PER_SIDE * MOST_PER_SIDE];
    double distance[MOST_PER_SIDE * MOST_PER_SIDE];
    const double *size = spline->mesh.face[f].size, spacing[2] = {size[0] / (n - 1), size[1] / (n - 1)};
    pc_bvh_hit hit = {.face = PC_NONE};
    for (int i = 0; i < n * n; i++) {
        double s = (i % n) * spacing[0], t = (i / n) * spacing[1]; /* NOLINT */
        residual[i] = take(&m, target, pc_tspline_point(spline, pc_tspline_place(spline, f, s, t)), &hit);
        distance[i] = pc_norm(residual[i]);
    }
    for (int i = 0; i < n * n; i++) {
        const double s = (i % n) * spacing[0], t = (i / n) * spacing[1]; /* NOLINT */
        if (distance[i] > near && is_summit(distance, i, n))
            climb(&m, spline, target, f, s, t, distance[i], spacing);
    }
    measure_irregular(&m, spline, target, f, &hit);
    if (!error) return m;
    error->max = m.max;
    for (int i = 0; i < n * n; i++) {
        pc_vec3 r = residual[i];
        if (i % n + 1 < n) error->change[0] += pow(pc_distance(residual[i + 1], r), 2);
        if (i / n + 1 < n) error->change[1] += pow(pc_distance(residual[i + n], r), 2);
    }
    return m;
}

static pc_status measure_surface(pc_accuracy *accuracy, pc_face_error *error, pc_context *ctx,
                                 const pc_tspline *spline, const pc_target *target, int per_side,
                                 double near) {
    pc_status status = PC_OK;
    measured *found = NULL;
    pc_index faces = spline->mesh.face_count;
    size_t samples = 0;
    PC_TRY(pc_new(&found, ctx, faces));
#pragma omp parallel for schedule(dynamic, 16)
    for (pc_index f = 0; f < faces; f++)
        if (!spline->mesh.face[f].ghost)
            found[f] = measure_face(error ? error + f : NULL, spline, target, f, per_side, near);
    for (pc_index f = 0; f < faces; f++) {
        if (spline->mesh.face[f].ghost) continue;
        samples += found[f].samples - found[f].beyond;
        accuracy->surface_max = fmax(accuracy->surface_max, found[f].max);
        accuracy->surface_mean += found[f].sum;
        accuracy->beyond += found[f].beyond;
    }
    if (samples) accuracy->surface_mean /= (double)samples;
    accuracy->samples += samples;
done:
    pc_free(ctx, found);
    return status;
}

static pc_status measure_scan(pc_accuracy *accuracy, pc_face_error *error, pc_context *ctx,
                              const pc_tspline *spline, const pc_target *target,
                              const pc_correspondence *correspondence) {
    pc_status status = PC_OK;
    const pc_mesh *mesh = target->mesh;
    pc_facets facets = {0};
    pc_nearest *nearest = NULL;
    size_t used = 0;
    PC_TRY(pc_facets_make(&facets, ctx, spline, 4, false));
    PC_TRY(pc_new(&nearest, ctx, mesh->vertex_count));
    pc_nearest_all(nearest, spline, &facets, mesh->position, mesh->vertex_count);
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        if (target->adjacency->vertex_half[v] == PC_NONE || nearest[v].place.element == PC_NONE) continue;
        pc_index f = spline->basis.element[nearest[v].place.element].face;
        if (correspondence && correspondence->spot[v].face != PC_NONE) f = correspondence->spot[v].face;
        used++;
        accuracy->scan_mean += nearest[v].distance;
        accuracy->scan_max = fmax(accuracy->scan_max, nearest[v].distance);
        if (error) error[f].max = fmax(error[f].max, nearest[v].distance);
    }
    if (used) accuracy->scan_mean /= (double)used;
    accuracy->samples += used;
done:
    pc_facets_free(&facets, ctx);
    pc_free(ctx, nearest);
    return status;
}

pc_status pc_accuracy_measure(pc_accuracy *accuracy, pc_face_error *error, pc_context *ctx,
                              const pc_tspline *spline, const pc_target *target,
                              const pc_correspondence *correspondence, int per_side, double near) {
    pc_status status = PC_OK;
    *accuracy = (pc_accuracy){0};
    for (pc_index f = 0; error && f < spline->mesh.face_count; f++)
        error[f] = (pc_face_error){0};
    per_side = per_side < 2 ? 2 : per_side > MOST_PER_SIDE ? MOST_PER_SIDE : per_side;
    PC_TRY(measure_surface(accuracy, error, ctx, spline, target, per_side, near));
    PC_TRY(measure_scan(accuracy, error, ctx, spline, target, correspondence));
    accuracy->max = fmax(accuracy->scan_max, accuracy->surface_max);
done:
    return status;
}
