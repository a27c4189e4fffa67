#include "relax.h"
#include "memory.h"
#include <string.h>

enum { GRAIN = 1024 };

typedef struct relaxation {
    pc_polymesh *quads;
    const pc_ground *ground;
    double *normal;         /* 3 per quad vertex: the scan's there */
    pc_index *start, *near; /* per vertex: its neighbours along edges, twice each in the interior */
    pc_index *hint;         /* per vertex: the scan face it was last on */
    uint8_t *border;
    pc_index *along; /* 2 per vertex: its neighbours along the border, or along the straight side that a
                        T-junction is on; PC_NONE elsewhere */
    uint8_t *active;
    double *moved; /* 3 per vertex */
} relaxation;

static pc_status find_neighbours(relaxation *r, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_polymesh *q = r->quads;
    pc_index corners = q->start[q->face_count];
    PC_TRY(pc_new(&r->start, ctx, (size_t)q->vertex_count + 2));
    PC_TRY(pc_new(&r->near, ctx, 2 * (size_t)corners));
    for (pc_index c = 0; c < corners; c++)
        r->start[q->corner[c] + 2] += 2;
    for (pc_index v = 0; v < q->vertex_count; v++)
        r->start[v + 2] += r->start[v + 1];
    for (pc_index f = 0; f < q->face_count; f++)
        for (pc_index c = q->start[f], n = q->start[f + 1] - c, k = 0; k < n; k++) {
            pc_index v = q->corner[c + k];
            r->near[r->start[v + 1]++] = q->corner[c + (k + 1) % n];
            r->near[r->start[v + 1]++] = q->corner[c + (k + n - 1) % n];
        }
    /* In the interior each neighbour is there twice, once from either face; along a border once. */
    PC_TRY(pc_new(&r->border, ctx, q->vertex_count));
    PC_TRY(pc_new(&r->along, ctx, 2 * (size_t)q->vertex_count));
    memset(r->along, 0xff, 2 * sizeof(pc_index) * q->vertex_count);
    for (pc_index v = 0; v < q->vertex_count; v++)
        for (pc_index i = r->start[v]; i < r->start[v + 1]; i++) {
            pc_index same = 0;
            for (pc_index j = r->start[v]; j < r->start[v + 1]; j++)
                same += r->near[j] == r->near[i];
            if (same % 2 == 0) continue;
            if (r->border[v] < 2) r->along[2 * (size_t)v + r->border[v]] = r->near[i];
            r->border[v]++;
        }
    for (pc_index f = 0; q->corner_flat && f < q->face_count; f++)
        for (pc_index c = q->start[f], n = q->start[f + 1] - c, k = 0; k < n; k++) {
            size_t v = q->corner[c + k];
            if (!q->corner_flat[c + k] || r->border[v]) continue;
            r->along[2 * v] = q->corner[c + (k + n - 1) % n];
            r->along[2 * v + 1] = q->corner[c + (k + 1) % n];
        }
done:
    return status;
}

/* Brings vertex v from `p` onto the scan. Where surfaces lie close together the nearest point may be on
 * another one, with its back turned: then the vertex stays where it was. */
static void look_up(relaxation *r, pc_index v, pc_vec3 p) {
    pc_bvh_hit hit = pc_bvh_closest(&r->ground->tree, p, r->hint[v]);
    if (hit.face == PC_NONE) return;
    pc_vec3 normal = pc_ground_normal(r->ground, &hit);
    if (pc_dot(normal, pc_vec3_at(r->normal, v)) < 0) return;
    r->hint[v] = hit.face;
    pc_vec3_put(r->normal, v, pc_unit(normal));
    pc_vec3_put(r->quads->position, v, hit.point);
}

