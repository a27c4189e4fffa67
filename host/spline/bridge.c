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
    uint8_t *is_stale; /* per face of the T-mesh: there is a loose vertex at a foot of it */
    pc_index *loose;
    pc_index loose_count;
    pc_index *list[2];
    pc_index *steps[2]; /* per vertex of the scan: from one foot and from the other; else PC_NONE */
    pc_index gaps;
} bridging;

static void loosen(bridging *b, pc_index v) {
    if (b->is_loose[v] || b->is_anchor[v] || b->target->adjacency->vertex_boundary[v]) return;
    b->is_loose[v] = 1;
    b->loose[b->loose_count++] = v;
}

/* Steps along edges from a triangle to all vertices, until `goal` is met or `far` steps are made; which were
 * met, in order, is in `list`. */
static size_t spread(bridging *b, pc_index *list, pc_index *steps, pc_index from, pc_index goal,
                     pc_index far) {
    enum { MOST = 20000 };
    const pc_mesh *mesh = b->target->mesh;
    size_t count = 0;
    for (size_t k = 0; k < 3; k++) {
        const pc_index v = mesh->triangle[3 * (size_t)from + k];
        steps[v] = 0, list[count++] = v;
    }
    for (size_t next = 0; next < count && count < MOST; next++) {
        const pc_index v = list[next];
        pc_index first = b->target->adjacency->vertex_half[v], h = first;
        if (steps[v] == far) break;
        do {
            const pc_index w = mesh->triangle[pc_next(h)];
            if (steps[w] == PC_NONE) steps[w] = steps[v] + 1, list[count++] = w;
            if (w == goal) far = steps[w];
            h = pc_turn_ccw(b->target->adjacency, h);
        } while (h != first && h != PC_NONE && count < MOST);
    }
    return count;
}

/* What lies on short ways over the scan from one foot to the other, however deep the groove; sheets that are
 * not connected near by stay as they are. */
static void loosen_between(bridging *b, const pc_foot *x, const pc_foot *y, double detour) {
    const pc_index goal = b->target->mesh->triangle[3 * (size_t)y->triangle];
    const size_t count = spread(b, b->list[0], b->steps[0], x->triangle, goal, PC_NONE);
    const pc_index length = b->steps[0][goal];
    b->gaps++;
    if (length != PC_NONE) {
        const pc_index longest = length + 2 + (pc_index)(detour * length);
        const size_t others = spread(b, b->list[1], b->steps[1], y->triangle, PC_NONE, longest);
        for (size_t i = 0; i < others; i++) {
            const pc_index v = b->list[1][i];
            if (b->steps[0][v] != PC_NONE && b->steps[0][v] + b->steps[1][v] <= longest) loosen(b, v);
            b->steps[1][v] = PC_NONE;
        }
    }
    for (size_t i = 0; i < count; i++)
        b->steps[0][b->list[0][i]] = PC_NONE;
}

/* Looks for gaps between feet of the same face, and loosens what lies in them; their number. */
static pc_index find_gaps(bridging *b, double detour) {
    const int n = b->feet->per_side;
    b->gaps = 0;
    for (pc_index f = 0; f < b->feet->face_count; f++) {
        const pc_foot *foot = b->feet->foot + (size_t)f * (size_t)(n * n);
        if (b->spline->mesh.face[f].ghost) continue;
        for (int i = 0; i < n * n; i++) {
            if ((i + 1) % n && pc_footpoints_gap(b->feet, b->spline, f, i, i + 1))
                loosen_between(b, foot + i, foot + i + 1, detour);
            if (i + n < n * n && pc_footpoints_gap(b->feet, b->spline, f, i, i + n))
                loosen_between(b, foot + i, foot + i + n, detour);
        }
    }
    return b->gaps;
}

/* What the loose vertices are means of: near neighbours on the scan weigh more. */
typedef struct membrane {
    size_t *start; /* per loose vertex, and the end */
    pc_index *around;
    double *weight, *share; /* per neighbour; per loose vertex, 1 / the sum of its weights */
} membrane;

static void free_membrane(membrane *m, pc_context *ctx) {
    pc_free(ctx, m->start);
    pc_free(ctx, m->around);
    pc_free(ctx, m->weight);
    pc_free(ctx, m->share);
}

