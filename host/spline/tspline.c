#include "tspline.h"
#include "closure.h"
#include "cubic.h"
#include "memory.h"
#include "ray.h"
#include "tlayout.h"
#include <string.h>

/* Where the surface would go on: the inner neighbours of a border vertex, mirrored at it. */
static pc_vec3 mirrored(const pc_tspline *spline, pc_index border, pc_index stem) {
    const pc_tmesh *mesh = &spline->mesh;
    pc_vec3 p = pc_vec3_at(spline->position, border), sum = {0, 0, 0};
    pc_ray ray = pc_ray_behind(mesh, stem);
    if (ray.way == PC_RAY_ALONG)
        return pc_sub(pc_scale(2, p), pc_vec3_at(spline->position, pc_thalf_head(mesh, ray.half)));
    int count = 0;
    pc_index h = mesh->vertex[border].out, first = h;
    do { /* an extraordinary border vertex: away from its inner edges */
        if (!mesh->face[mesh->half[h].face].ghost && !mesh->face[mesh->half[mesh->half[h].twin].face].ghost) {
            sum = pc_add(sum, pc_vec3_at(spline->position, pc_thalf_head(mesh, h)));
            count++;
        }
        h = pc_thalf_ccw(mesh, h);
    } while (h != first);
    return count ? pc_sub(pc_scale(2, p), pc_scale(1.0 / count, sum)) : p;
}

static void place_ghosts(pc_tspline *spline, const pc_index *source) {
    const pc_tmesh *mesh = &spline->mesh;
    for (int pass = 0; pass < 2; pass++) /* the outer corners from their neighbours, at last */
        for (pc_index v = 0; v < mesh->vertex_count; v++) {
            pc_index h = mesh->vertex[v].out, inward = pc_thalf_ccw(mesh, h);
            bool corner = mesh->half[inward].face == PC_NONE;
            if (source[v] != PC_NONE || corner != (pass == 1)) continue;
            if (!corner) {
                pc_vec3_put(spline->position, v, mirrored(spline, pc_thalf_head(mesh, inward), inward));
                continue;
            }
            pc_index a = pc_thalf_head(mesh, h), b = pc_thalf_head(mesh, inward);
            pc_index opposite = mesh->half[mesh->half[mesh->half[h].next].next].tail;
            pc_vec3 sum = pc_add(pc_vec3_at(spline->position, a), pc_vec3_at(spline->position, b));
            pc_vec3_put(spline->position, v, pc_sub(sum, pc_vec3_at(spline->position, opposite)));
        }
}

/* The point `along` from the start of a side of face f, on the straight edges between its vertices. */
static pc_vec3 on_side(const pc_tmesh *mesh, const double *position, pc_index f, int side, double along) {
    pc_index h = mesh->face[f].first;
    while (mesh->half[h].side != side || mesh->half[h].along + mesh->half[h].interval < along)
        h = mesh->half[h].next;
    const pc_thalf *e = mesh->half + h;
    pc_vec3 p = pc_vec3_at(position, e->tail), q = pc_vec3_at(position, mesh->half[e->next].tail);
    return pc_madd(p, (along - e->along) / e->interval, pc_sub(q, p));
}

