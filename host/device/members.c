/* Devices that compute together: lists of devices, and sub-devices of one. */
#include "device_private.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The devices of a list, by their places in the catalogue. */
static pc_status read_list(size_t *chosen, int *count, pc_context *ctx, const pc_catalogue *catalogue,
                           const char *wanted) {
    bool taken[PC_MOST_DEVICES] = {false};
    const char *at = wanted;
    *count = 0;
    for (;;) {
        char name[160];
        size_t length = strcspn(at, ",");
        (void)snprintf(name, sizeof name, "%.*s", (int)(length < sizeof name ? length : sizeof name - 1), at);
        if (strcmp(name, "host") == 0)
            return pc_fail(ctx, PC_E_DEVICE, "'%s': host is plain C and no OpenCL device", wanted);
        if (*count == PC_MOST_MEMBERS)
            return pc_fail(ctx, PC_E_DEVICE, "'%s': at most %d devices compute together", wanted,
                           PC_MOST_MEMBERS);
        size_t k = length > 0 ? pc_catalogue_find(catalogue, name, taken) : SIZE_MAX;
        if (k == SIZE_MAX && length > 0 && pc_catalogue_find(catalogue, name, NULL) != SIZE_MAX)
            return pc_fail(ctx, PC_E_DEVICE, "'%s': no further device fits '%s'", wanted, name);
        if (k == SIZE_MAX) return pc_catalogue_refuse(catalogue, ctx, length > 0 ? name : wanted);
        taken[k] = true;
        chosen[(*count)++] = k;
        if (at[length] == '\0') return PC_OK;
        at += length + 1;
    }
}

/* Their kernels must sum in the same order, and they must see each other's buffers. */
static pc_status check_alike(pc_context *ctx, const pc_catalogue *catalogue, const size_t *chosen,
                             int count) {
    const pc_device_info *first = &catalogue->info[chosen[0]];
    for (int k = 1; k < count; k++) {
        const pc_device_info *other = &catalogue->info[chosen[k]];
        if (other->platform != first->platform || other->cpu != first->cpu || other->gpu != first->gpu)
            return pc_fail(ctx, PC_E_DEVICE,
                           "'%s' (%d:%d) and '%s' (%d:%d) cannot compute together: devices of a list must be "
                           "of one platform and type",
                           first->name, first->platform, first->device, other->name, other->platform,
                           other->device);
    }
    return PC_OK;
}

static pc_status open_list(pc_device **device, pc_context *ctx, const pc_catalogue *catalogue,
                           const char *wanted) {
    size_t chosen[PC_MOST_MEMBERS] = {0};
    cl_device_id ids[PC_MOST_MEMBERS];
    cl_context context = NULL;
    pc_device *d = NULL;
    pc_status status = PC_OK;
    int count = 0;
    PC_TRY(read_list(chosen, &count, ctx, catalogue, wanted));
    PC_TRY(check_alike(ctx, catalogue, chosen, count));
    cl_uint distinct = 0;
    for (int k = 0; k < count; k++) {
        bool before = false;
        for (cl_uint i = 0; i < distinct; i++)
            before |= ids[i] == catalogue->id[chosen[k]];
        if (!before) ids[distinct++] = catalogue->id[chosen[k]];
    }
    cl_int error = CL_SUCCESS;
    context = clCreateContext(NULL, distinct, ids, NULL, NULL, &error);
    if (error != CL_SUCCESS) {
        status = pc_device_fail(ctx, error, wanted);
        goto done;
    }
    PC_TRY(pc_device_start(&d, ctx, &catalogue->info[chosen[0]], catalogue->id[chosen[0]], context));
    for (int k = 1; k < count; k++) {
        PC_TRY(pc_device_start(&d->member[k], ctx, &catalogue->info[chosen[k]], catalogue->id[chosen[k]],
                               context));
        d->member_count++;
    }
done:
    if (context) (void)clReleaseContext(context);
    if (status == PC_OK)
        *device = d;
    else
        pc_device_close(d, ctx);
    return status;
}

/* How many parts "A/N" asks for; `name` becomes A. 0 where it is no such text. */
static long read_parts(char *name, size_t size, const char *wanted) {
    const char *slash = strrchr(wanted, '/');
    char *end = NULL;
    if (!slash || slash == wanted || slash[1] < '0' || slash[1] > '9') return 0;
    long parts = strtol(slash + 1, &end, 10);
    if (*end != '\0' || (size_t)(slash - wanted) >= size) return 0;
    (void)snprintf(name, size, "%.*s", (int)(slash - wanted), wanted);
    return parts;
}

