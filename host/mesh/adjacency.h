/* Who touches whom on an oriented 2-manifold triangle mesh. */
#ifndef PC_ADJACENCY_H
#define PC_ADJACENCY_H

#include "trimesh.h"

typedef struct pc_adjacency {
    pc_index edge_count;
    pc_index boundary_edge_count;
    pc_index *twin;        /* per half-edge: the opposite one, PC_NONE on a boundary */
    pc_index *edge;        /* per half-edge: its undirected edge; both halves have the same */
    pc_index *edge_half;   /* per edge: its half-edge with the smaller index */
    pc_index *vertex_half; /* per vertex: one outgoing half-edge; at a boundary vertex the one whose twin is
                              missing, so that pc_turn_ccw from it meets the whole fan. PC_NONE if isolated */
    uint8_t *vertex_boundary; /* per vertex: 1 on a boundary */
} pc_adjacency;

/* PC_E_MESH, with the vertices, where more than two faces share an edge, two faces run along an edge in the
 * same direction, or a vertex has more than one fan: pc_repair cures all three. */
pc_status pc_adjacency_make(pc_adjacency *adjacency, pc_context *ctx, const pc_mesh *mesh);
void pc_adjacency_free(pc_adjacency *adjacency, pc_context *ctx);

/* The next outgoing half-edge of the same vertex, counter-clockwise (clockwise); PC_NONE past a boundary. */
static inline pc_index pc_turn_ccw(const pc_adjacency *a, pc_index h) {
    return a->twin[pc_prev(h)];
}
static inline pc_index pc_turn_cw(const pc_adjacency *a, pc_index h) {
    return a->twin[h] == PC_NONE ? PC_NONE : pc_next(a->twin[h]);
}

#endif
