#include "correspondence.h"
#include "memory.h"
#include <string.h>

typedef struct following {
    pc_correspondence *c;
    const pc_tspline *spline;
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    double *image;   /* 3 per vertex: its place as a point */
    double *normal;  /* 3 per vertex: of the surface there, unit length */
    pc_index *loose; /* vertices that spread out */
    pc_index loose_count;
    uint8_t *is_loose;
    pc_surface_place *next; /* per loose vertex */
} following;

pc_surface_place pc_correspondence_place(const pc_correspondence *c, const pc_tspline *spline, pc_index v) {
    if (c->spot[v].face == PC_NONE) return (pc_surface_place){PC_NONE, 0, 0};
    return pc_tspline_place(spline, c->spot[v].face, c->spot[v].at[0], c->spot[v].at[1]);
}

static void put_place(following *f, pc_index v, pc_surface_place place) {
    f->c->spot[v] = (pc_spot){f->spline->basis.element[place.element].face, {place.s, place.t}};
    pc_surface_point x = pc_tspline_evaluate(f->spline, place);
    pc_vec3_put(f->image, v, x.p);
    pc_vec3_put(f->normal, v, pc_unit(pc_cross(x.s, x.t)));
}

/* Towards the nearest point, by short ways only. */
static void approach(following *f) {
#pragma omp parallel for schedule(dynamic, 64)
    for (pc_index v = 0; v < f->c->count; v++) {
        pc_surface_place place = pc_correspondence_place(f->c, f->spline, v);
        if (place.element == PC_NONE) continue;
        put_place(f, v, pc_nearest_from(f->spline, place, pc_vec3_at(f->mesh->position, v)).place);
    }
}

/* The triangle runs the wrong way round in the parameters too, which fold less than the surface. */
static bool is_flipped(const following *f, const pc_index v[3]) {
    const pc_spot *spot = f->c->spot;
    double a[2], b[2];
    if (!pc_chart_between(a, &f->spline->mesh, spot + v[0], spot + v[1]) ||
        !pc_chart_between(b, &f->spline->mesh, spot + v[0], spot + v[2]))
        return true;
    return !(a[0] * b[1] - a[1] * b[0] >= 0);
}

/* The image of triangle t is upside down, or its longest side is out of proportion. */
static bool is_torn(const following *f, pc_index t) {
    const double most_stretch = 6;
    const pc_index *v = f->mesh->triangle + 3 * (size_t)t;
    if (f->c->spot[v[0]].face == PC_NONE || f->c->spot[v[1]].face == PC_NONE ||
        f->c->spot[v[2]].face == PC_NONE)
        return false;
    pc_vec3 x[3], q[3], n = {0, 0, 0};
    double longest = 0, image = 0;
    for (int k = 0; k < 3; k++) {
        x[k] = pc_vec3_at(f->mesh->position, v[k]);
        q[k] = pc_vec3_at(f->image, v[k]);
        n = pc_add(n, pc_vec3_at(f->normal, v[k]));
    }
    for (int k = 0; k < 3; k++) {
        longest = fmax(longest, pc_distance(x[k], x[(k + 1) % 3]));
        image = fmax(image, pc_distance(q[k], q[(k + 1) % 3]));
    }
    pc_vec3 area = pc_cross(pc_sub(q[1], q[0]), pc_sub(q[2], q[0]));
    return image > most_stretch * longest || (pc_dot(area, n) < -1e-6 * image * image && is_flipped(f, v));
}

/* Marks the corners of torn triangles; counts these. */
static pc_index find_torn(following *f) {
    pc_index count = 0;
    memset(f->c->torn, 0, f->c->count);
    for (pc_index t = 0; t < f->mesh->face_count; t++) {
        if (!is_torn(f, t)) continue;
        count++;
        for (int k = 0; k < 3; k++)
            f->c->torn[f->mesh->triangle[3 * (size_t)t + (size_t)k]] = 1;
    }
    return count;
}

static void loosen(following *f, pc_index v) {
    if (f->is_loose[v] || f->c->spot[v].face == PC_NONE || f->adjacency->vertex_boundary[v]) return;
    f->is_loose[v] = 1;
    f->loose[f->loose_count++] = v;
}

/* Torn vertices and what is up to `rings` edges away. */
static void gather_loose(following *f, int rings) {
    f->loose_count = 0;
    memset(f->is_loose, 0, f->c->count);
    for (pc_index v = 0; v < f->c->count; v++)
        if (f->c->torn[v]) loosen(f, v);
    for (pc_index from = 0; rings > 0; rings--) {
        for (pc_index end = f->loose_count; from < end; from++) {
            pc_index first = f->adjacency->vertex_half[f->loose[from]], h = first;
            do {
                loosen(f, f->mesh->triangle[pc_next(h)]);
                h = pc_turn_ccw(f->adjacency, h);
            } while (h != first && h != PC_NONE);
        }
    }
}

