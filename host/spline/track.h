/* Where given points have their nearest points on a spline surface, followed while the surface moves and is
 * refined: Newton's method from the last place mostly finds the next one, a tree of facets the others. */
#ifndef PC_TRACK_H
#define PC_TRACK_H

#include "nearest.h"

typedef struct pc_track {
    pc_index count;
    const double *point, *normal; /* 3 each, borrowed */
    pc_nearest *at;               /* element PC_NONE: not known yet */
    pc_index *face;               /* of the T-mesh, where a place is known */
    uint8_t *facing;              /* the surface's normal there points the way of the point's */
} pc_track;

/* No place is known at first. PC_E_NOMEM. */
pc_status pc_track_make(pc_track *track, pc_context *ctx, pc_index count, const double *point,
                        const double *normal);
void pc_track_free(pc_track *track, pc_context *ctx);

typedef struct pc_track_options {
    double enough;         /* a place nearer than that is taken as it is; beyond, the facets are asked whether
                              there is a nearer one. Distances of a track are never below the true ones. */
    const uint8_t *active; /* per element: only points on these are looked at (NULL: all) */
} pc_track_options;

/* Brings places up to date with the surface. The same bytes for any number of threads. PC_E_NOMEM. */
pc_status pc_track_update(pc_track *track, pc_context *ctx, const pc_tspline *spline,
                          const pc_track_options *options);
/* The places on flat facets (pc_facets_make), whose normals decide too. */
void pc_track_project(pc_track *track, const pc_facets *facets);
/* After pc_insertion_refine, which left the surface as it was: the same places in the finer mesh. PC_E_NOMEM.
 */
pc_status pc_track_carry(pc_track *track, pc_context *ctx, const pc_tspline *finer);

#endif
