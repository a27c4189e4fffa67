#include "param.h"
#include "clock.h"
#include "dislocation.h"
#include "integrate.h"
#include "memory.h"
#include "pgp.h"
#include "reconstruct.h"
#include "squeeze.h"
#include "transition.h"
#include "untangle.h"
#include "vec3.h"
#include <string.h>

enum { MOST_GUARDS = 12 };
static const double LEAST_ROOM = 0.3;             /* of the area asked for */
static const double INTEGRATION_TOLERANCE = 1e-5; /* of the change of coordinates, itself below a period */

static pc_status make_arrays(pc_param *param, pc_context *ctx, const pc_mesh *mesh, double period_length) {
    pc_status status = PC_OK;
    *param = (pc_param){
        .vertex_count = mesh->vertex_count, .face_count = mesh->face_count, .period_length = period_length};
    PC_TRY(pc_new(&param->phase, ctx, 4 * (size_t)mesh->vertex_count));
    PC_TRY(pc_new(&param->coordinate, ctx, 2 * (size_t)mesh->vertex_count));
    PC_TRY(pc_new(&param->turn, ctx, 3 * (size_t)mesh->face_count));
    PC_TRY(pc_new(&param->shift, ctx, 6 * (size_t)mesh->face_count));
    PC_TRY(pc_new(&param->singular, ctx, mesh->face_count));
done:
    return status;
}

static pc_status check_edges(pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency,
                             const double *scale, double period_length) {
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        pc_index i = pc_tail(mesh, adjacency->edge_half[e]), j = pc_head(mesh, adjacency->edge_half[e]);
        double length = pc_distance(pc_vec3_at(mesh->position, i), pc_vec3_at(mesh->position, j));
        double side = period_length / (scale ? fmax(scale[i], scale[j]) : 1);
        if (length >= 0.499 * side)
            return pc_fail(ctx, PC_E_MESH,
                           "edge %u-%u is %g long, too long for cells of side %g: refine first", i, j, length,
                           side);
    }
    return PC_OK;
}

static void count_flags(pc_param_stats *stats, const pc_param *param) {
    stats->dislocations = stats->field_singularities = stats->flipped = 0;
    for (pc_index f = 0; f < param->face_count; f++) {
        stats->dislocations += param->singular[f] == PC_DISLOCATION;
        stats->field_singularities += param->singular[f] == PC_FIELD_SINGULARITY;
        stats->flipped += param->singular[f] == PC_FLIPPED;
    }
}

/* What the steps after PGP work on. */
typedef struct solving {
    pc_context *ctx;
    pc_device *device;
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    const pc_field *field;
    const pc_coupling *coupling;
    const pc_edge_rows *rows;
    const double *scale;
    pc_solver **solver; /* of pc_integrate */
} solving;

/* Cancels, integrates, and where a region has lost most of its room to that (a horn may live on its
 * dislocations alone) starts again with those dislocations guarded. */
static pc_status cancel_dislocations(pc_param *param, pc_param_stats *stats, const solving *s, double reach) {
    pc_status status = PC_OK;
    pc_context *ctx = s->ctx;
    size_t shifts = 6 * (size_t)s->mesh->face_count, coordinates = 2 * (size_t)s->mesh->vertex_count;
    int32_t *shift = NULL, *coordinate = NULL;
    uint8_t *guarded = NULL;
    pc_dislocation_plans *plans = NULL;
    pc_squeeze squeeze = {0};
    PC_TRY(pc_new(&shift, ctx, shifts));
    PC_TRY(pc_new(&coordinate, ctx, coordinates));
    PC_TRY(pc_new(&guarded, ctx, s->mesh->vertex_count));
    memcpy(shift, param->shift, shifts * sizeof *shift);
    memcpy(coordinate, param->coordinate, coordinates * sizeof *coordinate);
    /* What is squeezed before anything is cancelled is not to be blamed on it, nor made worse. */
    pc_index squeezed;
    PC_TRY(pc_squeeze_make(&squeeze, ctx, param, s->mesh, s->rows, s->scale));
    PC_TRY(pc_squeeze_mark(guarded, &squeezed, ctx, &squeeze, param, s->mesh, LEAST_ROOM));
    for (int round = 0; round < MOST_GUARDS; round++) {
        PC_TRY(pc_dislocations_cancel(param, &stats->cancelled, &plans, ctx, s->mesh, s->adjacency, guarded,
                                      reach));
        PC_TRY(pc_integrate(param, ctx, s->device, s->mesh, s->adjacency, s->coupling, s->rows, s->field,
                            s->scale, s->solver, INTEGRATION_TOLERANCE, &stats->iterations));
        pc_reconstruct_torn(param, s->mesh, s->adjacency, s->coupling);
        pc_reconstruct_flags(param, s->mesh);
        PC_TRY(pc_squeeze_mark(guarded, &squeezed, ctx, &squeeze, param, s->mesh, LEAST_ROOM));
        pc_log(ctx, PC_LOG_DEBUG, "%u dislocations cancelled, %u vertices squeezed by it", stats->cancelled,
               squeezed);
        if (squeezed == 0 || round + 1 == MOST_GUARDS) break;
        memcpy(param->shift, shift, shifts * sizeof *shift);
        memcpy(param->coordinate, coordinate, coordinates * sizeof *coordinate);
        pc_reconstruct_flags(param, s->mesh);
    }
done:
    pc_free(ctx, shift);
    pc_free(ctx, coordinate);
    pc_free(ctx, guarded);
    pc_dislocation_plans_free(plans, ctx);
    pc_squeeze_free(&squeeze, ctx);
    return status;
}