/* The mean of the images around v, nearer neighbours on the scan weighing more. */
static pc_vec3 mean_around(const following *f, pc_index v) {
    pc_vec3 sum = {0, 0, 0}, x = pc_vec3_at(f->mesh->position, v);
    double total = 0;
    pc_index first = f->adjacency->vertex_half[v], h = first;
    do {
        pc_index w = f->mesh->triangle[pc_next(h)];
        double length = pc_distance(x, pc_vec3_at(f->mesh->position, w));
        double weight = 1 / fmax(length, 1e-300);
        sum = pc_madd(sum, weight, pc_vec3_at(f->image, w));
        total += weight;
        h = pc_turn_ccw(f->adjacency, h);
    } while (h != first && h != PC_NONE);
    return pc_scale(1 / total, sum);
}

/* Loose images sink to the means of those around them, as a membrane through the others; it need not lie on
 * the surface. */
static void stretch_membrane(following *f) {
    enum { SWEEPS = 200 };
    const double beyond = 1.6;
    for (int sweep = 0; sweep < SWEEPS; sweep++)
        for (pc_index i = 0; i < f->loose_count; i++) {
            pc_index v = f->loose[sweep % 2 ? f->loose_count - 1 - i : i];
            pc_vec3 q = pc_vec3_at(f->image, v);
            pc_vec3_put(f->image, v, pc_madd(q, beyond, pc_sub(mean_around(f, v), q)));
        }
}

/* From the fixed ones inwards, each loose vertex walks from the place of a neighbour to the point of the
 * surface nearest to the membrane. */
static void lay_membrane(following *f) {
    uint8_t *waits = f->is_loose; /* 1: waits, 2: laid */
    for (bool more = true; more;) {
        more = false;
        for (pc_index i = 0; i < f->loose_count; i++) {
            pc_index v = f->loose[i], first = f->adjacency->vertex_half[v], h = first, from = PC_NONE;
            if (waits[v] != 1) continue;
            do {
                pc_index w = f->mesh->triangle[pc_next(h)];
                if (waits[w] != 1 && f->c->spot[w].face != PC_NONE) from = w;
                h = pc_turn_ccw(f->adjacency, h);
            } while (from == PC_NONE && h != first && h != PC_NONE);
            if (from == PC_NONE) continue;
            pc_surface_place place = pc_correspondence_place(f->c, f->spline, from);
            put_place(f, v, pc_nearest_from(f->spline, place, pc_vec3_at(f->image, v)).place);
            waits[v] = 2;
            more = true;
        }
    }
    for (pc_index i = 0; i < f->loose_count; i++)
        waits[f->loose[i]] = 1;
}

/* Places move to the point nearest to the mean of those around them. */
static void spread(following *f, int sweeps) {
    for (int sweep = 0; sweep < sweeps; sweep++) {
#pragma omp parallel for schedule(static)
        for (pc_index i = 0; i < f->loose_count; i++) {
            pc_index v = f->loose[i];
            f->next[i] =
                pc_nearest_from(f->spline, pc_correspondence_place(f->c, f->spline, v), mean_around(f, v))
                    .place;
        }
#pragma omp parallel for schedule(static)
        for (pc_index i = 0; i < f->loose_count; i++)
            put_place(f, f->loose[i], f->next[i]);
    }
}

/* Vertices on the wrong sheet: the surface faces the other way there. */
static void mark_opposed(following *f, const double *normal) {
    for (pc_index v = 0; v < f->c->count; v++)
        if (f->c->spot[v].face != PC_NONE && pc_dot(pc_vec3_at(f->normal, v), pc_vec3_at(normal, v)) < 0)
            f->c->torn[v] = 1;
}

/* Torn regions, ever larger ones, are laid anew between what is around them; with `normal` of the scan what
 * is on the wrong sheet too. */
static void mend(following *f, const double *normal) {
    enum { TRIES = 6, SWEEPS = 12 };
    for (int attempt = 0;; attempt++) {
        f->c->torn_triangles = find_torn(f);
        if (attempt == TRIES || (!f->c->torn_triangles && (attempt || !normal))) break;
        if (attempt == 0 && normal) mark_opposed(f, normal);
        gather_loose(f, 2 + 2 * attempt);
        if (normal) {
            stretch_membrane(f);
            lay_membrane(f);
        }
        spread(f, SWEEPS);
    }
}

