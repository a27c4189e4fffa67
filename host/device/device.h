/* OpenCL devices, and `host`: the plain-C references with OpenMP. */
#ifndef PC_DEVICE_H
#define PC_DEVICE_H

#include "context.h"

typedef struct pc_device pc_device;

/* `wanted`: "host", "cpu", "gpu", "P:D" (platform:device) or a part of a device's name; NULL or "default" takes the
 * first CPU, else any device. PC_E_DEVICE lists what is there when nothing fits. */
pc_status pc_device_open(pc_device **device, pc_context *ctx, const char *wanted);
void pc_device_close(pc_device *device, pc_context *ctx);
/* True for "host": stages then call the plain-C references. */
bool pc_device_is_host(const pc_device *device);
const char *pc_device_name(const pc_device *device);

#endif
