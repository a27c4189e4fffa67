/* Cuts a graph into parts of like size with few edges between them: the unit of distribution. */
#ifndef PC_PARTS_H
#define PC_PARTS_H

#include "graph.h"

typedef struct pc_parts {
    pc_index part_count;
    pc_index vertex_count;
    pc_index
        *vertex_part; /* parts are numbered by their smallest vertex; on tiny graphs the last may be empty */
    uint64_t cut_edges; /* edges between parts */
} pc_parts;

/* METIS k-way with a fixed seed (Karypis and Kumar 1998); one part, and graphs of under 16 vertices per part
 * (runs of consecutive vertices), without it. PC_E_USAGE: part_count 0. PC_E_MESH: the graph exceeds METIS'
 * indices. PC_E_NOMEM. Signal handlers are afterwards what they were before; not to be called from two
 * threads at once. */
pc_status pc_parts_make(pc_parts *parts, pc_context *ctx, const pc_graph *graph, pc_index part_count);
void pc_parts_free(pc_parts *parts, pc_context *ctx);
/* Parts in range and in order, the cut counted right. PC_E_BUG else. */
pc_status pc_parts_check(const pc_parts *parts, pc_context *ctx, const pc_graph *graph);

#endif
