/* Smooth closed surfaces of any genus, cut out of an implicit function. */
#ifndef PC_SYNTH_BLOB_H
#define PC_SYNTH_BLOB_H

#include "trimesh.h"

/* A chain of `genus` melted rings along x (genus 0: a bumpy ball), each about 3 units wide, on a lattice of
 * `steps` per unit length (at least 6). Closed, one component, Euler number 2 - 2*genus. About 160*steps^2
 * faces per ring. The lattice is cut by marching tetrahedra, whose result is manifold for any function; then
 * the vertices are evened out and drawn back to the surface. */
pc_status pc_synth_blob(pc_mesh *mesh, pc_context *ctx, pc_index genus, pc_index steps);

#endif
