#include "pgp_launch.h"
#include "launch.h"
#include "memory.h"
#include "transition.h"
#include "vec3.h"

extern const char pc_kernel_pgp[];

enum { CHUNK = 1024, MOST_PER_RANGE = 1 << 22, GRAIN = 4096 };

/* Elements of `bytes` that go to the device at a time: few enough for its cap, whole chunks where there are
 * many. */
static pc_index range_size(const pc_device *device, size_t bytes) {
    size_t fitting = pc_device_allocation_cap(device) / bytes;
    if (fitting > MOST_PER_RANGE) fitting = MOST_PER_RANGE;
    if (fitting > CHUNK) fitting -= fitting % CHUNK;
    return fitting > 0 ? (pc_index)fitting : 1;
}

static uint32_t chunk_of(const pc_device *device) {
    return pc_device_shape(device) == PC_SHAPE_CHUNK ? CHUNK : 1;
}
static size_t items(pc_index count, uint32_t chunk) {
    return ((size_t)count + chunk - 1) / chunk;
}
static pc_index least(size_t a, size_t b) {
    return (pc_index)(a < b ? a : b);
}

static pc_status get(pc_kernel **kernel, pc_context *ctx, pc_device *device, const char *name) {
    pc_status status = pc_device_require_doubles(device, ctx, "the parameterization");
    return status == PC_OK ? pc_kernel_get(kernel, ctx, device, pc_kernel_pgp, name) : status;
}

/* ---- couplings ---- */

typedef struct vertices {
    pc_buffer *high, *low, *normal, *direction, *scale;
} vertices;

static void free_vertices(vertices *v, pc_context *ctx) {
    pc_buffer *all[] = {v->high, v->low, v->normal, v->direction, v->scale};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++)
        pc_buffer_free(all[k], ctx);
}

static pc_status upload_narrow(pc_buffer **buffer, pc_context *ctx, pc_device *device, const double *from,
                               size_t n, float *space) {
#pragma omp parallel for schedule(static, GRAIN)
    for (size_t k = 0; k < n; k++)
        space[k] = (float)from[k];
    return pc_buffer_from(buffer, ctx, device, space, n * sizeof *space);
}

/* Positions about the centre, in periods, each as the sum of two floats; frames in float. */
static pc_status upload_vertices(vertices *v, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                                 const pc_field *field, const double *scale, double period_length) {
    pc_status status = PC_OK;
    float *high = NULL, *low = NULL;
    size_t n = 3 * (size_t)mesh->vertex_count;
    double centre[3] = {0, 0, 0};
    PC_TRY(pc_new(&high, ctx, n));
    PC_TRY(pc_new(&low, ctx, n));
    for (size_t k = 0; k < n; k++)
        centre[k % 3] += mesh->position[k] / mesh->vertex_count;
#pragma omp parallel for schedule(static, GRAIN)
    for (size_t k = 0; k < n; k++) {
        double x = (mesh->position[k] - centre[k % 3]) / period_length;
        high[k] = (float)x;
        low[k] = (float)(x - (double)high[k]);
    }
    PC_TRY(pc_buffer_from(&v->high, ctx, device, high, n * sizeof *high));
    PC_TRY(pc_buffer_from(&v->low, ctx, device, low, n * sizeof *low));
    PC_TRY(upload_narrow(&v->normal, ctx, device, field->normal, n, high));
    PC_TRY(upload_narrow(&v->direction, ctx, device, field->direction, n, high));
    PC_TRY(upload_narrow(&v->scale, ctx, device, scale, scale ? n / 3 : 0, high));
done:
    pc_free(ctx, high);
    pc_free(ctx, low);
    return status;
}

