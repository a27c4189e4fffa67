/* Fits the control points of a T-spline to a scan: least squares with fairing, the correspondence corrected
 * by projection from round to round (digest C38, C39). */
#ifndef PC_FIT_H
#define PC_FIT_H

#include "device.h"
#include "target.h"

typedef struct pc_fit_options {
    double fairness; /* weight of the bending energy; has no unit */
    int rounds;      /* of correspondence and fit */
    int per_side;    /* samples along the side of a face */
    bool flat;       /* the control points are on the scan: begin from the faces between them */
    double
        tolerance;  /* of the solver: residual against what the matrix's diagonal makes of the model's size */
    double settled; /* no more rounds once no control point has moved as far as this; model units */
    const uint8_t *free; /* per control point: it may move (NULL: all) */
} pc_fit_options;
#define PC_FIT_DEFAULTS                                                                                      \
    { 1e-5, 8, 5, false, 1e-8, 0, NULL }

typedef struct pc_fit_stats {
    size_t samples, refused, flipped; /* in the last round */
    double rms;                       /* distance to the samples before the last solve, weighted */
    int rounds;
    pc_index moved;      /* control points that could move */
    pc_index iterations; /* of the solver, over all rounds */
} pc_fit_stats;

/* `track` is one of the scan's vertices (pc_target_track); it gives and takes their places on the surface
 * (NULL: found anew). PC_E_NOCONV where the solver does not converge; PC_E_NOMEM, PC_E_DEVICE. */
pc_status pc_fit(pc_tspline *spline, pc_fit_stats *stats, pc_track *track, pc_context *ctx, pc_device *device,
                 const pc_target *target, const pc_fit_options *options);
/* The elements under free control points (1, others 0); NULL: all. */
void pc_fit_reach(uint8_t *active, const pc_tspline *spline, const uint8_t *free);

#endif
