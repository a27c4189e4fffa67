#include "pgp.h"
#include "geometry.h"
#include "hostvec.h"
#include "memory.h"
#include "pgp_launch.h"
#include "random.h"
#include "topology.h"
#include "vec3.h"
#include <string.h>

enum { GRAIN = 4096 };
static const double LEAST_MASS = 1e-6; /* of the mean: a vertex among zero-area triangles still takes part */

/* ---- the system ---- */

static void put_entry(pc_system *system, pc_index at, int turn, double s, double t, double weight) {
    double a = 2 * PC_PI * s, b = 2 * PC_PI * t;
    double *value = system->value + 4 * (size_t)at;
    value[0] = -weight * cos(a), value[1] = weight * sin(a);
    value[2] = -weight * cos(b), value[3] = weight * sin(b);
    system->turn[at] = (uint8_t)turn;
}

static void assemble(pc_system *system, const pc_mesh *mesh, const pc_adjacency *adjacency,
                     const pc_index *slot, const pc_coupling *coupling) {
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        int turn = coupling->turn[e], back = pc_turn_back(turn);
        double s = coupling->advance[2 * (size_t)e], t = coupling->advance[2 * (size_t)e + 1];
        double weight = coupling->weight[e];
        put_entry(system, slot[2 * (size_t)e], turn, s, t, weight);
        pc_turn_pair(&s, &t, back);
        put_entry(system, slot[2 * (size_t)e + 1], back, -s, -t, weight);
    }
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        pc_index h = adjacency->edge_half[e];
        system->diagonal[pc_tail(mesh, h)] += coupling->weight[e];
        system->diagonal[pc_head(mesh, h)] += coupling->weight[e];
    }
}

pc_status pc_pgp_assemble(pc_system *system, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                          const pc_adjacency *adjacency, const pc_edge_rows *rows,
                          const pc_coupling *coupling) {
    pc_status status = PC_OK;
    PC_TRY(
        pc_system_make(system, ctx, PC_BLOCK_TURNED, mesh->vertex_count, 2 * (size_t)adjacency->edge_count));
    memcpy(system->start, rows->start, sizeof(pc_index) * ((size_t)rows->row_count + 1));
    memcpy(system->column, rows->column, sizeof(pc_index) * 2 * (size_t)rows->edge_count);
    if (pc_device_is_host(device))
        assemble(system, mesh, adjacency, rows->slot, coupling);
    else
        PC_TRY(pc_pgp_launch_assemble(system, ctx, device, rows, coupling));
done:
    if (status != PC_OK) pc_system_free(system, ctx);
    return status;
}

/* ---- normalise and solve ---- */

/* Per vertex the least shift: a reach beyond the vertex's component serves nothing and leaves a singular
 * system. */
static pc_status least_shifts(double *least, pc_context *ctx, const pc_mesh *mesh,
                              const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    pc_topology topology = {0};
    double total = 0;
    PC_TRY(pc_topology_make(&topology, ctx, mesh, adjacency));
    for (pc_index c = 0; c < topology.component_count; c++)
        total += topology.component[c].area;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        double area = fmax(topology.component[topology.face_component[f]].area, 1e-12 * total);
        for (int k = 0; k < 3; k++)
            least[mesh->triangle[3 * (size_t)f + (size_t)k]] = area > 0 ? 0.25 / area : 0;
    }
done:
    pc_topology_free(&topology, ctx);
    return status;
}

pc_status pc_pgp_normalise(double *phase, pc_context *ctx, pc_device *device, pc_index count) {
    if (!pc_device_is_host(device)) return pc_pgp_launch_normalise(phase, ctx, device, count);
#pragma omp parallel for schedule(static, GRAIN)
    for (size_t i = 0; i < 2 * (size_t)count; i++) {
        double *u = phase + 2 * i, norm = sqrt(u[0] * u[0] + u[1] * u[1]);
        u[0] = norm > 1e-30 ? u[0] / norm : 1;
        u[1] = norm > 1e-30 ? u[1] / norm : 0;
    }
    return PC_OK;
}

static void start_phases(double *phase, pc_index count, uint64_t seed) {
    double largest = 0;
    for (size_t i = 0; i < 4 * (size_t)count; i++)
        largest = fmax(largest, fabs(phase[i]));
    if (largest > 0) return;
    for (pc_index i = 0; i < 2 * count; i++) {
        double angle = 2 * PC_PI * (double)(pc_hash64(seed * 0x1000003u + i) >> 11) * 0x1p-53;
        phase[2 * (size_t)i] = cos(angle), phase[2 * (size_t)i + 1] = sin(angle);
    }
}

