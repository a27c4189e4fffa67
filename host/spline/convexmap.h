/* Points of the plane each of which is a weighted mean of others, but for some that are fixed: a convex
 * combination map (Floater 2003). With positive weights on a disk whose rim is fixed on a convex curve it is
 * one to one. */
#ifndef PC_CONVEXMAP_H
#define PC_CONVEXMAP_H

#include "context.h"

/* Row v holds the weights of what point v is the mean of; fixed points have none. */
typedef struct pc_convexmap {
    pc_index count;
    size_t *start;    /* count+1 offsets */
    pc_index *column; /* ascending within a row */
    double *weight;   /* positive; of a row they sum to 1 */
} pc_convexmap;

pc_status pc_convexmap_make(pc_convexmap *map, pc_context *ctx, pc_index count, size_t entries);
void pc_convexmap_free(pc_convexmap *map, pc_context *ctx);

/* `x`: 2 per point, those of fixed points given, the others a start on entry. Until every point is within
 * `tolerance` of its mean: PC_E_NOCONV where that is not reached, x being the best so far. Conjugate
 * gradients for matrices that are not symmetric (van der Vorst 1992), with an incomplete factorisation. One
 * thread. PC_E_NOMEM. */
pc_status pc_convexmap_solve(double *x, pc_context *ctx, const pc_convexmap *map, double tolerance);

#endif
