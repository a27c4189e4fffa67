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
        near; /* the tolerance; samples farther away than `near` come to weigh more. 0: none does */
    /* Of the scan's vertices, of the grids, of the summits; element PC_NONE: not used. */
    pc_surface_place *place;
    size_t count;     /* of all */
    size_t *rank;     /* where each stands when sorted by element */
    size_t *start;    /* per element, and the end */
    double *distance; /* sorted */
    size_t *per_face; /* vertices of the scan at each face */
} gathering;

static bool is_wanted(const gathering *g, pc_index f) {
    return f != PC_NONE && !g->spline->mesh.face[f].ghost && (!g->active || g->active[f]);
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

static pc_surface_place wanted_place(const gathering *g, const pc_correspondence *c, size_t i) {
    if (!is_wanted(g, c->spot[i].face)) return (pc_surface_place){PC_NONE, 0, 0};
    return pc_correspondence_place(c, g->spline, (pc_index)i);
}

static pc_surface_place place_of(const gathering *g, size_t i) {
    const size_t vertices = g->vertices->count, feet = pc_footpoints_count(g->feet);
    const size_t each = (size_t)g->feet->per_side * (size_t)g->feet->per_side;
    double at[2];
    if (i < vertices) return wanted_place(g, g->vertices, i);
    i -= vertices;
    if (i >= feet) return wanted_place(g, &g->summits->places, i - feet);
    const pc_index f = (pc_index)(i / each);
    if (!is_wanted(g, f)) return (pc_surface_place){PC_NONE, 0, 0};
    pc_footpoints_at(at, g->feet, f, (int)(i % each));
    return pc_tspline_place(g->spline, f, at[0], at[1]);
}

/* That of sample i, which is no vertex. */
static pc_foot *foot_of(const gathering *g, size_t i) {
    const size_t feet = pc_footpoints_count(g->feet);
    i -= g->vertices->count;
    return i < feet ? g->feet->foot + i : g->summits->foot + (i - feet);
}

static pc_vec3 target_at(const gathering *g, size_t i) {
    if (i < g->vertices->count) return pc_vec3_at(g->target->mesh->position, i);
    return target_of(g, foot_of(g, i), g->place[i]);
}

static void find_places(gathering *g) {
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < g->count; i++)
        g->place[i] = place_of(g, i);
}

/* Where the samples go: by element, and as they come within one. */
static pc_status sort_places(gathering *g, pc_context *ctx) {
    pc_status status = PC_OK;
    const size_t elements = g->spline->basis.element_count;
    PC_TRY(pc_new(&g->start, ctx, elements + 2));
    for (size_t i = 0; i < g->count; i++)
        if (g->place[i].element != PC_NONE) g->start[g->place[i].element + 2]++;
    for (size_t e = 0; e < elements; e++)
        g->start[e + 2] += g->start[e + 1];
    for (size_t i = 0; i < g->count; i++)
        if (g->place[i].element != PC_NONE) g->rank[i] = g->start[g->place[i].element + 1]++;
done:
    return status;
}

static pc_status count_vertices(gathering *g, pc_context *ctx) {
    pc_status status = pc_new(&g->per_face, ctx, g->spline->mesh.face_count);
    for (size_t v = 0; v < g->vertices->count && status == PC_OK; v++)
        if (g->vertices->spot[v].face != PC_NONE) g->per_face[g->vertices->spot[v].face]++;
    return status;
}

/* How often sample i was too far away. */
static float *stress_of(const gathering *g, size_t i) {
    return i < g->vertices->count ? &g->vertices->spot[i].stress : &foot_of(g, i)->stress;
}

/* The vertices at a face share up to half of its weight, and its grid the rest; a summit weighs as much as a
 * point of the grid. */
static double weigh(gathering *g, size_t i, double distance) {
    const double few = 4, most = 30;
    const double grid = (double)(g->feet->per_side * g->feet->per_side);
    const double vertices = (double)g->per_face[g->spline->basis.element[g->place[i].element].face];
    const double share = 0.5 / (vertices + few); /* of one vertex */
    float *stress = stress_of(g, i);
    if (g->near > 0) *stress = (float)fmin(fmax(fmax(*stress, 1) * distance / g->near, 1), most);
    return (i < g->vertices->count ? share : (1 - vertices * share) / grid) * fmax(*stress, 1);
}

static void put_samples(gathering *g, pc_samples *samples) {
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < g->count; i++) {
        const pc_surface_place place = g->place[i];
        if (place.element == PC_NONE) continue;
        const pc_vec3 target = target_at(g, i);
        const double distance = pc_distance(pc_tspline_point(g->spline, place), target);
        g->distance[g->rank[i]] = distance;
        samples->sample[g->rank[i]] = (pc_sample){place, target, weigh(g, i, distance)};
    }
}

static pc_status find_farthest(const gathering *g, pc_samples *samples, pc_context *ctx) {
    const pc_basis *basis = &g->spline->basis;
    const pc_status status = pc_new(&samples->far, ctx, basis->face_count);
    for (pc_index f = 0; f < basis->face_count && status == PC_OK; f++) {
        double far = -1;
        for (size_t i = g->start[basis->face_start[f]]; i < g->start[basis->face_start[f + 1]]; i++)
            far = fmax(far, g->distance[i]);
        samples->far[f] = far;
        samples->max = fmax(samples->max, far);
    }
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
    PC_TRY(pc_resize(&g.place, ctx, g.count));
    PC_TRY(pc_resize(&g.rank, ctx, g.count));
    find_places(&g);
    PC_TRY(sort_places(&g, ctx));
    samples->count = g.start[spline->basis.element_count];
    PC_TRY(pc_resize(&samples->sample, ctx, samples->count));
    PC_TRY(pc_resize(&g.distance, ctx, samples->count));
    PC_TRY(count_vertices(&g, ctx));
    put_samples(&g, samples);
    PC_TRY(find_farthest(&g, samples, ctx));
done:
    pc_free(ctx, g.place);
    pc_free(ctx, g.rank);
    pc_free(ctx, g.start);
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
