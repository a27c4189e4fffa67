/* The scan with its grooves drawn flat where the first, coarse faces of a surface bridge them, so
 * that these find all of it below them, side by side (digest C37). */
#ifndef PC_BRIDGE_H
#define PC_BRIDGE_H

#include "footpoints.h"

/* `flat` is the target's mesh with other positions; the triangles are shared and `flat` is freed with
 * pc_free on its positions. `feet` gets the feet of the bilinear faces on it. PC_E_NOMEM. */
pc_status pc_bridge_make(pc_mesh *flat, pc_footpoints *feet, pc_context *ctx, const pc_tspline *spline,
                         const pc_target *target);

#endif
