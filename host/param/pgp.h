/* The periodic unknowns of PGP: X = (cos s, sin s, cos t, sin t) per vertex, as smooth as the couplings
 * allow. */
#ifndef PC_PGP_H
#define PC_PGP_H

#include "coupling.h"
#include "edge_rows.h"
#include "newton.h"
#include "solver.h"

typedef enum pc_pgp_scheme {
    PC_PGP_NORMALISE, /* normalise and solve, in steps of falling reach */
    PC_PGP_NEWTON     /* a penalty on norms other than 1, by Newton's method (digest C24): the reference */
} pc_pgp_scheme;

typedef struct pc_pgp_options {
    pc_pgp_scheme scheme;
    double
        first_reach; /* diffusion lengths, in periods, of the first and the last normalise-and-solve step; */
    double last_reach; /* long reaches let dislocations find and cancel each other */
    int steps;
    double tolerance; /* relative residual of each solve */
    uint64_t seed;    /* of the start where `phase` holds zeros */
    pc_newton_options newton;
} pc_pgp_options;
#define PC_PGP_DEFAULTS                                                                                      \
    { PC_PGP_NORMALISE, 8.0, 0.7, 12, 1e-2, 1, PC_NEWTON_DEFAULTS }

typedef struct pc_pgp_stats {
    double energy;       /* sum of weight * |M^r X_j - D X_i|^2 over the edges, norms 1 */
    pc_index iterations; /* of the linear solver, all steps */
    pc_index steps;
    double seconds_in_solver;
} pc_pgp_stats;

/* The system whose quadratic form is sum_e weight_e |M^r X_j - D(advance) X_i|^2, made by this call: by the
 * kernel pgp_assemble or, on the host device, in plain C; they agree to rounding. */
pc_status pc_pgp_assemble(pc_system *system, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                          const pc_adjacency *adjacency, const pc_edge_rows *rows,
                          const pc_coupling *coupling);

/* U and V of each of `count` vertices brought to norm 1; zeros become 1. Kernel pgp_normalise or plain C. */
pc_status pc_pgp_normalise(double *phase, pc_context *ctx, pc_device *device, pc_index count);

/* Fills phase (4 per vertex, U and V of norm 1). No vertex is pinned: that lets |X| fall to 1e-16 over a
 * million vertices. Each normalise-and-solve step solves (A + M/reach^2) Y = M X/reach^2 and sets X = Y with
 * U and V brought back to norm 1. Newton starts from the first of these steps with the norms as they are; its
 * penalty, 1e-3 per vertex where ten mean edges are a period as in the paper, goes with area/period^2, so
 * that subdividing the mesh changes nothing. */
pc_status pc_pgp_solve(double *phase, pc_pgp_stats *stats, pc_context *ctx, pc_device *device,
                       const pc_mesh *mesh, const pc_adjacency *adjacency, const pc_coupling *coupling,
                       double period_length, const pc_pgp_options *options);

#endif
