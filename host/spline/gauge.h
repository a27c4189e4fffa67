/* What the faces of a surface were found to be from a scan, kept while the surface moves: only faces that
 * have moved since are measured again. */
#ifndef PC_GAUGE_H
#define PC_GAUGE_H

#include "tspline.h"

/* Of the samples on one face, distances in model units. */
typedef struct pc_face_found {
    double max, sum;
    double at[2];      /* the farthest place on the face, */
    pc_index triangle; /* ... and what of the scan is nearest to it */
    double change[2];  /* sum of squared differences of the residual between neighbours along s and along t */
    uint32_t samples, beyond; /* beyond: nearest to a border of the scan; they are not in `max` and `sum` */
    bool known;               /* up to date */
} pc_face_found;

/* Zero at first. */
typedef struct pc_gauge {
    pc_index face_count, vertex_count;
    pc_face_found *face; /* per face of the surface as it was last */
    double *position;    /* its control points, 3 each */
} pc_gauge;

/* Forgets what has moved since the last call; all of it where the numbers of faces or vertices are others.
 * PC_E_NOMEM. */
pc_status pc_gauge_update(pc_gauge *gauge, pc_context *ctx, const pc_tspline *spline);
/* After a refinement that left the surface as it was: faces that were not cut stay known. The gauge was up to
 * date before. PC_E_NOMEM. */
pc_status pc_gauge_carry(pc_gauge *gauge, pc_context *ctx, const pc_tspline *refined);
void pc_gauge_free(pc_gauge *gauge, pc_context *ctx);

#endif
