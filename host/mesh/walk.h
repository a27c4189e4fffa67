/* Nearest points of a triangle mesh by walking over it. */
#ifndef PC_WALK_H
#define PC_WALK_H

#include "adjacency.h"
#include "bvh.h"

/* From face `from` on to ever nearer neighbours, across edges and around vertices: a point that is nearer
 * than all others around it, which far from the mesh need not be the nearest of all. Face PC_NONE for `from`
 * PC_NONE. */
pc_bvh_hit pc_walk_closest(const pc_mesh *mesh, const pc_adjacency *adjacency, pc_vec3 point, pc_index from);

#endif
