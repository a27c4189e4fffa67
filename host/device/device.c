#include "device_private.h"
#include "memory.h"
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST_PLATFORMS = 16 };

static const char *error_name(cl_int error) {
    switch (error) {
    case CL_DEVICE_NOT_FOUND:
        return "no device found";
    case CL_DEVICE_NOT_AVAILABLE:
        return "device not available";
    case CL_COMPILER_NOT_AVAILABLE:
        return "no compiler available";
    case CL_MEM_OBJECT_ALLOCATION_FAILURE:
        return "device memory could not be had";
    case CL_OUT_OF_RESOURCES:
        return "out of device resources";
    case CL_OUT_OF_HOST_MEMORY:
        return "out of host memory";
    case CL_BUILD_PROGRAM_FAILURE:
        return "program does not build";
    case CL_INVALID_VALUE:
        return "invalid value";
    case CL_INVALID_BUFFER_SIZE:
        return "invalid buffer size";
    case CL_INVALID_BINARY:
        return "invalid binary";
    case CL_INVALID_KERNEL_NAME:
        return "no such kernel";
    case CL_INVALID_KERNEL_ARGS:
        return "a kernel argument is missing";
    case CL_INVALID_ARG_INDEX:
        return "too many kernel arguments";
    case CL_INVALID_ARG_SIZE:
        return "a kernel argument has the wrong size";
    case CL_INVALID_WORK_GROUP_SIZE:
        return "invalid work-group size";
    case CL_INVALID_MEM_OBJECT:
        return "invalid buffer";
    default:
        return "OpenCL error";
    }
}

pc_status pc_device_fail(pc_context *ctx, cl_int error, const char *what) {
    bool memory = error == CL_MEM_OBJECT_ALLOCATION_FAILURE || error == CL_OUT_OF_HOST_MEMORY;
    return pc_fail(ctx, memory ? PC_E_NOMEM : PC_E_DEVICE, "%s: %s (OpenCL %d)", what, error_name(error),
                   (int)error);
}

static void device_text(char *out, size_t size, cl_device_id id, cl_device_info what) {
    char text[512] = "";
    if (clGetDeviceInfo(id, what, sizeof text - 1, text, NULL) != CL_SUCCESS) text[0] = '\0';
    (void)snprintf(out, size, "%s", text);
}

static uint64_t device_number(cl_device_id id, cl_device_info what) {
    cl_ulong number = 0;
    return clGetDeviceInfo(id, what, sizeof number, &number, NULL) == CL_SUCCESS ? number : 0;
}

static void describe(pc_device_info *info, cl_platform_id platform, cl_device_id id, int p, int d) {
    char text[512] = "";
    *info = (pc_device_info){.platform = p, .device = d};
    if (clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof text - 1, text, NULL) == CL_SUCCESS)
        (void)snprintf(info->platform_name, sizeof info->platform_name, "%.95s", text);
    device_text(info->name, sizeof info->name, id, CL_DEVICE_NAME);
    device_text(info->version, sizeof info->version, id, CL_DEVICE_VERSION);
    device_text(info->driver, sizeof info->driver, id, CL_DRIVER_VERSION);
    cl_device_type type = 0;
    cl_uint units = 0;
    (void)clGetDeviceInfo(id, CL_DEVICE_TYPE, sizeof type, &type, NULL);
    (void)clGetDeviceInfo(id, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, NULL);
    info->cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
    info->gpu = (type & CL_DEVICE_TYPE_GPU) != 0;
    info->units = units;
    info->doubles = device_number(id, CL_DEVICE_DOUBLE_FP_CONFIG) != 0;
    info->memory_bytes = device_number(id, CL_DEVICE_GLOBAL_MEM_SIZE);
    info->allocation_cap = device_number(id, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
}

/* A machine without any OpenCL has none. */
static void enumerate(pc_catalogue *found) {
    cl_platform_id platforms[MOST_PLATFORMS];
    cl_uint platform_count = 0;
    found->count = 0;
    if (clGetPlatformIDs(MOST_PLATFORMS, platforms, &platform_count) != CL_SUCCESS) return;
    if (platform_count > MOST_PLATFORMS) platform_count = MOST_PLATFORMS;
    for (cl_uint p = 0; p < platform_count; p++) {
        cl_device_id ids[PC_MOST_DEVICES];
        cl_uint device_count = 0;
        if (clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, PC_MOST_DEVICES, ids, &device_count) !=
            CL_SUCCESS)
            continue;
        if (device_count > PC_MOST_DEVICES) device_count = PC_MOST_DEVICES;
        for (cl_uint d = 0; d < device_count && found->count < PC_MOST_DEVICES; d++) {
            describe(&found->info[found->count], platforms[p], ids[d], (int)p, (int)d);
            found->id[found->count++] = ids[d];
        }
    }
}

