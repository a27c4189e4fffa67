#include "singularity.h"
#include "memory.h"
#include "vec3.h"

typedef struct winding {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    const pc_connection *connection;
    const double *angle;
    double n;
} winding;

/* N times the turn of the field along h beyond parallel transport, unreduced; exactly antisymmetric. */
static double raw_turn(const winding *w, pc_index h) {
    pc_index low = w->adjacency->edge_half[w->adjacency->edge[h]];
    double x = w->n * (w->angle[pc_head(w->mesh, low)] - w->angle[pc_tail(w->mesh, low)] -
                       w->connection->transport[low]);
    return low == h ? x : -x;
}

static double near_turn(const winding *w, pc_index h) {
    double x = raw_turn(w, h);
    return x - 2 * PC_PI * nearbyint(x / (2 * PC_PI));
}

static int8_t face_index(const winding *w, pc_index face) {
    double sum = -w->n * PC_PI;
    for (pc_index h = 3 * face; h < 3 * face + 3; h++)
        sum += near_turn(w, h) + w->n * pc_connection_corner(w->connection, w->mesh, w->adjacency, h);
    return (int8_t)lround(sum / (2 * PC_PI));
}

static uint8_t turns(const winding *w, pc_index h) {
    int n = (int)w->n;
    double k = fmod(nearbyint(raw_turn(w, h) / (2 * PC_PI)), n);
    return (uint8_t)((n - (int)k) % n);
}

/* Boundary loops, each begun at its smallest half-edge; loop_index may be NULL to count only. */
static pc_index walk_loops(int32_t *loop_index, uint8_t *seen, const winding *w) {
    pc_index loops = 0, halves = 3 * w->mesh->face_count;
    for (pc_index v = 0; v < w->mesh->vertex_count; v++)
        seen[v] = 0;
    for (pc_index first = 0; first < halves; first++) {
        if (w->adjacency->twin[first] != PC_NONE || seen[pc_tail(w->mesh, first)]) continue;
        double sum = 0;
        pc_index h = first;
        do {
            pc_index v = pc_tail(w->mesh, h);
            seen[v] = 1;
            if (loop_index) sum += w->n * (PC_PI - w->connection->total[v]) - near_turn(w, h);
            h = w->adjacency->vertex_half[pc_head(w->mesh, h)];
        } while (h != first);
        if (loop_index) loop_index[loops] = (int32_t)lround(sum / (2 * PC_PI));
        loops++;
    }
    return loops;
}

pc_status pc_singularity_find(pc_field *field, pc_context *ctx, const pc_mesh *mesh,
                              const pc_adjacency *adjacency, const pc_connection *connection) {
    pc_status status = PC_OK;
    uint8_t *seen = NULL;
    winding w = {mesh, adjacency, connection, field->angle, field->symmetry};
    pc_free(ctx, field->turn);
    pc_free(ctx, field->index);
    pc_free(ctx, field->loop_index);
    field->turn = NULL, field->index = NULL, field->loop_index = NULL;
    PC_TRY(pc_new(&field->turn, ctx, 3 * (size_t)mesh->face_count));
    PC_TRY(pc_new(&field->index, ctx, mesh->face_count));
    PC_TRY(pc_new(&seen, ctx, mesh->vertex_count));
    field->loop_count = walk_loops(NULL, seen, &w);
    PC_TRY(pc_new(&field->loop_index, ctx, field->loop_count));
    (void)walk_loops(field->loop_index, seen, &w);
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < mesh->face_count; f++) {
        field->index[f] = face_index(&w, f);
        for (pc_index h = 3 * f; h < 3 * f + 3; h++)
            field->turn[h] = turns(&w, h);
    }
done:
    pc_free(ctx, seen);
    return status;
}

pc_index pc_singularity_count(const pc_field *field) {
    pc_index count = 0;
    for (pc_index f = 0; f < field->face_count; f++)
        count += field->index[f] != 0;
    return count;
}
