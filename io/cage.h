/* The control mesh of a spline surface as a cage for Catmull and Clark's subdivision, which modelling
 * programs take. */
#ifndef PC_CAGE_H
#define PC_CAGE_H

#include "polymesh.h"
#include "tspline.h"

/* The faces of the T-mesh as polygons, T-junctions being corners of the larger face too (corner_flat), ghosts
 * left out. Its vertices are the control points, in the order of the T-mesh's; those on the border lie where
 * the subdivision of the border (a smooth curve between corners, which are the vertices of one face only)
 * passes through the spline's border at the vertices. Where the T-mesh is a grid of equal knot intervals away
 * from the border, and around extraordinary vertices, the limit of the subdivision is the surface, closing
 * patches apart; beside T-junctions, changes of the interval and the border it is near. PC_E_NOMEM. */
pc_status pc_cage_make(pc_polymesh *cage, pc_context *ctx, const pc_tspline *spline);
/* As OBJ (pc_polyfile_write_obj). */
pc_status pc_cage_write(pc_context *ctx, const pc_tspline *spline, const char *path, bool force);

#endif
