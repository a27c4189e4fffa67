/* What a fit is told: points of the scan with their places on the surface (digest C37, C38). */
#ifndef PC_SAMPLES_H
#define PC_SAMPLES_H

#include "energy.h"
#include "matching.h"

typedef struct pc_samples {
    size_t count;
    pc_sample *sample; /* sorted by element */
    double max;        /* their largest distance to the surface */
    double *far;       /* the same per face, -1 without samples */
} pc_samples;

/* The foot points and summits of every face with active[f] (NULL: all), and the vertices of the scan at their
 * places there. At first the weights of a face without summits sum to 1. Each call multiplies the weight of
 * every sample by its distance over half of `within`, up to 30 times what it was and never below: least
 * squares fitted again and again come close to the smallest largest distance (Lawson 1961). `within` 0: no
 * weight changes. The factors are kept in `matching`. PC_E_NOMEM. */
pc_status pc_samples_make(pc_samples *samples, pc_context *ctx, const pc_tspline *spline,
                          const pc_target *target, pc_matching *matching, double within,
                          const uint8_t *active);
void pc_samples_free(pc_samples *samples, pc_context *ctx);

#endif
