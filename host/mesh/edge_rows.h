/* The sparsity of every system on the vertices of a mesh: a row per vertex, an entry per neighbour. */
#ifndef PC_EDGE_ROWS_H
#define PC_EDGE_ROWS_H

#include "adjacency.h"

typedef struct pc_edge_rows {
    pc_index row_count;
    pc_index edge_count;
    pc_index *start;  /* row_count+1 offsets */
    pc_index *column; /* 2*edge_count neighbours, ascending in each row */
    pc_index
        *slot; /* 2 per edge i->j (as in pc_adjacency.edge_half): where entry (i,j) stands, where (j,i) */
} pc_edge_rows;

pc_status pc_edge_rows_make(pc_edge_rows *rows, pc_context *ctx, const pc_mesh *mesh,
                            const pc_adjacency *adjacency);
void pc_edge_rows_free(pc_edge_rows *rows, pc_context *ctx);

#endif
