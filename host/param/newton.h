/* The norms of PGP's unknowns kept near 1 by a penalty, minimised by Newton's method (Li, thesis F.2.5;
 * digest C24). */
#ifndef PC_NEWTON_H
#define PC_NEWTON_H

#include "device.h"
#include "system.h"

typedef struct pc_newton_options {
    double penalty;    /* 1e-3 in the thesis; see pc_pgp_solve for what it is multiplied by */
    double tolerance;  /* root of the mean square of the gradient's entries; or */
    double least_gain; /* where three steps in a row lower F by less than this part of it, the rest is
                          dislocations that drift */
    int most_steps;
} pc_newton_options;
#define PC_NEWTON_DEFAULTS                                                                                   \
    { 1e-3, 1e-6, 3e-4, 60 }

typedef struct pc_newton_stats {
    double value;        /* of F at the end */
    double gradient;     /* as the tolerance */
    pc_index steps;      /* of Newton */
    pc_index products;   /* of the Hessian with a vector */
    pc_index iterations; /* of the multigrid solver inside */
    double seconds_in_solver;
} pc_newton_stats;

/* F(X) = X.AX + sum_i strength_i ((|U_i|^2-1)^2 + (|V_i|^2-1)^2), A a PC_BLOCK_TURNED `system` with the sum
 * of the weights on its diagonal, X = (U,V) per row. Fills gradient = F'(X) and returns F(X). */
double pc_newton_gradient(double *gradient, const pc_system *system, const double *strength, const double *x);
/* y = F''(X) p. Indefinite where |U| < 1: the turn of such a U gains energy from the penalty. */
void pc_newton_hessian(double *y, const pc_system *system, const double *strength, const double *x,
                       const double *p);

/* From x to a minimum nearby. Each step solves F'' d = -F' by conjugate gradients, stopped at a direction of
 * no positive curvature, so that d only lies where F'' is positive definite; their preconditioner is the
 * multigrid solver on the device for A + strength, solved roughly. The way along d is that of the first
 * minimum of the quartic F(x + tau d). strength > 0. PC_E_NOMEM, PC_E_DEVICE, PC_E_INTERRUPT; out of
 * steps it goes on with what it has. */
pc_status pc_newton_solve(double *x, pc_newton_stats *stats, pc_context *ctx, pc_device *device,
                          const pc_system *system, const double *strength, const pc_newton_options *options);

#endif
