/* A scale for the field at each vertex that takes its curl away, so that fewer cells break. */
#ifndef PC_CURL_H
#define PC_CURL_H

#include "adjacency.h"
#include "device.h"
#include "field.h"
#include "solver.h"

typedef struct pc_curl_options {
    double least; /* scales end in [least, 1]: cells get at most 1/least times as long */
    double
        quantile; /* of the vertices' scales, the one that becomes 1: spikes at singularities do not set it */
    double tolerance;
    pc_solver_options solver;
} pc_curl_options;
#define PC_CURL_DEFAULTS                                                                                     \
    { 0.25, 0.99, 1e-6, PC_SOLVER_DEFAULTS }

/* scale[V] out, in [least, 1]: nu with curl(nu K) = curl(nu K_perp) = 0 as nearly as can be, K the field's
 * direction. Where K turns by gamma, grad log nu = R90 grad gamma (Li, thesis F.4); least squares over the
 * triangles, one Poisson equation whose right-hand side is half the field's turn along the edge opposite to a
 * vertex, its triangle's curvature taken out. Triangles with a singularity have no gradient: they ask for
 * nothing and count a tenth. Each component has its own scale 1. PC_E_NOMEM, PC_E_DEVICE, PC_E_NOCONV. */
pc_status pc_curl_correct(double *scale, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                          const pc_adjacency *adjacency, const pc_field *field,
                          const pc_curl_options *options);

#endif