pc_status pc_device_list(pc_device_info **infos, size_t *count, pc_context *ctx) {
    pc_catalogue found;
    *count = 0;
    pc_status status = pc_new(infos, ctx, PC_MOST_DEVICES);
    if (status != PC_OK) return status;
    enumerate(&found);
    memcpy(*infos, found.info, found.count * sizeof **infos);
    *count = found.count;
    return PC_OK;
}

static bool contains_any_case(const char *text, const char *part) {
    size_t length = strlen(part);
    for (; *text; text++) {
        size_t k = 0;
        while (k < length && text[k] && tolower((unsigned char)text[k]) == tolower((unsigned char)part[k]))
            k++;
        if (k == length) return true;
    }
    return false;
}

/* "P:D" and nothing else. */
static bool is_place(const char *wanted, long *platform, long *device) {
    char *end = NULL;
    *platform = strtol(wanted, &end, 10);
    if (end == wanted || *end != ':') return false;
    const char *second = end + 1;
    *device = strtol(second, &end, 10);
    return end != second && *end == '\0';
}

size_t pc_catalogue_find(const pc_catalogue *catalogue, const char *wanted, const bool *taken) {
    const bool any = !wanted || !*wanted || strcmp(wanted, "default") == 0;
    long p = 0;
    long d = 0;
    const bool place = !any && is_place(wanted, &p, &d);
    size_t other = SIZE_MAX;
    for (size_t i = 0; i < catalogue->count; i++) {
        const pc_device_info *info = &catalogue->info[i];
        if (place) {
            if (p == info->platform && d == info->device) return i;
        } else if (!taken || !taken[i]) {
            bool fits = any || strcmp(wanted, "cpu") == 0 ? info->cpu
                        : strcmp(wanted, "gpu") == 0      ? info->gpu
                                                          : contains_any_case(info->name, wanted);
            if (fits) return i;
            if (any && other == SIZE_MAX) other = i;
        }
    }
    return other;
}

pc_status pc_catalogue_refuse(const pc_catalogue *catalogue, pc_context *ctx, const char *wanted) {
    char list[1200] = "";
    size_t used = 0;
    for (size_t i = 0; i < catalogue->count && used < sizeof list; i++) {
        const pc_device_info *info = &catalogue->info[i];
        int n = snprintf(list + used, sizeof list - used, "; %d:%d %s (%s)", info->platform, info->device,
                         info->name, info->platform_name);
        used += n > 0 ? (size_t)n : 0;
    }
    return pc_fail(ctx, PC_E_DEVICE, "no OpenCL device fits '%s'; there is: host%s",
                   wanted ? wanted : "default", list);
}

static pc_status start_queues(pc_device *device, pc_context *ctx, cl_context context) {
    cl_int error = context ? clRetainContext(context) : CL_SUCCESS;
    device->context = context ? context : clCreateContext(NULL, 1, &device->id, NULL, NULL, &error);
    if (error != CL_SUCCESS) return pc_device_fail(ctx, error, device->info.name);
    device->queue = clCreateCommandQueue(device->context, device->id, CL_QUEUE_PROFILING_ENABLE, &error);
    if (error == CL_SUCCESS && context)
        device->copies = clCreateCommandQueue(device->context, device->id, 0, &error);
    return error == CL_SUCCESS ? PC_OK : pc_device_fail(ctx, error, device->info.name);
}

pc_status pc_device_start(pc_device **device, pc_context *ctx, const pc_device_info *info, cl_device_id id,
                          cl_context context) {
    pc_device *d = NULL;
    *device = NULL;
    pc_status status = pc_new(&d, ctx, 1);
    if (status != PC_OK) return status;
    *d = (pc_device){.info = *info, .id = id, .allocation_cap = info->allocation_cap, .member_count = 1};
    d->shape = info->cpu ? PC_SHAPE_CHUNK : PC_SHAPE_ROW;
    d->member[0] = d;
    status = start_queues(d, ctx, context);
    if (status == PC_OK)
        *device = d;
    else
        pc_device_close(d, ctx);
    return status;
}

static pc_status open_host(pc_device **device, pc_context *ctx) {
    pc_device *d = NULL;
    pc_status status = pc_new(&d, ctx, 1);
    if (status != PC_OK) return status;
    *d = (pc_device){.host = true, .allocation_cap = SIZE_MAX, .member_count = 1};
    d->info = (pc_device_info){.name = "host", .cpu = true, .doubles = true};
    d->member[0] = d;
    *device = d;
    return PC_OK;
}

pc_status pc_device_open(pc_device **device, pc_context *ctx, const char *wanted) {
    pc_catalogue found;
    *device = NULL;
    if (wanted && strcmp(wanted, "host") == 0) return open_host(device, ctx);
    enumerate(&found);
    size_t chosen = pc_catalogue_find(&found, wanted, NULL);
    if (chosen == SIZE_MAX) return pc_members_open(device, ctx, &found, wanted);
    return pc_device_start(device, ctx, &found.info[chosen], found.id[chosen], NULL);
}

