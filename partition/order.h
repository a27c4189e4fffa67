/* A renumbering that keeps neighbours close in memory, and the way back to the user's numbers. */
#ifndef PC_ORDER_H
#define PC_ORDER_H

#include "graph.h"

typedef struct pc_order {
    pc_index vertex_count, face_count;
    pc_index *vertex_new, *vertex_old; /* new number of an old vertex, old number of a new one */
    pc_index *face_new, *face_old;
} pc_order;

/* Reverse Cuthill-McKee (George and Liu 1981), each component from a pseudo-peripheral vertex, components by
 * their smallest vertex; faces by their smallest new vertex, then by old number. Depends on the mesh only.
 * Linear time. `graph` is the mesh's own. PC_E_NOMEM. */
pc_status pc_order_make(pc_order *order, pc_context *ctx, const pc_mesh *mesh, const pc_graph *graph);
void pc_order_free(pc_order *order, pc_context *ctx);
/* Permutations and their inverses. PC_E_BUG else. */
pc_status pc_order_check(const pc_order *order, pc_context *ctx);

/* The mesh in new numbers; each face keeps its first corner, so half-edge 3f+k becomes 3*face_new[f]+k. */
pc_status pc_order_apply(pc_mesh *out, pc_context *ctx, const pc_order *order, const pc_mesh *mesh);
/* out[i] = in[from[i]] for `count` items of `bytes` bytes: values per new vertex into the user's order with
 * from = vertex_new, and from the user's into the new order with vertex_old. */
void pc_order_permute(void *out, const void *in, const pc_index *from, size_t count, size_t bytes);
/* The largest difference of neighbours' numbers, and their mean: what the order is about. */
typedef struct pc_bandwidth {
    pc_index largest;
    double mean;
} pc_bandwidth;
pc_bandwidth pc_order_bandwidth(const pc_graph *graph);

#endif
