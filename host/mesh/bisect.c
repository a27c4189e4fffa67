#include "bisect.h"
#include "memory.h"
#include "vec3.h"
#include <string.h>

static void put(pc_index *out, pc_index a, pc_index b, pc_index c) {
    out[0] = a, out[1] = b, out[2] = c;
}

/* The convex quad a b c d as two triangles along its shorter diagonal; ties go to a-c. */
static void put_quad(pc_index *out, const double *position, pc_index a, pc_index b, pc_index c, pc_index d) {
    double ac = pc_distance(pc_vec3_at(position, a), pc_vec3_at(position, c));
    double bd = pc_distance(pc_vec3_at(position, b), pc_vec3_at(position, d));
    if (ac <= bd)
        put(out, a, b, c), put(out + 3, a, c, d);
    else
        put(out, a, b, d), put(out + 3, b, c, d);
}

static double side(const double *position, const pc_index *t, int k) {
    return pc_distance(pc_vec3_at(position, t[k]), pc_vec3_at(position, t[(k + 1) % 3]));
}

/* t: the corners, m: the new vertex on the edge that leaves each, or PC_NONE. Returns the number of pieces.
 */
static int cut_face(pc_index *out, const double *position, const pc_index *t, const pc_index *m) {
    int cuts = 0, longest = 0;
    for (int k = 0; k < 3; k++)
        cuts += m[k] != PC_NONE;
    for (int k = 1; k < 3; k++)
        if (side(position, t, k) > side(position, t, longest)) longest = k;
    if (cuts == 0) {
        put(out, t[0], t[1], t[2]);
    } else if (cuts == 1) {
        int k = m[0] != PC_NONE ? 0 : m[1] != PC_NONE ? 1 : 2;
        pc_index a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
        put(out, a, m[k], c), put(out + 3, m[k], b, c);
    } else if (cuts == 2) {
        int k = m[0] == PC_NONE ? 0 : m[1] == PC_NONE ? 1 : 2; /* the edge a-b that stays */
        pc_index a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
        pc_index mb = m[(k + 1) % 3], mc = m[(k + 2) % 3];
        put_quad(out, position, a, b, mb, mc), put(out + 6, mb, c, mc);
    } else { /* two corners at the longest edge, and the quad between them and the third corner */
        int k = longest;
        pc_index a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
        pc_index ma = m[k], mb = m[(k + 1) % 3], mc = m[(k + 2) % 3];
        put(out, a, ma, mc), put(out + 3, ma, b, mb), put_quad(out + 6, position, mc, ma, mb, c);
    }
    return cuts + 1;
}

static void place_midpoints(pc_mesh *out, const pc_mesh *in, const pc_index *parent,
                            size_t new_vertex_count) {
    memcpy(out->position, in->position, 3 * sizeof(double) * (size_t)in->vertex_count);
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < new_vertex_count; i++) {
        pc_vec3 a = pc_vec3_at(in->position, parent[2 * i]), b = pc_vec3_at(in->position, parent[2 * i + 1]);
        pc_vec3_put(out->position, in->vertex_count + i, pc_add(pc_scale(0.5, a), pc_scale(0.5, b)));
    }
}

pc_status pc_bisect_edges(pc_mesh *out, pc_index **face_source, pc_context *ctx, const pc_mesh *in,
                          const pc_index *midpoint, const pc_index *parent, size_t new_vertex_count) {
    pc_status status = PC_OK;
    size_t *start = NULL;
    *out = (pc_mesh){0};
    if (face_source) *face_source = NULL;
    PC_TRY(pc_new(&start, ctx, (size_t)in->face_count + 1));
    for (size_t f = 0; f < in->face_count; f++) {
        const pc_index *m = midpoint + 3 * f;
        start[f + 1] = start[f] + 1 + (m[0] != PC_NONE) + (m[1] != PC_NONE) + (m[2] != PC_NONE);
    }
    PC_TRY(pc_mesh_make(out, ctx, in->vertex_count + new_vertex_count, start[in->face_count]));
    if (face_source) PC_TRY(pc_new(face_source, ctx, start[in->face_count]));
    place_midpoints(out, in, parent, new_vertex_count);
#pragma omp parallel for schedule(static)
    for (size_t f = 0; f < in->face_count; f++) {
        pc_index m[3];
        for (int k = 0; k < 3; k++)
            m[k] = midpoint[3 * f + (size_t)k] == PC_NONE ? PC_NONE
                                                          : in->vertex_count + midpoint[3 * f + (size_t)k];
        int pieces = cut_face(out->triangle + 3 * start[f], out->position, in->triangle + 3 * f, m);
        for (int i = 0; face_source && i < pieces; i++)
            (*face_source)[start[f] + (size_t)i] = (pc_index)f;
    }
done:
    pc_free(ctx, start);
    if (status != PC_OK) {
        pc_mesh_free(out, ctx);
        if (face_source) pc_free(ctx, *face_source), *face_source = NULL;
    }
    return status;
}
