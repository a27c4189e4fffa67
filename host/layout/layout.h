/* The cell complex that iso-lines draw on a scan: nodes, arcs and cells, realised as edges of a refined scan. */
#ifndef PC_LAYOUT_H
#define PC_LAYOUT_H

#include "trimesh.h"

typedef struct pc_layout {
    pc_mesh mesh;            /* the scan, its triangles split along the arcs; scan vertices come first, in order */
    pc_index *source_face;   /* per triangle of mesh: the triangle of the scan it lies in */
    pc_index *cell;          /* per triangle of mesh: the cell it lies in */
    pc_index node_count;
    pc_index *node_vertex;   /* per node: its vertex of mesh */
    pc_index arc_count;
    pc_index *arc_start;     /* arc_count+1 offsets into arc_vertex */
    pc_index *arc_vertex;    /* per arc the chain of mesh vertices from its first node to its last, both included */
    pc_index *arc_node;      /* 2 per arc: first and last node */
    pc_index *arc_cell;      /* 2 per arc: the cell on its left and on its right, PC_NONE past a boundary */
    pc_index cell_count;
    pc_index *cell_start;    /* cell_count+1 offsets into cell_side */
    pc_index *cell_side;     /* counter-clockwise sides of each cell: 2*arc, +1 where the arc is run backwards */
    uint8_t *cell_side_flat; /* per side: 1 where its first node is a T-junction on a straight side of this cell */
} pc_layout;

void pc_layout_free(pc_layout *layout, pc_context *ctx);

#endif
