/* Solves A X = B for three right-hand sides at once, as fits of surfaces in space have them: conjugate
 * gradients with D^-1, one pass over the matrix per iteration for all three, each with its own step lengths.
 * A column that is done stays as it is. */
#ifndef PC_THREEFOLD_H
#define PC_THREEFOLD_H

#include "device.h"
#include "system.h"

typedef struct pc_threefold pc_threefold;

typedef struct pc_threefold_stats {
    pc_index iterations; /* of the slowest column */
    double residual[3];  /* |b - A x| at the end */
} pc_threefold_stats;

/* `system` is of kind PC_BLOCK_SCALAR. On the host it is borrowed and must outlive the solver; on a device it
 * is copied. PC_E_NOMEM, PC_E_DEVICE. */
pc_status pc_threefold_make(pc_threefold **solver, pc_context *ctx, pc_device *device,
                            const pc_system *system);
/* NULL is fine. */
void pc_threefold_free(pc_threefold *solver, pc_context *ctx);
/* x holds the start on entry and the solution on return, b is left alone; both 3 numbers per row. Each column
 * k goes on until |b - A x| <= goal[k]; PC_E_NOCONV where `most` iterations do not get there: x is then the
 * best so far and `stats` says how good. The same bytes for any number of threads. */
pc_status pc_threefold_solve(pc_threefold *solver, pc_context *ctx, pc_threefold_stats *stats, double *x,
                             const double *b, const double goal[3], pc_index most);

#endif
