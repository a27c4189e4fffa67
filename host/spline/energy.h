/* What a fit minimises, as a linear system for the control points: the weighted squares of the distances to
 * samples, and the bending of thin plates (digest C38, C39). */
#ifndef PC_ENERGY_H
#define PC_ENERGY_H

#include "system.h"
#include "tspline.h"

/* A point that the surface should have at a place. */
typedef struct pc_sample {
    pc_surface_place place;
    pc_vec3 target;
    double weight;
} pc_sample;

/* The matrix and three right-hand sides (3 x vertex_count, coordinate by coordinate) of
 *   sum of weight |S(place) - target|^2 + fairness * sum over faces of the integral over [0,1]^2 of
 *   |S_uu|^2 + 2 |S_uv|^2 + |S_vv|^2, u and v running from 0 to 1 across each face.
 * Both terms scale with the square of the model's size, so that the fairness has no unit. `stiffness` (per
 * element, or NULL for 1) multiplies the second. Vertices without a
 * function on the surface keep their position. `samples` are sorted by element. The same bytes for any number
 * of threads. PC_E_NOMEM; PC_E_MESH where there are too many couplings. */
pc_status pc_energy_assemble(pc_system *system, double **right, pc_context *ctx, const pc_tspline *spline,
                             const pc_sample *samples, size_t count, double fairness,
                             const double *stiffness);

#endif
