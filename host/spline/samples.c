#include "samples.h"
#include "memory.h"
#include <math.h>

typedef struct gathering {
    const pc_tspline *spline;
    const pc_target *target;
    const pc_correspondence *correspondence;
    int per_side;
    double *image;  /* 3 per vertex of the scan: its place as a point */
    size_t *start;  /* per triangle: its first sample in `raw` */
    pc_sample *raw; /* of the scan's vertices, its triangles, then the elements; element PC_NONE: refused */
    size_t count;
} gathering;

static void sample_vertices(gathering *g) {
    const pc_mesh *mesh = g->target->mesh;
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_surface_place place = pc_correspondence_place(g->correspondence, g->spline, v);
        pc_vec3 image = {0, 0, 0};
        if (place.element != PC_NONE) image = pc_tspline_point(g->spline, place);
        pc_vec3_put(g->image, v, image);
        if (g->correspondence->torn[v]) place.element = PC_NONE;
        g->raw[v] = (pc_sample){.place = place, .target = pc_vec3_at(mesh->position, v)};
    }
}

/* The diagonal of the face around an element. */
static double face_diagonal(const pc_tspline *spline, pc_index e) {
    const double *b = spline->bezier + 48 * (size_t)e;
    double part[2];
    pc_tspline_part(part, spline, e);
    return fmax(pc_distance(pc_vec3_at(b, 0), pc_vec3_at(b, 15)),
                pc_distance(pc_vec3_at(b, 3), pc_vec3_at(b, 12))) /
           fmax(part[0], part[1]);
}

/* Into how many parts each side of triangle t is cut, so that a face has about per_side samples along its
 * sides; 0 where a corner is torn or has no place. */
static size_t cuts_of(const gathering *g, pc_index t) {
    enum { MOST = 12 };
    const pc_index *v = g->target->mesh->triangle + 3 * (size_t)t;
    double longest = 0, diagonal = INFINITY;
    for (int k = 0; k < 3; k++) {
        if (g->raw[v[k]].place.element == PC_NONE) return 0;
        diagonal = fmin(diagonal, face_diagonal(g->spline, g->raw[v[k]].place.element));
        longest =
            fmax(longest, pc_distance(pc_vec3_at(g->image, v[k]), pc_vec3_at(g->image, v[(k + 1) % 3])));
    }
    double cuts = ceil(longest * g->per_side / fmax(1.4 * diagonal, 1e-300));
    return g->per_side ? (size_t)fmin(fmax(cuts, 1), MOST) : 0;
}

/* Triangle t laid out in the frame of its first corner. */
typedef struct outline {
    const pc_spot *spot; /* of the first corner */
    double way[3][2];    /* to the second and the third */
    bool laid;           /* else corners are too far apart on the T-mesh */
} outline;

static outline outline_of(const gathering *g, const pc_index v[3]) {
    const pc_tmesh *mesh = &g->spline->mesh;
    const pc_spot *spot = g->correspondence->spot;
    outline o = {.spot = spot + v[0]};
    o.laid = pc_chart_between(o.way[1], mesh, spot + v[0], spot + v[1]) &&
             pc_chart_between(o.way[2], mesh, spot + v[0], spot + v[2]);
    return o;
}

/* The place between those of the corners; where these are far apart, what is nearest to the interpolated
 * point of the surface. */
static pc_surface_place place_between(const gathering *g, const outline *o, const pc_index v[3],
                                      const double weight[3]) {
    if (o->laid) {
        const double way[2] = {weight[1] * o->way[1][0] + weight[2] * o->way[2][0],
                               weight[1] * o->way[1][1] + weight[2] * o->way[2][1]};
        pc_spot spot = pc_chart_walk(&g->spline->mesh, o->spot, way);
        return pc_tspline_place(g->spline, spot.face, spot.at[0], spot.at[1]);
    }
    pc_vec3 image = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        image = pc_madd(image, weight[k], pc_vec3_at(g->image, v[k]));
    return pc_nearest_from(g->spline, g->raw[v[0]].place, image).place;
}

