/* The regions that drawn lines cut a mesh into, made to be disks that nowhere touch themselves along a line.
 */
#ifndef PC_CELLS_H
#define PC_CELLS_H

#include "overlay.h"

typedef struct pc_cells {
    uint8_t
        *wall; /* per edge of the overlay's mesh: 1 where it separates (drawn, or a boundary of the scan) */
    pc_index *cell; /* per face */
    pc_index cell_count;
} pc_cells;

typedef struct pc_cells_stats {
    pc_index dangling_edges; /* removed: pieces of lines that ended at singular triangles */
    pc_index cut_cells;      /* cells that were no disks and have been cut open */
    pc_index split_cells;    /* cells that met themselves along a line and have been split */
} pc_cells_stats;

/* Removes dangling lines, cuts what is no disk, splits what meets itself. The overlay is refined where a
 * split finds no way through; `adjacency` is that of overlay->mesh and is remade then. On success every cell
 * is an open disk whose rim runs along each wall at most once. */
pc_status pc_cells_make(pc_cells *cells, pc_cells_stats *stats, pc_context *ctx, pc_overlay *overlay,
                        pc_adjacency *adjacency);
void pc_cells_free(pc_cells *cells, pc_context *ctx);

/* The next wall half-edge along the rim of the cell on the left of h (digest C29's faces of the graph). */
static inline pc_index pc_rim_next(const pc_adjacency *adjacency, const uint8_t *wall, pc_index h) {
    pc_index g = pc_next(h);
    while (!wall[adjacency->edge[g]])
        g = pc_next(adjacency->twin[g]);
    return g;
}

#endif
