#include "triad.h"
#include "clock.h"
#include "memory.h"
#include <string.h>

extern const char pc_kernel_triad[];

/* What was never written is one page of zeros, which caches hold. */
static void fill(double *a, size_t n) {
    for (size_t i = 0; i < n; i++)
        a[i] = 1 + (double)(i % 7);
}

static pc_status host_triad(double *rate, pc_context *ctx, size_t n, int repeats) {
    pc_status status = PC_OK;
    double *a = NULL;
    double *b = NULL;
    double *c = NULL;
    PC_TRY(pc_new(&a, ctx, n));
    PC_TRY(pc_new(&b, ctx, n));
    PC_TRY(pc_new(&c, ctx, n));
    fill(b, n);
    fill(c, n);
    for (int repeat = 0; repeat < repeats; repeat++) {
        double begin = pc_clock_wall();
#pragma omp parallel for schedule(static)
        for (size_t i = 0; i < n; i++)
            a[i] = b[i] + 3 * c[i];
        double now = 24e-9 * (double)n / (pc_clock_wall() - begin);
        if (now > *rate) *rate = now;
    }
done:
    pc_free(ctx, a);
    pc_free(ctx, b);
    pc_free(ctx, c);
    return status;
}

static pc_status filled(pc_buffer **buffer, pc_context *ctx, pc_device *device, size_t n) {
    pc_status status = pc_buffer_make(buffer, ctx, device, n * sizeof(double));
    double *at = NULL;
    if (status == PC_OK) status = pc_buffer_map(&at, ctx, *buffer);
    if (status != PC_OK) return status;
    fill(at, n);
    return pc_buffer_unmap(*buffer, ctx, at);
}

/* Bytes per second of the kernel `name` since the last look. */
static pc_status look(double *rate, pc_context *ctx, pc_device *device, const char *name, double *before,
                      double bytes) {
    const pc_kernel_stats *table;
    size_t count;
    pc_status status = pc_device_kernel_stats(&table, &count, ctx, device);
    for (size_t i = 0; status == PC_OK && i < count; i++) {
        if (strcmp(table[i].name, name) != 0) continue;
        double seconds = table[i].seconds - *before;
        *before = table[i].seconds;
        if (seconds > 0 && 1e-9 * bytes / seconds > *rate) *rate = 1e-9 * bytes / seconds;
    }
    return status;
}

static pc_status device_triad(double *rate, pc_context *ctx, pc_device *device, size_t n, int repeats) {
    pc_status status = PC_OK;
    const uint32_t per_item = pc_device_shape(device) == PC_SHAPE_CHUNK ? 8192 : 1;
    const size_t items = (n / 8 + per_item - 1) / per_item;
    const double bytes = 24.0 * (double)n;
    double before = 0;
    double ignored = 0;
    pc_kernel *kernel;
    pc_buffer *a = NULL;
    pc_buffer *b = NULL;
    pc_buffer *c = NULL;
    PC_TRY(pc_kernel_get(&kernel, ctx, device, pc_kernel_triad, "triad"));
    PC_TRY(pc_buffer_zeroed(&a, ctx, device, n * sizeof(double)));
    PC_TRY(filled(&b, ctx, device, n));
    PC_TRY(filled(&c, ctx, device, n));
    for (int repeat = -1; repeat < repeats; repeat++) {
        PC_TRY(pc_kernel_run(ctx, kernel, items, pc_chunk_group(device), bytes,
                             PC_ARGS(PC_BUF(a), PC_BUF(b), PC_BUF(c), PC_U32((uint32_t)(n / 8)),
                                     PC_U32(per_item), PC_F64(3))));
        /* The first launch compiles. */
        PC_TRY(look(repeat < 0 ? &ignored : rate, ctx, device, "triad", &before, bytes));
    }
done:
    pc_buffer_free(a, ctx);
    pc_buffer_free(b, ctx);
    pc_buffer_free(c, ctx);
    return status;
}

pc_status pc_triad(double *rate, pc_context *ctx, pc_device *device, size_t n, int repeats) {
    *rate = 0;
    return pc_device_is_host(device) ? host_triad(rate, ctx, n, repeats)
                                     : device_triad(rate, ctx, device, n, repeats);
}
