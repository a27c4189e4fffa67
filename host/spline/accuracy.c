#include "accuracy.h"
#include "memory.h"

enum { MOST_PER_SIDE = 24 };

/* The nearest point is on an edge or vertex of the scan's border. */
static bool is_on_border(const pc_target *target, const pc_bvh_hit *hit) {
    for (pc_index k = 0; k < 3; k++) {
        pc_index h = 3 * hit->face + k;
        if (target->adjacency->twin[h] == PC_NONE && hit->weight[(k + 2) % 3] <= 0) return true;
        if (hit->weight[k] >= 1 && target->adjacency->vertex_boundary[target->mesh->triangle[h]]) return true;
    }
    return false;
}

/* Samples on a grid, at the corners of its squares too; the residuals' changes from one to the next. */
static pc_face_error measure_face(const pc_tspline *spline, const pc_target *target, pc_index f, int n) {
    pc_face_error m = {0};
    pc_vec3 residual[MOST_PER_SIDE * MOST_PER_SIDE];
    const double *size = spline->mesh.face[f].size;
    pc_index hint = PC_NONE;
    for (int i = 0; i < n * n; i++) {
        double u = (double)(i % n) / (n - 1), v = (double)(i / n) / (n - 1); /* NOLINT */
        pc_vec3 p = pc_tspline_point(spline, pc_tspline_place(spline, f, u * size[0], v * size[1]));
        pc_bvh_hit hit = pc_bvh_closest(&target->tree, p, hint);
        hint = hit.face;
        residual[i] = pc_sub(p, hit.point);
        if (hit.face == PC_NONE || is_on_border(target, &hit)) {
            residual[i] = (pc_vec3){0, 0, 0};
            m.beyond++;
            continue;
        }
        m.surface_max = fmax(m.surface_max, hit.distance);
        m.surface_sum += hit.distance;
    }
    for (int i = 0; i < n * n; i++) {
        pc_vec3 r = residual[i];
        if (i % n + 1 < n) m.change[0] += pow(pc_distance(residual[i + 1], r), 2);
        if (i / n + 1 < n) m.change[1] += pow(pc_distance(residual[i + n], r), 2);
    }
    return m;
}

static bool has_changed(const pc_tspline *spline, const uint8_t *changed, pc_index f) {
    const pc_basis *basis = &spline->basis;
    for (pc_index e = basis->face_start[f]; changed && e < basis->face_start[f + 1]; e++)
        if (changed[e]) return true;
    return !changed;
}

static void measure_surface(pc_accuracy *accuracy, pc_face_error *error, const pc_tspline *spline,
                            const pc_target *target, const pc_accuracy_options *options) {
    const int n = options->per_side < 2               ? 2
                  : options->per_side > MOST_PER_SIDE ? MOST_PER_SIDE
                                                      : options->per_side;
    const pc_index faces = spline->mesh.face_count;
    size_t samples = 0;
#pragma omp parallel for schedule(dynamic, 16)
    for (pc_index f = 0; f < faces; f++)
        if (!spline->mesh.face[f].ghost && has_changed(spline, options->changed, f))
            error[f] = measure_face(spline, target, f, n);
    for (pc_index f = 0; f < faces; f++) {
        if (spline->mesh.face[f].ghost) continue;
        samples += (size_t)n * (size_t)n - error[f].beyond;
        error[f].max = error[f].surface_max;
        accuracy->surface_max = fmax(accuracy->surface_max, error[f].surface_max);
        accuracy->surface_mean += error[f].surface_sum;
        accuracy->beyond += error[f].beyond;
    }
    if (samples) accuracy->surface_mean /= (double)samples;
    accuracy->samples += samples;
}

static pc_status measure_scan(pc_accuracy *accuracy, pc_face_error *error, pc_track *track, pc_context *ctx,
                              const pc_tspline *spline, const pc_target *target,
                              const pc_accuracy_options *options) {
    const pc_track_options tracking = {options->enough, options->changed};
    size_t used = 0;
    pc_status status = pc_track_update(track, ctx, spline, &tracking);
    for (pc_index v = 0; status == PC_OK && v < track->count; v++) {
        const double distance = track->at[v].distance;
        if (target->adjacency->vertex_half[v] == PC_NONE || track->at[v].place.element == PC_NONE) continue;
        used++;
        accuracy->scan_mean += distance;
        accuracy->scan_max = fmax(accuracy->scan_max, distance);
        error[track->face[v]].max = fmax(error[track->face[v]].max, distance);
    }
    if (used) accuracy->scan_mean /= (double)used;
    accuracy->samples += used;
    return status;
}

pc_status pc_accuracy_update(pc_accuracy *accuracy, pc_face_error *error, pc_track *track, pc_context *ctx,
                             const pc_tspline *spline, const pc_target *target,
                             const pc_accuracy_options *options) {
    pc_status status = PC_OK;
    *accuracy = (pc_accuracy){0};
    measure_surface(accuracy, error, spline, target, options);
    PC_TRY(measure_scan(accuracy, error, track, ctx, spline, target, options));
    accuracy->max = fmax(accuracy->scan_max, accuracy->surface_max);
done:
    return status;
}

pc_status pc_accuracy_measure(pc_accuracy *accuracy, pc_face_error *error, pc_context *ctx,
                              const pc_tspline *spline, const pc_target *target, int per_side) {
    pc_status status = PC_OK;
    const pc_accuracy_options options = {per_side, 0, NULL};
    pc_track track = {0};
    pc_face_error *own = NULL;
    PC_TRY(pc_target_track(&track, ctx, target));
    if (!error) PC_TRY(pc_new(&own, ctx, spline->mesh.face_count));
    PC_TRY(pc_accuracy_update(accuracy, error ? error : own, &track, ctx, spline, target, &options));
done:
    pc_track_free(&track, ctx);
    pc_free(ctx, own);
    return status;
}
