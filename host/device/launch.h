/* Buffers and kernel launches on an OpenCL device. Nothing here works on the host device.
 *
 *     pc_buffer *in = NULL, *out = NULL;
 *     pc_kernel *scale = NULL;
 *     PC_TRY(pc_kernel_get(&scale, ctx, device, pc_kernel_vector, "vector_scale"));
 *     PC_TRY(pc_buffer_from(&in, ctx, device, array, n * sizeof *array));
 *     PC_TRY(pc_buffer_make(&out, ctx, device, n * sizeof *array));
 *     PC_TRY(pc_kernel_run(ctx, scale, n, 0, 2.0 * n * sizeof *array,
 *                          PC_ARGS(PC_BUF(out), PC_BUF(in), PC_F64(3.0), PC_U32(n))));
 *     PC_TRY(pc_buffer_read(array, ctx, out, 0, n * sizeof *array));
 * done:
 *     pc_buffer_free(in, ctx);
 *     pc_buffer_free(out, ctx);
 *
 * A kernels/<stem>.cl is embedded as `extern const char pc_kernel_<stem>[]` (declare it in the .c that
 * launches it). It is compiled with -DPC_CHUNK=1 on chunk-shaped devices, else 0, and -DPC_DOUBLE=1 where the
 * device has doubles. Launches run in order, one after the other; only pc_buffer_read and pc_launch_wait wait
 * for them. */
#ifndef PC_LAUNCH_H
#define PC_LAUNCH_H

#include "device.h"

typedef struct pc_kernel pc_kernel; /* owned by the device */
typedef struct pc_buffer pc_buffer;

typedef struct pc_argument {
    const pc_buffer *buffer;
    size_t size; /* of the scalar; 0: `buffer` is meant */
    union {
        uint32_t u32;
        int32_t i32;
        float f32;
        double f64;
        uint64_t u64;
    } value;
} pc_argument;

#define PC_BUF(b) ((pc_argument){.buffer = (b)})
#define PC_U32(x) ((pc_argument){.size = 4, .value.u32 = (x)})
#define PC_I32(x) ((pc_argument){.size = 4, .value.i32 = (x)})
#define PC_F32(x) ((pc_argument){.size = 4, .value.f32 = (x)})
#define PC_F64(x) ((pc_argument){.size = 8, .value.f64 = (x)})
#define PC_U64(x) ((pc_argument){.size = 8, .value.u64 = (x)})
/* The array of arguments and its length. */
#define PC_ARGS(...)                                                                                         \
    (const pc_argument[]){__VA_ARGS__}, sizeof((const pc_argument[]){__VA_ARGS__}) / sizeof(pc_argument)

/* The kernel `name` of an embedded source, built (or read from the cache) on first use; the device keeps it.
 * PC_E_DEVICE with the compiler's log where it does not build. */
pc_status pc_kernel_get(pc_kernel **kernel, pc_context *ctx, pc_device *device, const char *source,
                        const char *name);
/* Starts `items` work-items in groups of `local` (0: a size that suits the device; items are then rounded up
 * to whole groups, so the kernel compares get_global_id(0) with its count). `bytes`: memory moved, for the
 * report. 0 items do nothing. */
pc_status pc_kernel_run(pc_context *ctx, pc_kernel *kernel, size_t items, size_t local, double bytes,
                        const pc_argument *arguments, size_t count);
/* The `local` of a kernel whose work-items do a chunk each: on a CPU a group of its own, so that few chunks
 * are shared out too. */
static inline size_t pc_chunk_group(const pc_device *device) {
    return pc_device_shape(device) == PC_SHAPE_CHUNK ? 1 : 0;
}
/* Waits until everything started is done. */
pc_status pc_launch_wait(pc_context *ctx, pc_device *device);

/* Uninitialised. PC_E_DEVICE over the device's allocation cap, PC_E_NOMEM where memory lacks. 0 bytes are
 * fine. */
pc_status pc_buffer_make(pc_buffer **buffer, pc_context *ctx, pc_device *device, size_t bytes);
/* The same, filled with zero bytes. */
pc_status pc_buffer_zeroed(pc_buffer **buffer, pc_context *ctx, pc_device *device, size_t bytes);
/* A copy of `bytes` bytes at `from`. */
pc_status pc_buffer_from(pc_buffer **buffer, pc_context *ctx, pc_device *device, const void *from,
                         size_t bytes);
/* Both copy and wait; offsets and sizes in bytes. */
pc_status pc_buffer_read(void *to, pc_context *ctx, const pc_buffer *buffer, size_t offset, size_t bytes);
pc_status pc_buffer_write(const pc_buffer *buffer, pc_context *ctx, size_t offset, const void *from,
                          size_t bytes);
/* `*to` (a pointer to a pointer to any type) becomes where the whole buffer is to be written, without being
 * read, until pc_buffer_unmap: large arrays are made there without a second copy. Waits for what was started
 * before. */
pc_status pc_buffer_map(void *to, pc_context *ctx, const pc_buffer *buffer);
/* `at` as mapped; NULL is fine. */
pc_status pc_buffer_unmap(const pc_buffer *buffer, pc_context *ctx, void *at);
/* NULL is fine. */
void pc_buffer_free(pc_buffer *buffer, pc_context *ctx);

#endif
