/* The vertices of a mesh as a graph: compressed rows of neighbours. */
#ifndef PC_GRAPH_H
#define PC_GRAPH_H

#include "adjacency.h"

typedef struct pc_graph {
    pc_index vertex_count;
    pc_index *start;     /* vertex_count+1 offsets into neighbour */
    pc_index *neighbour; /* ascending within a row, without the vertex itself; symmetric */
} pc_graph;

/* An isolated vertex has an empty row. PC_E_NOMEM; PC_E_MESH where 32-bit offsets do not suffice. */
pc_status pc_graph_make(pc_graph *graph, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency);
void pc_graph_free(pc_graph *graph, pc_context *ctx);
/* Rows ascending, in range, without loops, symmetric. PC_E_BUG else. */
pc_status pc_graph_check(const pc_graph *graph, pc_context *ctx);

static inline pc_index pc_graph_degree(const pc_graph *graph, pc_index v) {
    return graph->start[v + 1] - graph->start[v];
}
/* Is w a neighbour of v? Bisection. */
bool pc_graph_has(const pc_graph *graph, pc_index v, pc_index w);

#endif
