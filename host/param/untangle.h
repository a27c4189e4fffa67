/* Turns flipped triangles back: local averages where the parameter plane folds over. */
#ifndef PC_UNTANGLE_H
#define PC_UNTANGLE_H

#include "adjacency.h"
#include "param.h"

/* Moves the coordinates of vertices around flipped faces, and around cones whose parts are flipped, to the
 * mean of their neighbours' (Tutte 1963: a convex combination cannot fold), in rounds over growing patches.
 * Transitions stay as they are; no move may make an edge jump a period. Flags are brought up to date.
 * Sequential, in vertex order. */
pc_status pc_untangle(pc_param *param, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency);

#endif
