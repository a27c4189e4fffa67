#include "launch.h"
#include "memory.h"
#include "normalcycle.h"
#include "vec3.h"

extern const char pc_kernel_curvature[];

enum { LUMP = 12, RESULT = 16 }; /* floats per vertex, as in curvature.cl */

typedef struct buffers {
    pc_buffer *high, *low, *triangle, *twin, *edge, *edge_half, *start, *vertex, *half;
    pc_buffer *bend, *lump, *other, *result;
    uint32_t chunk;
} buffers;

/* Positions about the centre, in mean edges, each as the sum of two floats. */
static pc_status upload_positions(buffers *b, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                                  double scale) {
    pc_status status = PC_OK;
    float *high = NULL, *low = NULL;
    size_t n = 3 * (size_t)mesh->vertex_count;
    double centre[3] = {0, 0, 0};
    PC_TRY(pc_new(&high, ctx, n));
    PC_TRY(pc_new(&low, ctx, n));
    for (size_t k = 0; k < n; k++)
        centre[k % 3] += mesh->position[k] / mesh->vertex_count;
#pragma omp parallel for schedule(static)
    for (size_t k = 0; k < n; k++) {
        double x = (mesh->position[k] - centre[k % 3]) * scale;
        high[k] = (float)x;
        low[k] = (float)(x - (double)high[k]);
    }
    PC_TRY(pc_buffer_from(&b->high, ctx, device, high, n * sizeof *high));
    PC_TRY(pc_buffer_from(&b->low, ctx, device, low, n * sizeof *low));
done:
    pc_free(ctx, high);
    pc_free(ctx, low);
    return status;
}

static pc_status upload(buffers *b, pc_context *ctx, pc_device *device, const pc_normalcycle *work) {
    pc_status status = PC_OK;
    const pc_mesh *mesh = work->mesh;
    const pc_adjacency *a = work->adjacency;
    size_t n = mesh->vertex_count, halves = 3 * (size_t)mesh->face_count, entries = work->ring->start[n];
    PC_TRY(upload_positions(b, ctx, device, mesh, work->step > 0 ? 1 / work->step : 1));
    PC_TRY(pc_buffer_from(&b->triangle, ctx, device, mesh->triangle, halves * sizeof(pc_index)));
    PC_TRY(pc_buffer_from(&b->twin, ctx, device, a->twin, halves * sizeof(pc_index)));
    PC_TRY(pc_buffer_from(&b->edge, ctx, device, a->edge, halves * sizeof(pc_index)));
    PC_TRY(pc_buffer_from(&b->edge_half, ctx, device, a->edge_half, a->edge_count * sizeof(pc_index)));
    PC_TRY(pc_buffer_from(&b->start, ctx, device, work->ring->start, (n + 1) * sizeof(pc_index)));
    PC_TRY(pc_buffer_from(&b->vertex, ctx, device, work->ring->vertex, entries * sizeof(pc_index)));
    PC_TRY(pc_buffer_from(&b->half, ctx, device, work->ring->half, entries * sizeof(pc_index)));
    PC_TRY(pc_buffer_make(&b->bend, ctx, device, a->edge_count * sizeof(float)));
    PC_TRY(pc_buffer_make(&b->lump, ctx, device, LUMP * n * sizeof(float)));
    PC_TRY(pc_buffer_make(&b->other, ctx, device, LUMP * n * sizeof(float)));
    PC_TRY(pc_buffer_make(&b->result, ctx, device, RESULT * n * sizeof(float)));
    b->chunk = pc_device_shape(device) == PC_SHAPE_CHUNK ? 1024 : 1;
done:
    return status;
}

static void free_buffers(buffers *b, pc_context *ctx) {
    pc_buffer *all[] = {b->high,   b->low,  b->triangle, b->twin, b->edge,  b->edge_half, b->start,
                        b->vertex, b->half, b->bend,     b->lump, b->other, b->result};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++)
        pc_buffer_free(all[k], ctx);
}

static pc_status run_averages(buffers *b, pc_context *ctx, pc_device *device, const pc_normalcycle *work,
                              int passes) {
    pc_status status = PC_OK;
    pc_kernel *average = NULL;
    pc_index n = work->mesh->vertex_count;
    size_t items = ((size_t)n + b->chunk - 1) / b->chunk;
    double entries = work->ring->start[n];
    PC_TRY(pc_kernel_get(&average, ctx, device, pc_kernel_curvature, "curvature_average"));
    for (int pass = 0; pass < passes; pass++) {
        pc_buffer *in = b->lump;
        PC_TRY(pc_check_interrupt(ctx));
        PC_TRY(pc_kernel_run(
            ctx, average, items, pc_chunk_group(device), n * (2.0 * LUMP + 7) * 4 + entries * 4,
            PC_ARGS(PC_BUF(b->other), PC_BUF(in), PC_BUF(b->high), PC_BUF(b->low), PC_BUF(b->start),
                    PC_BUF(b->vertex), PC_F32(1.0f), PC_U32(b->chunk), PC_U32(n))));
        b->lump = b->other;
        b->other = in;
    }
done:
    return status;
}

