/* Takes small relief out of a connection, so that bumps smaller than a cell attract no singularities. */
#ifndef PC_RELIEF_H
#define PC_RELIEF_H

#include "connection.h"
#include "device.h"
#include "solver.h"

/* transport[3F] out: the connection's transport changed as little as can be, so that the Gaussian curvature
 * it sees is the mesh's diffused over `length` (model units): (A + length^2 D) k' = K on the faces, D the
 * dual Laplacian, then transport -= length^2 * dual gradient of k'. Total curvature stays (Ray, Vallet,
 * Alonso and Levy, Geometry-aware direction field processing, 2009, do the same with a target curvature).
 * No edge's transport changes by more than 0.3 radians. length 0 copies. PC_E_NOMEM, PC_E_DEVICE,
 * PC_E_NOCONV. */
pc_status pc_relief_smooth(double *transport, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                           const pc_adjacency *adjacency, const pc_connection *connection, double length,
                           const pc_solver_options *solver);

#endif
