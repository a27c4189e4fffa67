/* Cuts faces of a T-mesh. The mesh stays valid after every call; whether the basis does is another matter
 * (closure.h). */
#ifndef PC_TSPLIT_H
#define PC_TSPLIT_H

#include "tmesh.h"

/* Cuts face f by a line of constant s (direction 0) or t (direction 1) at `at`, strictly inside of it, in the
 * frame of the face. Ends that meet a vertex use it; others become T-junctions. f keeps the part with its
 * corner (0,0), the new face is the last one. PC_E_NOMEM. */
pc_status pc_tsplit_face(pc_tmesh *mesh, pc_context *ctx, pc_index f, int direction, double at);
/* Into four, through the middle. */
pc_status pc_tsplit_face_in_four(pc_tmesh *mesh, pc_context *ctx, pc_index f);
/* Every face becomes its own root. */
void pc_tsplit_start(pc_tmesh *mesh);

#endif