/* The sum over the edges in blocks of fixed size, so that the number of threads does not show. */
static double edge_energy(const double *phase, const pc_mesh *mesh, const pc_adjacency *adjacency,
                          const pc_coupling *coupling) {
    double sum = 0;
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        pc_index h = adjacency->edge_half[e];
        const double *x = phase + 4 * (size_t)pc_tail(mesh, h), *y = phase + 4 * (size_t)pc_head(mesh, h);
        double s = atan2(y[1], y[0]), t = atan2(y[3], y[2]);
        pc_turn_pair(&s, &t, coupling->turn[e]);
        s -= atan2(x[1], x[0]) + 2 * PC_PI * coupling->advance[2 * (size_t)e];
        t -= atan2(x[3], x[2]) + 2 * PC_PI * coupling->advance[2 * (size_t)e + 1];
        sum += coupling->weight[e] * (4 - 2 * cos(s) - 2 * cos(t));
    }
    return sum;
}

/* What both schemes work on. */
typedef struct problem {
    pc_context *ctx;
    pc_device *device;
    pc_index count;
    double period_length;
    pc_system
        system; /* couplings, and the sum of their weights on the diagonal; gone once the solver is made */
    pc_solver *solver;
    double *mass, *degree, *least, *diagonal, *rhs;
} problem;

static pc_status pose(problem *p, const pc_mesh *mesh, const pc_adjacency *adjacency,
                      const pc_coupling *coupling) {
    pc_status status = PC_OK;
    pc_edge_rows rows = {0};
    pc_index n = p->count = mesh->vertex_count;
    PC_TRY(pc_new(&p->mass, p->ctx, n));
    PC_TRY(pc_new(&p->least, p->ctx, n));
    pc_geometry_vertex_areas(p->mass, mesh, LEAST_MASS);
    PC_TRY(least_shifts(p->least, p->ctx, mesh, adjacency));
    PC_TRY(pc_edge_rows_make(&rows, p->ctx, mesh, adjacency));
    PC_TRY(pc_pgp_assemble(&p->system, p->ctx, p->device, mesh, adjacency, &rows, coupling));
    PC_TRY(pc_new(&p->degree, p->ctx, n));
    memcpy(p->degree, p->system.diagonal, sizeof(double) * n);
done:
    pc_edge_rows_free(&rows, p->ctx);
    return status;
}

static void dispose(problem *p) {
    double *arrays[] = {p->mass, p->degree, p->least, p->diagonal, p->rhs};
    pc_solver_free(p->solver, p->ctx);
    pc_system_free(&p->system, p->ctx);
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++)
        pc_free(p->ctx, arrays[k]);
}

/* The solver for A + M/reach^2. */
static pc_status aim(problem *p, double reach, bool keep_system) {
    pc_status status = PC_OK;
    const pc_solver_options solver_options = PC_SOLVER_DEFAULTS;
    const double shift = 1 / (reach * reach);
    if (p->solver && !p->diagonal) PC_TRY(pc_new(&p->diagonal, p->ctx, p->count));
    double *diagonal = p->solver ? p->diagonal : p->system.diagonal;
    for (pc_index i = 0; i < p->count; i++)
        diagonal[i] = p->degree[i] + fmax(shift, p->least[i]) * p->mass[i];
    if (p->solver) return pc_solver_set_diagonal(p->solver, p->ctx, diagonal);
    PC_TRY(pc_solver_make(&p->solver, p->ctx, p->device, &p->system, &solver_options));
    if (keep_system)
        memcpy(p->system.diagonal, p->degree, sizeof(double) * p->count);
    else
        pc_system_free(&p->system, p->ctx);
done:
    return status;
}

/* phase = (A + M/reach^2)^-1 M/reach^2 phase/|phase|. The solver starts from the phases as they were, norms
 * and all: around singularities, where norms vanish, those of norm 1 are far rougher than the solution.
 * Making it takes the most memory: the first phases and the right-hand side come afterwards. */
