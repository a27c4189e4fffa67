#include "nearest.h"
#include "geometry.h"
#include "memory.h"
#include <string.h>

/* The bilinear interpolation of the four corners of the element's face. */
static pc_vec3 flat_point(const pc_tspline *spline, const pc_element *element, double s, double t) {
    const pc_tmesh *mesh = &spline->mesh;
    const pc_tface *face = mesh->face + element->face;
    double u = s / face->size[0], v = t / face->size[1];
    const double share[4] = {(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v};
    pc_vec3 p = {0, 0, 0};
    pc_index corner[4];
    pc_tface_corners(corner, mesh, element->face);
    for (int k = 0; k < 4; k++)
        p = pc_madd(p, share[k], pc_vec3_at(spline->position, corner[k]));
    return p;
}

/* Of the first `count` elements, or of those in facets->element. */
static pc_status make_facets(pc_facets *facets, pc_context *ctx, const pc_tspline *spline, pc_index count,
                             bool flat) {
    pc_status status = PC_OK;
    const int per_side = facets->per_side;
    const pc_index n = (pc_index)per_side, row = n + 1;
    PC_TRY(pc_mesh_make(&facets->mesh, ctx, (size_t)count * row * row, 2 * (size_t)count * n * n));
#pragma omp parallel for schedule(static)
    for (pc_index place = 0; place < count; place++) {
        const pc_index e = facets->element ? facets->element[place] : place;
        const pc_element *element = spline->basis.element + e;
        pc_index *corner = facets->mesh.triangle + 6 * (size_t)place * n * n;
        pc_index first = place * row * row;
        for (pc_index i = 0; i < row * row; i++) {
            const pc_index column = i % row, line = i / row;
            double s = element->low[0] + (element->high[0] - element->low[0]) * column / per_side;
            double t = element->low[1] + (element->high[1] - element->low[1]) * line / per_side;
            pc_vec3 p = flat ? flat_point(spline, element, s, t)
                             : pc_tspline_point(spline, (pc_surface_place){e, s, t});
            pc_vec3_put(facets->mesh.position, first + i, p);
        }
        for (pc_index i = 0; i < n * n; i++) {
            pc_index at = first + i / n * row + i % n;
            const pc_index square[6] = {at, at + 1, at + row, at + row + 1, at + row, at + 1};
            for (int k = 0; k < 6; k++)
                *corner++ = square[k];
        }
    }
    PC_TRY(pc_bvh_make(&facets->tree, ctx, &facets->mesh));
done:
    if (status != PC_OK) pc_facets_free(facets, ctx);
    return status;
}

pc_status pc_facets_make(pc_facets *facets, pc_context *ctx, const pc_tspline *spline, int per_side,
                         bool flat) {
    *facets = (pc_facets){.per_side = per_side, .basis = &spline->basis};
    return make_facets(facets, ctx, spline, spline->basis.element_count, flat);
}

/* The middle of a box around the element's Bezier points, and with that half its diagonal. */
static pc_vec3 element_middle(double *radius, const pc_tspline *spline, pc_index e) {
    const pc_box box = pc_box_of(spline->bezier + 48 * (size_t)e, 16);
    *radius = pc_box_diagonal(box) / 2;
    return pc_scale(0.5, pc_add(box.low, box.high));
}

pc_status pc_facets_make_near(pc_facets *facets, pc_context *ctx, const pc_tspline *spline, int per_side,
                              const double *points, size_t count, double reach) {
    pc_status status = PC_OK;
    const pc_index elements = spline->basis.element_count;
    pc_mesh dots = {0}; /* the points, as triangles without extent */
    pc_bvh tree = {0};
    uint8_t *near = NULL;
    pc_index chosen = 0;
    *facets = (pc_facets){.per_side = per_side, .basis = &spline->basis};
    PC_TRY(pc_mesh_make(&dots, ctx, count, count));
    memcpy(dots.position, points, 3 * count * sizeof *points);
    for (size_t i = 0; i < 3 * count; i++)
        dots.triangle[i] = (pc_index)(i / 3);
    PC_TRY(pc_bvh_make(&tree, ctx, &dots));
    PC_TRY(pc_new(&near, ctx, elements));
    PC_TRY(pc_new(&facets->element, ctx, elements));
#pragma omp parallel for schedule(dynamic, 256)
    for (pc_index e = 0; e < elements; e++) {
        double radius;
        const pc_vec3 middle = element_middle(&radius, spline, e);
        near[e] = pc_bvh_closest(&tree, middle, PC_NONE).distance <= reach + radius;
    }
    for (pc_index e = 0; e < elements; e++)
        if (near[e]) facets->element[chosen++] = e;
    PC_TRY(make_facets(facets, ctx, spline, chosen, false));
done:
    pc_free(ctx, near);
    pc_bvh_free(&tree, ctx);
    pc_mesh_free(&dots, ctx);
    if (status != PC_OK) pc_facets_free(facets, ctx);
    return status;
}

void pc_facets_free(pc_facets *facets, pc_context *ctx) {
    pc_free(ctx, facets->element), facets->element = NULL;
    pc_bvh_free(&facets->tree, ctx);
    pc_mesh_free(&facets->mesh, ctx);
}

pc_surface_place pc_facets_place(const pc_facets *facets, pc_index triangle, const double weight[3]) {
    pc_index n = (pc_index)facets->per_side, e = triangle / (2 * n * n), square = triangle / 2 % (n * n);
    if (facets->element) e = facets->element[e];
    bool upper = triangle % 2;
    double u = upper ? 1 - weight[1] : weight[1], v = upper ? 1 - weight[2] : weight[2];
    const pc_index column = square % n, line = square / n;
    double s = (column + u) / n, t = (line + v) / n;
    return pc_element_place(facets->basis, e, s, t);
}

/* Newton's step for the distance; where its matrix bends the wrong way that of Gauss and Newton. A parameter
 * that is `locked` (0 or 1, else -1) stays. */
static void newton_step(double step[2], const pc_surface_point *x, pc_vec3 target, int locked) {
    pc_vec3 r = pc_sub(x->p, target);
    double gs = pc_dot(r, x->s), gt = pc_dot(r, x->t);
    double e = pc_dot(x->s, x->s), f = pc_dot(x->s, x->t), g = pc_dot(x->t, x->t);
    double a = e + pc_dot(r, x->ss), b = f + pc_dot(r, x->st), c = g + pc_dot(r, x->tt);
    if (!(a > 0.1 * e && c > 0.1 * g && a * c - b * b > 0.1 * (e * g - f * f))) a = e, b = f, c = g;
    double det = a * c - b * b;
    step[0] = step[1] = 0;
    if (locked == 0 && c > 0) step[1] = -gt / c;
    if (locked == 1 && a > 0) step[0] = -gs / a;
    if (locked >= 0 || !(det > 1e-12 * a * c)) return;
    step[0] = -(c * gs - b * gt) / det;
    step[1] = -(a * gt - b * gs) / det;
}

/* Goes from the place along the step as far as the element reaches; returns the side it stops at, or -1. */
static int advance(pc_surface_place *place, const pc_element *e, const double step[2]) {
    double part = 1;
    int side = -1;
    const double from[2] = {place->s, place->t};
    for (int k = 0; k < 2; k++) {
        double room = step[k] > 0 ? e->high[k] - from[k] : from[k] - e->low[k];
        if (room < part * fabs(step[k])) {
            part = room > 0 ? room / fabs(step[k]) : 0;
            side = k == 0 ? (step[k] > 0 ? 1 : 3) : (step[k] > 0 ? 2 : 0);
        }
    }
    place->s = from[0] + part * step[0];
    place->t = from[1] + part * step[1];
    if (side == 1 || side == 3) place->s = side == 1 ? e->high[0] : e->low[0];
    if (side == 0 || side == 2) place->t = side == 2 ? e->high[1] : e->low[1];
    return side;
}

pc_nearest pc_nearest_from(const pc_tspline *spline, pc_surface_place place, pc_vec3 target) {
    enum { MOST_STEPS = 12 };
    const double fine = 1e-7,
                 last = 1e-5; /* of the element: no step, and one after which the next is nothing */
    pc_surface_point x = pc_tspline_evaluate(spline, place);
    pc_nearest best = {.place = place, .point = x.p, .distance = pc_distance(x.p, target)};
    double damping = 1;
    int locked = -1;
    for (int i = 0; i < MOST_STEPS && damping > 0.1; i++) {
        double step[2];
        const pc_element *e = spline->basis.element + best.place.element;
        newton_step(step, &x, target, locked);
        step[0] *= damping, step[1] *= damping;
        const double part =
            (fabs(step[0]) + fabs(step[1])) / (e->high[0] - e->low[0] + e->high[1] - e->low[1]);
        if (part < fine) break;
        place = best.place;
        const int side = advance(&place, e, step);
        const bool stays = place.s == best.place.s && place.t == best.place.t;
        const pc_surface_point y = pc_tspline_evaluate(spline, place);
        const double distance = pc_distance(y.p, target);
        if (!stays && !(distance < best.distance)) {
            damping /= 2;
            continue;
        }
        x = y;
        best.place = place, best.point = y.p, best.distance = fmin(distance, best.distance);
        pc_surface_place beyond;
        if (side >= 0 && pc_tspline_cross(&beyond, spline, place, side)) {
            best.place = beyond;
            locked = -1;
            x = pc_tspline_evaluate(spline, beyond);
        } else if (side >= 0) { /* along the border of the surface */
            if (locked >= 0) break;
            locked = side == 1 || side == 3 ? 0 : 1;
        } else if (part < last) {
            break;
        }
    }
    return best;
}

void pc_nearest_all(pc_nearest *nearest, const pc_tspline *spline, const pc_facets *facets,
                    const double *points, size_t count) {
    enum { CHUNK = 128 };
    size_t chunks = (count + CHUNK - 1) / CHUNK;
#pragma omp parallel for schedule(dynamic, 4)
    for (size_t c = 0; c < chunks; c++) {
        pc_index hint = PC_NONE;
        for (size_t i = c * CHUNK; i < (c + 1) * CHUNK && i < count; i++) {
            pc_vec3 p = pc_vec3_at(points, i);
            pc_bvh_hit hit = pc_bvh_closest(&facets->tree, p, hint);
            hint = hit.face;
            nearest[i] = (pc_nearest){.place = {PC_NONE, 0, 0}, .distance = INFINITY};
            if (hit.face != PC_NONE)
                nearest[i] = pc_nearest_from(spline, pc_facets_place(facets, hit.face, hit.weight), p);
        }
    }
}
