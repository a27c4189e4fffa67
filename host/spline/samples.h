/* What a fit is told: points of the scan with their places on the surface (digest C37, C38). */
#ifndef PC_SAMPLES_H
#define PC_SAMPLES_H

#include "correspondence.h"
#include "energy.h"

typedef struct pc_samples {
    size_t count;
    pc_sample *sample; /* sorted by element */
    double *stiffness; /* per element: 1 where the scan says enough, up to a thousand where it says nothing
                          and only fairing can keep the surface in shape */
    size_t refused;    /* no partner: torn vertices of the scan, and points of the surface whose nearest point
                          of the scan belongs elsewhere */
} pc_samples;

/* Every vertex of the scan at its place, points inside its triangles, and a grid of every face of the surface
 * with its nearest points of the scan: so many of both that a face has about `per_side` along its sides (0:
 * vertices only). The weights of an element sum to its share of its
 * face. PC_E_NOMEM. */
pc_status pc_samples_make(pc_samples *samples, pc_context *ctx, const pc_tspline *spline,
                          const pc_target *target, const pc_correspondence *correspondence, int per_side);
void pc_samples_free(pc_samples *samples, pc_context *ctx);

#endif
