#include "target.h"
#include "geometry.h"
#include "memory.h"
#include "walk.h"
#include <string.h>

pc_status pc_target_make(pc_target *target, pc_context *ctx, const pc_mesh *mesh,
                         const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    *target = (pc_target){.mesh = mesh, .adjacency = adjacency};
    PC_TRY(pc_bvh_make(&target->tree, ctx, mesh));
    PC_TRY(pc_new(&target->normal, ctx, 3 * (size_t)mesh->vertex_count));
    pc_geometry_vertex_normals(target->normal, mesh, adjacency, PC_NORMAL_ANGLE);
    target->diagonal = pc_box_diagonal(pc_geometry_box(mesh));
done:
    if (status != PC_OK) pc_target_free(target, ctx);
    return status;
}

void pc_target_free(pc_target *target, pc_context *ctx) {
    pc_bvh_free(&target->tree, ctx);
    pc_free(ctx, target->normal);
    *target = (pc_target){0};
}

pc_status pc_target_track(pc_track *track, pc_context *ctx, const pc_target *target) {
    return pc_track_make(track, ctx, target->mesh->vertex_count, target->mesh->position, target->normal);
}

void pc_hints_free(pc_hints *hints, pc_context *ctx) {
    pc_free(ctx, hints->triangle);
    *hints = (pc_hints){0};
}

typedef struct gathering {
    const pc_tspline *spline;
    const pc_target *target;
    const pc_samples_options *options;
    pc_facets facets; /* flat ones; before the first fit only */
    pc_hints *hints;
    bool first_hints; /* they are not known yet */
    pc_sample *raw;   /* of the scan's vertices, then of the faces; element PC_NONE: refused */
    size_t count;
    size_t idle; /* vertices that were not asked for */
} gathering;

static bool is_active(const gathering *g, pc_index element) {
    return element != PC_NONE && (!g->options->active || g->options->active[element]);
}

static void sample_vertices(gathering *g, const pc_track *track) {
    size_t idle = 0;
#pragma omp parallel for schedule(static) reduction(+ : idle)
    for (pc_index v = 0; v < track->count; v++) {
        const bool used = g->target->adjacency->vertex_half[v] != PC_NONE;
        const bool asked = used && is_active(g, track->at[v].place.element);
        g->raw[v] = (pc_sample){.place.element = PC_NONE, .target = pc_vec3_at(track->point, v)};
        if (asked && track->facing[v]) g->raw[v].place = track->at[v].place;
        idle += !asked;
    }
    g->idle = idle;
}

/* A point of the surface, and its normal; the bilinear face's before the first fit. */
static pc_vec3 surface_point(const gathering *g, pc_surface_place place, pc_vec3 *normal) {
    if (!g->options->flat) {
        pc_surface_point p = pc_tspline_evaluate(g->spline, place);
        *normal = pc_cross(p.s, p.t);
        return p.p;
    }
    const pc_element *e = g->spline->basis.element + place.element;
    int n = g->facets.per_side;
    double u = n * (place.s - e->low[0]) / (e->high[0] - e->low[0]);
    double v = n * (place.t - e->low[1]) / (e->high[1] - e->low[1]);
    int i = (int)fmin(u, n - 1), j = (int)fmin(v, n - 1);
    pc_index row = (pc_index)n + 1, at = place.element * row * row + (pc_index)j * row + (pc_index)i;
    const double *x = g->facets.mesh.position;
    pc_vec3 a = pc_vec3_at(x, at), b = pc_vec3_at(x, at + 1), c = pc_vec3_at(x, at + row);
    pc_vec3 d = pc_vec3_at(x, at + row + 1);
    *normal = pc_cross(pc_sub(d, a), pc_sub(c, b));
    u -= i, v -= j;
    return pc_add(pc_scale(1 - v, pc_add(pc_scale(1 - u, a), pc_scale(u, b))),
                  pc_scale(v, pc_add(pc_scale(1 - u, c), pc_scale(u, d))));
}

static int grid_of(const gathering *g, pc_index e) {
    const pc_element *element = g->spline->basis.element + e;
    const double *size = g->spline->mesh.face[element->face].size;
    double part =
        fmax((element->high[0] - element->low[0]) / size[0], (element->high[1] - element->low[1]) / size[1]);
    return (int)ceil(part * g->options->per_side);
}

static void sample_element(gathering *g, pc_index e, pc_sample *to, pc_index *hints) {
    const pc_element *element = g->spline->basis.element + e;
    int n = grid_of(g, e);
    pc_index hint = PC_NONE;
    for (int i = 0; i < n * n; i++) {
        double u = (i % n + 0.5) / n, v = (i / n + 0.5) / n; /* NOLINT(bugprone-integer-division) */
        pc_surface_place place = {e, element->low[0] + u * (element->high[0] - element->low[0]),
                                  element->low[1] + v * (element->high[1] - element->low[1])};
        pc_vec3 normal, scan = {0, 0, 0}, p = surface_point(g, place, &normal);
        pc_bvh_hit hit = g->options->near && !g->first_hints
                             ? pc_walk_closest(g->target->mesh, g->target->adjacency, p, hints[i])
                             : pc_bvh_closest(&g->target->tree, p, g->first_hints ? hint : hints[i]);
        hint = hints[i] = hit.face;
        to[i] = (pc_sample){.place.element = PC_NONE};
        if (hit.face == PC_NONE) continue;
        to[i] = (pc_sample){.place = place, .target = hit.point};
        const pc_index *t = g->target->mesh->triangle + 3 * (size_t)hit.face;
        for (int k = 0; k < 3; k++)
            scan = pc_madd(scan, hit.weight[k], pc_vec3_at(g->target->normal, t[k]));
        if (!(pc_dot(normal, scan) > 0)) to[i].place.element = PC_NONE;
    }
}

