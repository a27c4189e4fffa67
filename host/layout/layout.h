/* The cell complex that iso-lines draw on a scan: nodes, arcs and cells, realised as edges of a refined scan.
 */
#ifndef PC_LAYOUT_H
#define PC_LAYOUT_H

#include "param.h"

typedef struct pc_layout {
    pc_mesh mesh; /* the scan, its triangles split along the arcs; scan vertices come first, in order */
    pc_index *source_face; /* per triangle of mesh: the triangle of the scan it lies in */
    pc_index *cell;        /* per triangle of mesh: the cell it lies in */
    pc_index node_count;
    pc_index *node_vertex; /* per node: its vertex of mesh */
    pc_index arc_count;
    pc_index *arc_start; /* arc_count+1 offsets into arc_vertex */
    pc_index
        *arc_vertex; /* per arc the chain of mesh vertices from its first node to its last, both included */
    pc_index *arc_node; /* 2 per arc: first and last node */
    pc_index *arc_cell; /* 2 per arc: the cell on its left and on its right, PC_NONE past a boundary */
    pc_index cell_count;
    pc_index *cell_start; /* cell_count+1 offsets into cell_side */
    pc_index *cell_side;  /* counter-clockwise sides of each cell: 2*arc, +1 where the arc is run backwards */
    uint8_t *
        cell_side_flat; /* per side: 1 where its first node is a T-junction on a straight side of this cell */
} pc_layout;

typedef struct pc_layout_stats {
    pc_index dangling_edges; /* pieces of lines removed because they ended at a singularity */
    pc_index cut_cells;      /* regions that were no disks and have been cut */
    pc_index split_cells;    /* cells that met themselves and have been split */
} pc_layout_stats;

/* The cells between the iso-lines of `param`. Every cell is a disk, no arc has the same cell on both sides or
 * the same node at both ends, so that nodes - arcs + cells = chi of the mesh, exactly (digest C28, C29). */
pc_status pc_layout_make(pc_layout *layout, pc_layout_stats *stats, pc_context *ctx, const pc_mesh *mesh,
                         const pc_param *param);
void pc_layout_free(pc_layout *layout, pc_context *ctx);
/* All that is promised above, and that every side of every cell is where the arcs say. PC_E_BUG else. */
pc_status pc_layout_check(const pc_layout *layout, pc_context *ctx);

#endif
