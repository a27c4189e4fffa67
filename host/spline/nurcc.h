/* The surface on a face with extraordinary corners: local subdivision as of non-uniform rational
 * Catmull-Clark surfaces, bicubic on every part that has become regular, and a closing bicubic patch at the
 * extraordinary vertex (digest C36; Sederberg et al. 2003; Loop et al. 2009 for the closing patch).
 *
 * The rules are those of cubic B-splines at regular vertices, for any intervals, and those of Catmull and
 * Clark at extraordinary ones, around which the intervals are equal. A face whose extraordinary vertices are
 * of depth k is subdivided k times, each time only the part that is still irregular. The closing patches have
 * the position and the tangent plane of the Catmull-Clark limit at the vertex, share their borders, and join
 * the rest with one tangent plane; along the edges that leave the vertex normals differ a little, the less
 * the deeper. */
#ifndef PC_NURCC_H
#define PC_NURCC_H

#include "tmesh.h"

/* One bicubic patch: its 16 Bezier points (i + 4j, i along s) as combinations of the control points of the
 * face's surroundings. */
typedef struct pc_patch {
    double low[2], high[2]; /* the part of the face, in the frame of the face */
    double *weight;         /* 16 rows of point_count */
} pc_patch;

typedef struct pc_patches {
    pc_index patch_count, point_count;
    pc_index *point; /* vertices of the T-mesh */
    pc_patch *patch;
    double *weight; /* of all patches */
} pc_patches;

/* PC_E_BUG where a face around has T-junctions in its sides. */
pc_status pc_nurcc_make(pc_patches *patches, pc_context *ctx, const pc_tmesh *mesh, pc_index f);
void pc_nurcc_free(pc_patches *patches, pc_context *ctx);

#endif
