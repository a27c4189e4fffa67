/* Of the N directions that a field has at a vertex one stands for all. Chosen alike across nearly all edges,
 * few couplings turn from one direction to another, which suits branch prediction in everything that runs
 * over them. */
#ifndef PC_COMB_H
#define PC_COMB_H

#include "connection.h"

/* Turns angle[v] by multiples of 2 pi / symmetry, breadth first from the first vertex of each component. */
pc_status pc_comb_angles(double *angle, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency,
                         const pc_connection *connection, int symmetry);

#endif
