/* What PGP knows of an edge before solving: quarter turn, advance of (s,t), weight (digest C20-C23). */
#ifndef PC_COUPLING_H
#define PC_COUPLING_H

#include "adjacency.h"
#include "device.h"
#include "field.h"
#include "system.h"

/* Per undirected edge, for its half-edge i -> j in pc_adjacency.edge_half. */
typedef struct pc_coupling {
    pc_index edge_count;
    uint8_t *turn;  /* r: K_j turned by r quarters agrees with K_i */
    float *advance; /* 2 per edge: s and t gained from i to j in i's frame, in periods */
    float
        *weight; /* (cot + cot)/2 of the angles opposite, kept within [0.05, 20] so that it stays a metric */
} pc_coupling;

/* Advances for cells of side `period_length`; `scale` (per vertex, positive) multiplies them, NULL: 1
 * everywhere. Computed by the kernel pgp_couple, or by its plain-C twin on the host device. The caller frees.
 */
pc_status pc_coupling_make(pc_coupling *coupling, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                           const pc_adjacency *adjacency, const pc_field *field, const double *scale,
                           double period_length);
void pc_coupling_free(pc_coupling *coupling, pc_context *ctx);

/* The same edge seen from j: turn, and the advance from j to i in j's frame. */
static inline int pc_turn_back(int turn) {
    return (4 - turn) & 3;
}
/* (s,t) -> S^turn (s,t), S(s,t) = (t,-s): what a quarter turn of K does to the coordinates (erratum 16). */
static inline void pc_turn_pair(double *s, double *t, int turn) {
    double u = *s, v = *t;
    *s = turn == 0 ? u : turn == 1 ? v : turn == 2 ? -u : -v;
    *t = turn == 0 ? v : turn == 1 ? -u : turn == 2 ? -v : u;
}

#endif
