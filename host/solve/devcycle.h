/* The multigrid cycle on a device (kernels/cycle.cl), or on the members of one: each holds what share.h deals
 * out to it. */
#ifndef PC_DEVCYCLE_H
#define PC_DEVCYCLE_H

#include "exchange.h"
#include "solver.h"

typedef struct pc_devlevel {
    pc_row_order order;
    pc_devmat matrix, prolongator, restriction;
    pc_chebyshev chebyshev;
    size_t numbers;             /* of a vector on the device, without copies */
    pc_buffer *x, *x_other, *b; /* residuals go to x_other; the two change places */
    pc_buffer *lent;            /* the caller's: one of them on the finest level, as x_other to begin with */
} pc_devlevel;

/* One member's part. The first one has all of the levels that are not spread out; where the device computes
 * alone it is the only one. */
typedef struct pc_devcycle {
    struct pc_devcycle *next; /* member */
    int number;
    pc_exchange *exchange; /* of all; NULL where there is but one */
    int spread;            /* levels that all have rows of */
    pc_device *device;
    pc_shape shape;
    int width;
    int level_count;
    pc_storage storage;
    bool jacobi;  /* D^-1 takes the place of the cycle */
    double scale; /* of the hierarchy against the system */
    pc_devlevel level[PC_MOST_LEVELS];
    pc_buffer *direct;
    pc_index direct_count;
    pc_kernel *product, *first, *solve_direct;
} pc_devcycle;

/* As pc_devsolve_make. */
pc_status pc_devcycle_make(pc_devcycle **cycle, pc_context *ctx, pc_device *device, const pc_system *system,
                           pc_multigrid *multigrid, const pc_solver_options *options);
/* After pc_multigrid_set_diagonal. */
pc_status pc_devcycle_set_diagonal(pc_devcycle *cycle, pc_context *ctx, const pc_multigrid *multigrid);
/* NULL is fine. */
void pc_devcycle_free(pc_devcycle *cycle, pc_context *ctx);
/* level[0].x = about (scale A)^-1 level[0].b, on all members. */
pc_status pc_devcycle_run(pc_devcycle *cycle, pc_context *ctx);

#endif
