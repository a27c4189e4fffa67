/* Distances between a spline surface and its scan, many of them, for pictures: where they are (the surface's)
 * and how they are spread (both ways). What is promised is measured by accuracy.h; this says how it looks. */
#ifndef PC_ERRORS_H
#define PC_ERRORS_H

#include "target.h"

enum { PC_ERRORS_BINS = 48, PC_ERRORS_QUANTILES = 3 };

typedef struct pc_errors {
    pc_index element_count;
    int per_side;                   /* squares along each side of an element */
    float *distance;                /* (per_side+1)^2 per element, s fastest, to the scan, in model units;
                                       NaN where the scan has no data */
    double largest;                 /* of all distances asked for, or told as reached */
    double high;                    /* where bins and colours end: `largest` or the tolerance, whichever
                                       is more, but six tolerances at most; what is more is in the last bin */
    double surface[PC_ERRORS_BINS]; /* part of the surface's area in each bin; sums to 1 */
    double scan[PC_ERRORS_BINS];    /* part of the scan's vertices whose distance to the surface is in it */
    double quantile[PC_ERRORS_QUANTILES]; /* distances that half, 95 % and 99 % of the area do not exceed */
    double within;                        /* part of the surface's area within the tolerance; 1 without one */
    size_t scan_count;                    /* vertices of the scan that were asked */
} pc_errors;

/* About a quarter of a million samples of the surface, and at most 100,000 vertices of the scan, evenly
 * taken. Beyond the scan's borders there is no data: samples whose nearest point is on a border count up to
 * the tolerance only (without one up to 0.1 % of the diagonal). `reached` (model units, may be 0): the
 * largest distance, measured before. The same for any number of threads.
 * PC_E_NOMEM. */
pc_status pc_errors_make(pc_errors *errors, pc_context *ctx, const pc_tspline *spline,
                         const pc_target *target, double tolerance, double reached);
void pc_errors_free(pc_errors *errors, pc_context *ctx);

/* At u, v in 0..1 of an element, between the samples around. */
float pc_errors_at(const pc_errors *errors, pc_index element, double u, double v);

#endif
