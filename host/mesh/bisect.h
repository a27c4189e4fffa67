/* Cuts triangles at given points on their edges: the one place where faces are split. */
#ifndef PC_BISECT_H
#define PC_BISECT_H

#include "trimesh.h"

/* `midpoint` is per half-edge of `in`: the new vertex on it, counted from 0, or PC_NONE. Both halves of an
 * edge that stays closed name the same one; halves that name different ones come apart. New vertex i stands
 * halfway between `parent[2i]` and `parent[2i+1]` and gets the number in->vertex_count + i; old vertices keep
 * theirs. The pieces of a face follow each other in face order. `face_source` (the face in `in` of each new
 * face) may be NULL, else it is made here and the caller frees it with pc_free. A face cut on two or three
 * edges takes the shorter diagonals, so that no new edge is longer than sqrt(3)/2 of the longest edge of its
 * face if that is among the cut ones. PC_E_MESH where 32-bit indices do not suffice. */
pc_status pc_bisect_edges(pc_mesh *out, pc_index **face_source, pc_context *ctx, const pc_mesh *in,
                          const pc_index *midpoint, const pc_index *parent, size_t new_vertex_count);

#endif
