/* Cures triangles of exactly zero area without moving the surface. */
#ifndef PC_SLIVERS_H
#define PC_SLIVERS_H

#include "adjacency.h"

typedef struct pc_sliver_count {
    pc_index found; /* faces of zero area at the beginning */
    pc_index cured; /* of those: flipped or dropped */
} pc_sliver_count;

/* The middle vertex of a zero-area face lies on its longest edge. Flipping that edge gives two faces that
 * share out the area of the neighbour; a face with that edge on the boundary is dropped where the middle
 * vertex is inside. Faces that allow neither (the flipped edge exists already) stay. `face_source` moves with
 * the faces (a part of the neighbour names the neighbour's). `zero_area` (per face of the beginning: 1 where
 * its area is zero) may be NULL. No vertex is added or left alone. */
pc_status pc_slivers_cure(pc_sliver_count *count, uint8_t *zero_area, pc_context *ctx, pc_mesh *mesh,
                          pc_index *face_source);

#endif
