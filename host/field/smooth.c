#include "smooth.h"
#include "assembly.h"
#include "memory.h"
#include "relief.h"
#include "vec3.h"

typedef struct smoothing {
    pc_context *ctx;
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    const pc_connection *connection;
    const pc_smooth_options *options;
    const double *area, *target, *weight;
    pc_ring
        ring; /* as the transport, gone once the system is there: making the solver takes the most memory */
    double *transport;
    pc_system system;
    pc_solver *solver;
    double *stiff; /* per vertex: rho times the sum of its edges' weights */
    double *z, *right;
    pc_index iterations;
} smoothing;

/* The diagonal is the sum of the sizes of the entries as they came out, so that rounding cannot make the
 * system indefinite. */
static void sum_row(smoothing *s, pc_index v) {
    double sum = 0;
    for (pc_index k = s->ring.start[v]; k < s->ring.start[v + 1]; k++)
        sum += hypot(s->system.value[2 * (size_t)k], s->system.value[2 * (size_t)k + 1]);
    s->stiff[v] = sum;
}

static pc_status assemble(smoothing *s, pc_device *device) {
    pc_status status = PC_OK;
    pc_assembly work = {s->mesh,
                        s->adjacency,
                        &s->ring,
                        s->connection->weight,
                        s->transport,
                        s->options->symmetry,
                        s->options->smoothness};
    size_t n = s->mesh->vertex_count, entries;
    PC_TRY(pc_ring_make(&s->ring, s->ctx, s->mesh, s->adjacency));
    entries = s->ring.start[n];
    PC_TRY(pc_system_make(&s->system, s->ctx, PC_BLOCK_COMPLEX, s->mesh->vertex_count, entries));
    PC_TRY(pc_new(&s->stiff, s->ctx, n));
    for (size_t v = 0; v <= n; v++)
        s->system.start[v] = s->ring.start[v];
    for (size_t k = 0; k < entries; k++)
        s->system.column[k] = s->ring.vertex[k];
    if (pc_device_is_host(device))
        pc_assembly_ref(s->system.value, &work);
    else
        PC_TRY(pc_assembly_launch(s->system.value, s->ctx, device, &work));
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < s->mesh->vertex_count; v++)
        sum_row(s, v);
done:
    pc_ring_free(&s->ring, s->ctx);
    pc_free(s->ctx, s->transport);
    s->transport = NULL;
    return status;
}

/* A start that no data is needed for: the direction nearest to the x axis. */
static void start_field(smoothing *s) {
    const double x_axis[3] = {1, 0, 0};
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < s->mesh->vertex_count; v++) {
        double a = s->options->symmetry * pc_connection_angle(s->connection, v, x_axis);
        s->z[2 * (size_t)v] = cos(a);
        s->z[2 * (size_t)v + 1] = sin(a);
    }
}

static void load(smoothing *s, double mu) {
    double data = (1 - s->options->smoothness) / (s->options->length * s->options->length);
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < s->mesh->vertex_count; v++) {
        size_t re = 2 * (size_t)v, im = re + 1;
        double size = hypot(s->z[re], s->z[im]), a = s->area[v];
        if (!(size > 0)) s->z[re] = size = 1;
        double w = data * s->weight[v] * a, keep = mu * a;
        s->z[re] /= size;
        s->z[im] /= size;
        s->right[re] = w * s->target[re] + keep * s->z[re];
        s->right[im] = w * s->target[im] + keep * s->z[im];
        s->system.diagonal[v] = s->stiff[v] + w + keep;
    }
}

static pc_status solve_step(smoothing *s, pc_device *device, double mu) {
    const double worst = 0.1;
    pc_solver_stats stats = {0};
    pc_status status = PC_OK;
    load(s, mu);
    if (!s->solver) {
        PC_TRY(pc_solver_make(&s->solver, s->ctx, device, &s->system, &s->options->solver));
        pc_system_free_couplings(&s->system, s->ctx);
    } else {
        PC_TRY(pc_solver_set_diagonal(s->solver, s->ctx, s->system.diagonal));
    }
    PC_TRY(pc_solver_approach(s->solver, s->ctx, s->z, s->right, s->options->tolerance, worst, &stats));
    s->iterations += stats.iterations;
    pc_log(s->ctx, PC_LOG_DEBUG, "field: %u iterations to residual %.1e, %.2f s + %.2f s", stats.iterations,
           stats.residual, stats.setup_seconds, stats.solve_seconds);
done:
    return status;
}

static double sum_area(const smoothing *s) {
    double sum = 0;
    for (pc_index v = 0; v < s->mesh->vertex_count; v++)
        sum += s->area[v];
    return sum;
}

pc_status pc_smooth_field(double *angle, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                          const pc_adjacency *adjacency, const pc_connection *connection, const double *area,
                          const double *target, const double *weight, const pc_smooth_options *options) {
    pc_status status = PC_OK;
    smoothing s = {.ctx = ctx,
                   .mesh = mesh,
                   .adjacency = adjacency,
                   .connection = connection,
                   .options = options,
                   .area = area,
                   .target = target,
                   .weight = weight};
    double rho = options->smoothness, whole;
    PC_TRY(pc_new(&s.transport, ctx, 3 * (size_t)mesh->face_count));
    PC_TRY(pc_relief_smooth(s.transport, ctx, device, mesh, adjacency, connection, options->relief,
                            &options->solver));
    PC_TRY(assemble(&s, device));
    PC_TRY(pc_new(&s.z, ctx, 2 * (size_t)mesh->vertex_count));
    PC_TRY(pc_new(&s.right, ctx, 2 * (size_t)mesh->vertex_count));
    whole = sum_area(&s);
    start_field(&s);
    PC_TRY(solve_step(&s, device, (rho + 1e-3) * 1e-2 / whole));
    for (int round = 0; round < options->rounds; round++) {
        double length = options->length * (1 << (options->rounds - 1 - round));
        double mu = (rho + 1e-3) / (length * length), least = (rho + 1e-3) / whole;
        PC_TRY(pc_check_interrupt(ctx));
        PC_TRY(solve_step(&s, device, mu > least ? mu : least));
    }
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        angle[v] = atan2(s.z[2 * (size_t)v + 1], s.z[2 * (size_t)v]) / options->symmetry;
done:
    pc_solver_free(s.solver, ctx);
    pc_system_free(&s.system, ctx);
    pc_free(ctx, s.transport);
    pc_free(ctx, s.stiff);
    pc_free(ctx, s.z);
    pc_free(ctx, s.right);
    return status;
}
