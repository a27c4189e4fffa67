/* Dislocations: triangles around which (s,t) comes back shifted by whole periods, so that a line ends there.
 *
 * PGP leaves them wherever the spacing of the field's lines changes. Two of opposite shift can be brought
 * together and vanish; a cone takes in any one, for its fixed point only moves; a border lets any one out.
 * What it costs is cells that are less equal in size. Moving one across an edge is one integer addition to
 * that edge's transition. */
#ifndef PC_DISLOCATION_H
#define PC_DISLOCATION_H

#include "adjacency.h"
#include "param.h"

/* Cancels dislocations with the nearest partner, cone or border within `reach` (model units, along the
 * surface), the closest pairs first, until none is left that has any. Those at vertices with guarded[v] != 0
 * stay (NULL: none). Transitions change, coordinates do not: integrate afterwards. Flags are brought up to
 * date. Returns in *cancelled how many have vanished. */
pc_status pc_dislocations_cancel(pc_param *param, pc_index *cancelled, pc_context *ctx, const pc_mesh *mesh,
                                 const pc_adjacency *adjacency, const uint8_t *guarded, double reach);

#endif
