/* Knot intervals of faces with T-junctions (digest C34, Rule 1): sums on opposite sides are equal. */
#ifndef PC_INTERVALS_H
#define PC_INTERVALS_H

#include "polymesh.h"

typedef struct pc_intervals_stats {
    pc_index chains;  /* of edges whose intervals are in fixed proportion */
    pc_index rows;    /* faces' sums that tie several of them */
    pc_index changed; /* chains that are not as wanted */
    pc_index refused; /* faces that could not be had */
} pc_intervals_stats;

/* `interval` (one per corner of `faces`, of the edge that leaves it) comes with what is wanted and leaves
 * with the nearest that fulfils Rule 1, by least squares relative to what was wanted, no smaller than `least`
 * times that. All are binary fractions if those wanted are: sums are exact. Edges that leave a vertex with
 * other than four quarters keep the proportions that were wanted, where they can.
 *
 * refused[f] = 1 (face_count values, 0 at first) tells faces with `may_go[f]` for which this cannot be had:
 * then intervals are as wanted, and the caller takes these faces apart. PC_E_BUG where faces that may not go
 * contradict each other; PC_E_NOMEM. */
pc_status pc_intervals_solve(double *interval, uint8_t *refused, pc_intervals_stats *stats, pc_context *ctx,
                             const pc_polymesh *faces, const uint8_t *may_go, double least);

#endif
