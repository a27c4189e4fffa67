/* The faces under the blending function of a vertex, each with the function's knots in its own frame (digest
 * C39, steps 1 to 3). */
#ifndef PC_SUPPORT_H
#define PC_SUPPORT_H

#include "tmesh.h"

typedef struct pc_footprint {
    pc_index face, vertex;
    double s[5], t[5]; /* knots in the frame of the face */
} pc_footprint;

typedef struct pc_footprints {
    size_t count, room;
    pc_footprint *at;
} pc_footprints;

/* Scratch for many calls on one mesh. */
typedef struct pc_support {
    struct pc_placement *placement; /* faces seen, in the frame of the vertex */
    size_t room;
} pc_support;

/* Appends the faces where the function of vertex v is not zero, but for ghosts and faces with extraordinary
 * corners. Walks stay within one quadrant of the function's rectangle and never cross an edge of an
 * extraordinary vertex inside of it, so that coordinates do not depend on the way. PC_E_NOMEM. */
pc_status pc_support_append(pc_footprints *footprints, pc_support *scratch, pc_context *ctx,
                            const pc_tmesh *mesh, pc_index v);
void pc_support_free(pc_support *scratch, pc_context *ctx);
void pc_footprints_free(pc_footprints *footprints, pc_context *ctx);

#endif
