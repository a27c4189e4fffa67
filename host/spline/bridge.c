#include "bridge.h"
#include "memory.h"
#include <string.h>

typedef struct bridging {
    pc_mesh *flat;
    pc_footpoints *feet;
    const pc_tspline *spline;
    const pc_target *target;
    pc_index *at;       /* per vertex of the T-mesh: the triangle of the scan it is on */
    uint8_t *is_anchor; /* per vertex of the scan: on such a triangle */
    uint8_t *is_loose;
    pc_index *loose;
    pc_index loose_count;
    pc_index *stack;
    pc_index *seen; /* per vertex of the scan: the last gap that reached it */
    pc_index gaps;
} bridging;

static void loosen(bridging *b, pc_index v) {
    if (b->is_loose[v] || b->is_anchor[v] || b->target->adjacency->vertex_boundary[v]) return;
    b->is_loose[v] = 1;
    b->loose[b->loose_count++] = v;
}

static void reach(bridging *b, size_t *count, pc_index v, pc_vec3 middle, double radius) {
    if (b->seen[v] == b->gaps || pc_distance(pc_vec3_at(b->target->mesh->position, v), middle) > radius)
        return;
    b->seen[v] = b->gaps;
    b->stack[(*count)++] = v;
    loosen(b, v);
}

/* What can be reached from either foot without leaving a ball around both, on the scan as it is. */
static void loosen_between(bridging *b, const pc_foot *x, const pc_foot *y, double stretch) {
    const pc_mesh *mesh = b->target->mesh;
    const pc_vec3 p = pc_footpoints_point(mesh, x), q = pc_footpoints_point(mesh, y);
    const pc_vec3 middle = pc_scale(0.5, pc_add(p, q));
    const double radius = stretch * pc_distance(p, q);
    size_t count = 0;
    b->gaps++;
    for (size_t k = 0; k < 3; k++) {
        reach(b, &count, mesh->triangle[3 * (size_t)x->triangle + k], middle, radius);
        reach(b, &count, mesh->triangle[3 * (size_t)y->triangle + k], middle, radius);
    }
    while (count > 0) {
        pc_index first = b->target->adjacency->vertex_half[b->stack[--count]], h = first;
        do {
            reach(b, &count, mesh->triangle[pc_next(h)], middle, radius);
            h = pc_turn_ccw(b->target->adjacency, h);
        } while (h != first && h != PC_NONE);
    }
}

/* Looks for gaps between feet of the same face, and loosens what lies in them; their number. */
static pc_index find_gaps(bridging *b, double stretch) {
    const int n = b->feet->per_side;
    b->gaps = 0;
    memset(b->seen, 0, b->target->mesh->vertex_count * sizeof *b->seen);
    for (pc_index f = 0; f < b->feet->face_count; f++) {
        const pc_foot *foot = b->feet->foot + (size_t)f * (size_t)(n * n);
        if (b->spline->mesh.face[f].ghost) continue;
        for (int i = 0; i < n * n; i++) {
            if ((i + 1) % n && pc_footpoints_gap(b->feet, b->spline, f, i, i + 1))
                loosen_between(b, foot + i, foot + i + 1, stretch);
            if (i + n < n * n && pc_footpoints_gap(b->feet, b->spline, f, i, i + n))
                loosen_between(b, foot + i, foot + i + n, stretch);
        }
    }
    return b->gaps;
}

/* The mean of the points around v, near neighbours on the scan weighing more. */
static pc_vec3 mean_around(const bridging *b, pc_index v) {
    const pc_mesh *mesh = b->target->mesh;
    pc_vec3 sum = {0, 0, 0}, x = pc_vec3_at(mesh->position, v);
    double total = 0;
    pc_index first = b->target->adjacency->vertex_half[v], h = first;
    do {
        const pc_index w = mesh->triangle[pc_next(h)];
        const double weight = 1 / fmax(pc_distance(x, pc_vec3_at(mesh->position, w)), 1e-300);
        sum = pc_madd(sum, weight, pc_vec3_at(b->flat->position, w));
        total += weight;
        h = pc_turn_ccw(b->target->adjacency, h);
    } while (h != first && h != PC_NONE);
    return pc_scale(1 / total, sum);
}

/* Loose vertices sink to the means of those around them, as a membrane through the others. */
static void stretch_membrane(bridging *b) {
    enum { SWEEPS = 200 };
    const double beyond = 1.6;
    for (int sweep = 0; sweep < SWEEPS; sweep++)
        for (pc_index i = 0; i < b->loose_count; i++) {
            const pc_index v = b->loose[sweep % 2 ? b->loose_count - 1 - i : i];
            const pc_vec3 q = pc_vec3_at(b->flat->position, v);
            pc_vec3_put(b->flat->position, v, pc_madd(q, beyond, pc_sub(mean_around(b, v), q)));
        }
}

static pc_status find_anchors(bridging *b, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &b->spline->mesh;
    pc_bvh_hit *hit = NULL;
    PC_TRY(pc_new(&hit, ctx, mesh->vertex_count));
    pc_bvh_closest_all(hit, &b->target->tree, b->spline->position, mesh->vertex_count);
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        b->at[v] = hit[v].face;
        for (size_t k = 0; k < 3; k++)
            b->is_anchor[b->target->mesh->triangle[3 * (size_t)hit[v].face + k]] = 1;
    }
done:
    pc_free(ctx, hit);
    return status;
}

pc_status pc_bridge_make(pc_mesh *flat, pc_footpoints *feet, pc_context *ctx, const pc_tspline *spline,
                         const pc_target *target) {
    enum { TRIES = 5 };
    pc_status status = PC_OK;
    const size_t count = target->mesh->vertex_count;
    bridging b = {.flat = flat, .feet = feet, .spline = spline, .target = target};
    *flat = *target->mesh;
    flat->position = NULL;
    PC_TRY(pc_new(&flat->position, ctx, 3 * count));
    memcpy(flat->position, target->mesh->position, 3 * count * sizeof *flat->position);
    PC_TRY(pc_new(&b.at, ctx, spline->mesh.vertex_count));
    PC_TRY(pc_new(&b.is_anchor, ctx, count));
    PC_TRY(pc_new(&b.is_loose, ctx, count));
    PC_TRY(pc_new(&b.loose, ctx, count));
    PC_TRY(pc_new(&b.stack, ctx, count));
    PC_TRY(pc_new(&b.seen, ctx, count));
    PC_TRY(find_anchors(&b, ctx));
    for (int attempt = 0;; attempt++) {
        pc_footpoints_land(feet, spline, flat, target->adjacency, b.at);
        if (attempt == TRIES || !find_gaps(&b, 0.75 + 0.25 * attempt)) break;
        stretch_membrane(&b);
    }
    pc_log(ctx, PC_LOG_DEBUG, "spline: %u vertices of the scan drawn flat", b.loose_count);
done:
    pc_free(ctx, b.at);
    pc_free(ctx, b.is_anchor);
    pc_free(ctx, b.is_loose);
    pc_free(ctx, b.loose);
    pc_free(ctx, b.stack);
    pc_free(ctx, b.seen);
    if (status != PC_OK) pc_free(ctx, flat->position), flat->position = NULL;
    return status;
}
