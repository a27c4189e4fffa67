/* Fits a T-spline to a surface of which every nearest point is known exactly: what the spline space can do,
 * without a scan's triangles and noise between. */
#ifndef PC_EXACTFIT_H
#define PC_EXACTFIT_H

#include "tspline.h"

typedef struct pc_exact_shape {
    const char *name;
    pc_vec3 (*nearest)(pc_vec3 p);
    bool (*is_away)(pc_vec3 p); /* from extraordinary vertices; NULL: everywhere */
} pc_exact_shape;

/* The unit sphere; away: 20 degrees from the corners of the cube. */
extern const pc_exact_shape pc_exact_sphere;
/* The torus of radii 2 and 1. */
extern const pc_exact_shape pc_exact_torus;

/* Distances of samples on a grid in every element, its borders included. */
typedef struct pc_exact_error {
    double max, rms; /* rms over the area */
    double away_max; /* over the samples away from extraordinary vertices */
} pc_exact_error;
/* `face_max` (per face of the mesh; may be NULL), and `change` (2 per face: sums of squared differences
 * between neighbouring samples along s and t). */
void pc_exact_measure(pc_exact_error *error, double *face_max, double *change, const pc_tspline *spline,
                      const pc_exact_shape *shape);

/* Least squares at Gauss points, every face with equal weight, towards the nearest points of the shape; again
 * from where that leads, until the rms changes by less than 1 %. PC_E_NOMEM, PC_E_NOCONV. */
pc_status pc_exact_fit(pc_tspline *spline, pc_context *ctx, const pc_exact_shape *shape);

#endif
