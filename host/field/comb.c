#include "comb.h"
#include "memory.h"
#include "vec3.h"

typedef struct combing {
    const pc_mesh *mesh;
    const pc_connection *connection;
    double *angle;
    uint8_t *reached;
    pc_index *queue;
    pc_index queued;
    int symmetry;
} combing;

/* Whole turns of 2 pi / N, below N, by which the head of h is ahead of its tail. */
static int turns_ahead(const combing *c, pc_index h) {
    double ahead =
        c->angle[pc_head(c->mesh, h)] - c->angle[pc_tail(c->mesh, h)] - c->connection->transport[h];
    return (int)fmod(nearbyint(c->symmetry * ahead / (2 * PC_PI)), c->symmetry);
}

static void reach(combing *c, pc_index v, int turns) {
    c->angle[v] -= turns * 2 * PC_PI / c->symmetry;
    c->reached[v] = 1;
    c->queue[c->queued++] = v;
}

static void reach_neighbours(combing *c, const pc_adjacency *adjacency, pc_index v) {
    pc_index first = adjacency->vertex_half[v];
    for (pc_index h = first; h != PC_NONE;) {
        pc_index back = pc_prev(h);
        if (!c->reached[pc_head(c->mesh, h)]) reach(c, pc_head(c->mesh, h), turns_ahead(c, h));
        /* The last edge of an open fan has no half-edge that leaves. */
        if (adjacency->twin[back] == PC_NONE && !c->reached[pc_tail(c->mesh, back)])
            reach(c, pc_tail(c->mesh, back), -turns_ahead(c, back));
        h = pc_turn_ccw(adjacency, h);
        if (h == first) break;
    }
}

pc_status pc_comb_angles(double *angle, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency,
                         const pc_connection *connection, int symmetry) {
    pc_status status = PC_OK;
    combing c = {.mesh = mesh, .connection = connection, .symmetry = symmetry};
    c.angle = angle;
    PC_TRY(pc_new(&c.reached, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&c.queue, ctx, mesh->vertex_count));
    pc_index next = 0;
    for (pc_index seed = 0; seed < mesh->vertex_count; seed++) {
        if (c.reached[seed]) continue;
        reach(&c, seed, 0);
        while (next < c.queued)
            reach_neighbours(&c, adjacency, c.queue[next++]);
    }
done:
    pc_free(ctx, c.reached);
    pc_free(ctx, c.queue);
    return status;
}
