/* The control mesh of a T-spline: quadrilateral faces of rectangular parameters, with T-junctions in their
 * sides, around vertices of any valence. Half-edges carry knot intervals (digest C33, C34).
 *
 * Open surfaces are continued by one ring of ghost faces, so that what is a border of the surface lies inside
 * the control mesh and reaches the scan's border with full freedom; no point of the surface is in a ghost.
 * Past the outer rim of the ghosts run half-edges of no face: every half-edge has a twin. */
#ifndef PC_TMESH_H
#define PC_TMESH_H

#include "polymesh.h"

enum { PC_TMESH_VALENCE = 64 }; /* the largest */

typedef struct pc_thalf {
    pc_index tail; /* vertex it leaves */
    pc_index next, prev, twin;
    pc_index face;   /* on its left; PC_NONE outside of the rim */
    double interval; /* knots between tail and head, the same as the twin's */
    double along;    /* of the tail from the start of its side of the face; 0 at the four corners */
    uint8_t side;    /* 0..3 counter-clockwise: +s, +t, -s, -t in the frame of the face */
} pc_thalf;

typedef struct pc_tface {
    pc_index first;   /* the half-edge that leaves the corner (0,0) along side 0 */
    double size[2];   /* of the rectangle of parameters */
    pc_index root;    /* the face of the mesh before the last refinement that this one is a part of */
    double origin[2]; /* of this face in the frame of its root */
    bool ghost;
} pc_tface;

typedef struct pc_tvertex {
    pc_index out;       /* one half-edge that leaves it; on the rim the one whose twin has no face */
    bool extraordinary; /* the angles of the faces around do not sum to a full turn */
    uint8_t depth;      /* subdivisions around it before the closing patches; extraordinary vertices only */
} pc_tvertex;

typedef struct pc_tmesh {
    pc_index vertex_count, half_count, face_count;
    size_t vertex_room, half_room, face_room; /* elements the arrays have room for */
    pc_tvertex *vertex;
    pc_thalf *half;
    pc_tface *face;
} pc_tmesh;

typedef struct pc_tmesh_options {
    uint8_t depth; /* of extraordinary vertices; the paper has 2 */
} pc_tmesh_options;
#define PC_TMESH_DEFAULTS                                                                                    \
    { 3 }

/* Corners of `quads` that are flat become T-junctions. `interval` (one per corner, NULL: all 1): of the edge
 * that leaves it, the same from both sides; ghosts are 1 deep. What pc_tmesh_check asks of intervals is left
 * to those who give them and to pc_closure_settle. `source` (may be NULL; the caller frees it) gets the
 * vertex of `quads` that each vertex stands for, PC_NONE for those of ghosts; a vertex where several fans of
 * faces meet becomes one per fan. PC_E_MESH where a face has not four corners that turn, an edge is not
 * between two faces that run along it in opposite directions, or a vertex has fewer than three faces around
 * or more than PC_TMESH_VALENCE, with the ids. */
pc_status pc_tmesh_make(pc_tmesh *mesh, pc_index **source, pc_context *ctx, const pc_polymesh *quads,
                        const double *interval, const pc_tmesh_options *options);
pc_status pc_tmesh_copy(pc_tmesh *copy, pc_context *ctx, const pc_tmesh *mesh);
void pc_tmesh_free(pc_tmesh *mesh, pc_context *ctx);
/* Links, equal sums of intervals on opposite sides, T-junctions that turn no face inside out, equal intervals
 * around extraordinary vertices, valences. PC_E_BUG else. */
pc_status pc_tmesh_check(const pc_tmesh *mesh, pc_context *ctx);

/* Room for that many more of each. PC_E_NOMEM. */
pc_status pc_tmesh_reserve(pc_tmesh *mesh, pc_context *ctx, size_t vertices, size_t halves, size_t faces);
/* Sets side and along of the half-edges of face f, whose `first` and turns (along 0 at corners) are known. */
void pc_tmesh_measure(pc_tmesh *mesh, pc_index f);

static inline pc_index pc_thalf_head(const pc_tmesh *mesh, pc_index h) {
    return mesh->half[mesh->half[h].twin].tail;
}
/* The tail is one of the four corners of the face. */
static inline bool pc_thalf_turns(const pc_tmesh *mesh, pc_index h) {
    return mesh->half[h].along <= 0;
}
/* The next half-edge that leaves the same vertex, counter-clockwise. */
static inline pc_index pc_thalf_ccw(const pc_tmesh *mesh, pc_index h) {
    return mesh->half[mesh->half[h].prev].twin;
}
static inline pc_index pc_thalf_cw(const pc_tmesh *mesh, pc_index h) {
    return mesh->half[mesh->half[h].twin].next;
}
/* Where the tail of h lies in the frame of its face. */
static inline void pc_thalf_place(double at[2], const pc_tmesh *mesh, pc_index h) {
    const pc_thalf *e = mesh->half + h;
    const double *size = mesh->face[e->face].size;
    at[0] = e->side == 0 ? e->along : e->side == 1 ? size[0] : e->side == 2 ? size[0] - e->along : 0;
    at[1] = e->side == 0 ? 0 : e->side == 1 ? e->along : e->side == 2 ? size[1] : size[1] - e->along;
}
/* The vertices at its corners, from (0,0) counter-clockwise. */
void pc_tface_corners(pc_index corner[4], const pc_tmesh *mesh, pc_index f);
/* One of its corners is extraordinary. */
bool pc_tface_is_irregular(const pc_tmesh *mesh, pc_index f);

#endif
