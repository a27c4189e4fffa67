/* The solver of threefold.h on an OpenCL device (kernels/threefold.cl). */
#ifndef PC_THREEFOLD_DEVICE_H
#define PC_THREEFOLD_DEVICE_H

#include "threefold.h"

typedef struct pc_threefold_device pc_threefold_device;

/* PC_E_DEVICE on a device without doubles. */
pc_status pc_threefold_device_make(pc_threefold_device **solver, pc_context *ctx, pc_device *device,
                                   const pc_system *system);
/* NULL is fine. */
void pc_threefold_device_free(pc_threefold_device *solver, pc_context *ctx);
/* As pc_threefold_solve. */
pc_status pc_threefold_device_run(pc_threefold_device *solver, pc_context *ctx, pc_threefold_stats *stats,
                                  double *x, const double *b, const double goal[3], pc_index most);

#endif
