/* What a fit is told: points of the scan with their places on the surface (digest C37, C38). */
#ifndef PC_SAMPLES_H
#define PC_SAMPLES_H

#include "energy.h"
#include "matching.h"

typedef struct pc_samples {
    size_t count;
    pc_sample *sample; /* sorted by element */
} pc_samples;

/* The foot points of every face, and the vertices of the scan at their places. The weights of a face sum to 1
 * where none is farther than `near` from the surface (0: whatever the distances); those beyond weigh in
 * proportion to their distance, up to 30 times as much, so that least squares fitted again and again come
 * close to the smallest largest distance (Lawson 1961). PC_E_NOMEM. */
pc_status pc_samples_make(pc_samples *samples, pc_context *ctx, const pc_tspline *spline,
                          const pc_target *target, const pc_matching *matching, double near);
void pc_samples_free(pc_samples *samples, pc_context *ctx);

#endif
