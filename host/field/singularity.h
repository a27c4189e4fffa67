/* Where a direction field is singular: indices of faces and of boundary loops, in integers. */
#ifndef PC_SINGULARITY_H
#define PC_SINGULARITY_H

#include "connection.h"
#include "field.h"

/* Makes field->turn, index, loop_count and loop_index from field->symmetry and field->angle (any real
 * numbers). The index of a face is (the field's turns along its three edges + N times the angle excess of the
 * face) / 2 pi, an integer up to rounding; each edge is counted once per side with opposite signs, so that
 * the sum over faces and loops is N * (V - E + F) whatever the field. A loop's index is that of the hole less
 * the hole's own Euler number: a field that runs along the boundary has 0. PC_E_NOMEM. */
pc_status pc_singularity_find(pc_field *field, pc_context *ctx, const pc_mesh *mesh,
                              const pc_adjacency *adjacency, const pc_connection *connection);
/* Faces with an index other than 0. */
pc_index pc_singularity_count(const pc_field *field);

#endif
