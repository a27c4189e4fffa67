#include "event.h"
#include "device_private.h"

/* A pc_event is an OpenCL event under another name. */
static cl_event handle_of(pc_event *event) {
    return (cl_event)(void *)event;
}

static pc_event *event_of(cl_event handle) {
    return (pc_event *)(void *)handle;
}

/* Other queues may wait only for what was handed to the device. */
static pc_status hand_over(pc_context *ctx, cl_int error, cl_command_queue queue, const char *what) {
    if (error == CL_SUCCESS) error = clFlush(queue);
    return error == CL_SUCCESS ? PC_OK : pc_device_fail(ctx, error, what);
}

pc_status pc_event_mark(pc_event **event, pc_context *ctx, pc_device *device) {
    cl_event handle = NULL;
    cl_int error = clEnqueueMarkerWithWaitList(device->queue, 0, NULL, &handle);
    *event = event_of(handle);
    return hand_over(ctx, error, device->queue, "marking a place in a queue");
}

pc_status pc_event_await(pc_context *ctx, pc_device *device, pc_event *const *events, size_t count) {
    cl_event list[PC_MOST_MEMBERS];
    cl_uint n = 0;
    for (size_t k = 0; k < count; k++) {
        if (events[k]) list[n++] = handle_of(events[k]);
        if (n == PC_MOST_MEMBERS || (k + 1 == count && n > 0)) {
            cl_int error = clEnqueueBarrierWithWaitList(device->queue, n, list, NULL);
            if (error != CL_SUCCESS) return pc_device_fail(ctx, error, "waiting for another device");
            n = 0;
        }
    }
    return PC_OK;
}

void pc_event_free(pc_event *event) {
    if (event) (void)clReleaseEvent(handle_of(event));
}

pc_status pc_event_copy(pc_context *ctx, const pc_buffer *to, size_t to_offset, const pc_buffer *from,
                        size_t from_offset, size_t bytes, pc_event *after) {
    if (bytes == 0) return PC_OK;
    cl_event wait = handle_of(after);
    cl_int error = clEnqueueCopyBuffer(to->device->queue, from->handle, to->handle, from_offset, to_offset,
                                       bytes, 1, &wait, NULL);
    return error == CL_SUCCESS ? PC_OK : pc_device_fail(ctx, error, "copying between devices");
}

pc_status pc_event_copy_beside(pc_event **there, pc_context *ctx, const pc_buffer *to, size_t to_offset,
                               const pc_buffer *from, size_t from_offset, size_t bytes,
                               pc_event *const after[2]) {
    const cl_event wait[2] = {handle_of(after[0]), handle_of(after[1])};
    cl_event handle = NULL;
    cl_int error = clEnqueueCopyBuffer(to->device->copies, from->handle, to->handle, from_offset, to_offset,
                                       bytes, 2, wait, &handle);
    *there = event_of(handle);
    return hand_over(ctx, error, to->device->copies, "copying between devices");
}
