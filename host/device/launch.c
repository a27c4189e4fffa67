#include "launch.h"
#include "device_private.h"
#include "memory.h"
#include <stdio.h>
#include <string.h>

enum { LOCAL_CPU = 64, LOCAL_GPU = 128 };

pc_status pc_kernel_get(pc_kernel **kernel, pc_context *ctx, pc_device *device, const char *source,
                        const char *name) {
    pc_program *program = NULL;
    pc_kernel *k = NULL;
    cl_int error = CL_SUCCESS;
    *kernel = NULL;
    pc_status status = pc_program_get(&program, ctx, device, source);
    if (status != PC_OK) return status;
    for (k = program->kernels; k; k = k->next) {
        if (strcmp(k->name, name) == 0) {
            *kernel = k;
            return PC_OK;
        }
    }
    status = pc_new(&k, ctx, 1);
    if (status != PC_OK) return status;
    (void)snprintf(k->name, sizeof k->name, "%s", name);
    k->device = device;
    k->handle = clCreateKernel(program->handle, name, &error);
    if (error != CL_SUCCESS) {
        pc_free(ctx, k);
        return pc_device_fail(ctx, error, name);
    }
    k->next = program->kernels;
    program->kernels = k;
    *kernel = k;
    return PC_OK;
}

pc_status pc_launch_harvest(pc_context *ctx, pc_device *device) {
    if (device->pending_count == 0) return PC_OK;
    cl_int error = clFinish(device->queue);
    if (error != CL_SUCCESS) return pc_device_fail(ctx, error, "waiting for the device");
    for (size_t i = 0; i < device->pending_count; i++) {
        cl_event event = device->pending[i].event;
        cl_ulong begin = 0;
        cl_ulong end = 0;
        if (clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START, sizeof begin, &begin, NULL) ==
                CL_SUCCESS &&
            clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL) == CL_SUCCESS &&
            end > begin)
            device->pending[i].kernel->seconds += 1e-9 * (double)(end - begin);
        (void)clReleaseEvent(event);
    }
    device->pending_count = 0;
    return PC_OK;
}

/* Waits for the first launch of every variant on a member: PoCL 3.1 loses count of a kernel that two devices
 * start for the first time at once, and aborts (pocl_release_dlhandle_cache). */
static pc_status wait_for_first(pc_context *ctx, pc_kernel *kernel, size_t items, size_t local) {
    const pc_variant now = {local, items > UINT16_MAX};
    for (int i = 0; i < kernel->variant_count; i++)
        if (kernel->variant[i].local == now.local && kernel->variant[i].wide == now.wide) return PC_OK;
    if (kernel->variant_count < PC_MOST_VARIANTS) kernel->variant[kernel->variant_count++] = now;
    return pc_launch_wait(ctx, kernel->device);
}

pc_status pc_kernel_run(pc_context *ctx, pc_kernel *kernel, size_t items, size_t local, double bytes,
                        const pc_argument *arguments, size_t count) {
    pc_device *device = kernel->device;
    cl_int error = CL_SUCCESS;
    if (items == 0) return PC_OK;
    for (size_t i = 0; i < count && error == CL_SUCCESS; i++) {
        const pc_argument *a = &arguments[i];
        const void *value = a->size ? (const void *)&a->value : (const void *)&a->buffer->handle;
        error = clSetKernelArg(kernel->handle, (cl_uint)i, a->size ? a->size : sizeof(cl_mem), value);
    }
    if (error != CL_SUCCESS) return pc_device_fail(ctx, error, kernel->name);
    if (local == 0) {
        local = device->info.cpu ? LOCAL_CPU : LOCAL_GPU;
        items = (items + local - 1) / local * local;
    }
    if (device->pending_count == PC_PENDING_EVENTS) {
        pc_status status = pc_launch_harvest(ctx, device);
        if (status != PC_OK) return status;
    }
    cl_event event = NULL;
    error = clEnqueueNDRangeKernel(device->queue, kernel->handle, 1, NULL, &items, &local, 0, NULL, &event);
    if (error != CL_SUCCESS) return pc_device_fail(ctx, error, kernel->name);
    device->pending[device->pending_count++] = (pc_pending){event, kernel};
    kernel->count++;
    kernel->bytes += bytes;
    return device->copies ? wait_for_first(ctx, kernel, items, local) : PC_OK;
}

pc_status pc_launch_wait(pc_context *ctx, pc_device *device) {
    if (device->host) return PC_OK;
    cl_int error = clFinish(device->queue);
    return error == CL_SUCCESS ? PC_OK : pc_device_fail(ctx, error, "waiting for the device");
}

/* Memory of ours under a buffer. */
typedef struct lent {
    pc_context *ctx;
    pc_device *device;
    void *block;
} lent;

static void CL_CALLBACK take_back(cl_mem handle, void *user) {
    lent *l = user;
    pc_device *device = l->device;
    (void)handle;
    pc_free(l->ctx, l->block);
    pc_free(l->ctx, l);
    atomic_fetch_sub(&device->lent, 1);
}

/* Large buffers of devices that compute in the host's memory lie in memory of ours: on huge pages, and back
 * at the system when they go. */
