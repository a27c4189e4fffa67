#include "track.h"
#include "memory.h"
#include <string.h>

enum { CHUNK = 128, FACETS_PER_SIDE = 4 };

pc_status pc_track_make(pc_track *track, pc_context *ctx, pc_index count, const double *point,
                        const double *normal) {
    pc_status status = PC_OK;
    *track = (pc_track){.count = count, .point = point, .normal = normal};
    PC_TRY(pc_new(&track->at, ctx, count));
    PC_TRY(pc_new(&track->face, ctx, count));
    PC_TRY(pc_new(&track->facing, ctx, count));
    for (pc_index v = 0; v < count; v++) {
        track->at[v] = (pc_nearest){.place = {PC_NONE, 0, 0}, .distance = INFINITY};
        track->face[v] = PC_NONE;
    }
done:
    if (status != PC_OK) pc_track_free(track, ctx);
    return status;
}

void pc_track_free(pc_track *track, pc_context *ctx) {
    pc_free(ctx, track->at);
    pc_free(ctx, track->face);
    pc_free(ctx, track->facing);
    *track = (pc_track){0};
}

static void put(pc_track *track, pc_index v, const pc_basis *basis, const pc_nearest *found) {
    track->at[v] = *found;
    track->face[v] = basis->element[found->place.element].face;
    track->facing[v] = pc_dot(found->normal, pc_vec3_at(track->normal, v)) > 0;
}

/* The nearest place by way of the facets, or the one that is known already where that is nearer. */
static pc_nearest search(pc_index *hint, const pc_tspline *spline, const pc_facets *facets, pc_vec3 p,
                         const pc_nearest *known) {
    pc_nearest best = *known;
    if (known->place.element != PC_NONE) *hint = pc_facets_triangle(facets, known->place);
    const pc_bvh_hit hit = pc_bvh_closest(&facets->tree, p, *hint);
    *hint = hit.face;
    if (hit.face == PC_NONE) return best;
    const pc_nearest found = pc_nearest_from(spline, pc_facets_place(facets, hit.face, hit.weight), p);
    return found.distance < best.distance ? found : best;
}

static bool is_asked(const pc_track *track, pc_index v, const pc_track_options *options) {
    const pc_index element = track->at[v].place.element;
    return !options->active || element == PC_NONE || options->active[element];
}

static bool is_open(const pc_track *track, pc_index v, const pc_track_options *options) {
    return track->at[v].place.element == PC_NONE || !(track->at[v].distance <= options->enough);
}

/* Newton's method from the known places; counts those that the facets have to look for. */
static size_t follow(pc_track *track, const pc_tspline *spline, const pc_track_options *options) {
    const pc_index chunks = (track->count + CHUNK - 1) / CHUNK;
    size_t open = 0;
#pragma omp parallel for schedule(dynamic, 4) reduction(+ : open)
    for (pc_index c = 0; c < chunks; c++)
        for (pc_index v = c * CHUNK; v < (c + 1) * CHUNK && v < track->count; v++) {
            if (!is_asked(track, v, options)) continue;
            const pc_surface_place place = track->at[v].place;
            if (place.element != PC_NONE) {
                const pc_nearest found = pc_nearest_from(spline, place, pc_vec3_at(track->point, v));
                put(track, v, &spline->basis, &found);
            }
            open += is_open(track, v, options);
        }
    return open;
}

static void look_up(pc_track *track, const pc_tspline *spline, const pc_facets *facets,
                    const pc_track_options *options) {
    const pc_index chunks = (track->count + CHUNK - 1) / CHUNK;
#pragma omp parallel for schedule(dynamic, 4)
    for (pc_index c = 0; c < chunks; c++) {
        pc_index hint = PC_NONE;
        for (pc_index v = c * CHUNK; v < (c + 1) * CHUNK && v < track->count; v++) {
            if (!is_asked(track, v, options) || !is_open(track, v, options)) continue;
            const pc_nearest found =
                search(&hint, spline, facets, pc_vec3_at(track->point, v), &track->at[v]);
            if (found.place.element != PC_NONE) put(track, v, &spline->basis, &found);
        }
    }
}