/* Coons: between the sides of the face. */
static pc_vec3 inside_face(const pc_tmesh *mesh, const double *position, pc_index f, const double at[2]) {
    const double *size = mesh->face[f].size;
    const double u = at[0] / size[0], v = at[1] / size[1];
    const double length[4] = {at[0], at[1], size[0] - at[0], size[1] - at[1]};
    const double share[4] = {1 - v, u, v, 1 - u},
                 corner[4] = {(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v};
    pc_vec3 p = {0, 0, 0};
    for (int k = 0; k < 4; k++) {
        p = pc_madd(p, share[k], on_side(mesh, position, f, k, length[k]));
        p = pc_madd(p, -corner[k], on_side(mesh, position, f, k, 0));
    }
    return p;
}

/* Cuts what the basis asks for; new vertices lie where the faces were. */
static pc_status settle(pc_tspline *spline, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_tmesh raw = {0}, *mesh = &spline->mesh;
    pc_closure_stats stats;
    PC_TRY(pc_tmesh_copy(&raw, ctx, mesh));
    PC_TRY(pc_closure_settle(mesh, &stats, ctx));
    PC_TRY(pc_resize(&spline->position, ctx, 3 * (size_t)mesh->vertex_count));
    for (pc_index v = raw.vertex_count; v < mesh->vertex_count; v++) {
        double at[2];
        const pc_tface *face = mesh->face + mesh->half[mesh->vertex[v].out].face;
        pc_thalf_place(at, mesh, mesh->vertex[v].out);
        for (int k = 0; k < 2; k++)
            at[k] += face->origin[k];
        pc_vec3_put(spline->position, v, inside_face(&raw, spline->position, face->root, at));
    }
    pc_log(ctx, PC_LOG_DEBUG, "spline: %u vertices, %u after %u cuts that the basis asks for, %u T-junctions",
           raw.vertex_count, mesh->vertex_count, stats.cuts, stats.junctions);
done:
    pc_tmesh_free(&raw, ctx);
    return status;
}

static pc_status make_plain(pc_tspline *spline, pc_context *ctx, const pc_polymesh *quads,
                            const double *interval, const pc_tmesh_options *options) {
    pc_status status = PC_OK;
    pc_index *source = NULL;
    PC_TRY(pc_tmesh_make(&spline->mesh, &source, ctx, quads, interval, options));
    PC_TRY(pc_new(&spline->position, ctx, 3 * (size_t)spline->mesh.vertex_count));
    for (pc_index v = 0; v < spline->mesh.vertex_count; v++)
        if (source[v] != PC_NONE)
            memcpy(spline->position + 3 * (size_t)v, quads->position + 3 * (size_t)source[v],
                   3 * sizeof(double));
    place_ghosts(spline, source);
done:
    pc_free(ctx, source);
    return status;
}

pc_status pc_tspline_make(pc_tspline *spline, pc_context *ctx, const pc_polymesh *polygons,
                          const pc_tmesh_options *options) {
    pc_status status = PC_OK;
    pc_tlayout layout = {0};
    *spline = (pc_tspline){0};
    if (pc_tlayout_is_plain(polygons)) {
        PC_TRY(make_plain(spline, ctx, polygons, NULL, options));
    } else {
        PC_TRY(pc_tlayout_make(&layout, ctx, polygons));
        PC_TRY(make_plain(spline, ctx, &layout.faces, layout.interval, options));
        PC_TRY(settle(spline, ctx));
    }
    PC_TRY(pc_tspline_complete(spline, ctx));
done:
    pc_tlayout_free(&layout, ctx);
    if (status != PC_OK) pc_tspline_free(spline, ctx);
    return status;
}

pc_status pc_tspline_complete(pc_tspline *spline, pc_context *ctx) {
    pc_status status = PC_OK;
    PC_TRY(pc_basis_make(&spline->basis, ctx, &spline->mesh));
    PC_TRY(pc_new(&spline->bezier, ctx, 48 * (size_t)spline->basis.element_count));
    pc_tspline_update(spline);
done:
    return status;
}

void pc_tspline_free(pc_tspline *spline, pc_context *ctx) {
    pc_tmesh_free(&spline->mesh, ctx);
    pc_basis_free(&spline->basis, ctx);
    pc_free(ctx, spline->position);
    pc_free(ctx, spline->bezier);
    *spline = (pc_tspline){0};
}

pc_status pc_tspline_check(const pc_tspline *spline, pc_basis_facts *facts, pc_context *ctx) {
    pc_status status = pc_tmesh_check(&spline->mesh, ctx);
    return status == PC_OK ? pc_basis_check(&spline->basis, facts, ctx) : status;
}

void pc_tspline_update(pc_tspline *spline) {
    pc_tspline_update_faces(spline, NULL);
}

void pc_tspline_update_faces(pc_tspline *spline, const uint8_t *active) {
#pragma omp parallel for schedule(dynamic, 256)
    for (pc_index e = 0; e < spline->basis.element_count; e++)
        if (!active || active[spline->basis.element[e].face])
            pc_basis_bezier(spline->bezier + 48 * (size_t)e, &spline->basis, e, spline->position);
}

/* Bernstein polynomials in both directions and the sizes of the element. */
typedef struct local {
    double b[2][3][4]; /* direction, derivative, polynomial */
    double size[2];
} local;

static local localise(const pc_tspline *spline, pc_surface_place place) {
    const pc_element *e = spline->basis.element + place.element;
    local l = {.size = {e->high[0] - e->low[0], e->high[1] - e->low[1]}};
    pc_bernstein(l.b[0][0], l.b[0][1], l.b[0][2], (place.s - e->low[0]) / l.size[0]);
    pc_bernstein(l.b[1][0], l.b[1][1], l.b[1][2], (place.t - e->low[1]) / l.size[1]);
    return l;
}

/* sum over j of b[j] * row[j], times `scale`. */
static pc_vec3 sum_rows(double row[4][3], const double b[4], double scale) {
    double p[3];
    for (int k = 0; k < 3; k++)
        p[k] = scale * (b[0] * row[0][k] + b[1] * row[1][k] + b[2] * row[2][k] + b[3] * row[3][k]);
    return (pc_vec3){p[0], p[1], p[2]};
}

pc_surface_point pc_tspline_evaluate(const pc_tspline *spline, pc_surface_place place) {
    const double *bezier = spline->bezier + 48 * (size_t)place.element;
    local l = localise(spline, place);
    double u = 1 / l.size[0], v = 1 / l.size[1];
    double row[3][4][3]; /* derivatives along s on the four rows of Bezier points */
    for (int d = 0; d < 3; d++)
        for (int j = 0; j < 4; j++) {
            const double *b = l.b[0][d], *x = bezier + (size_t)12 * (size_t)j;
            for (int k = 0; k < 3; k++)
                row[d][j][k] = b[0] * x[k] + b[1] * x[3 + k] + b[2] * x[6 + k] + b[3] * x[9 + k];
        }
    return (pc_surface_point){.p = sum_rows(row[0], l.b[1][0], 1),
                              .s = sum_rows(row[1], l.b[1][0], u),
                              .t = sum_rows(row[0], l.b[1][1], v),
                              .ss = sum_rows(row[2], l.b[1][0], u * u),
                              .st = sum_rows(row[1], l.b[1][1], u * v),
                              .tt = sum_rows(row[0], l.b[1][2], v * v)};
}

pc_vec3 pc_tspline_point(const pc_tspline *spline, pc_surface_place place) {
    const double *bezier = spline->bezier + 48 * (size_t)place.element;
    const pc_element *e = spline->basis.element + place.element;
    double s[4], t[4], p[3] = {0, 0, 0};
    pc_bernstein_values(s, (place.s - e->low[0]) / (e->high[0] - e->low[0]));
    pc_bernstein_values(t, (place.t - e->low[1]) / (e->high[1] - e->low[1]));
    for (size_t j = 0; j < 4; j++) {
        const double *x = bezier + 12 * j;
        for (size_t k = 0; k < 3; k++)
            p[k] += t[j] * (s[0] * x[k] + s[1] * x[3 + k] + s[2] * x[6 + k] + s[3] * x[9 + k]);
    }
    return (pc_vec3){p[0], p[1], p[2]};
}

pc_surface_place pc_tspline_place(const pc_tspline *spline, pc_index face, double s, double t) {
    return (pc_surface_place){pc_basis_find(&spline->basis, face, s, t), s, t};
}

/* The element of `face` that holds the point, a little further in than the side it lies on. */
static pc_index element_inside(const pc_tspline *spline, pc_index face, const double at[2], int direction,
                               double by) {
    double inside[2] = {at[0], at[1]};
    inside[direction] += by;
    return pc_basis_find(&spline->basis, face, inside[0], inside[1]);
}

bool pc_tspline_cross(pc_surface_place *beyond, const pc_tspline *spline, pc_surface_place place, int side) {
    const pc_tmesh *mesh = &spline->mesh;
    const pc_element *e = spline->basis.element + place.element;
    const double *size = mesh->face[e->face].size, nudge = 1e-9;
    double at[2] = {place.s, place.t};
    int across = side % 2 == 0, out = side == 1 || side == 2 ? 1 : -1;
    double edge = out > 0 ? e->high[across] : e->low[across];
    at[across] = edge;
    if (edge > 0 && edge < size[across]) {
        *beyond = (pc_surface_place){element_inside(spline, e->face, at, across, out * nudge * size[across]),
                                     at[0], at[1]};
        return true;
    }
    double along = side == 0 ? at[0] : side == 1 ? at[1] : side == 2 ? size[0] - at[0] : size[1] - at[1];
    pc_index h = mesh->face[e->face].first;
    while (mesh->half[h].side != side || mesh->half[h].along + mesh->half[h].interval < along)
        h = mesh->half[h].next;
    const pc_thalf *twin = mesh->half + mesh->half[h].twin;
    if (twin->face == PC_NONE || mesh->face[twin->face].ghost) return false;
    double offset = twin->along + twin->interval - (along - mesh->half[h].along);
    const double *far = mesh->face[twin->face].size;
    at[0] = twin->side == 0 ? offset : twin->side == 1 ? far[0] : twin->side == 2 ? far[0] - offset : 0;
    at[1] = twin->side == 0 ? 0 : twin->side == 1 ? offset : twin->side == 2 ? far[1] : far[1] - offset;
    across = twin->side % 2 == 0, out = twin->side == 1 || twin->side == 2 ? -1 : 1;
    *beyond = (pc_surface_place){element_inside(spline, twin->face, at, across, out * nudge * far[across]),
                                 at[0], at[1]};
    return true;
}
