#include "tsplit.h"

void pc_tsplit_start(pc_tmesh *mesh) {
    for (pc_index f = 0; f < mesh->face_count; f++) {
        mesh->face[f].root = f;
        mesh->face[f].origin[0] = mesh->face[f].origin[1] = 0;
    }
}

/* Cuts half-edge h, and its twin, x behind its tail; returns the part of h that leaves the new vertex. */
static pc_index cut_edge(pc_tmesh *mesh, pc_index h, double x) {
    pc_index v = mesh->vertex_count++, n = mesh->half_count++, m = mesh->half_count++;
    pc_thalf *e = mesh->half + h, *t = mesh->half + e->twin;
    pc_index back = e->twin;
    double rest = e->interval - x;
    mesh->half[n] = *e;
    mesh->half[n].tail = v;
    mesh->half[n].prev = h;
    mesh->half[n].interval = rest;
    mesh->half[n].along = e->along + x;
    mesh->half[m] = *t;
    mesh->half[m].tail = v;
    mesh->half[m].prev = back;
    mesh->half[m].interval = x;
    mesh->half[m].along = t->along + rest;
    mesh->half[e->next].prev = n;
    mesh->half[t->next].prev = m;
    e->next = n, e->interval = x, e->twin = m;
    t->next = m, t->interval = rest, t->twin = n;
    mesh->half[m].twin = h;
    mesh->half[n].twin = back;
    mesh->vertex[v] = (pc_tvertex){.out = e->face == PC_NONE ? m : n};
    return n;
}

/* The half-edge of face f that leaves the point `along` of a side; cut where there is no vertex. */
static pc_index leave_at(pc_tmesh *mesh, pc_index f, int side, double along) {
    pc_index h = mesh->face[f].first;
    while (mesh->half[h].side != side || mesh->half[h].along + mesh->half[h].interval <= along)
        h = mesh->half[h].next;
    if (mesh->half[h].along == along) return h;
    return cut_edge(mesh, h, along - mesh->half[h].along);
}

static inline void link_halves(pc_tmesh *mesh, pc_index a, pc_index b) {
    mesh->half[a].next = b;
    mesh->half[b].prev = a;
}

pc_status pc_tsplit_face(pc_tmesh *mesh, pc_context *ctx, pc_index f, int direction, double at) {
    pc_status status = pc_tmesh_reserve(mesh, ctx, 2, 6, 1);
    if (status != PC_OK) return status;
    double opposite = mesh->face[f].size[direction] - at;
    pc_index a = leave_at(mesh, f, direction, at);
    pc_index b = leave_at(mesh, f, direction + 2, opposite);
    pc_index p = mesh->half_count++, q = mesh->half_count++, g = mesh->face_count++;
    double length = mesh->face[f].size[1 - direction];
    pc_index before_a = mesh->half[a].prev, before_b = mesh->half[b].prev;
    mesh->half[p] = (pc_thalf){.tail = mesh->half[a].tail, .twin = q, .interval = length, .face = f};
    mesh->half[q] = (pc_thalf){.tail = mesh->half[b].tail, .twin = p, .interval = length, .face = g};
    link_halves(mesh, before_a, p);
    link_halves(mesh, p, b);
    link_halves(mesh, before_b, q);
    link_halves(mesh, q, a);
    mesh->half[a].along = mesh->half[b].along = 0;
    mesh->face[g] = mesh->face[f];
    mesh->face[g].first = direction == 0 ? a : q;
    mesh->face[g].origin[direction] += at;
    pc_tmesh_measure(mesh, f);
    pc_tmesh_measure(mesh, g);
    return PC_OK;
}

pc_status pc_tsplit_face_in_four(pc_tmesh *mesh, pc_context *ctx, pc_index f) {
    pc_status status = PC_OK;
    double half = mesh->face[f].size[1] / 2;
    PC_TRY(pc_tsplit_face(mesh, ctx, f, 0, mesh->face[f].size[0] / 2));
    PC_TRY(pc_tsplit_face(mesh, ctx, f, 1, half));
    PC_TRY(pc_tsplit_face(mesh, ctx, mesh->face_count - 2, 1, half));
done:
    return status;
}
