/* How far the other side of a wall, or of a gap, is. */
#ifndef PC_THICKNESS_H
#define PC_THICKNESS_H

#include "ground.h"

/* The distance from scan vertex v to the nearest place that faces the other way, across the surface or across
 * what is outside: the chord of the largest empty ball that touches the scan there (Ma, Bae, Choi, 3D medial
 * axis point approximation using nearest neighbors and the normal field, 2012). INFINITY where it is farther
 * than `most`, or the ball meets something else first, as beside an edge. */
double pc_thickness_at(const pc_ground *ground, pc_index v, double most);

#endif