static pc_status follow(pc_correspondence *c, pc_context *ctx, const pc_tspline *spline,
                        const pc_target *target, const double *normal) {
    pc_status status = PC_OK;
    following f = {.c = c, .spline = spline, .mesh = target->mesh, .adjacency = target->adjacency};
    PC_TRY(pc_new(&f.image, ctx, 3 * (size_t)c->count));
    PC_TRY(pc_new(&f.normal, ctx, 3 * (size_t)c->count));
    PC_TRY(pc_new(&f.loose, ctx, c->count));
    PC_TRY(pc_new(&f.is_loose, ctx, c->count));
    PC_TRY(pc_new(&f.next, ctx, c->count));
    approach(&f);
    mend(&f, normal);
done:
    pc_free(ctx, f.image);
    pc_free(ctx, f.normal);
    pc_free(ctx, f.loose);
    pc_free(ctx, f.is_loose);
    pc_free(ctx, f.next);
    return status;
}

pc_status pc_correspondence_follow(pc_correspondence *c, pc_context *ctx, const pc_tspline *spline,
                                   const pc_target *target) {
    return follow(c, ctx, spline, target, NULL);
}

static pc_status find_nearest(pc_correspondence *c, pc_context *ctx, const pc_target *target,
                              const pc_facets *facets) {
    pc_bvh_hit *hits = NULL;
    pc_status status = pc_new(&hits, ctx, c->count);
    if (status != PC_OK) return status;
    pc_bvh_closest_all(hits, &facets->tree, target->mesh->position, c->count);
    for (pc_index v = 0; v < c->count; v++) {
        c->spot[v].face = PC_NONE;
        if (target->adjacency->vertex_half[v] == PC_NONE || hits[v].face == PC_NONE) continue;
        pc_surface_place place = pc_facets_place(facets, hits[v].face, hits[v].weight);
        c->spot[v] = (pc_spot){facets->basis->element[place.element].face, {place.s, place.t}};
    }
    pc_free(ctx, hits);
    return PC_OK;
}

pc_status pc_correspondence_make(pc_correspondence *c, pc_context *ctx, const pc_tspline *spline,
                                 const pc_target *target, bool flat) {
    enum { PER_SIDE = 4 };
    pc_status status = PC_OK;
    pc_facets facets = {0};
    *c = (pc_correspondence){.count = target->mesh->vertex_count};
    PC_TRY(pc_new(&c->spot, ctx, c->count));
    PC_TRY(pc_new(&c->torn, ctx, c->count));
    PC_TRY(pc_facets_make(&facets, ctx, spline, PER_SIDE, flat));
    PC_TRY(find_nearest(c, ctx, target, &facets));
    PC_TRY(follow(c, ctx, spline, target, target->normal));
done:
    pc_facets_free(&facets, ctx);
    if (status != PC_OK) pc_correspondence_free(c, ctx);
    return status;
}

void pc_correspondence_free(pc_correspondence *c, pc_context *ctx) {
    pc_free(ctx, c->spot);
    pc_free(ctx, c->torn);
    *c = (pc_correspondence){0};
}

/* The part of the old face that holds a point: the one it lies deepest in. */
static pc_index find_part(const pc_tmesh *mesh, const pc_index *part, size_t count, const double at[2]) {
    pc_index best = PC_NONE;
    double least = INFINITY;
    for (size_t i = 0; i < count; i++) {
        const pc_tface *face = mesh->face + part[i];
        double outside = 0;
        for (int k = 0; k < 2; k++)
            outside += fmax(0, fmax(face->origin[k] - at[k], at[k] - face->origin[k] - face->size[k]));
        if (outside < least) least = outside, best = part[i];
    }
    return best;
}

pc_status pc_correspondence_carry(pc_correspondence *c, pc_context *ctx, const pc_tmesh *refined) {
    pc_status status = PC_OK;
    pc_index roots = 0;
    size_t *start = NULL;
    pc_index *part = NULL;
    for (pc_index f = 0; f < refined->face_count; f++)
        if (refined->face[f].root >= roots) roots = refined->face[f].root + 1;
    PC_TRY(pc_new(&start, ctx, (size_t)roots + 2));
    PC_TRY(pc_new(&part, ctx, refined->face_count));
    for (pc_index f = 0; f < refined->face_count; f++)
        start[refined->face[f].root + 2]++;
    for (size_t r = 0; r < roots; r++)
        start[r + 2] += start[r + 1];
    for (pc_index f = 0; f < refined->face_count; f++)
        part[start[refined->face[f].root + 1]++] = f;
    for (pc_index v = 0; v < c->count; v++) {
        if (c->spot[v].face == PC_NONE) continue;
        size_t first = start[c->spot[v].face];
        double *at = c->spot[v].at;
        pc_index f = find_part(refined, part + first, start[c->spot[v].face + 1] - first, at);
        c->spot[v].face = f;
        for (int k = 0; k < 2; k++)
            at[k] -= refined->face[f].origin[k];
    }
done:
    pc_free(ctx, start);
    pc_free(ctx, part);
    return status;
}
