#include "field.h"
#include "borders.h"
#include "comb.h"
#include "connection.h"
#include "geometry.h"
#include "memory.h"
#include "singularity.h"
#include "smooth.h"
#include "vec3.h"

typedef struct data {
    double *area;   /* per vertex */
    double *target; /* 2 per vertex: z0 */
    double *weight;
} data;

static pc_status new_data(data *d, pc_context *ctx, size_t n) {
    pc_status status = PC_OK;
    PC_TRY(pc_new(&d->area, ctx, n));
    PC_TRY(pc_new(&d->target, ctx, 2 * n));
    PC_TRY(pc_new(&d->weight, ctx, n));
done:
    return status;
}

static void free_data(data *d, pc_context *ctx) {
    pc_free(ctx, d->area);
    pc_free(ctx, d->target);
    pc_free(ctx, d->weight);
}

static void set_target(data *d, pc_index v, double angle, double weight, int n) {
    d->target[2 * (size_t)v] = cos(n * angle);
    d->target[2 * (size_t)v + 1] = sin(n * angle);
    d->weight[v] = weight;
}

static void curvature_data(data *d, const pc_connection *connection, const pc_curvature *curvature, int n,
                           double gain) {
    if (n == 1) return;
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < curvature->vertex_count; v++) {
        const double *k = curvature->value + 2 * (size_t)v;
        double bend = curvature->radius * fmax(fabs(k[0]), fabs(k[1]));
        set_target(d, v, pc_connection_angle(connection, v, curvature->direction + 3 * (size_t)v),
                   curvature->weight[v] * (1 + gain * bend * bend * bend * bend), n);
    }
}

/* The border outweighs the curvature: its strip of cells is one cell wide, so it weighs as an area of the
 * length of its edges times the feature length. */
static pc_status border_data(data *d, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency,
                             const pc_connection *connection, const pc_smooth_options *smooth,
                             pc_border_rule rule) {
    pc_status status = PC_OK;
    double *weight = NULL, *angle = NULL;
    PC_TRY(pc_new(&weight, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&angle, ctx, mesh->vertex_count));
    pc_borders_find(weight, angle, mesh, adjacency, connection, rule);
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        if (!(weight[v] > 0)) continue;
        pc_index h = adjacency->vertex_half[v];
        double edge =
            pc_distance(pc_vec3_at(mesh->position, v), pc_vec3_at(mesh->position, pc_head(mesh, h)));
        double strip = weight[v] * edge * smooth->length / d->area[v];
        if (strip > d->weight[v]) set_target(d, v, angle[v], strip, smooth->symmetry);
    }
done:
    pc_free(ctx, weight);
    pc_free(ctx, angle);
    return status;
}

static pc_status new_field(pc_field *field, pc_context *ctx, const pc_mesh *mesh, int symmetry) {
    pc_status status = PC_OK;
    size_t n = mesh->vertex_count;
    *field =
        (pc_field){.symmetry = symmetry, .vertex_count = mesh->vertex_count, .face_count = mesh->face_count};
    PC_TRY(pc_new(&field->normal, ctx, 3 * n));
    PC_TRY(pc_new(&field->direction, ctx, 3 * n));
    PC_TRY(pc_new(&field->angle, ctx, n));
done:
    return status;
}

static pc_status check_options(pc_context *ctx, const pc_field_options *o) {
    if (o->symmetry != 1 && o->symmetry != 2 && o->symmetry != 4)
        return pc_fail(ctx, PC_E_USAGE, "a direction field has symmetry 1, 2 or 4, not %d", o->symmetry);
    if (!(o->smoothness >= 0 && o->smoothness < 1))
        return pc_fail(ctx, PC_E_USAGE, "smoothness must be in [0,1), not %g", o->smoothness);
    return PC_OK;
}

/* All the rest from the angles, which are combed. */
static pc_status complete(pc_field *field, pc_context *ctx, const pc_mesh *mesh,
                          const pc_adjacency *adjacency, const pc_connection *connection) {
    pc_status status = PC_OK;
    PC_TRY(pc_comb_angles(field->angle, ctx, mesh, adjacency, connection, field->symmetry));
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_connection_direction(field->direction + 3 * (size_t)v, connection, v, field->angle[v]);
        pc_vec3_put(field->normal, v, pc_vec3_at(connection->normal, v));
    }
    PC_TRY(pc_singularity_find(field, ctx, mesh, adjacency, connection));
    PC_TRY(pc_field_check(field, ctx, mesh, adjacency));
done:
    return status;
}

