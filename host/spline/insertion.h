/* Local refinement of a T-spline that leaves its surface as it is (digest C40). */
#ifndef PC_INSERTION_H
#define PC_INSERTION_H

#include "closure.h"
#include "tspline.h"

/* Cuts the faces with wish[f] and those that must be cut with them (pc_closure_refine), and gives the control
 * points of the finer mesh. In an analysis-suitable T-spline the functionals of the local knots are dual to
 * the functions (Beirao da Veiga et al. 2012): the control point of a vertex is the blossom of the old
 * surface at the vertex's three inner knots in s and in t, taken from any one of the old elements under its
 * function. The surface stays the same but for rounding, except in the closing patches of vertices whose
 * depth was 0 already. The roots and origins of the new faces tell where they were in the old mesh.
 * PC_E_NOMEM; on failure `spline` stays. */
pc_status pc_insertion_refine(pc_tspline *spline, pc_closure_stats *stats, pc_context *ctx,
                              const uint8_t *wish);

#endif
