/* Glues triangles along edges into oriented 2-manifold sheets, also where more than two meet at an edge. */
#ifndef PC_SHEETS_H
#define PC_SHEETS_H

#include "trimesh.h"

/* Faces at an edge beyond which no pairing is tried: all are cut apart. */
enum { PC_SHEETS_MOST_PAIRED = 64 };

typedef struct pc_sheets {
    pc_index
        *twin; /* per half-edge: the one it is glued to (same or opposite direction, see flip), or PC_NONE */
    uint8_t *flip;   /* per face: 1 where it must be turned round, so that all glued pairs are opposite */
    pc_index *piece; /* per face: its connected piece, numbered by smallest face */
    pc_index piece_count;
    pc_index edge_count;
    uint8_t *vertex_cut; /* per vertex: 1 at the ends of crowded and torn edges */
    pc_index *crowded;   /* one half-edge of each edge with more than two faces */
    pc_index crowded_count;
    pc_index *torn; /* one half-edge of each edge where a piece has no orientation; left unglued */
    pc_index torn_count;
} pc_sheets;

/* Edges with two faces are glued, and pieces of them oriented by flood fill. At a crowded edge the faces are
 * then paired as straight on as possible: first those that keep the orientations given, convex before
 * concave, faces that hang on this edge only last; never so that a piece loses its orientation. The rest
 * stays open there. In a piece of mixed orientation the majority is kept; if it is closed, it is turned
 * outward (positive volume). Deterministic. PC_E_NOMEM.*/
pc_status pc_sheets_make(pc_sheets *sheets, pc_context *ctx, const pc_mesh *mesh);
void pc_sheets_free(pc_sheets *sheets, pc_context *ctx);

#endif
