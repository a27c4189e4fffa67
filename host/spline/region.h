/* The part of a surface that a fit works on: what surrounds the faces that are too far from the scan. The
 * rest keeps its control points and its matching. */
#ifndef PC_REGION_H
#define PC_REGION_H

#include "tspline.h"

typedef struct pc_region {
    uint8_t *free;          /* per control point: it moves */
    uint8_t *active;        /* per face: a free control point has a function on it */
    pc_index points, faces; /* how many of each */
} pc_region;

/* Around the faces with far[f] > limit (one per face): free are the control points with a function on one of
 * them, or on a face that shares a function with one of them. PC_E_NOMEM. */
pc_status pc_region_make(pc_region *region, pc_context *ctx, const pc_tspline *spline, const double *far,
                         double limit);
void pc_region_free(pc_region *region, pc_context *ctx);

#endif
