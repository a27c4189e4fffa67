/* What the files of the device layer know of each other. */
#ifndef PC_DEVICE_PRIVATE_H
#define PC_DEVICE_PRIVATE_H

#include "device.h"
#include "event.h"
#include <CL/cl.h>
#include <stdatomic.h>

enum { PC_PENDING_EVENTS = 512, PC_MOST_DEVICES = 32, PC_MOST_VARIANTS = 8 };

/* What a runtime may compile a kernel anew for. */
typedef struct pc_variant {
    size_t local;
    bool wide; /* more work-items than 16 bits count */
} pc_variant;

struct pc_kernel {
    pc_kernel *next;
    pc_device *device;
    cl_kernel handle;
    char name[64];
    pc_variant variant[PC_MOST_VARIANTS]; /* launched so far; members only */
    int variant_count;
    uint64_t count;
    double seconds;
    double bytes;
};

/* A built program and the kernels taken from it. */
typedef struct pc_program {
    struct pc_program *next;
    const char *source; /* static: compared by address */
    char options[96];
    uint64_t key;
    bool fresh; /* built from source: worth storing */
    cl_program handle;
    pc_kernel *kernels;
} pc_program;

struct pc_buffer {
    pc_device *device;
    cl_mem handle;
    size_t bytes;
};

typedef struct pc_pending {
    cl_event event;
    pc_kernel *kernel;
} pc_pending;

struct pc_device {
    bool host;
    pc_shape shape;
    size_t allocation_cap;
    atomic_size_t lent; /* blocks of our memory under its buffers; the runtime's threads give them back */
    pc_device_info info;
    cl_device_id id;
    cl_context context;
    cl_command_queue queue;
    cl_command_queue copies; /* from other members, beside the launches; members only */
    bool divided;            /* `id` is a sub-device of ours */
    int member_count;        /* 1 where it computes alone */
    pc_device *member[PC_MOST_MEMBERS];
    pc_program *programs;
    pc_pending pending[PC_PENDING_EVENTS]; /* launches whose times are not read yet */
    size_t pending_count;
    pc_kernel_stats *stats;
};

/* The devices of this machine, in the order of P:D. */
typedef struct pc_catalogue {
    size_t count;
    pc_device_info info[PC_MOST_DEVICES];
    cl_device_id id[PC_MOST_DEVICES];
} pc_catalogue;

/* The first that fits and is not `taken` (NULL: none is), SIZE_MAX where there is none; P:D may be taken
 * again. */
size_t pc_catalogue_find(const pc_catalogue *catalogue, const char *wanted, const bool *taken);
/* PC_E_DEVICE with what there is. */
pc_status pc_catalogue_refuse(const pc_catalogue *catalogue, pc_context *ctx, const char *wanted);
/* Opens `id`, in `context` with a queue for copies, or (NULL) in a context of its own. */
pc_status pc_device_start(pc_device **device, pc_context *ctx, const pc_device_info *info, cl_device_id id,
                          cl_context context);
/* "A,B" and "A/N"; PC_E_DEVICE where `wanted` is neither, or cannot be had. */
pc_status pc_members_open(pc_device **device, pc_context *ctx, const pc_catalogue *catalogue,
                          const char *wanted);

/* PC_E_DEVICE (PC_E_NOMEM where memory lacks) with what failed and the error's name. */
pc_status pc_device_fail(pc_context *ctx, cl_int error, const char *what);
/* Finds or builds the program of an embedded source for the device's shape. */
pc_status pc_program_get(pc_program **program, pc_context *ctx, pc_device *device, const char *source);
/* Stores fresh binaries and releases everything. */
void pc_program_free_all(pc_device *device, pc_context *ctx);
/* Reads the times of all launches so far; waits for them. */
pc_status pc_launch_harvest(pc_context *ctx, pc_device *device);

#endif
