#include "sizing.h"
#include "bvh.h"
#include "memory.h"
#include "polysurface.h"
#include "thickness.h"

enum { MOST_SWEEPS = 64 };
static const double FOLD_GROWTH = 1.4; /* a folded face says that cells are too large, not by how much */

/* How far the quads may be from vertex v, where they are `distance` from it. */
static double limit_at(pc_index v, const pc_ground *ground, double scale, double distance,
                       const pc_sizing_options *options) {
    const double part = 0.4, least = 0.1; /* of the thickness; of the edges as asked */
    const double length = options->edge_length;
    double limit = length * fmax(options->reach / scale, options->floor);
    if (options->farthest > 0) limit = fmin(limit, options->farthest);
    if (!options->walls || distance > limit || distance < least * length) return limit;
    const double thickness = pc_thickness_at(ground, v, limit / part);
    return fmin(limit, fmax(part * thickness, least * length));
}

/* Of all scan vertices. */
static void measure_distances(pc_sizing_stats *stats, const pc_bvh_hit *hits, pc_index count) {
    double sum = 0;
    for (pc_index v = 0; v < count; v++) {
        const double distance = hits[v].face == PC_NONE ? INFINITY : hits[v].distance;
        stats->worst = fmax(stats->worst, distance);
        sum += pow(distance, 4);
    }
    stats->typical = pow(sum / count, 0.25);
}

/* Factors from distances: how much finer the quads must be for a vertex to be within reach. */
static pc_status want_by_distance(double *want, pc_sizing_stats *stats, pc_context *ctx,
                                  const pc_ground *ground, const double *scale, const pc_polymesh *quads,
                                  const pc_sizing_options *options) {
    pc_status status = PC_OK;
    const pc_mesh *scan = ground->scan;
    pc_mesh surface = {0};
    pc_bvh tree = {0};
    pc_bvh_hit *hits = NULL;
    double *limit = NULL;
    PC_TRY(pc_polysurface_make(&surface, NULL, ctx, quads));
    PC_TRY(pc_bvh_make(&tree, ctx, &surface));
    PC_TRY(pc_new(&hits, ctx, scan->vertex_count));
    PC_TRY(pc_new(&limit, ctx, scan->vertex_count));
    pc_bvh_closest_all(hits, &tree, scan->position, scan->vertex_count);
#pragma omp parallel for schedule(dynamic, 256)
    for (pc_index v = 0; v < scan->vertex_count; v++)
        if (hits[v].face != PC_NONE) limit[v] = limit_at(v, ground, scale[v], hits[v].distance, options);
    measure_distances(stats, hits, scan->vertex_count);
    for (pc_index v = 0; v < scan->vertex_count; v++)
        if (hits[v].face == PC_NONE || hits[v].distance > limit[v])
            want[v] = hits[v].face == PC_NONE ? options->growth
                                              : fmin(hits[v].distance / limit[v] + 0.2, options->growth);
done:
    pc_free(ctx, hits);
    pc_free(ctx, limit);
    pc_bvh_free(&tree, ctx);
    pc_mesh_free(&surface, ctx);
    return status;
}

static void want_by_folds(double *want, const pc_bvh *tree, const pc_polymesh *quads, const uint8_t *folded) {
    for (pc_index f = 0; f < quads->face_count; f++)
        for (pc_index c = quads->start[f]; folded[f] && c < quads->start[f + 1]; c++) {
            pc_bvh_hit hit = pc_bvh_closest(tree, pc_vec3_at(quads->position, quads->corner[c]), PC_NONE);
            for (int k = 0; hit.face != PC_NONE && k < 3; k++) {
                pc_index v = tree->mesh->triangle[3 * (size_t)hit.face + (size_t)k];
                want[v] = fmax(want[v], FOLD_GROWTH);
            }
        }
}

/* No vertex is coarser than its neighbour by more than the gradation allows: sweeps there and back until that
 * holds. */
static void grade(double *scale, const pc_mesh *scan, const pc_adjacency *adjacency, double length) {
    for (int sweep = 0; sweep < MOST_SWEEPS; sweep++) {
        bool changed = false;
        for (pc_index i = 0; i < adjacency->edge_count; i++) {
            pc_index h = adjacency->edge_half[sweep % 2 ? adjacency->edge_count - 1 - i : i];
            pc_index a = pc_tail(scan, h), b = pc_head(scan, h);
            if (scale[a] == scale[b]) continue;
            double along = pc_distance(pc_vec3_at(scan->position, a), pc_vec3_at(scan->position, b));
            double fall = exp(-along / length);
            if (scale[b] < scale[a] * fall * 0.999) scale[b] = scale[a] * fall, changed = true;
            if (scale[a] < scale[b] * fall * 0.999) scale[a] = scale[b] * fall, changed = true;
        }
        if (!changed) break;
    }
}

void pc_sizing_limit_by_edges(double *scale, const pc_mesh *scan, const pc_adjacency *adjacency,
                              double longest, double least) {
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        pc_index a = pc_tail(scan, adjacency->edge_half[e]), b = pc_head(scan, adjacency->edge_half[e]);
        double along = pc_distance(pc_vec3_at(scan->position, a), pc_vec3_at(scan->position, b));
        double most = fmax(least, longest / along);
        scale[a] = fmin(scale[a], most);
        scale[b] = fmin(scale[b], most);
    }
}

pc_status pc_sizing_update(double *scale, pc_sizing_stats *stats, pc_context *ctx, const pc_ground *ground,
                           const pc_polymesh *quads, const uint8_t *folded,
                           const pc_sizing_options *options) {
    pc_status status = PC_OK;
    const pc_mesh *scan = ground->scan;
    double *want = NULL;
    *stats = (pc_sizing_stats){0};
    PC_TRY(pc_new(&want, ctx, scan->vertex_count));
    PC_TRY(want_by_distance(want, stats, ctx, ground, scale, quads, options));
    want_by_folds(want, &ground->tree, quads, folded);
    for (pc_index v = 0; v < scan->vertex_count; v++) {
        if (want[v] <= 0) continue;
        stats->wanting++;
        scale[v] = fmin(scale[v] * want[v], options->most);
    }
    if (stats->wanting == 0) goto done;
    grade(scale, scan, ground->adjacency, options->gradation * options->edge_length);
    pc_sizing_limit_by_edges(scale, scan, ground->adjacency, 0.45 * options->period_length, 1);
done:
    pc_free(ctx, want);
    return status;
}
