/* Reads PLY: ascii and both binary orders, any elements and properties, polygons and triangle strips. */
#ifndef PC_PLY_H
#define PC_PLY_H

#include "scan_input.h"

/* The mesh owns its arrays (pc_mesh_free). Faces with a repeated vertex are kept as they are; degenerate
 * triangles of strips, which only serve to turn the strip, are not. PC_E_FORMAT, PC_E_NOMEM. */
pc_status pc_ply_read(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const pc_scan_input *input);

#endif
