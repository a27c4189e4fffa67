#include "relief.h"
#include "memory.h"
#include "vec3.h"
#include <math.h>
#include <string.h>

/* Radians, of one edge's transport. Around a handle a few edges wide more would have to be moved: a field
 * that is smooth in such a connection is none on the surface, and gains singularities. */
static const double most_change = 0.3;

/* Dual weights, edge over dual edge, are one over the cotangent weights. */
static double dual_weight(const pc_adjacency *a, const pc_connection *c, pc_index h) {
    return 1 / c->weight[a->edge[h]];
}

static double face_area(const pc_mesh *mesh, pc_index f) {
    const pc_index *t = mesh->triangle + 3 * (size_t)f;
    pc_vec3 p = pc_vec3_at(mesh->position, t[0]), a = pc_sub(pc_vec3_at(mesh->position, t[1]), p);
    return 0.5 * pc_norm(pc_cross(a, pc_sub(pc_vec3_at(mesh->position, t[2]), p)));
}

static pc_status new_dual_system(pc_system *system, pc_context *ctx, const pc_mesh *mesh,
                                 const pc_adjacency *a) {
    pc_status status = pc_system_make(system, ctx, PC_BLOCK_SCALAR, mesh->face_count,
                                      3 * (size_t)mesh->face_count - a->boundary_edge_count);
    if (status != PC_OK) return status;
    system->start[0] = 0;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_index count = 0;
        for (pc_index h = 3 * f; h < 3 * f + 3; h++)
            count += a->twin[h] != PC_NONE;
        system->start[f + 1] = system->start[f] + count;
    }
    return PC_OK;
}

static void dual_row(pc_system *system, const pc_adjacency *a, const pc_connection *c, pc_index f,
                     double area, double t) {
    pc_index begin = system->start[f], count = 0;
    double sum = 0;
    for (pc_index h = 3 * f; h < 3 * f + 3; h++) {
        if (a->twin[h] == PC_NONE) continue;
        double w = t * dual_weight(a, c, h);
        pc_index other = a->twin[h] / 3, at = begin + count++;
        for (; at > begin && system->column[at - 1] > other; at--) {
            system->column[at] = system->column[at - 1];
            system->value[at] = system->value[at - 1];
        }
        system->column[at] = other;
        system->value[at] = -w;
        sum += w;
    }
    system->diagonal[f] = area + sum;
}

static double angle_excess(const pc_mesh *mesh, const pc_adjacency *a, const pc_connection *c, pc_index f) {
    double sum = -PC_PI;
    for (pc_index h = 3 * f; h < 3 * f + 3; h++)
        sum += pc_connection_corner(c, mesh, a, h);
    return sum;
}

static double total_area(const pc_mesh *mesh) {
    double sum = 0;
    for (pc_index f = 0; f < mesh->face_count; f++)
        sum += face_area(mesh, f);
    return sum;
}

pc_status pc_relief_smooth(double *transport, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                           const pc_adjacency *adjacency, const pc_connection *connection, double length,
                           const pc_solver_options *solver) {
    pc_status status = PC_OK;
    pc_system system = {0};
    pc_solver *engine = NULL;
    pc_solver_stats stats = {0};
    double *excess = NULL, *density = NULL, t = length * length, whole = total_area(mesh);
    const size_t bytes = 3 * (size_t)mesh->face_count * sizeof *transport;
    if (!(length > 0) || !(whole > 0)) {
        memcpy(transport, connection->transport, bytes);
        return PC_OK;
    }
    double least = 1e-4 * whole / mesh->face_count;
    PC_TRY(pc_new(&excess, ctx, mesh->face_count));
    PC_TRY(new_dual_system(&system, ctx, mesh, adjacency));
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < mesh->face_count; f++) {
        double area = face_area(mesh, f);
        excess[f] = angle_excess(mesh, adjacency, connection, f);
        dual_row(&system, adjacency, connection, f, area > least ? area : least, t);
    }
    PC_TRY(pc_solver_make(&engine, ctx, device, &system, solver));
    pc_system_free(&system, ctx);
    PC_TRY(pc_new(&density, ctx, mesh->face_count));
    PC_TRY(pc_solver_approach(engine, ctx, density, excess, 1e-4, 0.1, &stats));
    pc_log(ctx, PC_LOG_DEBUG, "relief: %u iterations to residual %.1e, %.2f s + %.2f s", stats.iterations,
           stats.residual, stats.setup_seconds, stats.solve_seconds);
    memcpy(transport, connection->transport, bytes);
#pragma omp parallel for schedule(static)
    for (pc_index h = 0; h < 3 * mesh->face_count; h++)
        if (adjacency->twin[h] != PC_NONE) {
            double change = t * dual_weight(adjacency, connection, h) *
                            (density[h / 3] - density[adjacency->twin[h] / 3]);
            transport[h] -= fmin(fmax(change, -most_change), most_change);
        }
done:
    pc_solver_free(engine, ctx);
    pc_system_free(&system, ctx);
    pc_free(ctx, excess);
    pc_free(ctx, density);
    return status;
}