pc_status pc_track_update(pc_track *track, pc_context *ctx, const pc_tspline *spline,
                          const pc_track_options *options) {
    pc_status status = PC_OK;
    pc_facets facets = {0};
    if (!follow(track, spline, options)) return PC_OK;
    PC_TRY(pc_facets_make(&facets, ctx, spline, FACETS_PER_SIDE, false));
    look_up(track, spline, &facets, options);
done:
    pc_facets_free(&facets, ctx);
    return status;
}

void pc_track_project(pc_track *track, const pc_facets *facets) {
    const pc_index chunks = (track->count + CHUNK - 1) / CHUNK;
#pragma omp parallel for schedule(dynamic, 4)
    for (pc_index c = 0; c < chunks; c++) {
        pc_index hint = PC_NONE;
        for (pc_index v = c * CHUNK; v < (c + 1) * CHUNK && v < track->count; v++) {
            const pc_bvh_hit hit = pc_bvh_closest(&facets->tree, pc_vec3_at(track->point, v), hint);
            hint = hit.face;
            if (hit.face == PC_NONE) continue;
            const pc_index *t = facets->mesh.triangle + 3 * (size_t)hit.face;
            const double *x = facets->mesh.position;
            const pc_vec3 a = pc_vec3_at(x, t[0]), b = pc_vec3_at(x, t[1]), d = pc_vec3_at(x, t[2]);
            const pc_nearest found = {pc_facets_place(facets, hit.face, hit.weight), hit.point, hit.distance,
                                      pc_cross(pc_sub(b, a), pc_sub(d, a))};
            put(track, v, facets->basis, &found);
        }
    }
}

/* The part of the place's old face that it is in, and the place in its frame. */
static void carry(pc_track *track, pc_index v, const pc_tspline *finer, const size_t *start,
                  const pc_index *part) {
    pc_surface_place *place = &track->at[v].place;
    const pc_index root = track->face[v];
    double least = INFINITY;
    pc_index best = PC_NONE;
    for (size_t k = start[root]; k < start[root + 1]; k++) {
        const pc_tface *face = finer->mesh.face + part[k];
        const double s = place->s - face->origin[0], t = place->t - face->origin[1];
        const double outside = fmax(0, fmax(-s, s - face->size[0])) + fmax(0, fmax(-t, t - face->size[1]));
        if (outside < least) least = outside, best = part[k];
    }
    const pc_tface *face = finer->mesh.face + best;
    *place = pc_tspline_place(finer, best, fmin(fmax(place->s - face->origin[0], 0), face->size[0]),
                              fmin(fmax(place->t - face->origin[1], 0), face->size[1]));
    track->face[v] = best;
}

pc_status pc_track_carry(pc_track *track, pc_context *ctx, const pc_tspline *finer) {
    pc_status status = PC_OK;
    const pc_index faces = finer->mesh.face_count;
    size_t *start = NULL;
    pc_index *part = NULL;
    PC_TRY(pc_new(&start, ctx, (size_t)faces + 2)); /* of each old face: its parts */
    PC_TRY(pc_new(&part, ctx, faces));
    for (pc_index f = 0; f < faces; f++)
        start[finer->mesh.face[f].root + 2]++;
    for (pc_index f = 0; f < faces; f++)
        start[f + 2] += start[f + 1];
    for (pc_index f = 0; f < faces; f++)
        part[start[finer->mesh.face[f].root + 1]++] = f;
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < track->count; v++)
        if (track->at[v].place.element != PC_NONE) carry(track, v, finer, start, part);
done:
    pc_free(ctx, start);
    pc_free(ctx, part);
    return status;
}
