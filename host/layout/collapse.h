/* Takes quads out of a mesh by drawing two opposite corners together. */
#ifndef PC_COLLAPSE_H
#define PC_COLLAPSE_H

#include "polymesh.h"

/* Collapses quads with wanted[f] != 0 that are apart from each other, where the mesh stays manifold: each
 * takes one face, one vertex and two edges, so that the Euler number stays. Of the two diagonals the one that
 * leaves valences closer to four. Unused vertices are dropped; `*collapsed` counts. */
pc_status pc_quads_collapse(pc_polymesh *quads, pc_index *collapsed, pc_context *ctx, const uint8_t *wanted);

#endif