static void gather_corners(pc_index *corner, const pc_mesh *mesh, const pc_adjacency *adjacency,
                           pc_index first, pc_index count) {
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index e = 0; e < count; e++) {
        pc_index h = adjacency->edge_half[first + e], twin = adjacency->twin[h], *c = corner + 4 * (size_t)e;
        c[0] = pc_tail(mesh, h), c[1] = pc_head(mesh, h);
        c[2] = mesh->triangle[pc_prev(h)];
        c[3] = twin == PC_NONE ? PC_NONE : mesh->triangle[pc_prev(twin)];
    }
}

typedef struct couple_range {
    pc_kernel *kernel;
    pc_index *corner_host;
    pc_buffer *corner, *turn, *advance, *weight;
} couple_range;

static pc_status couple_edges(couple_range *r, pc_context *ctx, pc_device *device, pc_coupling *coupling,
                              const vertices *v, uint32_t scaled, pc_index first, pc_index count) {
    pc_status status = PC_OK;
    uint32_t chunk = chunk_of(device);
    PC_TRY(pc_buffer_write(r->corner, ctx, 0, r->corner_host, 4 * sizeof(pc_index) * (size_t)count));
    PC_TRY(pc_buffer_write(r->turn, ctx, 0, coupling->turn + first, count));
    PC_TRY(pc_kernel_run(ctx, r->kernel, items(count, chunk), pc_chunk_group(device),
                         count * (29.0 + 4 * 24 + 2 * 24),
                         PC_ARGS(PC_BUF(r->advance), PC_BUF(r->weight), PC_BUF(r->corner), PC_BUF(r->turn),
                                 PC_BUF(v->high), PC_BUF(v->low), PC_BUF(v->normal), PC_BUF(v->direction),
                                 PC_BUF(v->scale), PC_U32(scaled), PC_U32(chunk), PC_U32(count))));
    PC_TRY(pc_buffer_read(coupling->advance + 2 * (size_t)first, ctx, r->advance, 0,
                          2 * sizeof(float) * (size_t)count));
    PC_TRY(pc_buffer_read(coupling->weight + first, ctx, r->weight, 0, sizeof(float) * (size_t)count));
    PC_TRY(pc_check_interrupt(ctx));
done:
    return status;
}

pc_status pc_pgp_launch_couple(pc_coupling *coupling, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                               const pc_adjacency *adjacency, const pc_field *field, const double *scale,
                               double period_length) {
    pc_status status = PC_OK;
    vertices v = {0};
    couple_range r = {0};
    pc_index step = least(range_size(device, 4 * sizeof(pc_index)), coupling->edge_count);
    PC_TRY(get(&r.kernel, ctx, device, "pgp_couple"));
    PC_TRY(upload_vertices(&v, ctx, device, mesh, field, scale, period_length));
    PC_TRY(pc_new(&r.corner_host, ctx, 4 * (size_t)step));
    PC_TRY(pc_buffer_make(&r.corner, ctx, device, 4 * sizeof(pc_index) * (size_t)step));
    PC_TRY(pc_buffer_make(&r.turn, ctx, device, step));
    PC_TRY(pc_buffer_make(&r.advance, ctx, device, 2 * sizeof(float) * (size_t)step));
    PC_TRY(pc_buffer_make(&r.weight, ctx, device, sizeof(float) * (size_t)step));
    for (size_t first = 0; first < coupling->edge_count; first += step) {
        pc_index count = least(step, coupling->edge_count - first);
        gather_corners(r.corner_host, mesh, adjacency, (pc_index)first, count);
        PC_TRY(couple_edges(&r, ctx, device, coupling, &v, scale != NULL, (pc_index)first, count));
    }
done:
    free_vertices(&v, ctx);
    pc_free(ctx, r.corner_host);
    pc_buffer_free(r.corner, ctx);
    pc_buffer_free(r.turn, ctx);
    pc_buffer_free(r.advance, ctx);
    pc_buffer_free(r.weight, ctx);
    return status;
}

/* ---- the system ---- */

typedef struct assembly {
    pc_kernel *kernel;
    pc_index *origin; /* per entry: 2*edge, +1 seen from the edge's head */
    pc_index *from;   /* offsets of the range at hand */
    pc_buffer *advance, *weight, *turn;
} assembly;

