#include "reconstruct.h"
#include "pgp_launch.h"
#include "transition.h"
#include "vec3.h"
#include <stdlib.h>

enum { GRAIN = 4096 };

int32_t pc_fixed_coordinate(double periods) {
    double fraction = periods - floor(periods);
    int32_t fixed = (int32_t)(fraction * PC_PERIOD) | 1;
    return fixed & (PC_PERIOD - 1);
}

/* The whole number nearest to advance - (to-from)/PC_PERIOD, halves away from zero, in integers: every device
 * finds the same. */
static int32_t whole_periods(float advance, int64_t from, int64_t to) {
    float scaled = advance * PC_PERIOD, whole = floorf(scaled);
    int64_t steps = (int64_t)whole - (to - from);
    if (steps >= 0) return (int32_t)((steps + PC_PERIOD / 2) / PC_PERIOD);
    return -(int32_t)((PC_PERIOD / 2 - steps - (scaled > whole)) / PC_PERIOD);
}

/* The shift of edge e that brings the jump closest to its advance, put on both half-edges. */
static void round_shift(pc_param *param, pc_index e, const pc_mesh *mesh, const pc_adjacency *adjacency,
                        const pc_coupling *coupling) {
    const int32_t *c = param->coordinate;
    size_t h = adjacency->edge_half[e], i = pc_tail(mesh, (pc_index)h), j = pc_head(mesh, (pc_index)h);
    pc_point2 p = {c[2 * i], c[2 * i + 1]};
    pc_point2 q = pc_point2_turned((pc_point2){c[2 * j], c[2 * j + 1]}, coupling->turn[e]);
    pc_transition g = {coupling->turn[e], whole_periods(coupling->advance[2 * (size_t)e], p.s, q.s),
                       whole_periods(coupling->advance[2 * (size_t)e + 1], p.t, q.t)};
    param->turn[h] = (uint8_t)g.turn;
    param->shift[2 * h] = (int32_t)g.a, param->shift[2 * h + 1] = (int32_t)g.b;
    if (adjacency->twin[h] == PC_NONE) return;
    size_t twin = adjacency->twin[h];
    g = pc_transition_inverse(g);
    param->turn[twin] = (uint8_t)g.turn;
    param->shift[2 * twin] = (int32_t)g.a, param->shift[2 * twin + 1] = (int32_t)g.b;
}

void pc_reconstruct_shifts(pc_param *param, const pc_mesh *mesh, const pc_adjacency *adjacency,
                           const pc_coupling *coupling) {
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index e = 0; e < adjacency->edge_count; e++)
        round_shift(param, e, mesh, adjacency, coupling);
}

void pc_reconstruct_torn(pc_param *param, const pc_mesh *mesh, const pc_adjacency *adjacency,
                         const pc_coupling *coupling) {
    const int32_t *c = param->coordinate;
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        size_t h = adjacency->edge_half[e], i = pc_tail(mesh, (pc_index)h), j = pc_head(mesh, (pc_index)h);
        pc_point2 q = pc_transition_apply(pc_transition_of(param, h), (pc_point2){c[2 * j], c[2 * j + 1]});
        if (llabs(q.s - c[2 * i]) >= PC_PERIOD || llabs(q.t - c[2 * i + 1]) >= PC_PERIOD)
            round_shift(param, e, mesh, adjacency, coupling);
    }
}

int pc_reconstruct_flag(const pc_param *param, const pc_index *triangle, pc_index face) {
    size_t h = 3 * (size_t)face;
    pc_point2 p[3];
    pc_transition once =
        pc_transition_after(pc_transition_after(pc_transition_of(param, h), pc_transition_of(param, h + 1)),
                            pc_transition_of(param, h + 2));
    if (once.turn) return PC_FIELD_SINGULARITY;
    if (once.a || once.b) return PC_DISLOCATION;
    pc_param_corners(p, param, triangle, face);
    return pc_point2_area(p[0], p[1], p[2]) <= 0 ? PC_FLIPPED : PC_REGULAR;
}

void pc_reconstruct_flags(pc_param *param, const pc_mesh *mesh) {
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index f = 0; f < mesh->face_count; f++)
        param->singular[f] = (uint8_t)pc_reconstruct_flag(param, mesh->triangle, f);
}

pc_status pc_reconstruct(pc_param *param, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                         const pc_adjacency *adjacency, const pc_coupling *coupling, const double *phase) {
    pc_status status = PC_OK;
    if (pc_device_is_host(device)) {
#pragma omp parallel for schedule(static, GRAIN)
        for (size_t i = 0; i < 2 * (size_t)mesh->vertex_count; i++)
            param->coordinate[i] = pc_fixed_coordinate(atan2(phase[2 * i + 1], phase[2 * i]) / (2 * PC_PI));
        pc_reconstruct_shifts(param, mesh, adjacency, coupling);
    } else {
        PC_TRY(pc_pgp_launch_coordinates(param->coordinate, ctx, device, phase, mesh->vertex_count));
        PC_TRY(pc_pgp_launch_shifts(param, ctx, device, mesh, adjacency, coupling));
    }
    pc_reconstruct_flags(param, mesh);
done:
    return status;
}
