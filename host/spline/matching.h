/* What of a surface and of a scan belongs together, both ways (digest C37). */
#ifndef PC_MATCHING_H
#define PC_MATCHING_H

#include "correspondence.h"
#include "footpoints.h"
#include "summit.h"

typedef struct pc_matching {
    pc_footpoints feet;         /* of the surface on the scan */
    pc_correspondence vertices; /* of the scan on the surface */
    pc_summits summits;         /* of the surface between its feet; none at first */
    double let_go;              /* pairs that are held are kept until following them leads as near as this */
} pc_matching;

/* Of a surface whose control points still lie on the scan: by the bilinear faces between them. `per_side`
 * foot points along the side of a face. PC_E_NOMEM. */
pc_status pc_matching_make(pc_matching *matching, pc_context *ctx, const pc_tspline *spline,
                           const pc_target *target, int per_side);
void pc_matching_free(pc_matching *matching, pc_context *ctx);
/* After control points have moved, of the faces with active[f] (NULL: all). */
void pc_matching_follow(pc_matching *matching, const pc_tspline *spline, const pc_target *target,
                        const uint8_t *active);
/* Marks the faces on which a foot or a vertex is farther than that from what it belongs to. */
void pc_matching_suspect(uint8_t *suspect, const pc_matching *matching, const pc_tspline *spline,
                         const pc_target *target, double far);
/* After a refinement that left the surface as it was. PC_E_NOMEM. */
pc_status pc_matching_carry(pc_matching *matching, pc_context *ctx, const pc_tspline *refined,
                            const pc_target *target);

#endif