/* Buffers that were let go give their memory back on a thread of the runtime's, a little later. */
static void await_lent(pc_device *device) {
    const struct timespec moment = {0, 100000};
    for (int i = 0; i < 100000 && atomic_load(&device->lent) > 0; i++)
        (void)nanosleep(&moment, NULL);
}

void pc_device_close(pc_device *device, pc_context *ctx) {
    if (!device) return;
    for (int k = 0; k < device->member_count; k++)
        if (device->member[k] != device) pc_device_close(device->member[k], ctx);
    if (!device->host) {
        if (device->copies) (void)clFinish(device->copies);
        if (device->queue) (void)clFinish(device->queue);
        for (size_t i = 0; i < device->pending_count; i++)
            (void)clReleaseEvent(device->pending[i].event);
        await_lent(device);
        pc_program_free_all(device, ctx);
        if (device->copies) (void)clReleaseCommandQueue(device->copies);
        if (device->queue) (void)clReleaseCommandQueue(device->queue);
        if (device->context) (void)clReleaseContext(device->context);
        if (device->divided) (void)clReleaseDevice(device->id);
    }
    pc_free(ctx, device->stats);
    pc_free(ctx, device);
}

bool pc_device_is_host(const pc_device *device) {
    return device->host;
}

const char *pc_device_name(const pc_device *device) {
    return device->info.name;
}

const pc_device_info *pc_device_describe(const pc_device *device) {
    return &device->info;
}

int pc_device_member_count(const pc_device *device) {
    return device->member_count;
}

pc_device *pc_device_member(pc_device *device, int k) {
    return device->member[k];
}

pc_shape pc_device_shape(const pc_device *device) {
    return device->shape;
}

void pc_device_set_shape(pc_device *device, pc_shape shape) {
    device->shape = shape;
    for (int k = 0; k < device->member_count; k++)
        device->member[k]->shape = shape;
}

size_t pc_device_allocation_cap(const pc_device *device) {
    return device->allocation_cap;
}

void pc_device_set_allocation_cap(pc_device *device, size_t bytes) {
    device->allocation_cap = bytes;
    for (int k = 0; k < device->member_count; k++)
        device->member[k]->allocation_cap = bytes;
}

pc_status pc_device_require_doubles(const pc_device *device, pc_context *ctx, const char *what) {
    if (device->info.doubles) return PC_OK;
    return pc_fail(ctx, PC_E_DEVICE,
                   "%s needs double precision, which '%s' does not have; choose another --device "
                   "(or host)",
                   what, device->info.name);
}

/* The device and its members, each once: k from 0 on, NULL at the end. */
static pc_device *each(pc_device *device, int k) {
    const bool apart = device->member[0] != device;
    if (apart && k == 0) return device;
    k -= apart;
    return k < device->member_count ? device->member[k] : NULL;
}

/* Its row of the table, a new one where the kernel's name is not there yet. */
static pc_kernel_stats *stats_row(pc_device *device, size_t *count, const pc_kernel *kernel) {
    for (size_t i = 0; i < *count; i++)
        if (strcmp(device->stats[i].name, kernel->name) == 0) return &device->stats[i];
    pc_kernel_stats *row = &device->stats[(*count)++];
    memcpy(row->name, kernel->name, sizeof row->name);
    return row;
}

pc_status pc_device_kernel_stats(const pc_kernel_stats **table, size_t *count, pc_context *ctx,
                                 pc_device *device) {
    size_t n = 0;
    pc_status status = PC_OK;
    pc_device *d = NULL;
    *table = NULL;
    *count = 0;
    if (device->host) return PC_OK;
    for (int k = 0; (d = each(device, k)); k++) {
        PC_TRY(pc_launch_harvest(ctx, d));
        for (const pc_program *p = d->programs; p; p = p->next)
            for (const pc_kernel *kernel = p->kernels; kernel; kernel = kernel->next)
                n += kernel->count > 0;
    }
    pc_free(ctx, device->stats);
    device->stats = NULL;
    PC_TRY(pc_new(&device->stats, ctx, n));
    for (int k = 0; (d = each(device, k)); k++) {
        for (const pc_program *p = d->programs; p; p = p->next) {
            for (const pc_kernel *kernel = p->kernels; kernel; kernel = kernel->next) {
                if (kernel->count == 0) continue;
                pc_kernel_stats *row = stats_row(device, count, kernel);
                row->count += kernel->count;
                row->seconds += kernel->seconds;
                row->bytes += kernel->bytes;
            }
        }
    }
    *table = device->stats;
done:
    return status;
}

static void reset_stats(pc_device *device) {
    for (size_t i = 0; i < device->pending_count; i++)
        (void)clReleaseEvent(device->pending[i].event);
    device->pending_count = 0;
    for (const pc_program *p = device->programs; p; p = p->next) {
        for (pc_kernel *k = p->kernels; k; k = k->next) {
            k->count = 0;
            k->seconds = k->bytes = 0;
        }
    }
}

void pc_device_reset_stats(pc_device *device) {
    pc_device *d = NULL;
    for (int k = 0; (d = each(device, k)); k++)
        reset_stats(d);
}