static pc_status sample_faces(gathering *g, pc_samples *samples, pc_context *ctx) {
    pc_status status = PC_OK;
    size_t *start = NULL, vertices = g->target->mesh->vertex_count;
    pc_index elements = g->spline->basis.element_count;
    PC_TRY(pc_new(&start, ctx, (size_t)elements + 1));
    start[0] = vertices;
    for (pc_index e = 0; e < elements; e++)
        start[e + 1] = start[e] + (is_active(g, e) ? (size_t)(grid_of(g, e) * grid_of(g, e)) : 0);
    g->count = start[elements];
    g->first_hints = g->hints->count != g->count - vertices;
    if (g->first_hints) {
        pc_hints_free(g->hints, ctx);
        PC_TRY(pc_new(&g->hints->triangle, ctx, g->count - vertices));
        g->hints->count = g->count - vertices;
    }
    PC_TRY(pc_resize(&g->raw, ctx, g->count));
    PC_TRY(pc_new(&samples->stiffness, ctx, elements));
#pragma omp parallel for schedule(dynamic, 16)
    for (pc_index e = 0; e < elements; e++) {
        size_t lost = 0;
        if (!is_active(g, e)) continue;
        sample_element(g, e, g->raw + start[e], g->hints->triangle + (start[e] - vertices));
        for (size_t i = start[e]; i < start[e + 1]; i++)
            lost += g->raw[i].place.element == PC_NONE;
        samples->stiffness[e] = 1;
        if (lost) samples->stiffness[e] += 999 * (double)lost / (double)(start[e + 1] - start[e]);
    }
done:
    pc_free(ctx, start);
    return status;
}

/* Triangles within one face whose parameters run clockwise: their corners are refused. */
static pc_status refuse_flipped(gathering *g, pc_samples *samples, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_mesh *mesh = g->target->mesh;
    uint8_t *bad = NULL;
    PC_TRY(pc_new(&bad, ctx, mesh->vertex_count));
    for (pc_index f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        const pc_sample *s[3] = {g->raw + t[0], g->raw + t[1], g->raw + t[2]};
        pc_index face[3];
        for (int k = 0; k < 3; k++)
            face[k] =
                s[k]->place.element == PC_NONE ? PC_NONE : g->spline->basis.element[s[k]->place.element].face;
        if (face[0] == PC_NONE || face[0] != face[1] || face[0] != face[2]) continue;
        double area = (s[1]->place.s - s[0]->place.s) * (s[2]->place.t - s[0]->place.t) -
                      (s[2]->place.s - s[0]->place.s) * (s[1]->place.t - s[0]->place.t);
        if (area >= 0) continue;
        samples->flipped++;
        for (int k = 0; k < 3; k++)
            bad[t[k]] = 1;
    }
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        if (bad[v]) g->raw[v].place.element = PC_NONE;
done:
    pc_free(ctx, bad);
    return status;
}

static pc_status sort_samples(gathering *g, pc_samples *samples, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_basis *basis = &g->spline->basis;
    size_t *start = NULL;
    PC_TRY(pc_new(&start, ctx, (size_t)basis->element_count + 2));
    for (size_t i = 0; i < g->count; i++) {
        if (g->raw[i].place.element != PC_NONE) start[g->raw[i].place.element + 2]++;
    }
    for (size_t e = 0; e < basis->element_count; e++)
        start[e + 2] += start[e + 1];
    samples->count = start[basis->element_count + 1];
    samples->refused = g->count - g->idle - samples->count;
    PC_TRY(pc_new(&samples->sample, ctx, samples->count));
    for (size_t i = 0; i < g->count; i++)
        if (g->raw[i].place.element != PC_NONE)
            samples->sample[start[g->raw[i].place.element + 1]++] = g->raw[i];
    for (pc_index e = 0; e < basis->element_count; e++) {
        const pc_element *element = basis->element + e;
        const double *size = g->spline->mesh.face[element->face].size;
        double share =
            (element->high[0] - element->low[0]) / size[0] * (element->high[1] - element->low[1]) / size[1];
        for (size_t i = start[e]; i < start[e + 1]; i++)
            samples->sample[i].weight = share / (double)(start[e + 1] - start[e]);
    }
done:
    pc_free(ctx, start);
    return status;
}

pc_status pc_samples_make(pc_samples *samples, pc_hints *hints, pc_track *track, pc_context *ctx,
                          const pc_tspline *spline, const pc_target *target,
                          const pc_samples_options *options) {
    pc_status status = PC_OK;
    gathering g = {.spline = spline, .target = target, .options = options, .hints = hints};
    const pc_track_options tracking = {INFINITY, options->active};
    *samples = (pc_samples){0};
    if (options->flat) {
        PC_TRY(pc_facets_make(&g.facets, ctx, spline, 4, true));
        pc_track_project(track, &g.facets);
    } else {
        PC_TRY(pc_track_update(track, ctx, spline, &tracking));
    }
    PC_TRY(pc_new(&g.raw, ctx, track->count));
    sample_vertices(&g, track);
    PC_TRY(refuse_flipped(&g, samples, ctx));
    PC_TRY(sample_faces(&g, samples, ctx));
    PC_TRY(sort_samples(&g, samples, ctx));
done:
    pc_facets_free(&g.facets, ctx);
    pc_free(ctx, g.raw);
    if (status != PC_OK) pc_samples_free(samples, ctx);
    return status;
}

void pc_samples_free(pc_samples *samples, pc_context *ctx) {
    pc_free(ctx, samples->sample);
    pc_free(ctx, samples->stiffness);
    *samples = (pc_samples){0};
}
