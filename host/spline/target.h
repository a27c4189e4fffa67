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
/* Of a point of a triangle, by the weights of its corners: the normal, smooth across triangles, of length 1;
 * and whether it is on an edge or vertex of the scan's border. */
pc_vec3 pc_target_normal(const pc_target *target, pc_index triangle, const double weight[3]);
bool pc_target_on_border(const pc_target *target, pc_index triangle, const double weight[3]);
void pc_target_free(pc_target *target, pc_context *ctx);

#endif
