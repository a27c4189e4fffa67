/* Ragged borders: where a scanner saw nothing the scan ends in teeth and notches of single triangles, which
 * no smooth surface can follow. Notches are filled, and small ragged holes with them; borders that somebody
 * has made, corners included, stay as they are. */
#ifndef PC_RAGGED_H
#define PC_RAGGED_H

#include "trimesh.h"

typedef struct pc_ragged_stats {
    pc_index faces;  /* added */
    pc_index closed; /* holes that are no more */
} pc_ragged_stats;

/* Adds faces between vertices of the border, behind the others; no vertex, and none of the faces that are
 * there changes. A notch is filled from its bottom up while it is narrower than 150 degrees and four edges of
 * its border. `mesh` is what pc_adjacency_make accepts, and stays so. The same faces for any number of
 * threads. PC_E_NOMEM; PC_E_MESH from pc_adjacency_make. */
pc_status pc_ragged_fill(pc_mesh *mesh, pc_ragged_stats *stats, pc_context *ctx);

#endif
