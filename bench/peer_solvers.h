/* Other people's solvers on our systems: CHOLMOD in METIS' order, hypre's BoomerAMG. Where they are not
 * installed, the functions say so. */
#ifndef PC_PEER_SOLVERS_H
#define PC_PEER_SOLVERS_H

#include "system.h"

typedef struct pc_peer_result {
    double setup_cpu, setup_wall;
    double solve_cpu[2], solve_wall[2]; /* for each tolerance */
    double residual[2];
    int iterations[2];
    double bytes_before; /* resident before the set-up */
    double bytes_peak;   /* the most until the last solve was done; 0: as much as at the end */
} pc_peer_result;

/* b and x: width*row_count numbers. PC_E_USAGE where it was not built in. */
pc_status pc_peer_cholmod(pc_peer_result *result, pc_context *ctx, const pc_system *system, const double *b,
                          double *x, const double tolerance[2]);
pc_status pc_peer_boomeramg(pc_peer_result *result, pc_context *ctx, const pc_system *system, const double *b,
                            double *x, const double tolerance[2]);
/* |b - A x| / |b| */
double pc_peer_residual(const pc_system *system, pc_context *ctx, const double *b, const double *x);

#endif
