/* From a control mesh to a surface within tolerance: fit, measure, refine where it is too far off (digest
 * C41, many faces per round). */
#ifndef PC_ADAPT_H
#define PC_ADAPT_H

#include "accuracy.h"
#include "closure.h"
#include "fit.h"

typedef struct pc_adapt_options {
    double tolerance;    /* two-sided distance, in model units */
    pc_index max_points; /* control points; 0: no limit */
    int max_rounds;      /* of refinement */
    int patience;        /* rounds that may pass without an error smaller by a few percent */
    int per_side;        /* samples per side of a face where distances are measured */
    int feet;            /* foot points along the side of a face that the fit gets */
    double anisotropy;   /* halve in one direction only where the residual changes this much more along it */
    pc_fit_options fit;
} pc_adapt_options;
#define PC_ADAPT_DEFAULTS                                                                                    \
    { 0, 0, 20, 5, 6, 4, 2, PC_FIT_DEFAULTS }

typedef struct pc_adapt_stats {
    int rounds;
    pc_index first_points; /* control points before refinement, and */
    double first_max;      /* the error that they reached */
    pc_accuracy accuracy;  /* at the end */
    pc_fit_stats fit;      /* of the last fit */
    pc_index junctions;
    bool full; /* the budget ended it */
} pc_adapt_stats;

/* The control points of `spline` lie on the scan at first. PC_E_NOCONV, with the reached error in the message
 * and in `stats`, where the tolerance is not reached: within the budget, or because several rounds in a row
 * made nothing better (noise above the tolerance, a fold of the control mesh). `spline` is then the nearest
 * surface of all rounds, and `stats` is about it. The first one is fitted whatever the budget. */
pc_status pc_adapt(pc_tspline *spline, pc_adapt_stats *stats, pc_context *ctx, pc_device *device,
                   const pc_target *target, const pc_adapt_options *options);

#endif
