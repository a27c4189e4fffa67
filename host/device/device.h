/* OpenCL devices, and `host`: the plain-C references with OpenMP. */
#ifndef PC_DEVICE_H
#define PC_DEVICE_H

#include "context.h"

typedef struct pc_device pc_device;

enum { PC_MOST_MEMBERS = 16 };

/* One line of `percale devices`. */
typedef struct pc_device_info {
    int platform;
    int device;
    char platform_name[96];
    char name[160];
    char version[96];
    char driver[96];
    bool cpu;
    bool gpu;
    bool doubles;            /* double precision in kernels */
    uint32_t units;          /* compute units */
    uint64_t memory_bytes;   /* of the device */
    uint64_t allocation_cap; /* the largest single buffer */
} pc_device_info;

/* How kernels cut their work: wide vectors over chunks of rows with one work-item each (CPUs), or a row per
 * work-item (GPUs). Both run on every device; the device's type chooses. */
typedef enum pc_shape { PC_SHAPE_CHUNK, PC_SHAPE_ROW } pc_shape;

/* What one kernel did on a device so far. */
typedef struct pc_kernel_stats {
    char name[64];
    uint64_t count;
    double seconds; /* on the device, from profiling events */
    double bytes;   /* that its callers said it moves */
} pc_kernel_stats;

/* `wanted`: "host", "cpu", "gpu", "P:D" (platform:device) or a part of a device's name (any case); NULL or
 * "default" takes the first CPU, else any device. PC_E_DEVICE lists what is there when nothing fits.
 *
 * Members that compute together: "A,B" opens several devices of one platform and type, each the next that
 * fits (one may be named twice as P:D); "A/N" opens A and cuts its compute units into N sub-devices. What
 * does not know about members runs on A alone, undivided. */
pc_status pc_device_open(pc_device **device, pc_context *ctx, const char *wanted);
/* Also stores fresh program binaries in the cache folder. Buffers and kernels must be gone. NULL is fine. */
void pc_device_close(pc_device *device, pc_context *ctx);
/* True for "host": stages then call the plain-C references. */
bool pc_device_is_host(const pc_device *device);
const char *pc_device_name(const pc_device *device);

/* 1 for a device that computes alone; its only member is itself. A list's first member is the device itself,
 * the sub-devices of "A/N" are apart from it. They belong to the device; see event.h. */
int pc_device_member_count(const pc_device *device);
pc_device *pc_device_member(pc_device *device, int k);

/* All devices of all platforms, in the order of P:D; the caller frees `*infos` with pc_free. An empty list is
 * fine. */
pc_status pc_device_list(pc_device_info **infos, size_t *count, pc_context *ctx);
/* What is known of an open device; all zero but the name for the host. */
const pc_device_info *pc_device_describe(const pc_device *device);

/* Shape of the kernels, also of all members; set it before the first kernel is taken (tests run both on one
 * device). */
pc_shape pc_device_shape(const pc_device *device);
void pc_device_set_shape(pc_device *device, pc_shape shape);
/* The largest single buffer, in bytes; tests lower it, also for all members, to see things split. */
size_t pc_device_allocation_cap(const pc_device *device);
void pc_device_set_allocation_cap(pc_device *device, size_t bytes);
/* PC_E_DEVICE with a clear message unless the device computes in double; `what` says who needs it. */
pc_status pc_device_require_doubles(const pc_device *device, pc_context *ctx, const char *what);

/* Time, launches and bytes per kernel since the device was opened or last reset, those of its members added;
 * waits for the device. The table belongs to the device and is good until the next call. 0 kernels for the
 * host. */
pc_status pc_device_kernel_stats(const pc_kernel_stats **table, size_t *count, pc_context *ctx,
                                 pc_device *device);
void pc_device_reset_stats(pc_device *device);

#endif
