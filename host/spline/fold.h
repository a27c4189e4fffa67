/* Where surface and scan do not belong together one to one: the surface is folded, or bridges a groove whose
 * walls its feet share. A disk of faces around such a place and the disk of the scan below it are laid flat
 * on each other, which matches them anew without a fold. */
#ifndef PC_FOLD_H
#define PC_FOLD_H

#include "accuracy.h"
#include "matching.h"

/* Marks such faces: farther away than the tolerance (model units), with feet that are opposed, torn apart or
 * held, or with vertices of the scan that the surface faces away from. Without `error`: all faces with
 * opposed feet or vertices, however near. `folded`: one per face. Their number. */
pc_index pc_folds_find(uint8_t *folded, const pc_tspline *spline, const pc_target *target,
                       const pc_matching *matching, const pc_face_error *error, double tolerance);

/* Matches what is around the folded faces anew. A pair is held until following it leads to within
 * `tolerance`: what has only slid along the surface is let go. `opened` (may be NULL): disks for which that
 * went well; others stay as they are. The same bytes for any number of threads. PC_E_NOMEM. */
pc_status pc_folds_open(pc_matching *matching, pc_index *opened, pc_context *ctx, const pc_tspline *spline,
                        const pc_target *target, const uint8_t *folded, double tolerance);

#endif
