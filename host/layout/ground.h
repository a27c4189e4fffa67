/* The scan as the vertices of a quad mesh stand on it: closest points, smooth normals, borders to slide
 * along. */
#ifndef PC_GROUND_H
#define PC_GROUND_H

#include "adjacency.h"
#include "bvh.h"

typedef struct pc_ground {
    const pc_mesh *scan;           /* borrowed, as the tree borrows it */
    const pc_adjacency *adjacency; /* borrowed */
    pc_bvh tree;
    double *normal; /* 3 per scan vertex: area-weighted, unit length */
    pc_mesh rim; /* the border edges: "triangle" i runs from vertex i to its next and again to the next; so a
                    vertex per edge */
    pc_bvh rim_tree;
    pc_index *rim_before; /* per border edge the one that ends where it begins */
} pc_ground;

/* Time and memory: those of two trees. PC_E_NOMEM. */
pc_status pc_ground_make(pc_ground *ground, pc_context *ctx, const pc_mesh *scan,
                         const pc_adjacency *adjacency);
void pc_ground_free(pc_ground *ground, pc_context *ctx);

/* The smooth normal at a closest point, not of unit length; 0 for a miss. */
pc_vec3 pc_ground_normal(const pc_ground *ground, const pc_bvh_hit *hit);
/* The least cosine between `direction` (unit length) and the normals of the flat faces there: two, where the
 * point lies on an edge. 0 for a miss; faces without area do not count. */
double pc_ground_flat_cosine(const pc_ground *ground, const pc_bvh_hit *hit, pc_vec3 direction);

/* A place on the border: on an edge, `along` of it behind its start. */
typedef struct pc_rim_place {
    pc_index edge; /* PC_NONE: nowhere */
    double along;  /* 0..1 */
} pc_rim_place;
pc_rim_place pc_ground_rim_closest(const pc_ground *ground, pc_vec3 point);
pc_vec3 pc_ground_rim_point(const pc_ground *ground, pc_rim_place place);
/* Walks `distance` along the border, against its direction where negative; nowhere if `stop` comes first. */
pc_rim_place pc_ground_rim_walk(const pc_ground *ground, pc_rim_place from, double distance,
                                pc_rim_place stop);

#endif