/* The centres of its n x n parts. */
static void sample_triangle(const gathering *g, pc_index t, size_t n, pc_sample *to) {
    const pc_index *v = g->target->mesh->triangle + 3 * (size_t)t;
    const outline o = outline_of(g, v);
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < 2 * (n - i) - 1; j++) {
            double third = j % 2 ? 2.0 / 3 : 1.0 / 3;
            double a = ((double)i + third) / (double)n,
                   b = ((double)(j / 2) + third) / (double)n; /* NOLINT */
            const double weight[3] = {1 - a - b, b, a};
            to->target = (pc_vec3){0, 0, 0};
            for (int k = 0; k < 3; k++)
                to->target = pc_madd(to->target, weight[k], pc_vec3_at(g->target->mesh->position, v[k]));
            to->place = place_between(g, &o, v, weight);
            to++;
        }
}

static pc_status sample_triangles(gathering *g, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_mesh *mesh = g->target->mesh;
    PC_TRY(pc_new(&g->start, ctx, (size_t)mesh->face_count + 1));
#pragma omp parallel for schedule(static)
    for (pc_index t = 0; t < mesh->face_count; t++) {
        size_t n = cuts_of(g, t);
        g->start[t + 1] = n * n;
    }
    g->start[0] = mesh->vertex_count;
    for (pc_index t = 0; t < mesh->face_count; t++)
        g->start[t + 1] += g->start[t];
    g->count = g->start[mesh->face_count];
    PC_TRY(pc_resize(&g->raw, ctx, g->count));
#pragma omp parallel for schedule(dynamic, 256)
    for (pc_index t = 0; t < mesh->face_count; t++) {
        size_t n = (size_t)lround(sqrt((double)(g->start[t + 1] - g->start[t])));
        if (n) sample_triangle(g, t, n, g->raw + g->start[t]);
    }
done:
    return status;
}

static int grid_of(const gathering *g, pc_index e) {
    double part[2];
    pc_tspline_part(part, g->spline, e);
    return (int)ceil(fmax(part[0], part[1]) * g->per_side);
}

/* The triangle that was hit belongs near the place of the surface from which it was looked for: near in the
 * parameters, for where the surface bulges it is far from everything in space. */
static bool belongs(const gathering *g, const pc_bvh_hit *hit, pc_surface_place place) {
    const pc_tmesh *mesh = &g->spline->mesh;
    const pc_index *t = g->target->mesh->triangle + 3 * (size_t)hit->face,
                   face = g->spline->basis.element[place.element].face;
    const pc_spot here = {face, {place.s, place.t}}, *spot = g->correspondence->spot;
    const double reach = 6 * fmax(mesh->face[face].size[0], mesh->face[face].size[1]);
    double way[2], span = 0;
    int most = hit->weight[1] > hit->weight[0] ? 1 : 0;
    if (hit->weight[2] > hit->weight[most]) most = 2;
    for (int k = 0; k < 3; k++) {
        if (g->raw[t[k]].place.element == PC_NONE) return false;
        if (k != most && pc_chart_between(way, mesh, spot + t[most], spot + t[k]))
            span = fmax(span, hypot(way[0], way[1]));
    }
    return pc_chart_between(way, mesh, &here, spot + t[most]) && hypot(way[0], way[1]) <= reach + span;
}

/* A grid of points of the element and their nearest points of the scan. */
static void sample_element(const gathering *g, pc_index e, pc_sample *to) {
    const pc_element *element = g->spline->basis.element + e;
    int n = grid_of(g, e);
    pc_index hint = PC_NONE;
    for (int i = 0; i < n * n; i++) {
        double u = (i % n + 0.5) / n, v = (i / n + 0.5) / n; /* NOLINT(bugprone-integer-division) */
        pc_surface_place place = {e, element->low[0] + u * (element->high[0] - element->low[0]),
                                  element->low[1] + v * (element->high[1] - element->low[1])};
        pc_bvh_hit hit = pc_bvh_closest(&g->target->tree, pc_tspline_point(g->spline, place), hint);
        hint = hit.face;
        to[i] = (pc_sample){.place.element = PC_NONE};
        if (hit.face != PC_NONE && belongs(g, &hit, place))
            to[i] = (pc_sample){.place = place, .target = hit.point};
    }
}

