/* The polygon mesh that a layout becomes. */
#ifndef PC_QUADS_H
#define PC_QUADS_H

#include "layout.h"
#include "polymesh.h"
#include "vec3.h"

typedef enum pc_ngons {
    PC_NGONS_SPLIT, /* every cell becomes quads around its centre: quads only, no T-junctions */
    PC_NGONS_KEEP /* the cells themselves, joined where that makes better ones (see mosaic.h); T-junctions are
                     listed by the polygons on both sides */
} pc_ngons;

/* All vertices lie on the scan. With PC_NGONS_SPLIT a cell of n sides gives n quads (its centre, two middles
 * of sides, a node): singularities inside cells become irregular vertices, T-junctions become pairs of
 * valence 3 and 5, and every edge has two quads by construction. */
pc_status pc_quads_make(pc_polymesh *quads, pc_context *ctx, const pc_layout *layout, pc_ngons ngons);

/* The number of faces pc_quads_make would give; with PC_NGONS_KEEP that before cells are joined. */
size_t pc_quads_count(const pc_layout *layout, pc_ngons ngons);

/* The point halfway along an arc. */
pc_vec3 pc_layout_arc_middle(const pc_layout *layout, pc_index arc);

#endif
