/* The surface of a polygon mesh as triangles, for everything that wants one: distances, pictures, STL. */
#ifndef PC_POLYSURFACE_H
#define PC_POLYSURFACE_H

#include "polymesh.h"
#include "trimesh.h"

/* The triangles keep the polygons' vertices and orientation and follow each other in face order; `source`
 * gets the polygon of each (caller frees; may be NULL). A quad is cut along the diagonal whose worse triangle
 * is better, a larger polygon loses its best ear first; the quality of a triangle is the sine of its smallest
 * angle, negative where it faces against the polygon's normal. Polygons of fewer than three corners give
 * nothing. PC_E_NOMEM. */
pc_status pc_polysurface_make(pc_mesh *out, pc_index **source, pc_context *ctx, const pc_polymesh *mesh);

#endif
