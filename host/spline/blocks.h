/* Rectangles of regular faces that are one B-spline surface each. */
#ifndef PC_BLOCKS_H
#define PC_BLOCKS_H

#include "tspline.h"

/* A face in the frame of its block: its point p is at origin + R^turn p there, R a quarter turn. */
typedef struct pc_block_cell {
    pc_index face;
    int turn;
    double origin[2];
} pc_block_cell;

typedef struct pc_block {
    pc_index cell_count;
    size_t cell; /* its first in pc_blocks.cell */
    double size[2];
    pc_index side_count; /* half-edges around it, counter-clockwise from (0,0), its faces on their left */
    size_t side;         /* the first in pc_blocks.side */
} pc_block;

typedef struct pc_blocks {
    pc_index block_count;
    pc_block *block;
    pc_block_cell *cell;
    pc_index *side;
    pc_index *of_face; /* per face: its block, PC_NONE for ghosts and faces with extraordinary corners */
} pc_blocks;

/* Greedy: a face that is in no block yet grows by whole rows of faces, which must fit exactly. PC_E_NOMEM. */
pc_status pc_blocks_make(pc_blocks *blocks, pc_context *ctx, const pc_tspline *spline);
void pc_blocks_free(pc_blocks *blocks, pc_context *ctx);

/* The block as one bicubic B-spline surface. Its lines in direction k (ascending distinct knots from 0 to the
 * size, simple inside, fourfold at the ends) and its control points, (lines[0]+2) x (lines[1]+2), s fastest.
 * The caller frees both. */
typedef struct pc_block_surface {
    pc_index line_count[2];
    double *line[2];
    double *point;
} pc_block_surface;
pc_status pc_block_surface_make(pc_block_surface *surface, pc_context *ctx, const pc_tspline *spline,
                                const pc_blocks *blocks, pc_index block);
void pc_block_surface_free(pc_block_surface *surface, pc_context *ctx);

#endif
