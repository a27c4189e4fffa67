/* Fits the control points of a T-spline to a scan: least squares with fairing, the correspondence corrected
 * by projection from round to round (digest C38, C39). */
#ifndef PC_FIT_H
#define PC_FIT_H

#include "device.h"
#include "samples.h"

typedef struct pc_fit_options {
    double fairness;  /* weight of the bending energy; has no unit */
    int rounds;       /* of correspondence and fit */
    int per_side;     /* samples along the side of a face */
    double tolerance; /* relative residual of the solver */
} pc_fit_options;
#define PC_FIT_DEFAULTS                                                                                      \
    { 1e-5, 3, 5, 1e-8 }

typedef struct pc_fit_stats {
    size_t samples, refused; /* in the last round */
    pc_index torn;           /* triangles of the scan */
    double rms;              /* distance to the samples before the last solve, weighted */
    pc_index iterations;     /* of the solver, over all rounds and coordinates */
} pc_fit_stats;

/* The correspondence is followed before every round but the first. PC_E_NOCONV where the solver does not
 * converge; PC_E_NOMEM. */
pc_status pc_fit(pc_tspline *spline, pc_fit_stats *stats, pc_context *ctx, pc_device *device,
                 const pc_target *target, pc_correspondence *correspondence, const pc_fit_options *options);

#endif
