#include "insertion.h"
#include "cubic.h"
#include "memory.h"
#include "support.h"
#include <string.h>

/* How far the nearest point of the face is from the vertex, in sizes of the face. */
static double distance_to(const pc_footprint *print, const pc_tface *face) {
    double s = print->s[2], t = print->t[2];
    double ds = fmax(0, fmax(-s, s - face->size[0])) / face->size[0];
    double dt = fmax(0, fmax(-t, t - face->size[1])) / face->size[1];
    return ds + dt;
}

/* A point inside of the face near the vertex, so near that no line is between. */
static double inside(double knot, double size) {
    const double margin = 1e-6;
    return fmin(fmax(knot, margin * size), (1 - margin) * size);
}

/* The control point of the function with these knots. */
static pc_vec3 blossom_at(const pc_tspline *old, const pc_tface *face, const pc_footprint *print) {
    const double *o = face->origin;
    double s[3], t[3], ws[4], wt[4];
    pc_index e = pc_basis_find(&old->basis, face->root, o[0] + inside(print->s[2], face->size[0]),
                               o[1] + inside(print->t[2], face->size[1]));
    const pc_element *element = old->basis.element + e;
    for (int k = 0; k < 3; k++) {
        s[k] = print->s[k + 1] + o[0];
        t[k] = print->t[k + 1] + o[1];
    }
    pc_bezier_blossom_weights(ws, element->low[0], element->high[0], s);
    pc_bezier_blossom_weights(wt, element->low[1], element->high[1], t);
    pc_vec3 p = {0, 0, 0};
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++)
            p = pc_madd(p, ws[i] * wt[j], pc_vec3_at(old->bezier, 16 * (size_t)e + (size_t)(i + 4 * j)));
    return p;
}

/* New vertices without influence, outer corners of ghosts: the mean of their neighbours. */
static void place_unused(double *position, const pc_tmesh *mesh, pc_index v) {
    pc_vec3 sum = {0, 0, 0};
    int count = 0;
    pc_index first = mesh->vertex[v].out, h = first;
    do {
        if (pc_thalf_head(mesh, h) < v) {
            sum = pc_add(sum, pc_vec3_at(position, pc_thalf_head(mesh, h)));
            count++;
        }
        h = pc_thalf_ccw(mesh, h);
    } while (h != first);
    pc_vec3_put(position, v, pc_scale(count ? 1.0 / count : 0, sum));
}

static pc_vec3 old_tail(const pc_tspline *old, pc_index h) {
    return pc_vec3_at(old->position, old->mesh.half[h].tail);
}

/* The mean of the four corners of the face of h. */
static pc_vec3 centre_of(const pc_tspline *old, pc_index h) {
    pc_vec3 sum = {0, 0, 0};
    for (int k = 0; k < 4; k++, h = old->mesh.half[h].next)
        sum = pc_add(sum, old_tail(old, h));
    return pc_scale(0.25, sum);
}

/* Catmull and Clark's rule for the old vertex at the tail of h. */
static pc_vec3 corner_rule(const pc_tspline *old, pc_index h) {
    const pc_tmesh *mesh = &old->mesh;
    pc_vec3 sum = {0, 0, 0}, p = old_tail(old, h);
    double n = 0;
    pc_index first = h;
    do {
        sum = pc_add(sum, pc_add(p, old_tail(old, mesh->half[h].twin)));
        sum = pc_add(sum, centre_of(old, h));
        n++;
        h = pc_thalf_ccw(mesh, h);
    } while (h != first);
    return pc_add(pc_scale((n - 3) / n, p), pc_scale(1 / (n * n), sum));
}

/* A vertex under whose function all faces are irregular: it is far from none but extraordinary vertices, so
 * that all intervals around are equal and the rules of Catmull and Clark hold, in the old face that it is a
 * corner, a middle or the centre of. */
static void place_among_irregular(double *position, const pc_tspline *old, const pc_tmesh *mesh, pc_index v) {
    pc_index h = mesh->vertex[v].out;
    const pc_tface *face = mesh->face + mesh->half[h].face;
    const double *size = old->mesh.face[face->root].size;
    double at[2];
    pc_thalf_place(at, mesh, h);
    for (int k = 0; k < 2; k++)
        at[k] = (at[k] + face->origin[k]) / size[k];
    bool inner[2] = {at[0] > 0 && at[0]<1, at[1]> 0 && at[1] < 1};
    int side = inner[0] ? (at[1] > 0 ? 2 : 0) : inner[1] ? (at[0] > 0 ? 1 : 3) : 0;
    if (!inner[0] && !inner[1]) side = at[0] > 0 ? (at[1] > 0 ? 2 : 1) : at[1] > 0 ? 3 : 0;
    pc_index e = old->mesh.face[face->root].first;
    for (int k = 0; k < side; k++)
        e = old->mesh.half[e].next;
    pc_vec3 p;
    if (inner[0] && inner[1]) {
        p = centre_of(old, e);
    } else if (inner[0] || inner[1]) {
        pc_index twin = old->mesh.half[e].twin;
        p = pc_add(pc_add(old_tail(old, e), old_tail(old, twin)),
                   pc_add(centre_of(old, e), centre_of(old, twin)));
        p = pc_scale(0.25, p);
    } else {
        if (face->size[0] == size[0]) return; /* nothing was cut here */
        p = corner_rule(old, e);
    }
    pc_vec3_put(position, v, p);
}

static pc_status place_points(double *position, pc_context *ctx, const pc_tspline *old,
                              const pc_tmesh *mesh) {
    pc_status status = PC_OK;
    pc_support scratch = {0};
    pc_footprints prints = {0};
    memcpy(position, old->position, 3 * sizeof(double) * old->mesh.vertex_count);
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        const pc_footprint *best = NULL;
        double least = INFINITY;
        prints.count = 0;
        PC_TRY(pc_support_append(&prints, &scratch, ctx, mesh, v));
        for (size_t i = 0; i < prints.count; i++) {
            double distance = distance_to(prints.at + i, mesh->face + prints.at[i].face);
            if (distance < least) least = distance, best = prints.at + i;
        }
        if (best)
            pc_vec3_put(position, v, blossom_at(old, mesh->face + best->face, best));
        else if (pc_tface_is_irregular(mesh, mesh->half[mesh->vertex[v].out].face))
            place_among_irregular(position, old, mesh, v);
        else if (v >= old->mesh.vertex_count)
            place_unused(position, mesh, v);
    }
done:
    pc_footprints_free(&prints, ctx);
    pc_support_free(&scratch, ctx);
    return status;
}

pc_status pc_insertion_refine(pc_tspline *spline, pc_closure_stats *stats, pc_context *ctx,
                              const uint8_t *wish) {
    pc_status status = PC_OK;
    pc_tspline finer = {0};
    PC_TRY(pc_tmesh_copy(&finer.mesh, ctx, &spline->mesh));
    PC_TRY(pc_closure_refine(&finer.mesh, stats, ctx, wish));
    PC_TRY(pc_new(&finer.position, ctx, 3 * (size_t)finer.mesh.vertex_count));
    PC_TRY(place_points(finer.position, ctx, spline, &finer.mesh));
    PC_TRY(pc_tspline_complete(&finer, ctx));
    pc_tspline_free(spline, ctx);
    *spline = finer;
    finer = (pc_tspline){0};
done:
    pc_tspline_free(&finer, ctx);
    return status;
}
