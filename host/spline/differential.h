/* What the derivatives at a point of a surface say about it. */
#ifndef PC_DIFFERENTIAL_H
#define PC_DIFFERENTIAL_H

#include "tspline.h"

/* Unit normal, outward where the faces run counter-clockwise; zero where the derivatives are parallel. */
pc_vec3 pc_surface_normal(const pc_surface_point *at);

/* Principal curvatures k[0] >= k[1], positive where convex as in `percale`'s other results, 1/model units.
 * False, with zeros, where the derivatives are parallel. (The eigenvalues of the shape operator in an
 * orthonormal frame, which keeps them exact at umbilics; do Carmo 1976, section 3-3.) */
bool pc_surface_curvatures(double k[2], const pc_surface_point *at);

#endif
