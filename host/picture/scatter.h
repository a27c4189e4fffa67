/* Points spread evenly over a surface, however unevenly it is meshed. */
#ifndef PC_SCATTER_H
#define PC_SCATTER_H

#include "trimesh.h"

typedef struct pc_scatter {
    size_t count;
    pc_index *face;
    float *weight; /* 3 per point: of the face's corners, sum 1 */
} pc_scatter;

/* No two points nearer than `spacing` (model units, straight through space), and hardly a disk of that radius
 * without one. The same points for any number of threads. At most about 200,000 points: `spacing` is raised
 * where the surface would take more. */
pc_status pc_scatter_make(pc_scatter *scatter, pc_context *ctx, const pc_mesh *mesh, double spacing);
/* The surface's area, faces that are not finite left out. */
double pc_scatter_area(const pc_mesh *mesh);
void pc_scatter_free(pc_scatter *scatter, pc_context *ctx);

#endif