pc_status pc_param_make(pc_param *param, pc_param_stats *stats, pc_context *ctx, pc_device *device,
                        const pc_mesh *mesh, const pc_adjacency *adjacency, const pc_field *field,
                        const double *scale, const pc_param_options *options) {
    pc_status status = PC_OK;
    pc_coupling coupling = {0};
    pc_edge_rows rows = {0};
    pc_pgp_stats solved;
    pc_solver *solver = NULL;
    double *phase = NULL;
    *param = (pc_param){0};
    *stats = (pc_param_stats){0};
    PC_TRY(check_edges(ctx, mesh, adjacency, scale, options->period_length));
    PC_TRY(make_arrays(param, ctx, mesh, options->period_length));
    PC_TRY(pc_coupling_make(&coupling, ctx, device, mesh, adjacency, field, scale, options->period_length));
    PC_TRY(pc_new(&phase, ctx, 4 * (size_t)mesh->vertex_count));
    double cpu = pc_clock_cpu();
    PC_TRY(pc_pgp_solve(phase, &solved, ctx, device, mesh, adjacency, &coupling, options->period_length,
                        &options->pgp));
    stats->energy = solved.energy;
    stats->iterations = solved.iterations;
    stats->pgp_iterations = solved.iterations;
    stats->steps = solved.steps;
    stats->pgp_cpu_seconds = pc_clock_cpu() - cpu;
    for (size_t i = 0; i < 4 * (size_t)mesh->vertex_count; i++)
        param->phase[i] = (float)phase[i];
    PC_TRY(pc_reconstruct(param, ctx, device, mesh, adjacency, &coupling, phase));
    pc_free(ctx, phase);
    phase = NULL;
    count_flags(stats, param);
    stats->raw_dislocations = stats->dislocations;
    stats->raw_flipped = stats->flipped;
    pc_log(ctx, PC_LOG_DEBUG,
           "pgp: %u iterations, energy %g, %u dislocations, %u field singularities, %u flipped",
           stats->iterations, stats->energy, stats->dislocations, stats->field_singularities, stats->flipped);
    PC_TRY(pc_edge_rows_make(&rows, ctx, mesh, adjacency));
    PC_TRY(pc_integrate(param, ctx, device, mesh, adjacency, &coupling, &rows, field, scale, &solver,
                        INTEGRATION_TOLERANCE, &stats->iterations));
    pc_reconstruct_shifts(param, mesh, adjacency, &coupling);
    pc_reconstruct_flags(param, mesh);
    if (options->cancel_reach > 0) {
        const solving on = {ctx, device, mesh, adjacency, field, &coupling, &rows, scale, &solver};
        PC_TRY(cancel_dislocations(param, stats, &on, options->cancel_reach * options->period_length));
    }
    pc_solver_free(solver, ctx);
    solver = NULL;
    PC_TRY(pc_untangle(param, ctx, mesh, adjacency));
    count_flags(stats, param);
    pc_log(ctx, PC_LOG_DEBUG,
           "%u dislocations cancelled; left: %u dislocations, %u field singularities, %u flipped",
           stats->cancelled, stats->dislocations, stats->field_singularities, stats->flipped);
done:
    pc_solver_free(solver, ctx);
    pc_coupling_free(&coupling, ctx);
    pc_edge_rows_free(&rows, ctx);
    pc_free(ctx, phase);
    if (status != PC_OK) pc_param_free(param, ctx);
    return status;
}

void pc_param_free(pc_param *param, pc_context *ctx) {
    if (!param) return;
    pc_free(ctx, param->phase);
    pc_free(ctx, param->coordinate);
    pc_free(ctx, param->turn);
    pc_free(ctx, param->shift);
    pc_free(ctx, param->singular);
    *param = (pc_param){0};
}

pc_status pc_param_check(const pc_param *param, pc_context *ctx, const pc_mesh *mesh,
                         const pc_adjacency *adjacency) {
    const int32_t *c = param->coordinate;
    for (size_t i = 0; i < 2 * (size_t)param->vertex_count; i++)
        if (!(c[i] & 1)) return pc_fail(ctx, PC_E_BUG, "the coordinate of vertex %zu is even", i / 2);
    for (size_t h = 0; h < 3 * (size_t)param->face_count; h++) {
        pc_transition g = pc_transition_of(param, h);
        size_t i = pc_tail(mesh, (pc_index)h), j = pc_head(mesh, (pc_index)h);
        pc_point2 q = pc_transition_apply(g, (pc_point2){c[2 * j], c[2 * j + 1]});
        int64_t s = q.s - c[2 * i], t = q.t - c[2 * i + 1];
        if (s <= -PC_PERIOD || s >= PC_PERIOD || t <= -PC_PERIOD || t >= PC_PERIOD)
            return pc_fail(ctx, PC_E_BUG, "half-edge %zu jumps over a whole period", h);
        if (adjacency->twin[h] == PC_NONE) continue;
        pc_transition once = pc_transition_after(g, pc_transition_of(param, adjacency->twin[h]));
        if (once.turn || once.a || once.b)
            return pc_fail(ctx, PC_E_BUG, "the transitions of half-edge %zu and its twin do not cancel", h);
    }
    for (pc_index f = 0; f < param->face_count; f++)
        if (param->singular[f] != pc_reconstruct_flag(param, mesh->triangle, f))
            return pc_fail(ctx, PC_E_BUG, "the flag of face %u is %d, not %d", f, param->singular[f],
                           pc_reconstruct_flag(param, mesh->triangle, f));
    return PC_OK;
}
