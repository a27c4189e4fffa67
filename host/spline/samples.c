#include "samples.h"
#include "memory.h"
#include <math.h>

typedef struct gathering {
    const pc_tspline *spline;
    const pc_target *target;
    pc_footpoints *feet;
    pc_correspondence *vertices;
    pc_summits *summits;
    const uint8_t *active; /* per face: its samples are wanted */
    double within,
        near;       /* the tolerance; samples farther away than `near` come to weigh more. 0: none does */
    pc_sample *raw; /* of the scan's vertices, of the grids, of the summits; element PC_NONE: not used */
    size_t count;   /* of all */
    double *distance;
    size_t *per_face; /* vertices of the scan at each face */
} gathering;

static bool is_wanted(const gathering *g, pc_index f) {
    return f != PC_NONE && !g->spline->mesh.face[f].ghost && (!g->active || g->active[f]);
}

static void sample_vertices(gathering *g) {
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < g->vertices->count; v++) {
        g->raw[v].place.element = PC_NONE;
        if (!is_wanted(g, g->vertices->spot[v].face)) continue;
        g->raw[v] = (pc_sample){.place = pc_correspondence_place(g->vertices, g->spline, v),
                                .target = pc_vec3_at(g->target->mesh->position, v)};
    }
}

/* Beyond the border of the scan there are no data: as far as the tolerance the surface goes on as the scan
 * ends. */
static pc_vec3 target_of(const gathering *g, const pc_foot *foot, pc_surface_place place) {
    const double most = g->within;
    if (foot->held || foot->opposed || !pc_target_on_border(g->target, foot->triangle, foot->weight))
        return foot->point;
    const pc_vec3 n = pc_target_normal(g->target, foot->triangle, foot->weight);
    pc_vec3 past = pc_sub(pc_tspline_point(g->spline, place), foot->point);
    past = pc_madd(past, -pc_dot(past, n), n);
    const double length = pc_norm(past);
    return pc_madd(foot->point, length > most ? most / length : 1, past);
}

static void sample_grids(gathering *g) {
    const pc_footpoints *feet = g->feet;
    const size_t n = (size_t)feet->per_side, each = n * n;
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < feet->face_count; f++)
        for (size_t i = 0; i < each; i++) {
            pc_sample *to = g->raw + g->vertices->count + f * each + i;
            double at[2];
            to->place.element = PC_NONE;
            if (!is_wanted(g, f)) continue;
            pc_footpoints_at(at, feet, f, (int)i);
            to->place = pc_tspline_place(g->spline, f, at[0], at[1]);
            to->target = target_of(g, feet->foot + f * each + i, to->place);
        }
}

static void sample_summits(gathering *g) {
    pc_sample *to = g->raw + g->vertices->count + pc_footpoints_count(g->feet);
    for (pc_index i = 0; i < g->summits->places.count; i++) {
        to[i].place.element = PC_NONE;
        if (!is_wanted(g, g->summits->places.spot[i].face)) continue;
        to[i].place = pc_correspondence_place(&g->summits->places, g->spline, i);
        to[i].target = target_of(g, g->summits->foot + i, to[i].place);
    }
}

static pc_status count_vertices(gathering *g, pc_context *ctx) {
    pc_status status = pc_new(&g->per_face, ctx, g->spline->mesh.face_count);
    for (size_t v = 0; v < g->vertices->count && status == PC_OK; v++)
        if (g->vertices->spot[v].face != PC_NONE) g->per_face[g->vertices->spot[v].face]++;
    return status;
}

/* How often sample i was too far away. */
static float *stress_of(const gathering *g, size_t i) {
    if (i < g->vertices->count) return &g->vertices->spot[i].stress;
    i -= g->vertices->count;
    const size_t feet = pc_footpoints_count(g->feet);
    return i < feet ? &g->feet->foot[i].stress : &g->summits->foot[i - feet].stress;
}

/* The vertices at a face share up to half of its weight, and its grid the rest; a summit weighs as much as a
 * point of the grid. */
