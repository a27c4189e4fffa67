#include "borders.h"
#include "vec3.h"
#include <stdbool.h>

enum { WINDOW = 4 }; /* boundary edges looked at on each side */

static pc_index next_border(const pc_mesh *mesh, const pc_adjacency *a, pc_index h) {
    return a->vertex_half[pc_head(mesh, h)];
}

static double wrap(double x) {
    return remainder(x, 2 * PC_PI);
}

/* How the boundary turns, within the surface, at the head of boundary half-edge h: 0 where straight. */
static double turn_at_head(const pc_mesh *mesh, const pc_connection *c, pc_index h) {
    return PC_PI - c->total[pc_head(mesh, h)];
}

/* The boundary half-edge that ends where h begins: the last spoke of the fan, seen from outside. */
static pc_index previous_border(const pc_mesh *mesh, const pc_adjacency *a, pc_index h) {
    pc_index last = a->vertex_half[pc_tail(mesh, h)];
    for (pc_index turned = pc_turn_ccw(a, last); turned != PC_NONE; turned = pc_turn_ccw(a, last))
        last = turned;
    return pc_prev(last);
}

/* 1 where the boundary around the tail of h is straight, 0 where its turns reach 20 degrees each on average:
 * the signs of the turns do not matter, a ragged edge zigzags. */
static double smoothness_around(const pc_mesh *mesh, const pc_adjacency *a, const pc_connection *c,
                                pc_index h) {
    double sum = 0, most = PC_PI / 9;
    for (int k = 0; k < WINDOW + 1; k++)
        h = previous_border(mesh, a, h);
    for (int k = 0; k < 2 * WINDOW + 1; k++) {
        sum += fabs(turn_at_head(mesh, c, h));
        h = next_border(mesh, a, h);
    }
    double mean = sum / (2 * WINDOW + 1);
    return mean < most ? 1 - mean / most : 0;
}

void pc_borders_find(double *weight, double *angle, const pc_mesh *mesh, const pc_adjacency *adjacency,
                     const pc_connection *connection, pc_border_rule rule) {
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        weight[v] = angle[v] = 0;
    if (rule == PC_BORDERS_OFF) return;
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_index out = adjacency->vertex_half[v];
        if (out == PC_NONE || adjacency->twin[out] != PC_NONE) continue;
        /* The mean of going out and of coming in: half the interior angle off a right angle. */
        double inner = connection->total[v];
        bool corner = fabs(PC_PI - inner) > PC_PI / 4;
        angle[v] = wrap(connection->angle[out] + (corner ? 0 : 0.5 * (inner - PC_PI)));
        weight[v] = rule == PC_BORDERS_ALL ? 1 : smoothness_around(mesh, adjacency, connection, out);
    }
}
