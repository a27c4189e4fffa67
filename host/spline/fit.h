/* Fits the control points of a T-spline to a scan: least squares with fairing, the matching corrected by
 * projection from round to round (digest C38, C39). Every round takes the places as fixed: the matrix is
 * scalar and the same for three coordinates. */
#ifndef PC_FIT_H
#define PC_FIT_H

#include "device.h"
#include "matching.h"
#include "region.h"

typedef struct pc_fit_options {
    double fairness; /* weight of the bending energy; has no unit */
    int rounds;      /* of fit and matching, at most */
    /* Of the solver: its residual against what the matrix's diagonal makes of the model's size. */
    double tolerance;
    double within; /* largest distance that is wanted, in model units; 0: all rounds of plain least squares */
    bool
        rough; /* the surface is far off still: all of it moves in the first rounds, and distances say nothing
                  in the first one. Else only what surrounds faces with samples nearly that far moves. */
    const float *stiffness;  /* per face: how many times as much it resists bending. NULL: all once */
    const pc_region *region; /* what moves, in all rounds; borrowed. NULL: chosen as above */
} pc_fit_options;
#define PC_FIT_DEFAULTS                                                                                      \
    { 3e-4, 30, 1e-8, 0, true, NULL, NULL }

typedef struct pc_fit_stats {
    size_t samples; /* in the last round */
    double rms;     /* distance to the samples before the last solve, weighted */
    double max;     /* largest one, at the same time */
    int rounds;
    pc_index moved;      /* control points that could move in the last round */
    pc_index iterations; /* of the solver, over all rounds */
} pc_fit_stats;

/* The matching is followed after every round. PC_E_NOCONV where the solver does not converge; PC_E_NOMEM,
 * PC_E_DEVICE. */
pc_status pc_fit(pc_tspline *spline, pc_fit_stats *stats, pc_context *ctx, pc_device *device,
                 const pc_target *target, pc_matching *matching, const pc_fit_options *options);

#endif
