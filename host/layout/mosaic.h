/* The cells of a layout as polygons that can be joined: what PC_NGONS_KEEP writes instead of the bare cells.
 *
 * A layout is right as a graph, but two of its lines may meet twice in a sliver, a cell may touch itself at a
 * node, and a line may start and end within a few cells. Joining two cells over the arcs that they share
 * takes such things out and leaves disks, with the same Euler number. */
#ifndef PC_MOSAIC_H
#define PC_MOSAIC_H

#include "layout.h"
#include "polymesh.h"
#include "vec3.h"

/* Sides are numbered as in a layout: 2*arc on the arc's left, 2*arc+1 on its right, side^1 is the twin. */
typedef struct pc_mosaic {
    const pc_layout *layout; /* borrowed */
    pc_index node_count, arc_count, cell_count;
    pc_index *degree; /* per node: arcs that are left, 0 where it is gone */
    uint8_t *border;  /* per node: 1 on a boundary */
    pc_index *tail;   /* per side: the node it starts at */
    pc_index *next;   /* per side: the next one around its cell, counter-clockwise; PC_NONE past a boundary */
    pc_index *prev;   /* per side */
    pc_index *cell;   /* per side: its cell, PC_NONE past a boundary and where the arc is gone */
    double *angle;    /* per side: inside the cell at its first node, measured on the scan */
    double *length;   /* per arc */
    pc_index *via;    /* per arc: a former node near its middle, PC_NONE where it is an arc of the layout */
    pc_index *first;  /* per cell: one of its sides, PC_NONE where it has been joined to another */
    pc_index *joined; /* per cell: the one it has been joined to, itself while it is there */
    double *area;     /* per cell, model units squared */
    pc_index *scratch; /* per cell and node: marks of the search at hand */
    pc_index mark;
} pc_mosaic;

pc_status pc_mosaic_make(pc_mosaic *mosaic, pc_context *ctx, const pc_layout *layout);
void pc_mosaic_free(pc_mosaic *mosaic, pc_context *ctx);
/* Every side where its neighbours say, degrees and joined cells right, nodes - arcs + cells = chi of the
 * layout, no arc with the same cell on both sides. PC_E_BUG else. */
pc_status pc_mosaic_check(const pc_mosaic *mosaic, pc_context *ctx);

/* Of a cell that is there: T-junctions end sides too. */
static inline pc_index pc_mosaic_side_count(const pc_mosaic *m, pc_index cell) {
    pc_index count = 0, s = m->first[cell];
    do {
        count++;
        s = m->next[s];
    } while (s != m->first[cell]);
    return count;
}

/* A T-junction on a straight side of the cell of `side`, at its first node. */
static inline bool pc_mosaic_is_flat(const pc_mosaic *m, pc_index side) {
    return m->degree[m->tail[side]] == 3 && m->angle[side] > 0.75 * PC_PI;
}
/* The next side that leaves the same node, counter-clockwise; PC_NONE past a boundary. */
static inline pc_index pc_mosaic_turn(const pc_mosaic *m, pc_index side) {
    return m->cell[side] == PC_NONE ? PC_NONE : m->prev[side] ^ 1;
}
/* Whether the rim of the cell comes by the same node twice. */
bool pc_mosaic_is_pinched(const pc_mosaic *mosaic, pc_index cell);

/* Joins cell `other` to cell `to` over all arcs that they share; nodes that only two straight arcs are left
 * at go too. False, with nothing done, where the two share no arc or enclose something. */
bool pc_mosaic_join(pc_mosaic *mosaic, pc_index to, pc_index other);
/* Joins what has fewer than three corners, touches itself, or folds inwards to the neighbour with which it
 * makes the best cell, and triangles to pentagons. Returns the number of joins. */
pc_index pc_mosaic_mend(pc_mosaic *mosaic);
/* Joins each cell with wanted[cell] != 0 to the best neighbour, whatever it costs in quads, and mends what
 * comes of it. */
pc_index pc_mosaic_dissolve(pc_mosaic *mosaic, const uint8_t *wanted);
/* What has served well. */
#define PC_MOSAIC_LONGEST  16
#define PC_MOSAIC_SLIMMEST 3.0
/* Takes out lines that start at one T-junction and end at another, or at a border, where only quads lie along
 * them: two cells become one that is not `slimmest` times as long as wide. No longer ones than `longest`
 * arcs, short ones first. Returns the number of T-junctions that are gone. */
pc_status pc_mosaic_drop_lines(pc_mosaic *mosaic, pc_index *gone, pc_context *ctx, pc_index longest,
                               double slimmest);

/* The cells as polygons; `face_cell` (per face, the caller frees it with pc_free; or NULL) tells which cell.
 * Arcs between the same two nodes, and the sides of cells with fewer than three, get a vertex in their
 * middle; a cell that still touches itself is split around its centre. */
pc_status pc_mosaic_polygons(pc_polymesh *polygons, pc_index **face_cell, pc_context *ctx,
                             const pc_mosaic *mosaic);

#endif
