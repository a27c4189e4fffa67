#include "assembly.h"
#include "launch.h"
#include "memory.h"
#include "vec3.h"

extern const char pc_kernel_field[];

static void fill_row(double *value, const pc_assembly *work, pc_index v) {
    const pc_ring *ring = work->ring;
    for (pc_index k = ring->start[v]; k < ring->start[v + 1]; k++) {
        pc_index h = ring->half[k];
        double turn = work->symmetry * work->transport[h];
        double w = work->smoothness * work->weight[work->adjacency->edge[h]];
        value[2 * (size_t)k] = -w * cos(turn);
        value[2 * (size_t)k + 1] = (pc_tail(work->mesh, h) == v ? w : -w) * sin(turn);
    }
}

void pc_assembly_ref(double *value, const pc_assembly *work) {
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < work->mesh->vertex_count; v++)
        fill_row(value, work, v);
}

typedef struct buffers {
    pc_buffer *value, *start, *half, *tail, *edge, *weight, *turn;
} buffers;

/* Turns are reduced in double: a float would lose digits to the whole turns. */
static pc_status upload(buffers *b, pc_context *ctx, pc_device *device, const pc_assembly *work) {
    pc_status status = PC_OK;
    float *turn = NULL, *weight = NULL;
    size_t n = work->mesh->vertex_count, halves = 3 * (size_t)work->mesh->face_count;
    size_t entries = work->ring->start[n], edges = work->adjacency->edge_count;
    PC_TRY(pc_new(&turn, ctx, halves));
    PC_TRY(pc_new(&weight, ctx, edges));
#pragma omp parallel for schedule(static)
    for (size_t h = 0; h < halves; h++)
        turn[h] = (float)remainder(work->symmetry * work->transport[h], 2 * PC_PI);
#pragma omp parallel for schedule(static)
    for (size_t e = 0; e < edges; e++)
        weight[e] = (float)work->weight[e];
    PC_TRY(pc_buffer_from(&b->start, ctx, device, work->ring->start, (n + 1) * sizeof(pc_index)));
    PC_TRY(pc_buffer_from(&b->half, ctx, device, work->ring->half, entries * sizeof(pc_index)));
    PC_TRY(pc_buffer_from(&b->tail, ctx, device, work->mesh->triangle, halves * sizeof(pc_index)));
    PC_TRY(pc_buffer_from(&b->edge, ctx, device, work->adjacency->edge, halves * sizeof(pc_index)));
    PC_TRY(pc_buffer_from(&b->weight, ctx, device, weight, edges * sizeof *weight));
    PC_TRY(pc_buffer_from(&b->turn, ctx, device, turn, halves * sizeof *turn));
    PC_TRY(pc_buffer_make(&b->value, ctx, device, 2 * entries * sizeof(float)));
done:
    pc_free(ctx, turn);
    pc_free(ctx, weight);
    return status;
}

static void free_buffers(buffers *b, pc_context *ctx) {
    pc_buffer *all[] = {b->value, b->start, b->half, b->tail, b->edge, b->weight, b->turn};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++)
        pc_buffer_free(all[k], ctx);
}

pc_status pc_assembly_launch(double *value, pc_context *ctx, pc_device *device, const pc_assembly *work) {
    pc_status status = PC_OK;
    buffers b = {0};
    pc_kernel *kernel = NULL;
    float *result = NULL;
    pc_index n = work->mesh->vertex_count;
    size_t entries = work->ring->start[n];
    uint32_t chunk = pc_device_shape(device) == PC_SHAPE_CHUNK ? 1024 : 1;
    PC_TRY(pc_new(&result, ctx, 2 * entries));
    PC_TRY(upload(&b, ctx, device, work));
    PC_TRY(pc_kernel_get(&kernel, ctx, device, pc_kernel_field, "field_assemble"));
    PC_TRY(pc_kernel_run(ctx, kernel, ((size_t)n + chunk - 1) / chunk, pc_chunk_group(device),
                         entries * 28.0 + n * 4.0,
                         PC_ARGS(PC_BUF(b.value), PC_BUF(b.start), PC_BUF(b.half), PC_BUF(b.tail),
                                 PC_BUF(b.edge), PC_BUF(b.weight), PC_BUF(b.turn),
                                 PC_F32((float)work->smoothness), PC_U32(chunk), PC_U32(n))));
    PC_TRY(pc_buffer_read(result, ctx, b.value, 0, 2 * entries * sizeof *result));
    for (size_t k = 0; k < 2 * entries; k++)
        value[k] = result[k];
done:
    free_buffers(&b, ctx);
    pc_free(ctx, result);
    return status;
}
