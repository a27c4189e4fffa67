/* Kernels are tested in both shapes. */
#ifndef PC_SHAPE_TESTING_H
#define PC_SHAPE_TESTING_H

#include "device.h"

static const pc_shape shapes[2] = {PC_SHAPE_CHUNK, PC_SHAPE_ROW};

/* The default device in a shape; NULL where the machine has none. */
static inline pc_device *open_device(pc_context *ctx, pc_shape shape) {
    pc_device *device = NULL;
    if (pc_device_open(&device, ctx, NULL) != PC_OK) {
        pc_context_clear_message(ctx);
        return NULL;
    }
    pc_device_set_shape(device, shape);
    return device;
}

#endif