static bool can_partition(cl_device_id id, cl_device_partition_property how) {
    cl_device_partition_property ways[16] = {0};
    size_t bytes = 0;
    if (clGetDeviceInfo(id, CL_DEVICE_PARTITION_PROPERTIES, sizeof ways, ways, &bytes) != CL_SUCCESS)
        return false;
    for (size_t k = 0; k < bytes / sizeof *ways; k++)
        if (ways[k] == how) return true;
    return false;
}

static cl_uint units_of_part(cl_uint units, cl_uint parts, cl_uint part) {
    return units / parts + (part < units % parts);
}

/* All compute units, as evenly as they go. */
static pc_status divide(cl_device_id *ids, pc_context *ctx, const pc_device *whole, cl_uint parts) {
    cl_device_partition_property ways[PC_MOST_MEMBERS + 3] = {CL_DEVICE_PARTITION_BY_COUNTS};
    const cl_uint units = whole->info.units;
    cl_uint made = 0;
    if (!can_partition(whole->id, CL_DEVICE_PARTITION_BY_COUNTS))
        return pc_fail(ctx, PC_E_DEVICE, "'%s' cannot be divided into sub-devices", whole->info.name);
    if (parts > units)
        return pc_fail(ctx, PC_E_DEVICE,
                       "'%s' cannot be divided into %u sub-devices: it has %u compute unit%s",
                       whole->info.name, parts, units, units == 1 ? "" : "s");
    for (cl_uint k = 0; k < parts; k++)
        ways[k + 1] = units_of_part(units, parts, k);
    ways[parts + 1] = CL_DEVICE_PARTITION_BY_COUNTS_LIST_END;
    cl_int error = clCreateSubDevices(whole->id, ways, parts, ids, &made);
    if (error == CL_SUCCESS && made == parts) return PC_OK;
    return pc_fail(ctx, PC_E_DEVICE, "'%s' cannot be divided into %u sub-devices (OpenCL %d)",
                   whole->info.name, parts, (int)error);
}

static pc_status open_parts(pc_device **device, pc_context *ctx, const pc_device_info *info, cl_device_id id,
                            cl_uint parts) {
    cl_device_id ids[PC_MOST_MEMBERS] = {NULL};
    cl_context context = NULL;
    cl_uint opened = 0;
    pc_device *d = NULL;
    pc_status status = PC_OK;
    PC_TRY(pc_device_start(&d, ctx, info, id, NULL));
    if (parts > 1) {
        PC_TRY(divide(ids, ctx, d, parts));
        cl_int error = CL_SUCCESS;
        context = clCreateContext(NULL, parts, ids, NULL, NULL, &error);
        if (error != CL_SUCCESS) {
            status = pc_device_fail(ctx, error, info->name);
            goto done;
        }
        d->member_count = 0;
        for (; opened < parts; opened++) {
            pc_device_info of_part = *info;
            of_part.units = units_of_part(info->units, parts, opened);
            PC_TRY(pc_device_start(&d->member[opened], ctx, &of_part, ids[opened], context));
            d->member[opened]->divided = true;
            d->member_count++;
        }
    }
done:
    for (cl_uint k = opened; k < PC_MOST_MEMBERS && ids[k]; k++)
        (void)clReleaseDevice(ids[k]);
    if (context) (void)clReleaseContext(context);
    if (status == PC_OK)
        *device = d;
    else
        pc_device_close(d, ctx);
    return status;
}

pc_status pc_members_open(pc_device **device, pc_context *ctx, const pc_catalogue *catalogue,
                          const char *wanted) {
    char name[160];
    if (!wanted) return pc_catalogue_refuse(catalogue, ctx, wanted);
    if (strchr(wanted, ',')) return open_list(device, ctx, catalogue, wanted);
    const long parts = read_parts(name, sizeof name, wanted);
    if (parts == 0) return pc_catalogue_refuse(catalogue, ctx, wanted);
    if (parts > PC_MOST_MEMBERS)
        return pc_fail(ctx, PC_E_DEVICE, "'%s': at most %d sub-devices compute together", wanted,
                       PC_MOST_MEMBERS);
    if (strcmp(name, "host") == 0)
        return pc_fail(ctx, PC_E_DEVICE, "'%s': host is plain C and has no sub-devices", wanted);
    size_t k = pc_catalogue_find(catalogue, name, NULL);
    if (k == SIZE_MAX) return pc_catalogue_refuse(catalogue, ctx, wanted);
    return open_parts(device, ctx, &catalogue->info[k], catalogue->id[k], (cl_uint)parts);
}
