#include "walk.h"

typedef struct walk {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    pc_vec3 point;
    double best2;
    pc_index face;
    double weight[3];
} walk;

/* Takes face f if it is nearer. */
static bool try_face(walk *w, pc_index f) {
    const pc_index *t = w->mesh->triangle + 3 * (size_t)f;
    const double *p = w->mesh->position;
    double weight[3];
    const double d2 = pc_closest_on_triangle(weight, w->point, pc_vec3_at(p, t[0]), pc_vec3_at(p, t[1]),
                                             pc_vec3_at(p, t[2]));
    if (!(d2 < w->best2)) return false;
    w->best2 = d2, w->face = f;
    for (int k = 0; k < 3; k++)
        w->weight[k] = weight[k];
    return true;
}

/* All faces around a vertex. */
static bool try_around(walk *w, pc_index vertex) {
    const pc_index first = w->adjacency->vertex_half[vertex];
    bool nearer = false;
    pc_index h = first;
    do {
        nearer |= try_face(w, h / 3);
        h = pc_turn_ccw(w->adjacency, h);
    } while (h != PC_NONE && h != first);
    return nearer;
}

/* Where the nearest point is on an edge or a vertex: the faces beyond. */
static bool try_neighbours(walk *w) {
    const pc_index f = w->face;
    double weight[3];
    for (int k = 0; k < 3; k++)
        weight[k] = w->weight[k];
    for (pc_index k = 0; k < 3; k++)
        if (weight[k] >= 1) return try_around(w, w->mesh->triangle[3 * (size_t)f + k]);
    for (pc_index k = 0; k < 3; k++) {
        const pc_index twin = w->adjacency->twin[3 * f + (k + 1) % 3];
        if (weight[k] <= 0 && twin != PC_NONE) return try_face(w, twin / 3);
    }
    return false;
}

pc_bvh_hit pc_walk_closest(const pc_mesh *mesh, const pc_adjacency *adjacency, pc_vec3 point, pc_index from) {
    walk w = {mesh, adjacency, point, INFINITY, PC_NONE, {0}};
    pc_bvh_hit hit = {.face = PC_NONE, .distance = INFINITY, .point = point};
    if (from == PC_NONE) return hit;
    if (try_face(&w, from))
        while (try_neighbours(&w)) {
        }
    if (w.face == PC_NONE) return hit;
    const pc_index *t = mesh->triangle + 3 * (size_t)w.face;
    pc_vec3 sum = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        sum = pc_madd(sum, w.weight[k], pc_vec3_at(mesh->position, t[k]));
        hit.weight[k] = w.weight[k];
    }
    hit.point = sum, hit.face = w.face, hit.distance = sqrt(w.best2);
    return hit;
}
