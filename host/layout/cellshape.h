/* The shape of the cells of a quad mesh: angles, lengths, warp. */
#ifndef PC_CELLSHAPE_H
#define PC_CELLSHAPE_H

#include "geometry.h"
#include "polygraph.h"
#include "polymesh.h"

/* Four-cornered cells only (T-junctions on straight sides are no corners), but every edge. */
typedef struct pc_cellshape {
    pc_spread angle;           /* degrees away from 90, per corner */
    pc_spread edge_length;     /* model units, every edge between two vertices once */
    double edge_deviation;     /* standard deviation over the mean */
    pc_spread aspect;          /* longer over shorter mean of opposite sides, per cell */
    pc_spread scaled_jacobian; /* per cell the least over its corners: 1 square, <= 0 folded (Knupp 2000) */
    pc_index folded_cells;     /* those with <= 0 */
    pc_spread warp; /* degrees between the normals at opposite corners, the larger of the two pairs */
} pc_cellshape;

pc_status pc_cellshape_measure(pc_cellshape *shape, pc_context *ctx, const pc_polymesh *mesh,
                               const pc_polygraph *graph);

/* The corners of face f that are not flat, up to `room`; returns how many there are. */
pc_index pc_cell_corners(pc_index *corner, pc_index room, const pc_polymesh *mesh, pc_index f);
/* Half the sum of the cross products around the face: its length is the area of the projected polygon. */
pc_vec3 pc_face_normal(const pc_polymesh *mesh, pc_index f);

#endif