static pc_status diffuse(double *phase, pc_pgp_stats *stats, problem *p, double reach, double tolerance,
                         uint64_t seed, bool keep_system) {
    pc_status status = PC_OK;
    const double worst = 0.1; /* each step only has to bring the phases on */
    const double shift = 1 / (reach * reach);
    PC_TRY(aim(p, reach, keep_system));
    if (stats->steps == 0) {
        start_phases(phase, p->count, seed);
        PC_TRY(pc_new(&p->rhs, p->ctx, 4 * (size_t)p->count));
    }
    memcpy(p->rhs, phase, sizeof(double) * 4 * p->count);
    PC_TRY(pc_pgp_normalise(p->rhs, p->ctx, p->device, p->count));
    for (size_t i = 0; i < 4 * (size_t)p->count; i++)
        p->rhs[i] *= fmax(shift, p->least[i / 4]) * p->mass[i / 4];
    if (stats->steps == 0) memset(phase, 0, sizeof(double) * 4 * p->count); /* noise is no start */
    pc_solver_stats solved;
    PC_TRY(pc_solver_approach(p->solver, p->ctx, phase, p->rhs, tolerance, worst, &solved));
    pc_log(p->ctx, PC_LOG_DEBUG, "pgp: %u iterations to residual %.1e, %.2f s + %.2f s", solved.iterations,
           solved.residual, solved.setup_seconds, solved.solve_seconds);
    stats->steps++;
    stats->iterations += solved.iterations;
    stats->seconds_in_solver += solved.setup_seconds + solved.solve_seconds;
    PC_TRY(pc_check_interrupt(p->ctx));
done:
    return status;
}

static pc_status normalise_and_solve(double *phase, pc_pgp_stats *stats, problem *p,
                                     const pc_pgp_options *options) {
    pc_status status = PC_OK;
    const double last_step = 0.01; /* the last one is what counts */
    for (int step = 0; step < options->steps; step++) {
        double f = options->steps > 1 ? (double)step / (options->steps - 1) : 1;
        double reach =
            p->period_length * options->first_reach * pow(options->last_reach / options->first_reach, f);
        double tolerance = (step + 1 < options->steps ? 1 : last_step) * options->tolerance;
        PC_TRY(diffuse(phase, stats, p, reach, tolerance, options->seed, false));
        pc_progress(p->ctx, (step + 1.0) / options->steps);
    }
    PC_TRY(pc_pgp_normalise(phase, p->ctx, p->device, p->count));
done:
    return status;
}

/* To a mean square of 1 of U and of V. */
static void scale_to_unit(double *phase, pc_index count) {
    size_t n = 4 * (size_t)count;
    double square = pc_hostvec_dot(phase, phase, n);
    double factor = square > 0 ? sqrt((double)n / 2 / square) : 1;
    for (size_t i = 0; i < n; i++)
        phase[i] *= factor;
}

static pc_status penalise_norms(double *phase, pc_pgp_stats *stats, problem *p,
                                const pc_pgp_options *options) {
    pc_status status = PC_OK;
    /* Equilateral triangles with sides of a tenth of a period: sqrt(3)/2 of the square of a side belongs to a
     * vertex. */
    const double paper_area = sqrt(0.75) / 100;
    const double square = p->period_length * p->period_length;
    pc_newton_stats newton;
    PC_TRY(diffuse(phase, stats, p, options->first_reach * p->period_length, options->tolerance,
                   options->seed, true));
    scale_to_unit(phase, p->count);
    pc_solver_free(p->solver, p->ctx);
    p->solver = NULL;
    for (pc_index i = 0; i < p->count; i++)
        p->mass[i] *= options->newton.penalty / (paper_area * square);
    PC_TRY(pc_newton_solve(phase, &newton, p->ctx, p->device, &p->system, p->mass, &options->newton));
    stats->steps += newton.steps;
    stats->iterations += newton.iterations;
    stats->seconds_in_solver += newton.seconds_in_solver;
    PC_TRY(pc_pgp_normalise(phase, p->ctx, p->device, p->count));
done:
    return status;
}

pc_status pc_pgp_solve(double *phase, pc_pgp_stats *stats, pc_context *ctx, pc_device *device,
                       const pc_mesh *mesh, const pc_adjacency *adjacency, const pc_coupling *coupling,
                       double period_length, const pc_pgp_options *options) {
    pc_status status = PC_OK;
    problem p = {.ctx = ctx, .device = device, .period_length = period_length};
    *stats = (pc_pgp_stats){0};
    PC_TRY(pose(&p, mesh, adjacency, coupling));
    if (options->scheme == PC_PGP_NEWTON)
        PC_TRY(penalise_norms(phase, stats, &p, options));
    else
        PC_TRY(normalise_and_solve(phase, stats, &p, options));
    stats->energy = edge_energy(phase, mesh, adjacency, coupling);
done:
    dispose(&p);
    return status;
}
