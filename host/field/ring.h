/* The neighbours of each vertex as compressed rows: what gathers over a 1-ring and sparse systems share. */
#ifndef PC_RING_H
#define PC_RING_H

#include "adjacency.h"

typedef struct pc_ring {
    pc_index vertex_count;
    pc_index *start;  /* vertex_count+1 offsets */
    pc_index *vertex; /* per entry: the neighbour, ascending within a row */
    pc_index *half;   /* per entry: the half-edge of the spoke; its tail is the row's vertex, but for one
                         boundary   spoke per boundary vertex, where only the incoming half-edge exists */
} pc_ring;

/* PC_E_NOMEM. 2 entries per edge. */
pc_status pc_ring_make(pc_ring *ring, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency);
void pc_ring_free(pc_ring *ring, pc_context *ctx);

#endif
