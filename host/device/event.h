/* How the members of a device (device.h) work together: what one has started can wait for another, and
 * buffers of one are copied into those of another while it computes. Members share an OpenCL context, so
 * nothing here waits on the host. */
#ifndef PC_EVENT_H
#define PC_EVENT_H

#include "launch.h"

typedef struct pc_event pc_event;

/* Done when all that was started on the device before is. */
pc_status pc_event_mark(pc_event **event, pc_context *ctx, pc_device *device);
/* What is started on the device from now on waits for all of the events; NULL among them is fine. */
pc_status pc_event_await(pc_context *ctx, pc_device *device, pc_event *const *events, size_t count);
/* NULL is fine; what waits for the event still does. */
void pc_event_free(pc_event *event);

/* Copies `bytes` bytes at `from_offset` to `to_offset`, in the order of the launches on the device of `to`,
 * once `after` is done. Both devices are members of one. */
pc_status pc_event_copy(pc_context *ctx, const pc_buffer *to, size_t to_offset, const pc_buffer *from,
                        size_t from_offset, size_t bytes, pc_event *after);
/* The same beside the launches, once both events are done; `*there` when it is. */
pc_status pc_event_copy_beside(pc_event **there, pc_context *ctx, const pc_buffer *to, size_t to_offset,
                               const pc_buffer *from, size_t from_offset, size_t bytes,
                               pc_event *const after[2]);

#endif
