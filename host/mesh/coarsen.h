/* Fewer triangles on the vertices that stay: what a scan looks like to something as long as many of its
 * edges. */
#ifndef PC_COARSEN_H
#define PC_COARSEN_H

#include "adjacency.h"

typedef struct pc_coarse {
    pc_mesh mesh;
    pc_index *source; /* per vertex: the vertex of the given mesh that it is; ascending */
    pc_index *into;   /* per vertex of the given mesh: the one here that it was drawn into, itself where it
                         stays;   PC_NONE where no face has it */
} pc_coarse;

/* Half-edge collapses of inner vertices, in passes over independent ones, while that makes no edge longer
 * than `longest` at both its ends (one value per vertex, model units), turns no face far from those it
 * replaces, and leaves the surface what it is: same Euler number, same borders, all vertices of which stay.
 * Of the neighbours that a vertex may be drawn into, the one that makes the best triangles. The same bytes
 * for any number of threads. PC_E_NOMEM, PC_E_INTERRUPT. */
pc_status pc_coarsen(pc_coarse *coarse, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency,
                     const double *longest);
void pc_coarse_free(pc_coarse *coarse, pc_context *ctx);

#endif
