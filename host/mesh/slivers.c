#include "slivers.h"
#include "memory.h"
#include "vec3.h"
#include <string.h>

/* Exactly collinear in the arithmetic that everything later uses. */
static bool zero_area(const pc_mesh *mesh, pc_index a, pc_index b, pc_index c) {
    pc_vec3 p = pc_vec3_at(mesh->position, a);
    pc_vec3 normal =
        pc_cross(pc_sub(pc_vec3_at(mesh->position, b), p), pc_sub(pc_vec3_at(mesh->position, c), p));
    return normal.x == 0 && normal.y == 0 && normal.z == 0;
}

static bool zero_face(const pc_mesh *mesh, pc_index f) {
    const pc_index *t = mesh->triangle + 3 * (size_t)f;
    return zero_area(mesh, t[0], t[1], t[2]);
}

static pc_index longest_half(const pc_mesh *mesh, pc_index f) {
    double best = -1;
    pc_index longest = 3 * f;
    for (pc_index h = 3 * f; h < 3 * f + 3; h++) {
        double length = pc_distance(pc_vec3_at(mesh->position, pc_tail(mesh, h)),
                                    pc_vec3_at(mesh->position, pc_head(mesh, h)));
        if (length > best) best = length, longest = h;
    }
    return longest;
}

/* Is there an edge from the tail of `out` to vertex `d`? Looks round its whole fan; *inside: the fan is
 * closed. */
static bool reaches(const pc_mesh *mesh, const pc_adjacency *a, pc_index out, pc_index d, bool *inside) {
    pc_index h = out;
    *inside = true;
    do {
        if (pc_head(mesh, h) == d || pc_tail(mesh, pc_prev(h)) == d) return true;
        h = pc_turn_ccw(a, h);
    } while (h != PC_NONE && h != out);
    if (h == out) return false;
    *inside = false;
    for (h = pc_turn_cw(a, out); h != PC_NONE; h = pc_turn_cw(a, h))
        if (pc_head(mesh, h) == d || pc_tail(mesh, pc_prev(h)) == d) return true;
    return false;
}

static void link_halves(pc_adjacency *a, pc_index h, pc_index g) {
    a->twin[h] = g;
    if (g != PC_NONE) a->twin[g] = h;
}

/* c->a is the longest edge `h` of face a b c; beyond it lies a c d. They become a b d and b c d. */
static void flip(pc_mesh *mesh, pc_adjacency *a, pc_index h) {
    pc_index g = a->twin[h], f = h / 3 * 3, e = g / 3 * 3;
    pc_index ab = a->twin[pc_next(h)], bc = a->twin[pc_prev(h)];
    pc_index cd = a->twin[pc_next(g)], da = a->twin[pc_prev(g)];
    pc_index va = pc_head(mesh, h), vb = pc_tail(mesh, pc_prev(h)), vc = pc_tail(mesh, h);
    pc_index vd = pc_tail(mesh, pc_prev(g));
    const pc_index faces[6] = {va, vb, vd, vb, vc, vd};
    memcpy(mesh->triangle + f, faces, 3 * sizeof *faces);
    memcpy(mesh->triangle + e, faces + 3, 3 * sizeof *faces);
    link_halves(a, f, ab), link_halves(a, f + 1, e + 2), link_halves(a, f + 2, da);
    link_halves(a, e, bc), link_halves(a, e + 1, cd);
}

typedef enum cure { LEFT_ALONE, FLIPPED, DROPPED } cure;

static cure try_cure(pc_mesh *mesh, pc_adjacency *a, pc_index f) {
    pc_index h = longest_half(mesh, f), g = a->twin[h], middle = pc_prev(h);
    pc_index va = pc_head(mesh, h), vb = pc_tail(mesh, middle), vc = pc_tail(mesh, h), vd;
    bool inside;
    if (g == PC_NONE) {
        if (reaches(mesh, a, middle, PC_NONE, &inside) || !inside) return LEFT_ALONE;
        for (pc_index k = 3 * f; k < 3 * f + 3; k++) {
            if (a->twin[k] != PC_NONE) a->twin[a->twin[k]] = PC_NONE;
            a->twin[k] = PC_NONE;
        }
        return DROPPED;
    }
    vd = pc_tail(mesh, pc_prev(g));
    if (vd == vb || zero_area(mesh, va, vb, vd) || zero_area(mesh, vb, vc, vd)) return LEFT_ALONE;
    if (reaches(mesh, a, middle, vd, &inside)) return LEFT_ALONE;
    flip(mesh, a, h);
    return FLIPPED;
}

static void remove_faces(pc_mesh *mesh, pc_index *face_source, const uint8_t *dropped) {
    pc_index kept = 0;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        if (dropped[f]) continue;
        memmove(mesh->triangle + 3 * (size_t)kept, mesh->triangle + 3 * (size_t)f, 3 * sizeof(pc_index));
        face_source[kept++] = face_source[f];
    }
    mesh->face_count = kept;
}

/* A cure may make its neighbours curable, so rounds until nothing changes. */
static pc_index cure_all(pc_mesh *mesh, pc_adjacency *a, pc_index *list, pc_index count,
                         pc_index *face_source, uint8_t *dropped) {
    pc_index left = count, dropped_count = 0;
    for (bool progress = true; progress && left;) {
        pc_index still = 0;
        progress = false;
        for (pc_index i = 0; i < left; i++) {
            pc_index f = list[i], g = a->twin[longest_half(mesh, f)];
            if (dropped[f] || !zero_face(mesh, f)) continue;
            cure done = try_cure(mesh, a, f);
            if (done == LEFT_ALONE) {
                list[still++] = f;
                continue;
            }
            progress = true;
            if (done == FLIPPED) face_source[f] = face_source[g / 3];
            if (done == DROPPED) dropped[f] = 1, dropped_count++;
        }
        left = still;
    }
    if (dropped_count) remove_faces(mesh, face_source, dropped);
    return count - left;
}

pc_status pc_slivers_cure(pc_sliver_count *count, uint8_t *zero, pc_context *ctx, pc_mesh *mesh,
                          pc_index *face_source) {
    pc_status status = PC_OK;
    pc_adjacency adjacency = {0};
    pc_index *list = NULL, filled = 0;
    uint8_t *dropped = NULL;
    *count = (pc_sliver_count){0};
    for (pc_index f = 0; f < mesh->face_count; f++) {
        bool found = zero_face(mesh, f);
        count->found += found;
        if (zero) zero[f] = found;
    }
    if (!count->found) return PC_OK;
    PC_TRY(pc_adjacency_make(&adjacency, ctx, mesh));
    PC_TRY(pc_new(&list, ctx, count->found));
    PC_TRY(pc_new(&dropped, ctx, mesh->face_count));
    for (pc_index f = 0; f < mesh->face_count; f++)
        if (zero_face(mesh, f)) list[filled++] = f;
    count->cured = cure_all(mesh, &adjacency, list, filled, face_source, dropped);
done:
    pc_adjacency_free(&adjacency, ctx);
    pc_free(ctx, list);
    pc_free(ctx, dropped);
    return status;
}
