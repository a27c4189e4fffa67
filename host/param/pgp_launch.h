/* The passes of PGP on an OpenCL device (kernels/pgp.cl). Twins of the plain C in coupling.c, pgp.c and
 * reconstruct.c.
 *
 * Everything per edge, row or phase goes through the device in ranges well below its allocation cap; only
 * what is read in any order (positions, frames, couplings, coordinates) is there as a whole. All give
 * PC_E_DEVICE on a device without doubles, PC_E_NOMEM, PC_E_INTERRUPT. */
#ifndef PC_PGP_LAUNCH_H
#define PC_PGP_LAUNCH_H

#include "coupling.h"
#include "edge_rows.h"
#include "param.h"

/* Advance and weight of `coupling`; its turns are there. As the reference to a relative 1e-5. */
pc_status pc_pgp_launch_couple(pc_coupling *coupling, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                               const pc_adjacency *adjacency, const pc_field *field, const double *scale,
                               double period_length);
/* Values, turns and diagonal (weights only) of `system`; start and column are there. To rounding. */
pc_status pc_pgp_launch_assemble(pc_system *system, pc_context *ctx, pc_device *device,
                                 const pc_edge_rows *rows, const pc_coupling *coupling);
/* U and V of `count` vertices brought to norm 1, in place. To rounding. */
pc_status pc_pgp_launch_normalise(double *phase, pc_context *ctx, pc_device *device, pc_index count);
/* coordinate[2*count] from phase[4*count]; to the last odd number. */
pc_status pc_pgp_launch_coordinates(int32_t *coordinate, pc_context *ctx, pc_device *device,
                                    const double *phase, pc_index count);
/* turn and shift of param->coordinate on both sides of each edge; the reference's numbers. */
pc_status pc_pgp_launch_shifts(pc_param *param, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                               const pc_adjacency *adjacency, const pc_coupling *coupling);

#endif
