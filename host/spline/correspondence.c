#include "correspondence.h"
#include "memory.h"

pc_surface_place pc_correspondence_place(const pc_correspondence *c, const pc_tspline *spline, pc_index v) {
    if (c->spot[v].face == PC_NONE) return (pc_surface_place){PC_NONE, 0, 0};
    return pc_tspline_place(spline, c->spot[v].face, c->spot[v].at[0], c->spot[v].at[1]);
}

static void put_place(pc_correspondence *c, const pc_tspline *spline, pc_index v, pc_surface_place place) {
    c->spot[v] = (pc_spot){PC_NONE, {0, 0}, 1, false};
    if (place.element == PC_NONE) return;
    c->spot[v] = (pc_spot){spline->basis.element[place.element].face, {place.s, place.t}, 1, false};
}

void pc_correspondence_follow(pc_correspondence *c, const pc_tspline *spline, const pc_target *target,
                              double let_go, const uint8_t *active) {
#pragma omp parallel for schedule(dynamic, 64)
    for (pc_index v = 0; v < c->count; v++) {
        if (c->spot[v].face == PC_NONE || (active && !active[c->spot[v].face])) continue;
        const pc_surface_place place = pc_correspondence_place(c, spline, v);
        const pc_vec3 x = pc_vec3_at(target->mesh->position, v);
        const pc_nearest next = pc_nearest_from(spline, place, x);
        if (c->spot[v].held && !(next.distance < let_go)) continue;
        const float stress = c->spot[v].stress;
        put_place(c, spline, v, next.place);
        c->spot[v].stress = stress;
    }
}

pc_status pc_correspondence_make(pc_correspondence *c, pc_context *ctx, const pc_tspline *spline,
                                 const pc_target *target, const pc_mesh *flat) {
    enum { PER_SIDE = 4 };
    pc_status status = PC_OK;
    pc_facets facets = {0};
    pc_bvh_hit *hits = NULL;
    *c = (pc_correspondence){.count = flat->vertex_count};
    PC_TRY(pc_new(&c->spot, ctx, c->count));
    PC_TRY(pc_new(&hits, ctx, c->count));
    PC_TRY(pc_facets_make(&facets, ctx, spline, PER_SIDE, true));
    pc_bvh_closest_all(hits, &facets.tree, flat->position, c->count);
    for (pc_index v = 0; v < c->count; v++) {
        pc_surface_place place = {PC_NONE, 0, 0};
        if (target->adjacency->vertex_half[v] != PC_NONE && hits[v].face != PC_NONE)
            place = pc_facets_place(&facets, hits[v].face, hits[v].weight);
        put_place(c, spline, v, place);
    }
done:
    pc_free(ctx, hits);
    pc_facets_free(&facets, ctx);
    if (status != PC_OK) pc_correspondence_free(c, ctx);
    return status;
}

void pc_correspondence_free(pc_correspondence *c, pc_context *ctx) {
    pc_free(ctx, c->spot);
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
