/* Where on the surface each vertex of the scan belongs, the other way round from the foot points: a near
 * point, followed from fit to fit and through refinement (digest C37). The nearest one of the whole surface
 * would jump between the sheets of an ear or a handle. */
#ifndef PC_CORRESPONDENCE_H
#define PC_CORRESPONDENCE_H

#include "target.h"

/* A place on a T-mesh. */
typedef struct pc_spot {
    pc_index face; /* PC_NONE: none */
    double at[2];  /* in its frame */
    float stress;  /* how often its distance was too large: a factor of its weight (pc_samples_make) */
    bool held;     /* stays while the vertex is far from it (pc_folds_open) */
} pc_spot;

typedef struct pc_correspondence {
    pc_index count;
    pc_spot *spot; /* per vertex of the scan; face PC_NONE for vertices of no triangle */
} pc_correspondence;

/* The nearest points of the bilinear faces between the control points from the vertices of `flat`, the scan
 * with its grooves bridged (pc_bridge_make). PC_E_NOMEM. */
pc_status pc_correspondence_make(pc_correspondence *c, pc_context *ctx, const pc_tspline *spline,
                                 const pc_target *target, const pc_mesh *flat);
void pc_correspondence_free(pc_correspondence *c, pc_context *ctx);

/* Every vertex at a face with active[f] (NULL: all) moves to the nearest point in its neighbourhood; one that
 * is held only where that is within `let_go` of it. The same bytes for any number of threads. */
void pc_correspondence_follow(pc_correspondence *c, const pc_tspline *spline, const pc_target *target,
                              double let_go, const uint8_t *active);
/* The same places on a mesh whose faces are parts of those so far (pc_tface.root). PC_E_NOMEM. */
pc_status pc_correspondence_carry(pc_correspondence *c, pc_context *ctx, const pc_tmesh *refined);

/* The place of vertex v, element PC_NONE where it has none. */
pc_surface_place pc_correspondence_place(const pc_correspondence *c, const pc_tspline *spline, pc_index v);

#endif