static pc_status assemble_rows(assembly *a, pc_system *system, pc_context *ctx, pc_device *device,
                               pc_index first, pc_index count) {
    pc_status status = PC_OK;
    pc_buffer *value = NULL, *entry_turn = NULL, *degree = NULL, *start = NULL, *origin = NULL;
    size_t begin = system->start[first], entries = system->start[first + count] - begin;
    uint32_t chunk = chunk_of(device);
    for (pc_index i = 0; i <= count; i++)
        a->from[i] = system->start[first + i] - (pc_index)begin;
    PC_TRY(pc_buffer_from(&start, ctx, device, a->from, sizeof(pc_index) * ((size_t)count + 1)));
    PC_TRY(pc_buffer_from(&origin, ctx, device, a->origin + begin, sizeof(pc_index) * entries));
    PC_TRY(pc_buffer_make(&value, ctx, device, 4 * sizeof(double) * entries));
    PC_TRY(pc_buffer_make(&entry_turn, ctx, device, entries));
    PC_TRY(pc_buffer_make(&degree, ctx, device, sizeof(double) * count));
    PC_TRY(pc_kernel_run(ctx, a->kernel, items(count, chunk), pc_chunk_group(device),
                         (double)entries * (37 + 13) + 12.0 * count,
                         PC_ARGS(PC_BUF(value), PC_BUF(entry_turn), PC_BUF(degree), PC_BUF(start),
                                 PC_BUF(origin), PC_BUF(a->advance), PC_BUF(a->weight), PC_BUF(a->turn),
                                 PC_U32(chunk), PC_U32(count))));
    PC_TRY(pc_buffer_read(system->value + 4 * begin, ctx, value, 0, 4 * sizeof(double) * entries));
    PC_TRY(pc_buffer_read(system->turn + begin, ctx, entry_turn, 0, entries));
    PC_TRY(pc_buffer_read(system->diagonal + first, ctx, degree, 0, sizeof(double) * count));
    PC_TRY(pc_check_interrupt(ctx));
done:
    pc_buffer_free(value, ctx);
    pc_buffer_free(entry_turn, ctx);
    pc_buffer_free(degree, ctx);
    pc_buffer_free(start, ctx);
    pc_buffer_free(origin, ctx);
    return status;
}

/* Rows from `first` on that have at most `entries` entries together, at least one row. */
static pc_index rows_within(const pc_system *system, pc_index first, pc_index entries) {
    pc_index low = first + 1, high = system->row_count; /* the last row + 1 lies between */
    while (low < high) {
        pc_index middle = low + (high - low + 1) / 2;
        if (system->start[middle] - system->start[first] <= entries)
            low = middle;
        else
            high = middle - 1;
    }
    return low - first;
}

pc_status pc_pgp_launch_assemble(pc_system *system, pc_context *ctx, pc_device *device,
                                 const pc_edge_rows *rows, const pc_coupling *coupling) {
    pc_status status = PC_OK;
    assembly a = {0};
    size_t edges = coupling->edge_count;
    pc_index entries = range_size(device, 4 * sizeof(double));
    PC_TRY(get(&a.kernel, ctx, device, "pgp_assemble"));
    PC_TRY(pc_new(&a.origin, ctx, 2 * edges));
    PC_TRY(pc_new(&a.from, ctx, (size_t)system->row_count + 1));
    PC_TRY(pc_buffer_from(&a.advance, ctx, device, coupling->advance, 2 * sizeof(float) * edges));
    PC_TRY(pc_buffer_from(&a.weight, ctx, device, coupling->weight, sizeof(float) * edges));
    PC_TRY(pc_buffer_from(&a.turn, ctx, device, coupling->turn, edges));
#pragma omp parallel for schedule(static, GRAIN)
    for (size_t i = 0; i < 2 * edges; i++)
        a.origin[rows->slot[i]] = (pc_index)i;
    for (pc_index first = 0, count; first < system->row_count; first += count) {
        count = rows_within(system, first, entries);
        PC_TRY(assemble_rows(&a, system, ctx, device, first, count));
    }
done:
    pc_buffer_free(a.advance, ctx);
    pc_buffer_free(a.weight, ctx);
    pc_buffer_free(a.turn, ctx);
    pc_free(ctx, a.origin);
    pc_free(ctx, a.from);
    return status;
}

