/* The closest point on a triangle mesh: a tree of boxes, eight children per node, full but for the last node
 * of each level; the triangles are shared out by halving them along the longest axis (Bentley 1975). Boxes
 * are floats rounded outwards, triangles are measured in double. */
#ifndef PC_BVH_H
#define PC_BVH_H

#include "trimesh.h"
#include "vec3.h"

enum { PC_BVH_WIDTH = 8, PC_BVH_LEVELS = 12 };

/* The boxes of eight siblings, one coordinate after the other so that a loop over the siblings vectorises. */
typedef struct pc_bvh_block {
    float low[3][PC_BVH_WIDTH];
    float high[3][PC_BVH_WIDTH];
} pc_bvh_block;

typedef struct pc_bvh {
    const pc_mesh *mesh; /* borrowed: must outlive the tree, unchanged */
    pc_vec3 centre;      /* boxes live in (p - centre) * scale */
    double scale;
    int level_count;
    size_t level_start[PC_BVH_LEVELS + 1]; /* blocks of each level, level 0 holds the triangles */
    pc_bvh_block *block;
    pc_index *face; /* the triangle at each place of level 0 */
} pc_bvh;

typedef struct pc_bvh_hit {
    pc_index face;    /* PC_NONE where the mesh has no faces */
    double distance;  /* in model units */
    pc_vec3 point;    /* the closest point of that face */
    double weight[3]; /* its barycentric coordinates there */
} pc_bvh_hit;

/* Time and memory: about 0.4 us on two cores and 32 bytes per triangle. The same tree for any number of
 * threads. PC_E_NOMEM. */
pc_status pc_bvh_make(pc_bvh *bvh, pc_context *ctx, const pc_mesh *mesh);
void pc_bvh_free(pc_bvh *bvh, pc_context *ctx);

/* The face closest to `point`, the one of lowest number where several are equally close. `hint` is any face
 * that may be near (or PC_NONE): it makes the search shorter and never changes the answer. */
pc_bvh_hit pc_bvh_closest(const pc_bvh *bvh, pc_vec3 point, pc_index hint);
/* The same for `count` points (3 doubles each), in parallel. Neighbours in the list should be near in space.
 */
void pc_bvh_closest_all(pc_bvh_hit *hits, const pc_bvh *bvh, const double *points, size_t count);

/* The closest point of one triangle abc, with barycentric weights; returns the squared distance. Degenerate
 * triangles are measured as the segment or point that they are. */
double pc_closest_on_triangle(double weight[3], pc_vec3 p, pc_vec3 a, pc_vec3 b, pc_vec3 c);

#endif
