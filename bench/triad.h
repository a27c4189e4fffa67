/* The memory bandwidth of the moment: the roof that benchmarks compare with. */
#ifndef PC_TRIAD_H
#define PC_TRIAD_H

#include "launch.h"

/* GB/s of a = b + s*c over three arrays of `n` doubles: the best of `repeats`. On the host with OpenMP; on a
 * device with its own kernel, timed by profiling events. */
pc_status pc_triad(double *rate, pc_context *ctx, pc_device *device, size_t n, int repeats);

#endif
