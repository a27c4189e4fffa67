/* Coordinates that fit the advances best, the transitions held fixed: a Poisson problem with quarter turns.
 */
#ifndef PC_INTEGRATE_H
#define PC_INTEGRATE_H

#include "coupling.h"
#include "edge_rows.h"
#include "param.h"
#include "solver.h"

/* Moves param->coordinate to the minimum of sum_e weight |g_ij p_j - p_i - advance|^2, g the transitions of
 * `param`, with the corners of singular triangles drawn to their cones. PGP leaves the strain of every
 * dislocation at one spot; this spreads it as evenly as it can be. Flags and shifts are not touched.
 * `*solver`, NULL at first, is kept for further calls with the same turns; the caller frees it. */
pc_status pc_integrate(pc_param *param, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                       const pc_adjacency *adjacency, const pc_coupling *coupling, const pc_edge_rows *rows,
                       const pc_field *field, const double *scale, pc_solver **solver, double tolerance,
                       pc_index *iterations);

#endif
