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

/* What a search has found for each dislocation before any was cancelled. */
typedef struct pc_dislocation_plans pc_dislocation_plans;

/* Cancels dislocations with the nearest partner, cone or border within `reach` (model units, along the
 * surface), the closest pairs first, until none is left that has any. Those at vertices with guarded[v] != 0
 * stay (NULL: none). Transitions change, coordinates do not: integrate afterwards. Flags are brought up to
 * date. Returns in *cancelled how many have vanished. `known` (or NULL) saves the searches where the same
 * param is taken again with more of it guarded: *known is NULL before the first call, and freed by the caller
 * after the last. */
pc_status pc_dislocations_cancel(pc_param *param, pc_index *cancelled, pc_dislocation_plans **known,
                                 pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency,
                                 const uint8_t *guarded, double reach);
void pc_dislocation_plans_free(pc_dislocation_plans *plans, pc_context *ctx);

#endif