static pc_status sample_elements(gathering *g, pc_context *ctx) {
    pc_status status = PC_OK;
    size_t *start = NULL;
    pc_index elements = g->spline->basis.element_count;
    PC_TRY(pc_new(&start, ctx, (size_t)elements + 1));
    start[0] = g->count;
    for (pc_index e = 0; e < elements; e++)
        start[e + 1] = start[e] + (size_t)(grid_of(g, e) * grid_of(g, e));
    g->count = start[elements];
    PC_TRY(pc_resize(&g->raw, ctx, g->count));
#pragma omp parallel for schedule(dynamic, 16)
    for (pc_index e = 0; e < elements; e++)
        sample_element(g, e, g->raw + start[e]);
done:
    pc_free(ctx, start);
    return status;
}

static pc_status sort_samples(gathering *g, pc_samples *samples, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_basis *basis = &g->spline->basis;
    size_t *start = NULL;
    PC_TRY(pc_new(&start, ctx, (size_t)basis->element_count + 2));
    for (size_t i = 0; i < g->count; i++) {
        if (g->raw[i].place.element == PC_NONE)
            samples->refused++;
        else
            start[g->raw[i].place.element + 2]++;
    }
    for (size_t e = 0; e < basis->element_count; e++)
        start[e + 2] += start[e + 1];
    samples->count = g->count - samples->refused;
    PC_TRY(pc_new(&samples->sample, ctx, samples->count));
    for (size_t i = 0; i < g->count; i++)
        if (g->raw[i].place.element != PC_NONE)
            samples->sample[start[g->raw[i].place.element + 1]++] = g->raw[i];
    for (pc_index e = 0; e < basis->element_count; e++) {
        double part[2];
        pc_tspline_part(part, g->spline, e);
        for (size_t i = start[e]; i < start[e + 1]; i++)
            samples->sample[i].weight = part[0] * part[1] / (double)(start[e + 1] - start[e]);
    }
done:
    pc_free(ctx, start);
    return status;
}

/* Where there are fewer samples than a quarter of what was meant, fairing has to keep the surface in shape.
 */
static pc_status stiffen(pc_samples *samples, const pc_tspline *spline, int per_side, pc_context *ctx) {
    const double most = 1000;
    const pc_basis *basis = &spline->basis;
    pc_status status = pc_new(&samples->stiffness, ctx, basis->element_count);
    if (status != PC_OK) return status;
    for (size_t i = 0; i < samples->count; i++)
        samples->stiffness[samples->sample[i].place.element]++;
    for (pc_index e = 0; e < basis->element_count; e++) {
        double part[2];
        pc_tspline_part(part, spline, e);
        double meant = part[0] * part[1] * per_side * per_side / 4;
        double lack = fmax(0, 1 - samples->stiffness[e] / fmax(meant, 1));
        samples->stiffness[e] = 1 + (most - 1) * lack;
    }
    return PC_OK;
}

pc_status pc_samples_make(pc_samples *samples, pc_context *ctx, const pc_tspline *spline,
                          const pc_target *target, const pc_correspondence *correspondence, int per_side) {
    pc_status status = PC_OK;
    gathering g = {
        .spline = spline, .target = target, .correspondence = correspondence, .per_side = per_side};
    *samples = (pc_samples){0};
    PC_TRY(pc_new(&g.raw, ctx, target->mesh->vertex_count));
    PC_TRY(pc_new(&g.image, ctx, 3 * (size_t)target->mesh->vertex_count));
    sample_vertices(&g);
    PC_TRY(sample_triangles(&g, ctx));
    PC_TRY(sample_elements(&g, ctx));
    PC_TRY(sort_samples(&g, samples, ctx));
    PC_TRY(stiffen(samples, spline, per_side, ctx));
done:
    pc_free(ctx, g.raw);
    pc_free(ctx, g.image);
    pc_free(ctx, g.start);
    if (status != PC_OK) pc_samples_free(samples, ctx);
    return status;
}

void pc_samples_free(pc_samples *samples, pc_context *ctx) {
    pc_free(ctx, samples->sample);
    pc_free(ctx, samples->stiffness);
    *samples = (pc_samples){0};
}