static double weigh(gathering *g, size_t i, double distance) {
    const double few = 4, most = 30;
    const double grid = (double)(g->feet->per_side * g->feet->per_side);
    const double vertices = (double)g->per_face[g->spline->basis.element[g->raw[i].place.element].face];
    const double share = 0.5 / (vertices + few); /* of one vertex */
    float *stress = stress_of(g, i);
    if (g->near > 0) *stress = (float)fmin(fmax(fmax(*stress, 1) * distance / g->near, 1), most);
    return (i < g->vertices->count ? share : (1 - vertices * share) / grid) * fmax(*stress, 1);
}

static void weigh_all(gathering *g) {
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < g->count; i++) {
        pc_sample *sample = g->raw + i;
        if (sample->place.element == PC_NONE) continue;
        g->distance[i] = pc_distance(pc_tspline_point(g->spline, sample->place), sample->target);
        sample->weight = weigh(g, i, g->distance[i]);
    }
}

static pc_status find_farthest(const gathering *g, pc_samples *samples, pc_context *ctx) {
    const pc_basis *basis = &g->spline->basis;
    const pc_status status = pc_new(&samples->far, ctx, basis->face_count);
    for (pc_index f = 0; f < basis->face_count && status == PC_OK; f++)
        samples->far[f] = -1;
    for (size_t i = 0; i < g->count && status == PC_OK; i++) {
        if (g->raw[i].place.element == PC_NONE) continue;
        double *far = samples->far + basis->element[g->raw[i].place.element].face;
        *far = fmax(*far, g->distance[i]);
        samples->max = fmax(samples->max, g->distance[i]);
    }
    return status;
}

static pc_status sort_samples(gathering *g, pc_samples *samples, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_basis *basis = &g->spline->basis;
    size_t *start = NULL;
    PC_TRY(pc_new(&start, ctx, (size_t)basis->element_count + 2));
    for (size_t i = 0; i < g->count; i++)
        if (g->raw[i].place.element != PC_NONE) start[g->raw[i].place.element + 2]++;
    for (size_t e = 0; e < basis->element_count; e++)
        start[e + 2] += start[e + 1];
    samples->count = start[basis->element_count + 1];
    PC_TRY(pc_new(&samples->sample, ctx, samples->count));
    for (size_t i = 0; i < g->count; i++)
        if (g->raw[i].place.element != PC_NONE)
            samples->sample[start[g->raw[i].place.element + 1]++] = g->raw[i];
done:
    pc_free(ctx, start);
    return status;
}

pc_status pc_samples_make(pc_samples *samples, pc_context *ctx, const pc_tspline *spline,
                          const pc_target *target, pc_matching *matching, double within,
                          const uint8_t *active) {
    pc_status status = PC_OK;
    gathering g = {.spline = spline,
                   .target = target,
                   .feet = &matching->feet,
                   .vertices = &matching->vertices,
                   .summits = &matching->summits,
                   .active = active,
                   .within = within,
                   .near = 0.5 * within};
    *samples = (pc_samples){0};
    g.count = g.vertices->count + pc_footpoints_count(g.feet) + g.summits->places.count;
    PC_TRY(pc_new(&g.raw, ctx, g.count));
    PC_TRY(pc_new(&g.distance, ctx, g.count));
    sample_vertices(&g);
    sample_grids(&g);
    sample_summits(&g);
    PC_TRY(count_vertices(&g, ctx));
    weigh_all(&g);
    PC_TRY(find_farthest(&g, samples, ctx));
    PC_TRY(sort_samples(&g, samples, ctx));
done:
    pc_free(ctx, g.raw);
    pc_free(ctx, g.distance);
    pc_free(ctx, g.per_face);
    if (status != PC_OK) pc_samples_free(samples, ctx);
    return status;
}

void pc_samples_free(pc_samples *samples, pc_context *ctx) {
    pc_free(ctx, samples->sample);
    pc_free(ctx, samples->far);
    *samples = (pc_samples){0};
}
