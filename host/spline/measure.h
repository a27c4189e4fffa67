/* Area and enclosed volume of a spline surface, for comparison with what other programs read from our files.
 */
#ifndef PC_MEASURE_H
#define PC_MEASURE_H

#include "tspline.h"

typedef struct pc_measure {
    double area;   /* model units squared */
    double volume; /* enclosed, positive where the normals point outward; 0 for an open surface */
    bool closed;
} pc_measure;

/* By Gauss's rule with 8 x 8 points per element. The volume, an integral of polynomials by the divergence
 * theorem, is exact up to rounding; the area is not that of polynomials, and good to about 1e-9 of itself
 * where no element is folded. The same for any number of threads. PC_E_NOMEM. */
pc_status pc_tspline_measure(pc_measure *measure, pc_context *ctx, const pc_tspline *spline);

#endif
