/* What a fit is told: points of the scan with their places on the surface (digest C37, C38). */
#ifndef PC_SAMPLES_H
#define PC_SAMPLES_H

#include "energy.h"
#include "matching.h"

typedef struct pc_samples {
    size_t count;
    pc_sample *sample; /* sorted by element */
    double *stiffness; /* per element: 1 where the scan says enough, up to a thousand where it says nothing
                          and only fairing can keep the surface in shape */
    size_t refused;    /* vertices of the scan that are astray, and foot points lost */
} pc_samples;

/* The foot points of every face, and the vertices of the scan at their places. The weights of a face sum to 1
 * where no foot point is lost. PC_E_NOMEM. */
pc_status pc_samples_make(pc_samples *samples, pc_context *ctx, const pc_tspline *spline,
                          const pc_target *target, const pc_matching *matching, double goal, bool unfold);
void pc_samples_free(pc_samples *samples, pc_context *ctx);

#endif
