/* A spline surface as triangles that share their vertices wherever elements meet: no cracks, T-junctions
 * included. For files; pictures have triangles of their own. */
#ifndef PC_SKIN_H
#define PC_SKIN_H

#include "trimesh.h"
#include "tspline.h"

typedef struct pc_skin {
    pc_mesh mesh;            /* vertices on the surface; triangles in the order of the elements */
    double *normal;          /* 3 per vertex, unit; zero where the surface has none */
    pc_surface_place *place; /* per vertex: one of the places that it stands at */
    pc_index *element;       /* per triangle, ascending: the element that it lies on */
    double *corner;          /* 6 per triangle: (s, t) of its corners in the frame of the element's face */
    size_t place_room, triangle_room;
} pc_skin;

/* Of the faces with wanted[f] (NULL: all). `steps` cells, rounded up to a power of two, 64 at most, along
 * each side of a face of the T-mesh, fewer on the parts that its elements are. A vertex at which a neighbour
 * is finer is taken up by a fan around the cell's centre. PC_E_NOMEM. */
pc_status pc_skin_make(pc_skin *skin, pc_context *ctx, const pc_tspline *spline, int steps,
                       const uint8_t *wanted);
void pc_skin_free(pc_skin *skin, pc_context *ctx);

#endif
