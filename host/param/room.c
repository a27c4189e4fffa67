#include "room.h"
#include "connection.h"
#include "edge_rows.h"
#include "geometry.h"
#include "memory.h"
#include "solver.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void spread_over_corners(double *singularities, const pc_mesh *mesh, const pc_field *field) {
    for (pc_index h = 0; h < 3 * mesh->face_count; h++)
        singularities[mesh->triangle[h]] += abs(field->index[h / 3]) / 3.0;
}

static pc_status heat_system(pc_system *system, pc_context *ctx, const pc_mesh *mesh,
                             const pc_adjacency *adjacency, const double *area, double reach) {
    pc_status status = PC_OK;
    pc_edge_rows rows = {0};
    pc_connection connection = {0};
    pc_index n = mesh->vertex_count;
    PC_TRY(pc_edge_rows_make(&rows, ctx, mesh, adjacency));
    PC_TRY(pc_connection_make(&connection, ctx, mesh, adjacency));
    PC_TRY(pc_system_make(system, ctx, PC_BLOCK_SCALAR, n, 2 * (size_t)adjacency->edge_count));
    memcpy(system->start, rows.start, sizeof(pc_index) * ((size_t)n + 1));
    memcpy(system->column, rows.column, sizeof(pc_index) * 2 * (size_t)adjacency->edge_count);
    memcpy(system->diagonal, area, sizeof(double) * n);
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        pc_index h = adjacency->edge_half[e];
        double flow = reach * reach * connection.weight[e];
        system->value[rows.slot[2 * (size_t)e]] = system->value[rows.slot[2 * (size_t)e + 1]] = -flow;
        system->diagonal[pc_tail(mesh, h)] += flow, system->diagonal[pc_head(mesh, h)] += flow;
    }
done:
    pc_connection_free(&connection, ctx);
    pc_edge_rows_free(&rows, ctx);
    return status;
}

pc_status pc_room_make(double *scale, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                       const pc_adjacency *adjacency, const pc_field *field, const pc_room_options *options) {
    pc_status status = PC_OK;
    pc_system system = {0};
    pc_solver *solver = NULL;
    pc_solver_stats solved;
    const pc_solver_options solver_options = PC_SOLVER_DEFAULTS;
    double *area = NULL, *singularities = NULL, *density = NULL;
    pc_index n = mesh->vertex_count;
    PC_TRY(pc_new(&area, ctx, n));
    PC_TRY(pc_new(&singularities, ctx, n));
    PC_TRY(pc_new(&density, ctx, n));
    pc_geometry_vertex_areas(area, mesh, 1e-6);
    spread_over_corners(singularities, mesh, field);
    PC_TRY(heat_system(&system, ctx, mesh, adjacency, area, options->period_length));
    PC_TRY(pc_solver_make(&solver, ctx, device, &system, &solver_options));
    pc_system_free(&system, ctx);
    PC_TRY(pc_solver_approach(solver, ctx, density, singularities, 1e-4, 0.1, &solved));
    for (pc_index v = 0; v < n; v++) {
        double wanted = options->cells * density[v] * options->period_length * options->period_length;
        scale[v] = fmax(scale[v], fmin(sqrt(fmax(wanted, 0)), options->most));
    }
done:
    pc_solver_free(solver, ctx);
    pc_system_free(&system, ctx);
    pc_free(ctx, area);
    pc_free(ctx, singularities);
    pc_free(ctx, density);
    return status;
}