/* ---- phases and coordinates ---- */

pc_status pc_pgp_launch_normalise(double *phase, pc_context *ctx, pc_device *device, pc_index count) {
    pc_status status = PC_OK;
    pc_kernel *kernel = NULL;
    pc_buffer *buffer = NULL;
    size_t pairs = 2 * (size_t)count, pair = 2 * sizeof(double);
    pc_index step = least(range_size(device, pair), pairs);
    uint32_t chunk = chunk_of(device);
    PC_TRY(get(&kernel, ctx, device, "pgp_normalise"));
    PC_TRY(pc_buffer_make(&buffer, ctx, device, pair * step));
    for (size_t first = 0; first < pairs; first += step) {
        pc_index n = least(step, pairs - first);
        PC_TRY(pc_buffer_write(buffer, ctx, 0, phase + 2 * first, pair * n));
        PC_TRY(pc_kernel_run(ctx, kernel, items(n, chunk), pc_chunk_group(device), 32.0 * n,
                             PC_ARGS(PC_BUF(buffer), PC_U32(chunk), PC_U32(n))));
        PC_TRY(pc_buffer_read(phase + 2 * first, ctx, buffer, 0, pair * n));
        PC_TRY(pc_check_interrupt(ctx));
    }
done:
    pc_buffer_free(buffer, ctx);
    return status;
}

pc_status pc_pgp_launch_coordinates(int32_t *coordinate, pc_context *ctx, pc_device *device,
                                    const double *phase, pc_index count) {
    pc_status status = PC_OK;
    pc_kernel *kernel = NULL;
    pc_buffer *in = NULL, *out = NULL;
    size_t pairs = 2 * (size_t)count, pair = 2 * sizeof(double);
    pc_index step = least(range_size(device, pair), pairs);
    uint32_t chunk = chunk_of(device);
    PC_TRY(get(&kernel, ctx, device, "pgp_coordinate"));
    PC_TRY(pc_buffer_make(&in, ctx, device, pair * step));
    PC_TRY(pc_buffer_make(&out, ctx, device, sizeof(int32_t) * step));
    for (size_t first = 0; first < pairs; first += step) {
        pc_index n = least(step, pairs - first);
        PC_TRY(pc_buffer_write(in, ctx, 0, phase + 2 * first, pair * n));
        PC_TRY(pc_kernel_run(ctx, kernel, items(n, chunk), pc_chunk_group(device), 20.0 * n,
                             PC_ARGS(PC_BUF(out), PC_BUF(in), PC_U32(chunk), PC_U32(n))));
        PC_TRY(pc_buffer_read(coordinate + first, ctx, out, 0, sizeof(int32_t) * n));
        PC_TRY(pc_check_interrupt(ctx));
    }
done:
    pc_buffer_free(in, ctx);
    pc_buffer_free(out, ctx);
    return status;
}

/* ---- shifts ---- */

typedef struct shift_range {
    pc_kernel *kernel;
    pc_index *ends_host;
    int32_t *shift_host;
    pc_buffer *ends, *turn, *advance, *coordinate, *shift;
} shift_range;

static void gather_ends(pc_index *ends, const pc_mesh *mesh, const pc_adjacency *adjacency, size_t first,
                        pc_index count) {
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index e = 0; e < count; e++) {
        ends[2 * (size_t)e] = pc_tail(mesh, adjacency->edge_half[first + e]);
        ends[2 * (size_t)e + 1] = pc_head(mesh, adjacency->edge_half[first + e]);
    }
}

