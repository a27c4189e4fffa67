/* Finds what is there twice: vertices at the same place, faces on the same vertices. */
#ifndef PC_DUPLICATES_H
#define PC_DUPLICATES_H

#include "trimesh.h"

/* Per vertex: the smallest vertex at exactly the same position (0 and -0 are the same); itself where it is
 * alone. The caller frees `*same`. Expected linear time. */
pc_status pc_duplicates_of_vertices(pc_index **same, pc_context *ctx, const pc_mesh *mesh);

/* Per face: the smallest face on the same three vertices, in any order. The caller frees `*same`. */
pc_status pc_duplicates_of_faces(pc_index **same, pc_context *ctx, const pc_mesh *mesh);

#endif