/* A corner is bad where the face turns too little, or the wrong way, about the scan's normal. */
static bool is_bad(const relaxation *r, pc_index f, double least_sine) {
    const pc_polymesh *q = r->quads;
    pc_index from = q->start[f], n = q->start[f + 1] - from;
    for (pc_index k = 0; k < n; k++) {
        if (q->corner_flat && q->corner_flat[from + k]) continue;
        pc_index v = q->corner[from + k];
        pc_vec3 p = pc_vec3_at(q->position, v);
        pc_vec3 a = pc_sub(pc_vec3_at(q->position, q->corner[from + (k + 1) % n]), p);
        pc_vec3 b = pc_sub(pc_vec3_at(q->position, q->corner[from + (k + n - 1) % n]), p);
        double lengths = pc_norm(a) * pc_norm(b);
        if (!(pc_dot(pc_cross(a, b), pc_vec3_at(r->normal, v)) > least_sine * lengths)) return true;
    }
    return false;
}

/* The face as a whole is upside down. */
static bool is_inverted(const relaxation *r, pc_index f) {
    const pc_polymesh *q = r->quads;
    pc_index from = q->start[f], n = q->start[f + 1] - from;
    pc_vec3 first = pc_vec3_at(q->position, q->corner[from]), area = {0, 0, 0}, normal = {0, 0, 0};
    for (pc_index k = 0; k < n; k++) {
        pc_vec3 a = pc_sub(pc_vec3_at(q->position, q->corner[from + k]), first);
        pc_vec3 b = pc_sub(pc_vec3_at(q->position, q->corner[from + (k + 1) % n]), first);
        area = pc_add(area, pc_cross(a, b));
        normal = pc_add(normal, pc_vec3_at(r->normal, q->corner[from + k]));
    }
    return pc_dot(area, normal) <= 0;
}

static pc_index activate(relaxation *r, double least_sine) {
    pc_index bad = 0;
    const pc_polymesh *q = r->quads;
    for (pc_index f = 0; f < q->face_count; f++) {
        if (!is_bad(r, f, least_sine)) continue;
        bad++;
        for (pc_index c = q->start[f]; c < q->start[f + 1]; c++)
            r->active[q->corner[c]] = 1;
    }
    return bad;
}

/* Where an active vertex wants to go: the mean of its neighbours, on a border or a straight side of the two
 * along it. */
static pc_vec3 wish(const relaxation *r, pc_index v, double fraction) {
    const double *position = r->quads->position;
    pc_vec3 p = pc_vec3_at(position, v), sum = {0, 0, 0};
    pc_index count = r->start[v + 1] - r->start[v];
    if (r->border[v] == 1 || r->border[v] > 2) return p;
    if (r->along[2 * (size_t)v] != PC_NONE) {
        pc_vec3 ends = pc_add(pc_vec3_at(position, r->along[2 * (size_t)v]),
                              pc_vec3_at(position, r->along[2 * (size_t)v + 1]));
        return pc_madd(p, fraction, pc_sub(pc_scale(0.5, ends), p));
    }
    for (pc_index i = r->start[v]; i < r->start[v + 1]; i++)
        sum = pc_add(sum, pc_vec3_at(position, r->near[i]));
    return count ? pc_madd(p, fraction, pc_sub(pc_scale(1.0 / count, sum), p)) : p;
}

/* On a border no vertex may come to lie on the next one. */
static bool keeps_apart(const relaxation *r, pc_index v, pc_vec3 p) {
    pc_vec3 a = pc_vec3_at(r->quads->position, r->along[2 * (size_t)v]);
    pc_vec3 b = pc_vec3_at(r->quads->position, r->along[2 * (size_t)v + 1]);
    double least = 0.2 * pc_distance(a, b);
    return pc_distance(p, a) > least && pc_distance(p, b) > least;
}

/* All active vertices step at once, so that their order does not show. Borders move only where `slide` allows
 * it. */
