/* What a mesh is as a surface: its pieces, their holes and handles. */
#ifndef PC_TOPOLOGY_H
#define PC_TOPOLOGY_H

#include "adjacency.h"

typedef struct pc_component {
    pc_index first_face; /* the smallest face in it */
    pc_index vertex_count, edge_count, face_count;
    pc_index loop_count; /* boundary loops */
    pc_index genus;      /* handles: (2 - chi - loops) / 2 */
    int64_t chi;         /* Euler characteristic, vertices - edges + faces */
    double area;         /* the user's units squared */
} pc_component;

typedef struct pc_topology {
    pc_index component_count;
    pc_component *component; /* ordered by first_face */
    pc_index *face_component;
    pc_index loop_count;
    pc_index *loop_start; /* loop_count+1 offsets into loop_half */
    pc_index *loop_half; /* boundary half-edges, head to tail with the surface on their left; each loop begins
                            with its smallest, and the loops are ordered by that */
    pc_index *loop_component; /* per loop */
    int64_t chi;              /* of all components together; isolated vertices are not counted */
    uint64_t genus;
} pc_topology;

/* Linear time. Every component of `mesh` is orientable, as pc_adjacency_make accepted it. PC_E_NOMEM. */
pc_status pc_topology_make(pc_topology *topology, pc_context *ctx, const pc_mesh *mesh,
                           const pc_adjacency *adjacency);
void pc_topology_free(pc_topology *topology, pc_context *ctx);
/* Counts add up, loops are closed chains of boundary half-edges that meet each exactly once. PC_E_BUG else.
 */
pc_status pc_topology_check(const pc_topology *topology, pc_context *ctx, const pc_mesh *mesh,
                            const pc_adjacency *adjacency);

#endif