static pc_status shift_edges(shift_range *r, pc_context *ctx, pc_device *device, const pc_coupling *coupling,
                             size_t first, pc_index count) {
    pc_status status = PC_OK;
    uint32_t chunk = chunk_of(device);
    size_t n = count, pair = 2 * sizeof(int32_t);
    PC_TRY(pc_buffer_write(r->ends, ctx, 0, r->ends_host, pair * n));
    PC_TRY(pc_buffer_write(r->turn, ctx, 0, coupling->turn + first, n));
    PC_TRY(pc_buffer_write(r->advance, ctx, 0, coupling->advance + 2 * first, pair * n));
    PC_TRY(pc_kernel_run(ctx, r->kernel, items(count, chunk), pc_chunk_group(device), 41.0 * count,
                         PC_ARGS(PC_BUF(r->shift), PC_BUF(r->ends), PC_BUF(r->turn), PC_BUF(r->advance),
                                 PC_BUF(r->coordinate), PC_U32(chunk), PC_U32(count))));
    PC_TRY(pc_buffer_read(r->shift_host, ctx, r->shift, 0, pair * n));
    PC_TRY(pc_check_interrupt(ctx));
done:
    return status;
}

static void put_transition(pc_param *param, size_t h, pc_transition g) {
    param->turn[h] = (uint8_t)g.turn;
    param->shift[2 * h] = (int32_t)g.a, param->shift[2 * h + 1] = (int32_t)g.b;
}

static void put_shifts(pc_param *param, const pc_adjacency *adjacency, const pc_coupling *coupling,
                       const int32_t *shift, size_t first, pc_index count) {
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index e = 0; e < count; e++) {
        pc_index h = adjacency->edge_half[first + e];
        pc_transition g = {coupling->turn[first + e], shift[2 * (size_t)e], shift[2 * (size_t)e + 1]};
        put_transition(param, h, g);
        if (adjacency->twin[h] != PC_NONE)
            put_transition(param, adjacency->twin[h], pc_transition_inverse(g));
    }
}

pc_status pc_pgp_launch_shifts(pc_param *param, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                               const pc_adjacency *adjacency, const pc_coupling *coupling) {
    pc_status status = PC_OK;
    shift_range r = {0};
    const size_t pair = 2 * sizeof(int32_t);
    pc_index step = least(range_size(device, pair), coupling->edge_count);
    PC_TRY(get(&r.kernel, ctx, device, "pgp_shift"));
    PC_TRY(pc_new(&r.ends_host, ctx, 2 * (size_t)step));
    PC_TRY(pc_new(&r.shift_host, ctx, 2 * (size_t)step));
    PC_TRY(pc_buffer_from(&r.coordinate, ctx, device, param->coordinate, pair * mesh->vertex_count));
    PC_TRY(pc_buffer_make(&r.ends, ctx, device, pair * step));
    PC_TRY(pc_buffer_make(&r.turn, ctx, device, step));
    PC_TRY(pc_buffer_make(&r.advance, ctx, device, pair * step));
    PC_TRY(pc_buffer_make(&r.shift, ctx, device, pair * step));
    for (size_t first = 0; first < coupling->edge_count; first += step) {
        pc_index count = least(step, coupling->edge_count - first);
        gather_ends(r.ends_host, mesh, adjacency, first, count);
        PC_TRY(shift_edges(&r, ctx, device, coupling, first, count));
        put_shifts(param, adjacency, coupling, r.shift_host, first, count);
    }
done:
    pc_free(ctx, r.ends_host);
    pc_free(ctx, r.shift_host);
    pc_buffer_free(r.coordinate, ctx);
    pc_buffer_free(r.ends, ctx);
    pc_buffer_free(r.turn, ctx);
    pc_buffer_free(r.advance, ctx);
    pc_buffer_free(r.shift, ctx);
    return status;
}
