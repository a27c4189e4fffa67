/* Where on the surface each vertex of the scan belongs: one place per vertex, followed from fit to fit, so
 * that what is beside each other on the scan stays so on the surface (digest C37, and its rule that no sample
 * may be flipped). The nearest point of the whole surface would tear an ear apart where the surface is still
 * coarse: part of it lies nearer to the head. */
#ifndef PC_CORRESPONDENCE_H
#define PC_CORRESPONDENCE_H

#include "chart.h"
#include "target.h"

typedef struct pc_correspondence {
    pc_index count;
    pc_spot *spot; /* on the T-mesh; face PC_NONE for vertices of no triangle */
    uint8_t *torn; /* a triangle of the vertex runs the wrong way round, or is stretched beyond belief */
    pc_index torn_triangles;
} pc_correspondence;

/* The nearest points: of the bilinear faces between the control points where these are still on the scan
 * (`flat`), else of the surface; then followed. PC_E_NOMEM. */
pc_status pc_correspondence_make(pc_correspondence *c, pc_context *ctx, const pc_tspline *spline,
                                 const pc_target *target, bool flat);
void pc_correspondence_free(pc_correspondence *c, pc_context *ctx);

/* Every vertex moves to the nearest point in its neighbourhood; where triangles are torn by that, places
 * spread out between those around them. The same bytes for any number of threads. PC_E_NOMEM. */
pc_status pc_correspondence_follow(pc_correspondence *c, pc_context *ctx, const pc_tspline *spline,
                                   const pc_target *target);
/* The same places on a mesh whose faces are parts of those so far (pc_tface.root). PC_E_NOMEM. */
pc_status pc_correspondence_carry(pc_correspondence *c, pc_context *ctx, const pc_tmesh *refined);

/* The place of vertex v, element PC_NONE where it has none. */
pc_surface_place pc_correspondence_place(const pc_correspondence *c, const pc_tspline *spline, pc_index v);

#endif
