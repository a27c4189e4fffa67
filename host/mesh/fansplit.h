/* Gives every fan of faces its own vertex, so that vertex numbers alone tell which faces are glued. */
#ifndef PC_FANSPLIT_H
#define PC_FANSPLIT_H

#include "trimesh.h"

/* `twin` (per half-edge, opposite direction, or PC_NONE) says how the faces of `mesh` are glued, `wish` (per
 * half-edge) which vertex at that place its tail was before vertices were merged. Rewrites the triangles:
 * each fan of faces around a vertex takes the smallest wish in it that is free, else a new vertex, numbered
 * from mesh->vertex_count on.
 * `*added_source` holds the vertex that each new one stands at (one of the fan's wishes); the caller frees
 * it, and grows mesh->position. */
pc_status pc_fansplit_vertices(pc_index **added_source, pc_index *added_count, pc_context *ctx, pc_mesh *mesh,
                               const pc_index *twin, const pc_index *wish);

/* Half-edges between the same two vertices that are not glued to each other would still be taken for
 * neighbours (after pc_fansplit_vertices this happens where two fans of one vertex pair meet again). All but
 * the first of them need a vertex in the middle. Fills `midpoint` per half-edge (both halves of a pair the
 * same) as pc_bisect_edges wants it, and per new vertex 2 entries of `*parent` (the caller frees it). Two
 * open half-edges of opposite direction that are alone between their vertices are left: they close. */
pc_status pc_fansplit_edges(pc_index *midpoint, pc_index **parent, size_t *added_count, pc_context *ctx,
                            const pc_mesh *mesh, const pc_index *twin);

#endif
