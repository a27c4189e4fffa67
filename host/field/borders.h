/* Which boundary edges a direction field should follow. */
#ifndef PC_BORDERS_H
#define PC_BORDERS_H

#include "connection.h"
#include "field.h"

/* weight[V] out, in [0,1]: how strongly the field should follow the boundary at each vertex, 0 off it; and
 * angle[V], the direction of the boundary there in the connection's frames (set only where weight > 0).
 * PC_BORDERS_AUTO trusts a boundary where it turns little over a window of edges both sides: the rim of a
 * part, not the ragged edge of a hole in a scan. */
void pc_borders_find(double *weight, double *angle, const pc_mesh *mesh, const pc_adjacency *adjacency,
                     const pc_connection *connection, pc_border_rule rule);

#endif