static pc_status make_membrane(membrane *m, pc_context *ctx, const bridging *b) {
    pc_status status = PC_OK;
    const pc_mesh *mesh = b->target->mesh;
    const pc_adjacency *adjacency = b->target->adjacency;
    size_t count = 0;
    *m = (membrane){0};
    PC_TRY(pc_new(&m->start, ctx, (size_t)b->loose_count + 1));
    PC_TRY(pc_new(&m->share, ctx, b->loose_count));
    for (pc_index i = 0; i < b->loose_count; i++) {
        const pc_index first = adjacency->vertex_half[b->loose[i]];
        pc_index h = first;
        do {
            count++;
            h = pc_turn_ccw(adjacency, h);
        } while (h != first);
        m->start[i + 1] = count;
    }
    PC_TRY(pc_new(&m->around, ctx, count));
    PC_TRY(pc_new(&m->weight, ctx, count));
    for (pc_index i = 0; i < b->loose_count; i++) {
        const pc_vec3 x = pc_vec3_at(mesh->position, b->loose[i]);
        pc_index h = adjacency->vertex_half[b->loose[i]];
        double total = 0;
        for (size_t k = m->start[i]; k < m->start[i + 1]; k++, h = pc_turn_ccw(adjacency, h)) {
            m->around[k] = pc_head(mesh, h);
            m->weight[k] = 1 / fmax(pc_distance(x, pc_vec3_at(mesh->position, m->around[k])), 1e-300);
            total += m->weight[k];
        }
        m->share[i] = 1 / total;
    }
done:
    return status;
}

/* Loose vertices sink to the means of those around them, as a membrane through the others. */
static pc_status stretch_membrane(bridging *b, pc_context *ctx) {
    enum { SWEEPS = 200 };
    const double beyond = 1.6;
    pc_status status = PC_OK;
    membrane m;
    PC_TRY(make_membrane(&m, ctx, b));
    for (int sweep = 0; sweep < SWEEPS; sweep++)
        for (pc_index k = 0; k < b->loose_count; k++) {
            const pc_index i = sweep % 2 ? b->loose_count - 1 - k : k, v = b->loose[i];
            const pc_vec3 q = pc_vec3_at(b->flat->position, v);
            pc_vec3 sum = {0, 0, 0};
            for (size_t e = m.start[i]; e < m.start[i + 1]; e++)
                sum = pc_madd(sum, m.weight[e], pc_vec3_at(b->flat->position, m.around[e]));
            pc_vec3_put(b->flat->position, v, pc_madd(q, beyond, pc_sub(pc_scale(m.share[i], sum), q)));
        }
done:
    free_membrane(&m, ctx);
    return status;
}

static void find_stale(bridging *b) {
    const size_t n = (size_t)b->feet->per_side, each = n * n;
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < b->feet->face_count; f++) {
        b->is_stale[f] = 0;
        for (size_t i = 0; i < 3 * each && !b->spline->mesh.face[f].ghost; i++) {
            const pc_foot *foot = b->feet->foot + f * each + i / 3;
            b->is_stale[f] |= b->is_loose[b->target->mesh->triangle[3 * (size_t)foot->triangle + i % 3]];
        }
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
    PC_TRY(pc_new(&b.is_stale, ctx, spline->mesh.face_count));
    PC_TRY(pc_new(&b.loose, ctx, count));
    for (int k = 0; k < 2; k++) {
        PC_TRY(pc_new(&b.list[k], ctx, count + 3));
        PC_TRY(pc_new(&b.steps[k], ctx, count));
        memset(b.steps[k], 0xff, count * sizeof *b.steps[k]); /* PC_NONE */
    }
    PC_TRY(find_anchors(&b, ctx));
    for (int attempt = 0;; attempt++) {
        pc_footpoints_land(feet, spline, flat, target->adjacency, b.at, attempt ? b.is_stale : NULL);
        if (attempt == TRIES || !find_gaps(&b, 0.25 + 0.25 * attempt)) break;
        PC_TRY(stretch_membrane(&b, ctx));
        find_stale(&b);
    }
    pc_log(ctx, PC_LOG_DEBUG, "spline: %u vertices of the scan drawn flat", b.loose_count);
done:
    pc_free(ctx, b.at);
    pc_free(ctx, b.is_anchor);
    pc_free(ctx, b.is_loose);
    pc_free(ctx, b.is_stale);
    pc_free(ctx, b.loose);
    for (int k = 0; k < 2; k++) {
        pc_free(ctx, b.list[k]);
        pc_free(ctx, b.steps[k]);
    }
    if (status != PC_OK) pc_free(ctx, flat->position), flat->position = NULL;
    return status;
}
