/* Places where the surface is too far from the scan while the feet of their faces, which lie around them, are
 * all near. They become samples of the fit, too: the surface is pulled back there without being refined. They
 * stay where a face is cut: its parts' feet may miss them as well. */
#ifndef PC_SUMMIT_H
#define PC_SUMMIT_H

#include "correspondence.h"
#include "footpoints.h"
#include "gauge.h"

typedef struct pc_summits {
    pc_correspondence places; /* on the surface, one each */
    pc_foot *foot;            /* on the scan, one each */
} pc_summits;

/* Adds the farthest place of every face that `gauge` found beyond the tolerance (model units) and whose feet
 * are not; none beside one that the face has already. Those faces are marked in `unseen` (one per face), and
 * no others. PC_E_NOMEM. */
pc_status pc_summits_find(pc_summits *summits, uint8_t *unseen, pc_context *ctx, const pc_tspline *spline,
                          const pc_footpoints *feet, const pc_gauge *gauge, double tolerance);
/* The feet of those on faces with active[f] (NULL: all) walk downhill, as pc_footpoints_follow. */
void pc_summits_follow(pc_summits *summits, const pc_tspline *spline, const pc_target *target,
                       const uint8_t *active);
void pc_summits_free(pc_summits *summits, pc_context *ctx);

#endif
