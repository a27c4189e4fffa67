/* The scan that a spline surface should follow. */
#ifndef PC_TARGET_H
#define PC_TARGET_H

#include "adjacency.h"
#include "nearest.h"

typedef struct pc_target {
    const pc_mesh *mesh; /* borrowed, as `adjacency` */
    const pc_adjacency *adjacency;
    pc_bvh tree;
    double *normal;  /* 3 per vertex */
    double diagonal; /* of the box around the mesh */
} pc_target;

/* `target` must not move: the tree points into the mesh it borrows. PC_E_NOMEM. */
pc_status pc_target_make(pc_target *target, pc_context *ctx, const pc_mesh *mesh,
                         const pc_adjacency *adjacency);
void pc_target_free(pc_target *target, pc_context *ctx);

#endif
