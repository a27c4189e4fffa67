/* A spline surface as triangles that are fine enough for a picture, with the spline's own normals. */
#ifndef PC_TESSELLATION_H
#define PC_TESSELLATION_H

#include "tspline.h"

/* Every element has a grid of its own, cells[0] x cells[1] squares, s fastest; no vertex is shared, so that
 * what is not smooth in the spline is not smooth here either. */
typedef struct pc_tessellation {
    pc_index vertex_count, face_count;
    double *position;   /* 3 per vertex */
    float *normal;      /* 3 per vertex, unit; zero where the surface has none */
    pc_index *triangle; /* 3 per face, counter-clockwise */
    pc_index *start;    /* per element +1: its first vertex */
    uint8_t (*cells)[2];
} pc_tessellation;

/* Sides of squares of about `spacing` (model units), coarser where there would be some millions of them. The
 * grids' rims reach a tenth of that beyond their elements, so that no gap shows where grids of unlike
 * fineness meet. The same for any number of threads. PC_E_NOMEM. */
pc_status pc_tessellation_make(pc_tessellation *tessellation, pc_context *ctx, const pc_tspline *spline,
                               double spacing);
void pc_tessellation_free(pc_tessellation *tessellation, pc_context *ctx);

#endif