static pc_status lend(pc_buffer *b, pc_context *ctx, bool zeroed) {
    pc_status status = PC_OK;
    lent *l = NULL;
    char *block = NULL;
    cl_int error = CL_SUCCESS;
    PC_TRY(pc_new(&l, ctx, 1));
    PC_TRY(zeroed ? pc_new(&block, ctx, b->bytes) : pc_resize(&block, ctx, b->bytes));
    *l = (lent){ctx, b->device, block};
    b->handle =
        clCreateBuffer(b->device->context, CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, b->bytes, block, &error);
    if (error == CL_SUCCESS) {
        error = clSetMemObjectDestructorCallback(b->handle, take_back, l);
        if (error == CL_SUCCESS) {
            atomic_fetch_add(&b->device->lent, 1); /* the buffer's release is what calls back */
            return PC_OK;
        }
        (void)clReleaseMemObject(b->handle);
    }
    status = pc_device_fail(ctx, error, "making a buffer");
done:
    pc_free(ctx, block);
    pc_free(ctx, l);
    return status;
}

static pc_status make_buffer(pc_buffer **buffer, pc_context *ctx, pc_device *device, size_t bytes,
                             bool zeroed) {
    enum { LENT_FROM = 1 << 20 };
    const cl_uint zero = 0;
    cl_int error = CL_SUCCESS;
    pc_buffer *b = NULL;
    *buffer = NULL;
    if (device->host) return pc_fail(ctx, PC_E_BUG, "the host device has no buffers");
    if (bytes > device->allocation_cap)
        return pc_fail(ctx, PC_E_DEVICE, "a buffer of %zu bytes is over the %zu that '%s' allows", bytes,
                       device->allocation_cap, device->info.name);
    pc_status status = pc_new(&b, ctx, 1);
    if (status != PC_OK) return status;
    *b = (pc_buffer){.device = device, .bytes = bytes};
    if (device->info.cpu && bytes >= LENT_FROM) {
        status = lend(b, ctx, zeroed);
    } else {
        b->handle = clCreateBuffer(device->context, CL_MEM_READ_WRITE, bytes ? bytes : 4, NULL, &error);
        if (error == CL_SUCCESS && zeroed && bytes > 0) {
            error =
                clEnqueueFillBuffer(device->queue, b->handle, &zero, sizeof zero, 0, bytes, 0, NULL, NULL);
            if (error != CL_SUCCESS) (void)clReleaseMemObject(b->handle);
        }
        if (error != CL_SUCCESS) status = pc_device_fail(ctx, error, "making a buffer");
    }
    if (status == PC_OK)
        *buffer = b;
    else
        pc_free(ctx, b);
    return status;
}

pc_status pc_buffer_make(pc_buffer **buffer, pc_context *ctx, pc_device *device, size_t bytes) {
    return make_buffer(buffer, ctx, device, bytes, false);
}

pc_status pc_buffer_zeroed(pc_buffer **buffer, pc_context *ctx, pc_device *device, size_t bytes) {
    return make_buffer(buffer, ctx, device, (bytes + 3) / 4 * 4, true);
}

pc_status pc_buffer_from(pc_buffer **buffer, pc_context *ctx, pc_device *device, const void *from,
                         size_t bytes) {
    pc_status status = pc_buffer_make(buffer, ctx, device, bytes);
    if (status != PC_OK || !*buffer) return status;
    status = pc_buffer_write(*buffer, ctx, 0, from, bytes);
    if (status != PC_OK) {
        pc_buffer_free(*buffer, ctx);
        *buffer = NULL;
    }
    return status;
}

pc_status pc_buffer_read(void *to, pc_context *ctx, const pc_buffer *buffer, size_t offset, size_t bytes) {
    if (bytes == 0) return PC_OK;
    cl_int error =
        clEnqueueReadBuffer(buffer->device->queue, buffer->handle, CL_TRUE, offset, bytes, to, 0, NULL, NULL);
    return error == CL_SUCCESS ? PC_OK : pc_device_fail(ctx, error, "reading a buffer");
}

pc_status pc_buffer_write(const pc_buffer *buffer, pc_context *ctx, size_t offset, const void *from,
                          size_t bytes) {
    if (bytes == 0) return PC_OK;
    cl_int error = clEnqueueWriteBuffer(buffer->device->queue, buffer->handle, CL_TRUE, offset, bytes, from,
                                        0, NULL, NULL);
    return error == CL_SUCCESS ? PC_OK : pc_device_fail(ctx, error, "writing a buffer");
}

pc_status pc_buffer_map(void *to, pc_context *ctx, const pc_buffer *buffer) {
    cl_int error = CL_SUCCESS;
    void *at =
        clEnqueueMapBuffer(buffer->device->queue, buffer->handle, CL_TRUE, CL_MAP_WRITE_INVALIDATE_REGION, 0,
                           buffer->bytes ? buffer->bytes : 4, 0, NULL, NULL, &error);
    if (error != CL_SUCCESS) return pc_device_fail(ctx, error, "mapping a buffer");
    memcpy(to, &at, sizeof at);
    return PC_OK;
}

pc_status pc_buffer_unmap(const pc_buffer *buffer, pc_context *ctx, void *at) {
    if (!at) return PC_OK;
    cl_int error = clEnqueueUnmapMemObject(buffer->device->queue, buffer->handle, at, 0, NULL, NULL);
    return error == CL_SUCCESS ? PC_OK : pc_device_fail(ctx, error, "unmapping a buffer");
}

void pc_buffer_free(pc_buffer *buffer, pc_context *ctx) {
    if (!buffer) return;
    (void)clReleaseMemObject(buffer->handle);
    pc_free(ctx, buffer);
}
