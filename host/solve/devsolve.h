/* Conjugate gradients and the multigrid cycle on an OpenCL device (kernels/conjugate.cl, kernels/cycle.cl).
 */
#ifndef PC_DEVSOLVE_H
#define PC_DEVSOLVE_H

#include "multigrid.h"
#include "solver.h"

typedef struct pc_devsolve pc_devsolve;

/* Moves the hierarchy to the device, its diagonals and last level stay here too, and copies the system, which
 * may be freed afterwards. `multigrid` holds all levels, or the finest alone: then D^-1 preconditions.
 * PC_E_DEVICE on a device without doubles. */
pc_status pc_devsolve_make(pc_devsolve **solve, pc_context *ctx, pc_device *device, const pc_system *system,
                           pc_multigrid *multigrid, const pc_solver_options *options);
/* The system's diagonal anew, after pc_multigrid_set_diagonal. */
pc_status pc_devsolve_set_diagonal(pc_devsolve *solve, pc_context *ctx, const double *diagonal,
                                   const pc_multigrid *multigrid);
/* NULL is fine. */
void pc_devsolve_free(pc_devsolve *solve, pc_context *ctx);
/* As pc_solver_solve; fills iterations and residual of `stats`. */
pc_status pc_devsolve_run(pc_devsolve *solve, pc_context *ctx, double *x, const double *b, double tolerance,
                          pc_index max_iterations, pc_solver_stats *stats);

#endif
