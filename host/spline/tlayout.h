/* From a mesh of polygons with T-junctions to the faces and knot intervals of a T-mesh (digest C33, C34). */
#ifndef PC_TLAYOUT_H
#define PC_TLAYOUT_H

#include "polymesh.h"

typedef struct pc_tlayout {
    pc_polymesh faces; /* four corners each that are not flat */
    double *interval;  /* per corner, of the edge that leaves it: binary fractions that fulfil Rule 1 */
} pc_tlayout;

/* Quads only, without T-junctions. */
bool pc_tlayout_is_plain(const pc_polymesh *polygons);
/* Polygons of four corners keep their T-junctions where knot intervals can be found for them
 * (pc_intervals_solve); those that cannot, and polygons of other than four corners, become faces around new
 * vertices (pc_pattern_make). Vertices of the polygons come first. Errors as
 * pc_pattern_make and pc_intervals_solve. */
pc_status pc_tlayout_make(pc_tlayout *layout, pc_context *ctx, const pc_polymesh *polygons);
void pc_tlayout_free(pc_tlayout *layout, pc_context *ctx);

#endif