pc_status pc_field_make(pc_field *field, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                        const pc_adjacency *adjacency, const pc_curvature *curvature,
                        const pc_field_options *options) {
    pc_status status = PC_OK;
    pc_connection connection = {0};
    data d = {0};
    pc_smooth_options smooth = {options->symmetry,       options->smoothness,
                                options->feature_length, options->relief_edges * curvature->mean_edge,
                                options->rounds,         options->tolerance,
                                options->solver};
    if (!(smooth.length > 0)) smooth.length = options->feature_edges * curvature->mean_edge;
    *field = (pc_field){0};
    PC_TRY(check_options(ctx, options));
    PC_TRY(new_field(field, ctx, mesh, options->symmetry));
    PC_TRY(new_data(&d, ctx, mesh->vertex_count));
    PC_TRY(pc_connection_make(&connection, ctx, mesh, adjacency));
    pc_geometry_vertex_areas(d.area, mesh, 1e-4);
    curvature_data(&d, &connection, curvature, options->symmetry, options->feature_gain);
    PC_TRY(border_data(&d, ctx, mesh, adjacency, &connection, &smooth, options->borders));
    PC_TRY(pc_smooth_field(field->angle, ctx, device, mesh, adjacency, &connection, d.area, d.target,
                           d.weight, &smooth));
    PC_TRY(complete(field, ctx, mesh, adjacency, &connection));
    pc_log(ctx, PC_LOG_INFO, "field: %u singular faces", pc_singularity_count(field));
done:
    pc_connection_free(&connection, ctx);
    free_data(&d, ctx);
    if (status != PC_OK) pc_field_free(field, ctx);
    return status;
}

pc_status pc_field_sample(pc_field *field, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                          const pc_adjacency *adjacency, const pc_field *given, const pc_index *source) {
    pc_status status = PC_OK;
    pc_connection connection = {0};
    data d = {0};
    const double edge = pc_geometry_mean_edge(mesh, adjacency);
    const pc_smooth_options smooth = {given->symmetry,   0.5, 1.5 * edge, 2 * edge, 1, 1e-3,
                                      PC_SOLVER_DEFAULTS};
    *field = (pc_field){0};
    PC_TRY(new_field(field, ctx, mesh, given->symmetry));
    PC_TRY(new_data(&d, ctx, mesh->vertex_count));
    PC_TRY(pc_connection_make(&connection, ctx, mesh, adjacency));
    pc_geometry_vertex_areas(d.area, mesh, 1e-4);
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        const double *direction = given->direction + 3 * (size_t)source[v];
        set_target(&d, v, pc_connection_angle(&connection, v, direction), 1, given->symmetry);
    }
    PC_TRY(pc_smooth_field(field->angle, ctx, device, mesh, adjacency, &connection, d.area, d.target,
                           d.weight, &smooth));
    PC_TRY(complete(field, ctx, mesh, adjacency, &connection));
done:
    pc_connection_free(&connection, ctx);
    free_data(&d, ctx);
    if (status != PC_OK) pc_field_free(field, ctx);
    return status;
}

void pc_field_free(pc_field *field, pc_context *ctx) {
    if (!field) return;
    pc_free(ctx, field->normal);
    pc_free(ctx, field->direction);
    pc_free(ctx, field->index);
    pc_free(ctx, field->loop_index);
    pc_free(ctx, field->angle);
    pc_free(ctx, field->turn);
    *field = (pc_field){0};
}

pc_status pc_field_check(const pc_field *field, pc_context *ctx, const pc_mesh *mesh,
                         const pc_adjacency *adjacency) {
    int64_t sum = 0, chi = (int64_t)mesh->vertex_count - adjacency->edge_count + mesh->face_count;
    for (pc_index v = 0; v < field->vertex_count; v++) {
        pc_vec3 n = pc_vec3_at(field->normal, v), d = pc_vec3_at(field->direction, v);
        if (!(fabs(pc_norm(n) - 1) < 1e-6 && fabs(pc_norm(d) - 1) < 1e-6 && fabs(pc_dot(n, d)) < 1e-6))
            return pc_fail(ctx, PC_E_BUG, "the field's direction at vertex %u is not a unit tangent", v);
        chi -= adjacency->vertex_half[v] == PC_NONE; /* isolated vertices are not part of the surface */
    }
    for (size_t h = 0; h < 3 * (size_t)field->face_count; h++)
        if (field->turn[h] >= field->symmetry)
            return pc_fail(ctx, PC_E_BUG, "turn %u of half-edge %zu is out of range", field->turn[h], h);
    for (pc_index f = 0; f < field->face_count; f++)
        sum += field->index[f];
    for (pc_index k = 0; k < field->loop_count; k++)
        sum += field->loop_index[k];
    if (sum != field->symmetry * chi)
        return pc_fail(ctx, PC_E_BUG, "field indices sum to %lld/%d, the Euler number is %lld",
                       (long long)sum, field->symmetry, (long long)chi);
    return PC_OK;
}
