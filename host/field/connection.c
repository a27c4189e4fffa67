#include "connection.h"
#include "geometry.h"
#include "memory.h"
#include "vec3.h"
#include <stdbool.h>

static pc_vec3 along(const pc_mesh *mesh, pc_index h) {
    return pc_sub(pc_vec3_at(mesh->position, pc_head(mesh, h)), pc_vec3_at(mesh->position, pc_tail(mesh, h)));
}

static pc_vec3 face_normal(const pc_mesh *mesh, pc_index h) {
    return pc_cross(along(mesh, h), pc_scale(-1, along(mesh, pc_prev(h))));
}

static double corner_cotangent(const pc_mesh *mesh, pc_index h) {
    pc_vec3 a = along(mesh, h), b = pc_scale(-1, along(mesh, pc_prev(h)));
    double sine = pc_norm(pc_cross(a, b)), cosine = pc_dot(a, b);
    if (fabs(cosine) >= PC_COTANGENT_MOST * sine)
        return cosine > 0 ? PC_COTANGENT_MOST : cosine < 0 ? -PC_COTANGENT_MOST : 0;
    return cosine / sine;
}

static double edge_weight(const pc_mesh *mesh, pc_index h, pc_index twin) {
    double w = 0.5 * corner_cotangent(mesh, pc_prev(h));
    if (twin != PC_NONE) w += 0.5 * corner_cotangent(mesh, pc_prev(twin));
    return w > PC_WEIGHT_LEAST ? w : PC_WEIGHT_LEAST;
}

/* Sets angles of the outgoing half-edges of v, its total, and its normal. */
static void spread_angles(pc_connection *c, const pc_mesh *mesh, const pc_adjacency *a, pc_index v) {
    pc_index first = a->vertex_half[v], h = first;
    pc_vec3 n = {0, 0, 0};
    double sum = 0;
    int count = 0;
    c->total[v] = 2 * PC_PI;
    pc_vec3_put(c->normal, v, (pc_vec3){0, 0, 1});
    if (first == PC_NONE) return;
    do {
        c->angle[h] = sum;
        sum += pc_corner_angle(mesh, h);
        n = pc_add(n, face_normal(mesh, h));
        count++;
        h = pc_turn_ccw(a, h);
    } while (h != PC_NONE && h != first);
    bool inside = h != PC_NONE, flat = !(sum > 1e-12);
    c->total[v] = inside ? 2 * PC_PI : flat ? PC_PI : sum;
    double scale = flat ? 1 : c->total[v] / sum, at = 0;
    h = first;
    for (int k = 0; k < count; k++, h = pc_turn_ccw(a, h)) {
        c->angle[h] = flat ? at : c->angle[h] * scale;
        at += c->total[v] / count;
    }
    n = pc_unit(n);
    if (pc_dot(n, n) > 0.5) pc_vec3_put(c->normal, v, n);
}

/* The direction of angle 0: the mean, over the spokes, of the projected spoke turned back by its angle. */
static void fit_axis(pc_connection *c, const pc_mesh *mesh, const pc_adjacency *a, pc_index v) {
    pc_index first = a->vertex_half[v], h = first;
    pc_vec3 n = pc_vec3_at(c->normal, v), pick = fabs(n.x) < 0.6 ? (pc_vec3){1, 0, 0} : (pc_vec3){0, 1, 0};
    pc_vec3 b1 = pc_unit(pc_cross(pick, n)), b2 = pc_cross(n, b1);
    double re = 0, im = 0;
    if (first != PC_NONE) do {
            pc_vec3 e = along(mesh, h);
            double x = pc_dot(e, b1), y = pc_dot(e, b2), turn = -c->angle[h];
            re += x * cos(turn) - y * sin(turn);
            im += x * sin(turn) + y * cos(turn);
            h = pc_turn_ccw(a, h);
        } while (h != PC_NONE && h != first);
    double size = hypot(re, im);
    if (!(size > 0)) re = size = 1;
    pc_vec3_put(c->axis, v, pc_unit(pc_madd(pc_scale(re / size, b1), im / size, b2)));
}

static void carry_edge(pc_connection *c, const pc_mesh *mesh, const pc_adjacency *a, pc_index e) {
    pc_index h = a->edge_half[e], twin = a->twin[h];
    double back = twin == PC_NONE ? c->total[pc_head(mesh, h)] : c->angle[twin];
    c->transport[h] = back + PC_PI - c->angle[h];
    if (twin != PC_NONE) c->transport[twin] = -c->transport[h];
    c->weight[e] = edge_weight(mesh, h, twin);
}

pc_status pc_connection_make(pc_connection *connection, pc_context *ctx, const pc_mesh *mesh,
                             const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    size_t n = mesh->vertex_count, halves = 3 * (size_t)mesh->face_count;
    *connection = (pc_connection){.vertex_count = mesh->vertex_count};
    PC_TRY(pc_new(&connection->normal, ctx, 3 * n));
    PC_TRY(pc_new(&connection->axis, ctx, 3 * n));
    PC_TRY(pc_new(&connection->total, ctx, n));
    PC_TRY(pc_new(&connection->angle, ctx, halves));
    PC_TRY(pc_new(&connection->transport, ctx, halves));
    PC_TRY(pc_new(&connection->weight, ctx, adjacency->edge_count));
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        spread_angles(connection, mesh, adjacency, v);
        fit_axis(connection, mesh, adjacency, v);
    }
#pragma omp parallel for schedule(static)
    for (pc_index e = 0; e < adjacency->edge_count; e++)
        carry_edge(connection, mesh, adjacency, e);
done:
    if (status != PC_OK) pc_connection_free(connection, ctx);
    return status;
}

void pc_connection_free(pc_connection *connection, pc_context *ctx) {
    if (!connection) return;
    pc_free(ctx, connection->normal);
    pc_free(ctx, connection->axis);
    pc_free(ctx, connection->total);
    pc_free(ctx, connection->angle);
    pc_free(ctx, connection->transport);
    pc_free(ctx, connection->weight);
    *connection = (pc_connection){0};
}

double pc_connection_corner(const pc_connection *connection, const pc_mesh *mesh,
                            const pc_adjacency *adjacency, pc_index h) {
    pc_index v = pc_tail(mesh, h), next = pc_turn_ccw(adjacency, h);
    bool last = next == PC_NONE || next == adjacency->vertex_half[v];
    return (last ? connection->total[v] : connection->angle[next]) - connection->angle[h];
}

double pc_connection_angle(const pc_connection *connection, pc_index v, const double vector[3]) {
    pc_vec3 n = pc_vec3_at(connection->normal, v), x = pc_vec3_at(connection->axis, v),
            d = pc_vec3_at(vector, 0);
    return atan2(pc_dot(d, pc_cross(n, x)), pc_dot(d, x));
}

void pc_connection_direction(double vector[3], const pc_connection *connection, pc_index v, double angle) {
    pc_vec3 n = pc_vec3_at(connection->normal, v), x = pc_vec3_at(connection->axis, v);
    pc_vec3_put(vector, 0, pc_madd(pc_scale(cos(angle), x), sin(angle), pc_cross(n, x)));
}
