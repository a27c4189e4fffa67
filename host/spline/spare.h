/* Takes out of a mesh of polygons the vertices that no control mesh can have. */
#ifndef PC_SPARE_H
#define PC_SPARE_H

#include "polymesh.h"

/* Inner vertices between two faces only go, where three corners stay: out of both faces; with a triangle,
 * whose place the other face takes; or, where their neighbours have an edge already, with the edges between
 * the faces, which become one. Corners stay flat only where the vertex is inside of the mesh, between three
 * faces and flat in one of them, of more than four corners. Vertices keep their numbers; `source` (per face
 * the former number) and `border` (per vertex: 1 on a boundary) are the caller's to free. PC_E_MESH where an
 * edge is not between two faces that run along it in opposite directions; PC_E_NOMEM, PC_E_BUG as
 * pc_polygraph_make. */
pc_status pc_spare_drop(pc_polymesh *mesh, pc_index **source, uint8_t **border, pc_context *ctx);

#endif
