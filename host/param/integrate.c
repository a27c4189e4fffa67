#include "integrate.h"
#include "cone.h"
#include "memory.h"
#include "transition.h"
#include "vec3.h"
#include <string.h>

enum { GRAIN = 4096 };
static const double CONE_WEIGHT =
    1.7; /* that of the three edges to the centroid of an equilateral triangle */

/* z = s + i t turns by (-i)^turn. */
static void turned_unit(double unit[2], int turn) {
    unit[0] = turn == 0 ? 1 : turn == 2 ? -1 : 0;
    unit[1] = turn == 1 ? -1 : turn == 3 ? 1 : 0;
}

static void put_coupling(pc_system *system, pc_index at, int turn, double weight) {
    double unit[2];
    turned_unit(unit, turn);
    system->value[2 * (size_t)at] = -weight * unit[0];
    system->value[2 * (size_t)at + 1] = -weight * unit[1];
}

/* The normal equations, without cones. */
static void fill_system(pc_system *system, const pc_mesh *mesh, const pc_adjacency *adjacency,
                        const pc_index *slot, const pc_coupling *coupling, const pc_param *param) {
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        pc_index h = adjacency->edge_half[e];
        double weight = coupling->weight[e];
        int turn = param->turn[h];
        put_coupling(system, slot[2 * (size_t)e], turn, weight);
        put_coupling(system, slot[2 * (size_t)e + 1], pc_turn_back(turn), weight);
        system->diagonal[pc_tail(mesh, h)] += weight, system->diagonal[pc_head(mesh, h)] += weight;
    }
}

/* Their right-hand side, in periods, for the change of the coordinates. */
static void fill_right(double *rhs, const pc_mesh *mesh, const pc_adjacency *adjacency,
                       const pc_coupling *coupling, const pc_param *param) {
    const int32_t *c = param->coordinate;
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        size_t h = adjacency->edge_half[e], i = pc_tail(mesh, (pc_index)h), j = pc_head(mesh, (pc_index)h);
        double weight = coupling->weight[e];
        pc_point2 q = pc_transition_apply(pc_transition_of(param, h), (pc_point2){c[2 * j], c[2 * j + 1]});
        double s = (double)(q.s - c[2 * i]) / PC_PERIOD - coupling->advance[2 * (size_t)e];
        double t = (double)(q.t - c[2 * i + 1]) / PC_PERIOD - coupling->advance[2 * (size_t)e + 1];
        rhs[2 * i] += weight * s, rhs[2 * i + 1] += weight * t;
        pc_turn_pair(&s, &t, pc_turn_back(param->turn[h]));
        rhs[2 * j] -= weight * s, rhs[2 * j + 1] -= weight * t;
    }
}

/* Corners of a singular triangle are drawn to where its cone wants them. The cone stands at the centroid. */
static void pull_to_cones(double *diagonal, double *rhs, const pc_mesh *mesh, const pc_param *param,
                          const pc_field *field, const double *scale) {
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_point2 cone;
        if (param->singular[f] != PC_FIELD_SINGULARITY || !pc_cone_point(&cone, param, f)) continue;
        const pc_index *corner = mesh->triangle + 3 * (size_t)f;
        pc_transition to[3] = {{0, 0, 0},
                               pc_transition_inverse(pc_transition_of(param, 3 * (size_t)f)),
                               pc_transition_of(param, 3 * (size_t)f + 2)};
        pc_vec3 sum = pc_add(pc_vec3_at(mesh->position, corner[0]), pc_vec3_at(mesh->position, corner[1]));
        pc_vec3 centre = pc_scale(1.0 / 3, pc_add(sum, pc_vec3_at(mesh->position, corner[2])));
        for (int k = 0; k < 3; k++) {
            size_t v = corner[k];
            pc_point2 goal = pc_transition_apply(to[k], cone);
            pc_vec3 way = pc_sub(centre, pc_vec3_at(mesh->position, v)),
                    along = pc_vec3_at(field->direction, v);
            pc_vec3 across = pc_cross(pc_vec3_at(field->normal, v), along);
            double cells = (scale ? scale[v] : 1) / param->period_length;
            double s = (double)(goal.s - param->coordinate[2 * v]) / PC_PERIOD - pc_dot(way, along) * cells;
            double t =
                (double)(goal.t - param->coordinate[2 * v + 1]) / PC_PERIOD - pc_dot(way, across) * cells;
            if (diagonal) diagonal[v] += CONE_WEIGHT;
            rhs[2 * v] += CONE_WEIGHT * s, rhs[2 * v + 1] += CONE_WEIGHT * t;
        }
    }
}

static pc_status make_solver(pc_solver **solver, double *rhs, pc_context *ctx, pc_device *device,
                             const pc_mesh *mesh, const pc_adjacency *adjacency, const pc_coupling *coupling,
                             const pc_edge_rows *rows, const pc_param *param, const pc_field *field,
                             const double *scale) {
    pc_status status = PC_OK;
    pc_system system = {0};
    pc_index n = mesh->vertex_count;
    const pc_solver_options options = PC_SOLVER_DEFAULTS;
    PC_TRY(pc_system_make(&system, ctx, PC_BLOCK_COMPLEX, n, 2 * (size_t)adjacency->edge_count));
    memcpy(system.start, rows->start, sizeof(pc_index) * ((size_t)n + 1));
    memcpy(system.column, rows->column, sizeof(pc_index) * 2 * (size_t)adjacency->edge_count);
    fill_system(&system, mesh, adjacency, rows->slot, coupling, param);
    pull_to_cones(system.diagonal, rhs, mesh, param, field, scale);
    /* Without singularities a constant can be added: a hair of the diagonal settles it. */
    for (pc_index i = 0; i < n; i++)
        system.diagonal[i] = system.diagonal[i] > 0 ? system.diagonal[i] * (1 + 1e-7) : 1;
    PC_TRY(pc_solver_make(solver, ctx, device, &system, &options));
done:
    pc_system_free(&system, ctx);
    return status;
}

pc_status pc_integrate(pc_param *param, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                       const pc_adjacency *adjacency, const pc_coupling *coupling, const pc_edge_rows *rows,
                       const pc_field *field, const double *scale, pc_solver **solver, double tolerance,
                       pc_index *iterations) {
    pc_status status = PC_OK;
    double *rhs = NULL, *change = NULL;
    pc_index n = mesh->vertex_count;
    const double worst = 0.1; /* less strained than before all the same */
    PC_TRY(pc_new(&rhs, ctx, 2 * (size_t)n));
    PC_TRY(pc_new(&change, ctx, 2 * (size_t)n));
    fill_right(rhs, mesh, adjacency, coupling, param);
    if (*solver)
        pull_to_cones(NULL, rhs, mesh, param, field, scale);
    else
        PC_TRY(make_solver(solver, rhs, ctx, device, mesh, adjacency, coupling, rows, param, field, scale));
    pc_solver_stats solved;
    PC_TRY(pc_solver_approach(*solver, ctx, change, rhs, tolerance, worst, &solved));
    pc_log(ctx, PC_LOG_DEBUG, "integrate: %u iterations to residual %.1e, %.2f s + %.2f s", solved.iterations,
           solved.residual, solved.setup_seconds, solved.solve_seconds);
    *iterations += solved.iterations;
#pragma omp parallel for schedule(static, GRAIN)
    for (size_t i = 0; i < 2 * (size_t)n; i++)
        param->coordinate[i] =
            (param->coordinate[i] + (int32_t)lround(change[i] * (0.5 * PC_PERIOD)) * 2) | 1;
done:
    pc_free(ctx, rhs);
    pc_free(ctx, change);
    return status;
}
