#include "device_private.h"
#include "memory.h"
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PLATFORMS = 16, MOST_DEVICES = 32 };

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

/* Fills up to `most` entries; a machine without any OpenCL has 0. */
static size_t enumerate(pc_device_info *infos, cl_device_id *ids, size_t most) {
    cl_platform_id platforms[MOST_PLATFORMS];
    cl_uint platform_count = 0;
    size_t count = 0;
    if (clGetPlatformIDs(MOST_PLATFORMS, platforms, &platform_count) != CL_SUCCESS) return 0;
    if (platform_count > MOST_PLATFORMS) platform_count = MOST_PLATFORMS;
    for (cl_uint p = 0; p < platform_count; p++) {
        cl_device_id found[MOST_DEVICES];
        cl_uint device_count = 0;
        if (clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, MOST_DEVICES, found, &device_count) !=
            CL_SUCCESS)
            continue;
        if (device_count > MOST_DEVICES) device_count = MOST_DEVICES;
        for (cl_uint d = 0; d < device_count && count < most; d++) {
            describe(&infos[count], platforms[p], found[d], (int)p, (int)d);
            ids[count++] = found[d];
        }
    }
    return count;
}

pc_status pc_device_list(pc_device_info **infos, size_t *count, pc_context *ctx) {
    cl_device_id ids[MOST_DEVICES];
    *count = 0;
    pc_status status = pc_new(infos, ctx, MOST_DEVICES);
    if (status == PC_OK) *count = enumerate(*infos, ids, MOST_DEVICES);
    return status;
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

static bool fits(const pc_device_info *info, const char *wanted) {
    char *end = NULL;
    if (strcmp(wanted, "cpu") == 0) return info->cpu;
    if (strcmp(wanted, "gpu") == 0) return info->gpu;
    long p = strtol(wanted, &end, 10);
    if (end != wanted && *end == ':') {
        const char *second = end + 1;
        long d = strtol(second, &end, 10);
        if (end != second && *end == '\0') return p == info->platform && d == info->device;
    }
    return contains_any_case(info->name, wanted);
}

static size_t choose(const pc_device_info *infos, size_t count, const char *wanted) {
    bool any = !wanted || !*wanted || strcmp(wanted, "default") == 0;
    for (size_t i = 0; i < count; i++) {
        if (any ? infos[i].cpu : fits(&infos[i], wanted)) return i;
    }
    return any && count > 0 ? 0 : SIZE_MAX;
}

static pc_status refuse(pc_context *ctx, const pc_device_info *infos, size_t count, const char *wanted) {
    char list[1200] = "";
    size_t used = 0;
    for (size_t i = 0; i < count && used < sizeof list; i++) {
        int n = snprintf(list + used, sizeof list - used, "; %d:%d %s (%s)", infos[i].platform,
                         infos[i].device, infos[i].name, infos[i].platform_name);
        used += n > 0 ? (size_t)n : 0;
    }
    return pc_fail(ctx, PC_E_DEVICE, "no OpenCL device fits '%s'; there is: host%s",
                   wanted ? wanted : "default", list);
}

static pc_status start_queue(pc_context *ctx, pc_device *device) {
    cl_int error = CL_SUCCESS;
    device->context = clCreateContext(NULL, 1, &device->id, NULL, NULL, &error);
    if (error != CL_SUCCESS) return pc_device_fail(ctx, error, device->info.name);
    device->queue = clCreateCommandQueue(device->context, device->id, CL_QUEUE_PROFILING_ENABLE, &error);
    return error == CL_SUCCESS ? PC_OK : pc_device_fail(ctx, error, device->info.name);
}

pc_status pc_device_open(pc_device **device, pc_context *ctx, const char *wanted) {
    pc_status status = PC_OK;
    pc_device_info *infos = NULL;
    cl_device_id ids[MOST_DEVICES];
    pc_device *d = NULL;
    *device = NULL;
    PC_TRY(pc_new(&d, ctx, 1));
    if (wanted && strcmp(wanted, "host") == 0) {
        d->host = true;
        d->info = (pc_device_info){.name = "host", .cpu = true, .doubles = true};
        d->allocation_cap = SIZE_MAX;
    } else {
        PC_TRY(pc_new(&infos, ctx, MOST_DEVICES));
        size_t count = enumerate(infos, ids, MOST_DEVICES);
        size_t chosen = choose(infos, count, wanted);
        if (chosen == SIZE_MAX) {
            status = refuse(ctx, infos, count, wanted);
            goto done;
        }
        d->info = infos[chosen];
        d->id = ids[chosen];
        d->allocation_cap = d->info.allocation_cap;
        d->shape = d->info.cpu ? PC_SHAPE_CHUNK : PC_SHAPE_ROW;
        PC_TRY(start_queue(ctx, d));
    }
done:
    pc_free(ctx, infos);
    if (status == PC_OK)
        *device = d;
    else
        pc_device_close(d, ctx);
    return status;
}

void pc_device_close(pc_device *device, pc_context *ctx) {
    if (!device) return;
    if (!device->host) {
        if (device->queue) (void)clFinish(device->queue);
        for (size_t i = 0; i < device->pending_count; i++)
            (void)clReleaseEvent(device->pending[i].event);
        pc_program_free_all(device, ctx);
        if (device->queue) (void)clReleaseCommandQueue(device->queue);
        if (device->context) (void)clReleaseContext(device->context);
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

pc_shape pc_device_shape(const pc_device *device) {
    return device->shape;
}

void pc_device_set_shape(pc_device *device, pc_shape shape) {
    device->shape = shape;
}

size_t pc_device_allocation_cap(const pc_device *device) {
    return device->allocation_cap;
}

void pc_device_set_allocation_cap(pc_device *device, size_t bytes) {
    device->allocation_cap = bytes;
}

pc_status pc_device_require_doubles(const pc_device *device, pc_context *ctx, const char *what) {
    if (device->info.doubles) return PC_OK;
    return pc_fail(ctx, PC_E_DEVICE,
                   "%s needs double precision, which '%s' does not have; choose another --device "
                   "(or host)",
                   what, device->info.name);
}

pc_status pc_device_kernel_stats(const pc_kernel_stats **table, size_t *count, pc_context *ctx,
                                 pc_device *device) {
    size_t n = 0;
    *table = NULL;
    *count = 0;
    if (device->host) return PC_OK;
    pc_status status = pc_launch_harvest(ctx, device);
    if (status != PC_OK) return status;
    for (const pc_program *p = device->programs; p; p = p->next)
        for (const pc_kernel *k = p->kernels; k; k = k->next)
            n += k->count > 0;
    pc_free(ctx, device->stats);
    device->stats = NULL;
    status = pc_new(&device->stats, ctx, n);
    if (status != PC_OK) return status;
    for (const pc_program *p = device->programs; p; p = p->next) {
        for (const pc_kernel *k = p->kernels; k; k = k->next) {
            if (k->count == 0) continue;
            pc_kernel_stats *row = &device->stats[(*count)++];
            *row = (pc_kernel_stats){.count = k->count, .seconds = k->seconds, .bytes = k->bytes};
            memcpy(row->name, k->name, sizeof row->name);
        }
    }
    *table = device->stats;
    return PC_OK;
}

void pc_device_reset_stats(pc_device *device) {
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
