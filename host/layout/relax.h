/* Moves the vertices of badly shaped quads along the scan until the quads stand upright. */
#ifndef PC_RELAX_H
#define PC_RELAX_H

#include "ground.h"
#include "polymesh.h"

typedef struct pc_relax_options {
    double least_sine; /* corners whose sine against the scan's normal is below this are bad */
    int rounds;        /* each moves the vertices of bad faces and, from round to round, more around them */
    int smooth_rounds; /* gentle rounds over all interior vertices before, each halfway to their neighbours'
                          mean */
} pc_relax_options;
#define PC_RELAX_DEFAULTS                                                                                    \
    { 0.15, 24, 2 }

typedef struct pc_relax_stats {
    pc_index bad_before, bad_after; /* faces */
} pc_relax_stats;

/* `folded` (per face, or NULL) gets 1 where a face still is upside down. Vertices move to the
 * mean of their neighbours and back onto the scan (its closest point); border vertices stay. Same result for
 * any number of threads. */
pc_status pc_relax(pc_polymesh *quads, pc_relax_stats *stats, uint8_t *folded, pc_context *ctx,
                   const pc_ground *ground, const pc_relax_options *options);

#endif
