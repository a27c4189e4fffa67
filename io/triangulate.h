/* Cuts polygons of a scan into triangles: quads along the better diagonal, others by clipping ears. */
#ifndef PC_TRIANGULATE_H
#define PC_TRIANGULATE_H

#include "context.h"

/* Scratch kept from one polygon to the next; starts zeroed. */
typedef struct pc_cutter {
    double *plane; /* 2 per corner: the corner in the plane across the polygon's Newell normal */
    double *worth; /* per corner: the quality of its ear, negative where it is none */
    pc_index *corner;
    pc_index *next;
    pc_index *prev;
    size_t capacity;
} pc_cutter;

/* More corners than this cannot be cut in sensible time (the clipping is quadratic). */
enum { PC_CUTTER_LIMIT = 20000 };

void pc_cutter_free(pc_cutter *cutter, pc_context *ctx);
/* `triangle` holds a polygon of `sides` > 3 corners as the fan (c0 c1 c2) (c0 c2 c3) ... and gets sides-2
 * other triangles of the same corners, orientation and boundary. Concave and not quite flat polygons are
 * fine; one that crosses itself still gives triangles, if poor ones. PC_E_FORMAT beyond PC_CUTTER_LIMIT
 * sides. */
pc_status pc_cutter_cut(pc_cutter *cutter, pc_context *ctx, pc_index *triangle, size_t sides,
                        const double *position);

#endif
