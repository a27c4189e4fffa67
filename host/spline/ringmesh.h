/* A few quads around one in the middle, whose vertices are combinations of given points: what local
 * subdivision works on. Only the middle face is complete; the others know their neighbours among themselves.
 */
#ifndef PC_RINGMESH_H
#define PC_RINGMESH_H

#include "context.h"

typedef struct pc_ringface {
    pc_index vertex[4];
    pc_index near[4];     /* the face across side k (from corner k to k+1), PC_NONE where it is not there */
    uint8_t near_side[4]; /* and which of its sides that is */
    double interval[4];   /* of side k */
    double ahead[4];      /* the next interval beyond corner k+1 in the direction of side k */
    double behind[4];     /* and beyond corner k against it */
} pc_ringface;

typedef struct pc_ringvertex {
    bool extraordinary;
    uint8_t depth;
} pc_ringvertex;

typedef struct pc_ringmesh {
    pc_index face_count, vertex_count;
    pc_index width;    /* points that the rows combine */
    pc_ringface *face; /* the middle one first */
    pc_ringvertex *vertex;
    double *row; /* width per vertex */
} pc_ringmesh;

/* One corner of one face. */
typedef struct pc_ringcorner {
    pc_index face;
    int corner;
} pc_ringcorner;

pc_status pc_ringmesh_make(pc_ringmesh *ring, pc_context *ctx, size_t faces, size_t vertices, size_t width);
void pc_ringmesh_free(pc_ringmesh *ring, pc_context *ctx);

/* The next face counter-clockwise around the vertex at a corner; face PC_NONE where it is not there. */
static inline pc_ringcorner pc_ringmesh_ccw(const pc_ringmesh *ring, pc_ringcorner at) {
    const pc_ringface *face = ring->face + at.face;
    int side = (at.corner + 3) & 3;
    return (pc_ringcorner){face->near[side], face->near_side[side]};
}

/* One step of subdivision of all that touches the middle face; `middle` has its four parts, part k at corner
 * k, in the frame of the middle face. Face point, edge point and vertex point as in digest C36. */
pc_status pc_ringmesh_subdivide(pc_ringmesh *finer, pc_index middle[4], pc_context *ctx,
                                const pc_ringmesh *ring);
/* The faces around face f, which becomes the middle one. */
pc_status pc_ringmesh_around(pc_ringmesh *part, pc_context *ctx, const pc_ringmesh *ring, pc_index f);
/* The Bezier points of the middle face as 16 rows of `width` (i + 4j): those of the B-spline, with the limit
 * of Catmull and Clark at extraordinary corners. */
void pc_ringmesh_bezier(double *weight, const pc_ringmesh *ring);

#endif