static void step(relaxation *r, double fraction, bool slide) {
    pc_polymesh *q = r->quads;
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index v = 0; v < q->vertex_count; v++)
        if (r->active[v]) pc_vec3_put(r->moved, v, wish(r, v, fraction));
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index v = 0; v < q->vertex_count; v++) {
        if (!r->active[v] || r->border[v]) continue;
        look_up(r, v, pc_vec3_at(r->moved, v));
    }
    /* One after the other: each looks at where its neighbours are by now. */
    for (pc_index v = 0; slide && v < q->vertex_count; v++) {
        if (!r->active[v] || r->border[v] != 2) continue;
        pc_bvh_hit hit = pc_bvh_closest(&r->ground->rim_tree, pc_vec3_at(r->moved, v), PC_NONE);
        if (hit.face == PC_NONE || !keeps_apart(r, v, hit.point)) continue;
        look_up(r, v, hit.point);
    }
}

/* Where the scan touches itself two vertices may stand on one spot and stay there. Off the scan, to the mean
 * of its neighbours, is then the lesser evil for one that is free. */
static void part_coincident(relaxation *r) {
    pc_polymesh *q = r->quads;
    for (pc_index f = 0; f < q->face_count; f++) {
        pc_index from = q->start[f], n = q->start[f + 1] - from;
        for (pc_index k = 0; k < n; k++) {
            pc_index v = q->corner[from + k], w = q->corner[from + (k + 2) % n];
            if (r->border[v] || pc_distance(pc_vec3_at(q->position, v), pc_vec3_at(q->position, w)) > 0)
                continue;
            pc_vec3_put(q->position, v, wish(r, v, 1));
        }
    }
}

static void widen(relaxation *r) {
    const pc_polymesh *q = r->quads;
    for (pc_index f = 0; f < q->face_count; f++)
        for (pc_index c = q->start[f]; c < q->start[f + 1]; c++)
            if (r->active[q->corner[c]] == 1) {
                for (pc_index d = q->start[f]; d < q->start[f + 1]; d++)
                    if (!r->active[q->corner[d]]) r->active[q->corner[d]] = 2;
                break;
            }
    for (pc_index v = 0; v < q->vertex_count; v++)
        r->active[v] = r->active[v] != 0;
}

pc_status pc_relax(pc_polymesh *quads, pc_relax_stats *stats, uint8_t *folded, pc_context *ctx,
                   const pc_ground *ground, const pc_relax_options *options) {
    pc_status status = PC_OK;
    relaxation r = {.quads = quads, .ground = ground};
    *stats = (pc_relax_stats){0};
    PC_TRY(pc_new(&r.normal, ctx, 3 * (size_t)quads->vertex_count));
    PC_TRY(pc_new(&r.moved, ctx, 3 * (size_t)quads->vertex_count));
    PC_TRY(pc_new(&r.hint, ctx, quads->vertex_count));
    PC_TRY(pc_new(&r.active, ctx, quads->vertex_count));
    memset(r.hint, 0xff, sizeof(pc_index) * quads->vertex_count);
    PC_TRY(find_neighbours(&r, ctx));
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index v = 0; v < quads->vertex_count; v++)
        look_up(&r, v, pc_vec3_at(quads->position, v));
    stats->bad_before = stats->bad_after = activate(&r, options->least_sine);
    memset(r.active, 1, quads->vertex_count);
    for (int i = 0; i < options->smooth_rounds; i++)
        step(&r, 0.5, false);
    for (int i = 0; i < options->rounds; i++) {
        memset(r.active, 0, quads->vertex_count);
        stats->bad_after = activate(&r, options->least_sine);
        if (stats->bad_after == 0) break;
        for (int ring = 0; ring < i / 6; ring++)
            widen(&r);
        step(&r, 0.7, i >= options->rounds / 4);
        PC_TRY(pc_check_interrupt(ctx));
    }
    part_coincident(&r);
    memset(r.active, 0, quads->vertex_count);
    stats->bad_after = activate(&r, options->least_sine);
    for (pc_index f = 0; folded && f < quads->face_count; f++)
        folded[f] = is_inverted(&r, f);
done:
    pc_free(ctx, r.normal);
    pc_free(ctx, r.start);
    pc_free(ctx, r.near);
    pc_free(ctx, r.hint);
    pc_free(ctx, r.border);
    pc_free(ctx, r.along);
    pc_free(ctx, r.active);
    pc_free(ctx, r.moved);
    return status;
}
