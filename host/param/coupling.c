#include "coupling.h"
#include "memory.h"
#include "pgp_launch.h"
#include "vec3.h"

enum { WEIGHT_GRAIN = 4096 };
static const double WEIGHT_LEAST = 0.05, WEIGHT_MOST = 20.0;

static double cotangent(pc_vec3 apex, pc_vec3 a, pc_vec3 b) {
    pc_vec3 u = pc_sub(a, apex), v = pc_sub(b, apex);
    double area = pc_norm(pc_cross(u, v)), dot = pc_dot(u, v);
    if (area <= 1e-12 * fabs(dot)) return dot > 0 ? 1e12 : -1e12;
    return dot / area;
}

/* Cosine and sine of the angle of the edge direction e in the frame (K, n x K) of vertex v. */
static void heading(double unit[2], const pc_field *field, pc_index v, pc_vec3 e) {
    pc_vec3 k = pc_vec3_at(field->direction, v), n = pc_vec3_at(field->normal, v);
    double c = pc_dot(e, k), s = pc_dot(e, pc_cross(n, k)), size = sqrt(c * c + s * s);
    unit[0] = size > 0 ? c / size : 1;
    unit[1] = size > 0 ? s / size : 0;
}

static void couple_edge(pc_coupling *coupling, pc_index edge, const pc_mesh *mesh,
                        const pc_adjacency *adjacency, const pc_field *field, const double *scale,
                        double period_length) {
    pc_index h = adjacency->edge_half[edge], i = pc_tail(mesh, h), j = pc_head(mesh, h);
    pc_vec3 pi = pc_vec3_at(mesh->position, i), pj = pc_vec3_at(mesh->position, j), e = pc_sub(pj, pi);
    double weight = cotangent(pc_vec3_at(mesh->position, mesh->triangle[pc_prev(h)]), pi, pj);
    pc_index twin = adjacency->twin[h];
    if (twin != PC_NONE)
        weight += cotangent(pc_vec3_at(mesh->position, mesh->triangle[pc_prev(twin)]), pi, pj);
    weight = fmin(fmax(0.5 * weight, WEIGHT_LEAST), WEIGHT_MOST);

    /* K' = R90^r K_j sees the edge at its angle in K_j's frame - r*90 degrees; r is the field's own choice.
     */
    double own[2], seen[2];
    heading(own, field, i, e);
    heading(seen, field, j, e);
    pc_turn_pair(&seen[0], &seen[1], coupling->turn[edge]);
    double half = 0.5 * pc_norm(e) / period_length;
    double at_tail = half * (scale ? scale[i] : 1), at_head = half * (scale ? scale[j] : 1);
    coupling->advance[2 * (size_t)edge] = (float)(at_tail * own[0] + at_head * seen[0]);
    coupling->advance[2 * (size_t)edge + 1] = (float)(at_tail * own[1] + at_head * seen[1]);
    coupling->weight[edge] = (float)weight;
}

pc_status pc_coupling_make(pc_coupling *coupling, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                           const pc_adjacency *adjacency, const pc_field *field, const double *scale,
                           double period_length) {
    pc_status status = PC_OK;
    *coupling = (pc_coupling){.edge_count = adjacency->edge_count};
    PC_TRY(pc_new(&coupling->turn, ctx, adjacency->edge_count));
    PC_TRY(pc_new(&coupling->advance, ctx, 2 * (size_t)adjacency->edge_count));
    PC_TRY(pc_new(&coupling->weight, ctx, adjacency->edge_count));
#pragma omp parallel for schedule(static, WEIGHT_GRAIN)
    for (pc_index edge = 0; edge < adjacency->edge_count; edge++)
        coupling->turn[edge] = (uint8_t)(field->turn[adjacency->edge_half[edge]] * (4 / field->symmetry) & 3);
    if (!pc_device_is_host(device)) {
        PC_TRY(pc_pgp_launch_couple(coupling, ctx, device, mesh, adjacency, field, scale, period_length));
        goto done;
    }
#pragma omp parallel for schedule(static, WEIGHT_GRAIN)
    for (pc_index edge = 0; edge < adjacency->edge_count; edge++)
        couple_edge(coupling, edge, mesh, adjacency, field, scale, period_length);
done:
    if (status != PC_OK) pc_coupling_free(coupling, ctx);
    return status;
}

void pc_coupling_free(pc_coupling *coupling, pc_context *ctx) {
    if (!coupling) return;
    pc_free(ctx, coupling->turn);
    pc_free(ctx, coupling->advance);
    pc_free(ctx, coupling->weight);
    *coupling = (pc_coupling){0};
}
