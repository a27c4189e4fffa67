/* Vectors of parameters across a T-mesh: knots agree on both sides of every edge but for a quarter turn, so
 * that faces around can be laid out in the frame of one. */
#ifndef PC_CHART_H
#define PC_CHART_H

#include "tmesh.h"

/* A point of a face, in the frame of the face. */
typedef struct pc_spot {
    pc_index face;
    double at[2];
} pc_spot;

/* The shortest way from a to b, in the frame of a's face, among those that cross few edges. False where b's
 * face is not near, or only beyond the border. */
bool pc_chart_between(double way[2], const pc_tmesh *mesh, const pc_spot *a, const pc_spot *b);
/* Where a straight way in the frame of `from` leads; it stops at the border of the surface. */
pc_spot pc_chart_walk(const pc_tmesh *mesh, const pc_spot *from, const double way[2]);

#endif