static pc_status run_level(buffers *b, pc_context *ctx, pc_device *device, const pc_normalcycle *work,
                           int k) {
    pc_status status = PC_OK;
    pc_kernel *principal = NULL;
    pc_index n = work->mesh->vertex_count;
    const pc_normalcycle_level *level = work->level + k;
    float prefer = k > 0 ? (float)PC_NORMALCYCLE_PREFER : 0.0f;
    PC_TRY(run_averages(b, ctx, device, work, level->passes - (k > 0 ? level[-1].passes : 0)));
    PC_TRY(pc_kernel_get(&principal, ctx, device, pc_kernel_curvature, "curvature_principal"));
    PC_TRY(
        pc_kernel_run(ctx, principal, ((size_t)n + b->chunk - 1) / b->chunk, pc_chunk_group(device),
                      n * (LUMP + RESULT) * 4.0,
                      PC_ARGS(PC_BUF(b->result), PC_BUF(b->lump), PC_F32((float)(level->flat * work->step)),
                              PC_F32((float)level->noise), PC_F32(prefer), PC_U32(b->chunk), PC_U32(n))));
done:
    return status;
}

static pc_status run(buffers *b, pc_context *ctx, pc_device *device, const pc_normalcycle *work) {
    pc_status status = PC_OK;
    pc_kernel *bend = NULL, *gather = NULL;
    pc_index n = work->mesh->vertex_count, edges = work->adjacency->edge_count;
    double halves = 3.0 * work->mesh->face_count, entries = work->ring->start[n];
    size_t items = ((size_t)n + b->chunk - 1) / b->chunk;
    PC_TRY(pc_kernel_get(&bend, ctx, device, pc_kernel_curvature, "curvature_bend"));
    PC_TRY(pc_kernel_get(&gather, ctx, device, pc_kernel_curvature, "curvature_gather"));
    PC_TRY(pc_kernel_run(ctx, bend, ((size_t)edges + b->chunk - 1) / b->chunk, pc_chunk_group(device),
                         edges * 8.0 + halves * 8 + n * 24.0,
                         PC_ARGS(PC_BUF(b->bend), PC_BUF(b->edge_half), PC_BUF(b->twin), PC_BUF(b->triangle),
                                 PC_BUF(b->high), PC_BUF(b->low), PC_U32(b->chunk), PC_U32(edges))));
    PC_TRY(pc_kernel_run(ctx, gather, items, pc_chunk_group(device),
                         n * (LUMP + 7) * 4.0 + entries * 8 + halves * 8 + edges * 4.0,
                         PC_ARGS(PC_BUF(b->lump), PC_BUF(b->bend), PC_BUF(b->edge), PC_BUF(b->triangle),
                                 PC_BUF(b->high), PC_BUF(b->low), PC_BUF(b->start), PC_BUF(b->vertex),
                                 PC_BUF(b->half), PC_F32(1.0f), PC_U32(b->chunk), PC_U32(n))));
    for (int k = 0; k < work->level_count; k++)
        PC_TRY(run_level(b, ctx, device, work, k));
done:
    return status;
}

/* Back to model units and to double; directions made unit and tangent to the last bit of a double. */
static void unpack(pc_curvature *c, const float *from, pc_index v, double per_length) {
    size_t i = v;
    for (int k = 0; k < 6; k++)
        c->tensor[6 * i + k] = from[k] * per_length;
    pc_vec3 n = pc_unit((pc_vec3){from[6], from[7], from[8]}), d = {from[11], from[12], from[13]};
    c->value[2 * i] = from[9] * per_length;
    c->value[2 * i + 1] = from[10] * per_length;
    pc_vec3_put(c->normal, i, n);
    pc_vec3_put(c->direction, i, pc_unit(pc_madd(d, -pc_dot(d, n), n)));
    c->weight[i] = from[14];
}

pc_status pc_normalcycle_launch(pc_curvature *curvature, pc_context *ctx, pc_device *device,
                                const pc_normalcycle *work) {
    pc_status status = PC_OK;
    buffers b = {0};
    float *result = NULL;
    size_t n = work->mesh->vertex_count;
    double per_length = work->step > 0 ? 1 / work->step : 1;
    PC_TRY(pc_new(&result, ctx, RESULT * n));
    PC_TRY(upload(&b, ctx, device, work));
    PC_TRY(run(&b, ctx, device, work));
    PC_TRY(pc_buffer_read(result, ctx, b.result, 0, RESULT * n * sizeof *result));
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < work->mesh->vertex_count; v++)
        unpack(curvature, result + RESULT * (size_t)v, v, per_length);
done:
    free_buffers(&b, ctx);
    pc_free(ctx, result);
    return status;
}
