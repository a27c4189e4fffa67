#include "samples.h"
#include "memory.h"
#include <math.h>
#include <stdlib.h>
#include <stdbool.h>

typedef struct gathering {
    const pc_tspline *spline;
    const pc_target *target;
    const pc_footpoints *feet;
    const pc_correspondence *correspondence;
    pc_sample *raw; /* of the scan's vertices, then of the grids; element PC_NONE: refused */
    size_t count, vertices;
    double goal; bool unfold;
    size_t *per_face; /* 2 per face: of vertices, of the grid */
} gathering;

static double opposed_share(const gathering *g, pc_index f) {
    const int full = g->feet->per_side * g->feet->per_side;
    int lost = 0;
    for (int i = 0; i < full; i++) lost += g->feet->foot[f * (size_t)full + (size_t)i].lost;
    return (double)lost / full;
}

static void sample_vertices(gathering *g) {
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < g->vertices; v++) {
        pc_surface_place place = {PC_NONE, 0, 0};
        if (!g->correspondence->astray[v]) place = pc_correspondence_place(g->correspondence, g->spline, v);
        if (g->unfold && place.element != PC_NONE && opposed_share(g, g->spline->basis.element[place.element].face) > 0.2) place.element = PC_NONE;
        g->raw[v] = (pc_sample){.place = place, .target = pc_vec3_at(g->target->mesh->position, v)};
    }
}

static void sample_grids(gathering *g) {
    const pc_footpoints *feet = g->feet;
    const size_t each = (size_t)(feet->per_side * feet->per_side);
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < feet->face_count; f++) {
        const bool drop = g->unfold && opposed_share(g, f) > 0.2;
        for (size_t i = 0; i < each; i++) {
            const pc_foot *foot = feet->foot + f * each + i;
            pc_sample *to = g->raw + g->vertices + f * each + i;
            *to = (pc_sample){.place.element = PC_NONE, .target = foot->point};
            if (g->spline->mesh.face[f].ghost || (foot->lost && !getenv("ALL")) || drop) continue;
            double at[2];
            pc_footpoints_at(at, feet, f, (int)i);
            to->place = pc_tspline_place(g->spline, f, at[0], at[1]);
        }
    }
}

static pc_index face_of(const gathering *g, const pc_sample *sample) {
    return g->spline->basis.element[sample->place.element].face;
}

static pc_status count_samples(gathering *g, pc_context *ctx) {
    pc_status status = pc_new(&g->per_face, ctx, 2 * (size_t)g->spline->mesh.face_count);
    for (size_t i = 0; i < g->count && status == PC_OK; i++)
        if (g->raw[i].place.element != PC_NONE)
            g->per_face[2 * (size_t)face_of(g, g->raw + i) + (i >= g->vertices)]++;
    return status;
}

/* Vertices and grid have half of the weight each, where there are vertices enough to be as good as a grid. */
static double weight_of(const gathering *g, size_t i) {
    const size_t *count = g->per_face + 2 * (size_t)face_of(g, g->raw + i);
    const double full = (double)(g->feet->per_side * g->feet->per_side);
    const double vertices = 0.5 * (double)count[0] / ((double)count[0] + 4);
    const double far = g->goal > 0 ? pc_distance(pc_tspline_point(g->spline, g->raw[i].place), g->raw[i].target) / g->goal : 0;
    const double cap = getenv("CAP") ? atof(getenv("CAP")) : 30, pw = getenv("PW") ? atof(getenv("PW")) : 1;
    return (i < g->vertices ? vertices / (double)count[0] : (1 - vertices) / full) * fmin(pow(fmax(far,1),pw), cap);
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
    for (size_t i = 0; i < g->count; i++) {
        if (g->raw[i].place.element == PC_NONE) continue;
        g->raw[i].weight = weight_of(g, i);
        samples->sample[start[g->raw[i].place.element + 1]++] = g->raw[i];
    }
done:
    pc_free(ctx, start);
    return status;
}

/* Where the grid has lost points, fairing has to keep the surface in shape. */
static pc_status stiffen(pc_samples *samples, const gathering *g, pc_context *ctx) {
    const double most = getenv("STIFF") ? atof(getenv("STIFF")) : 1000;
    const pc_basis *basis = &g->spline->basis;
    pc_status status = pc_new(&samples->stiffness, ctx, basis->element_count);
    for (pc_index e = 0; e < basis->element_count && status == PC_OK; e++) {
        const double lack = g->unfold && opposed_share(g, basis->element[e].face) > 0.2 ? 1 : 0;
        samples->stiffness[e] = 1 + (most - 1) * lack;
    }
    return status;
}

pc_status pc_samples_make(pc_samples *samples, pc_context *ctx, const pc_tspline *spline,
                          const pc_target *target, const pc_matching *matching, double goal, bool unfold) {
    pc_status status = PC_OK;
    const pc_footpoints *feet = &matching->feet;
    const pc_correspondence *correspondence = &matching->vertices;
    gathering g = {.spline = spline, .target = target, .feet = feet, .correspondence = correspondence, .goal = goal, .unfold = unfold};
    *samples = (pc_samples){0};
    g.vertices = correspondence->count;
    g.count = g.vertices + (size_t)feet->face_count * (size_t)(feet->per_side * feet->per_side);
    PC_TRY(pc_new(&g.raw, ctx, g.count));
    sample_vertices(&g);
    sample_grids(&g);
    PC_TRY(count_samples(&g, ctx));
    PC_TRY(sort_samples(&g, samples, ctx));
    PC_TRY(stiffen(samples, &g, ctx));
    samples->refused = correspondence->astray_count;
    for (pc_index f = 0; f < feet->face_count; f++)
        if (!spline->mesh.face[f].ghost)
            samples->refused += (size_t)(feet->per_side * feet->per_side) - g.per_face[2 * (size_t)f + 1];
done:
    pc_free(ctx, g.raw);
    pc_free(ctx, g.per_face);
    if (status != PC_OK) pc_samples_free(samples, ctx);
    return status;
}

void pc_samples_free(pc_samples *samples, pc_context *ctx) {
    pc_free(ctx, samples->sample);
    pc_free(ctx, samples->stiffness);
    *samples = (pc_samples){0};
}
