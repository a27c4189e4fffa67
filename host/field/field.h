/* A smooth direction field on the vertices: the product of the field stage. */
#ifndef PC_FIELD_H
#define PC_FIELD_H

#include "trimesh.h"

typedef struct pc_field {
    int symmetry;           /* N: 1 vectors, 2 lines, 4 crosses */
    pc_index vertex_count;
    pc_index face_count;
    pc_index loop_count;    /* boundary loops */
    double *normal;         /* 3 per vertex, unit */
    double *direction;      /* 3 per vertex: unit tangent K; K_perp = normal x K */
    int8_t *index;          /* per face: N times the singularity index inside it */
    int32_t *loop_index;    /* per boundary loop, in order of its smallest half-edge: N times its index. Always
                               sum(index) + sum(loop_index) = N * chi */
} pc_field;

void pc_field_free(pc_field *field, pc_context *ctx);

#endif
