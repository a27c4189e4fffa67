/* Smooth unit-length complex fields z = exp(i N angle) on a connection, near to given data. */
#ifndef PC_SMOOTH_H
#define PC_SMOOTH_H

#include "connection.h"
#include "device.h"
#include "ring.h"
#include "solver.h"

typedef struct pc_smooth_options {
    int symmetry;
    double smoothness; /* rho */
    double length;     /* l, model units */
    double relief;     /* relief shorter than this, model units, does not turn the field (relief.h) */
    int rounds;
    double tolerance;
    pc_solver_options solver;
} pc_smooth_options;

/* One step minimises, over complex z,
 *   (1-rho)/l^2 sum A_i w_i |z_i - z0_i|^2 + rho sum lambda_e |z_j - exp(i N r_ij) z_i|^2 + mu sum A_i |z_i -
 * u_i|^2 with u the last z made unit-length. The first has a mu so small that it only decides where no data
 * is (on a sphere: a step of inverse iteration); `rounds` more have a diffusion length 1/sqrt(mu) that falls
 * to l, so that z does not decay between data and close pairs of singularities cancel (Viertel and Osting
 * 2019). angle[V] out: arg(z)/N. area, target (2 per vertex: z0) and weight (w >= 0) per vertex. PC_E_NOMEM,
 * PC_E_DEVICE, PC_E_NOCONV, PC_E_INTERRUPT. */
pc_status pc_smooth_field(double *angle, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                          const pc_adjacency *adjacency, const pc_connection *connection, const double *area,
                          const double *target, const double *weight, const pc_smooth_options *options);

#endif
