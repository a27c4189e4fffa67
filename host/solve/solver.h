/* Solves A x = b for a pc_system on a device: conjugate gradients with a preconditioner. */
#ifndef PC_SOLVER_H
#define PC_SOLVER_H

#include "device.h"
#include "system.h"

typedef struct pc_solver pc_solver;

typedef enum pc_preconditioner { PC_PRECONDITION_JACOBI, PC_PRECONDITION_MULTIGRID } pc_preconditioner;

typedef struct pc_solver_options {
    pc_preconditioner preconditioner;
    pc_index max_iterations;
    pc_index spread_rows; /* levels with as many rows per member are spread over the members of a device; 0:
                             as many as are worth it */
    bool half; /* on devices: the hierarchy's numbers in 16 bits, else in 32: less memory and less to move;
                  about the same iterations */
} pc_solver_options;
#define PC_SOLVER_DEFAULTS                                                                                   \
    { PC_PRECONDITION_MULTIGRID, 500, 0, true }

typedef struct pc_solver_stats {
    pc_index iterations;
    double residual;      /* |b - A x| / |b| at the end */
    double setup_seconds; /* of the last make, update or set_diagonal */
    double solve_seconds;
} pc_solver_stats;

/* Copies what it needs of `system`. The device must outlive the solver. The members of a device compute
 * together, with the same bytes as one. */
pc_status pc_solver_make(pc_solver **solver, pc_context *ctx, pc_device *device, const pc_system *system,
                         const pc_solver_options *options);
/* New values on the same graph. */
pc_status pc_solver_update(pc_solver *solver, pc_context *ctx, const pc_system *system);
/* Another diagonal on the same couplings, nowhere below that of the last make or update (PC_E_BUG): costs
 * about as much as an iteration. The preconditioner fits best where the changes are smooth. */
pc_status pc_solver_set_diagonal(pc_solver *solver, pc_context *ctx, const double *diagonal);
/* x holds the start on entry and the solution on return; b is left alone; both width*row_count numbers.
 * PC_E_NOCONV where max_iterations do not reach `tolerance` (relative residual): x is then the best so far.
 */
pc_status pc_solver_solve(pc_solver *solver, pc_context *ctx, double *x, const double *b, double tolerance,
                          pc_solver_stats *stats);
/* As pc_solver_solve, for callers that can go on from less: up to a relative residual of `worst` the best so
 * far is taken, with a warning. */
pc_status pc_solver_approach(pc_solver *solver, pc_context *ctx, double *x, const double *b, double tolerance,
                             double worst, pc_solver_stats *stats);
void pc_solver_free(pc_solver *solver, pc_context *ctx);

#endif
