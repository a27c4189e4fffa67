#include "strips.h"
#include "memory.h"
#include "polygraph.h"
#include "vec3.h"

enum { MOST_LOOKS = 40 };

typedef struct strip {
    pc_index passes;    /* of quads; a quad may be passed both ways */
    pc_index crossings; /* quads that are passed both ways */
    double width;       /* mean length of the edges it runs across */
    pc_index id;
    double miss; /* of the count with this strip changed */
} strip;

typedef struct stripping {
    const pc_polymesh *quads;
    const pc_ground *ground; /* may be NULL */
    pc_polygraph graph;
    pc_index *label; /* per half of a quad: 2f, passed across its edges 0 and 2, 2f+1 across 1 and 3 */
    pc_index count;
    strip *strip;
} stripping;

static double side_length(const pc_polymesh *q, pc_index f, pc_index k) {
    const pc_index *c = q->corner + 4 * (size_t)f;
    return pc_distance(pc_vec3_at(q->position, c[k]), pc_vec3_at(q->position, c[(k + 1) % 4]));
}

/* Floods from one half to those it meets across edges. */
static void flood(stripping *s, pc_index *stack, pc_index first) {
    strip *it = s->strip + s->count;
    pc_index top = 0;
    *it = (strip){.id = s->count};
    s->label[first] = s->count;
    stack[top++] = first;
    while (top) {
        pc_index half = stack[--top], f = half / 2;
        it->passes++;
        for (pc_index k = half & 1; k < 4; k += 2) {
            pc_index twin = s->graph.twin[4 * f + k];
            it->width += side_length(s->quads, f, k) / 2;
            if (twin == PC_NONE) continue;
            pc_index next = 2 * (twin / 4) + (twin & 1);
            if (s->label[next] != PC_NONE) continue;
            s->label[next] = s->count;
            stack[top++] = next;
        }
    }
    it->width /= it->passes;
    s->count++;
}

static pc_status find_strips(stripping *s, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index *stack = NULL, halves = 2 * s->quads->face_count;
    PC_TRY(pc_polygraph_of_polymesh(&s->graph, ctx, s->quads));
    PC_TRY(pc_new(&s->label, ctx, halves));
    PC_TRY(pc_new(&s->strip, ctx, halves));
    PC_TRY(pc_new(&stack, ctx, halves));
    for (pc_index h = 0; h < halves; h++)
        s->label[h] = PC_NONE;
    for (pc_index h = 0; h < halves; h++)
        if (s->label[h] == PC_NONE) flood(s, stack, h);
    for (pc_index f = 0; f < s->quads->face_count; f++)
        if (s->label[2 * f] == s->label[2 * f + 1]) s->strip[s->label[2 * f]].crossings++;
done:
    pc_free(ctx, stack);
    return status;
}

/* The best first: within the tolerance by their width, else by what they leave. `narrow`: the narrowest. */
typedef struct ranking {
    double tolerance;
    bool narrow;
} ranking;

static bool goes_before(const strip *a, const strip *b, const ranking *by) {
    bool fits = a->miss <= by->tolerance, other = b->miss <= by->tolerance;
    if (fits != other) return fits;
    if (!fits) return a->miss < b->miss || (a->miss == b->miss && a->id < b->id);
    double order = by->narrow ? a->width - b->width : b->width - a->width;
    return order < 0 || (order == 0 && a->id < b->id);
}

/* The strip of that rank among those that improve the count; NULL where there are not so many. */
static const strip *choose(stripping *s, double wanted, const ranking *by, int rank) {
    double now = s->quads->face_count, miss = fabs(now / wanted - 1);
    const strip *best = NULL, *before = NULL;
    for (pc_index i = 0; i < s->count; i++) {
        strip *it = s->strip + i;
        double after = by->narrow ? now - it->passes : now + it->passes + it->crossings;
        it->miss = fabs(after / wanted - 1);
        if (by->narrow && it->crossings) it->miss = INFINITY;
    }
    for (; rank >= 0; rank--, before = best) {
        best = NULL;
        for (pc_index i = 0; i < s->count; i++) {
            const strip *it = s->strip + i;
            if (it->miss >= miss || (before && !goes_before(before, it, by))) continue;
            if (!best || goes_before(it, best, by)) best = it;
        }
        if (!best) return NULL;
    }
    return best;
}

static bool is_crossed(const stripping *s, const strip *it, pc_index c) {
    return s->label[2 * (c / 4) + (c & 1)] == it->id;
}

/* Of half-edge c from a to b: on the scan's border where that is one. */
static pc_vec3 middle_of(const stripping *s, pc_index c, pc_vec3 a, pc_vec3 b) {
    pc_vec3 p = pc_scale(0.5, pc_add(a, b));
    if (!s->graph.boundary[c] || !s->ground) return p;
    pc_rim_place place = pc_ground_rim_closest(s->ground, p);
    return place.edge == PC_NONE ? p : pc_ground_rim_point(s->ground, place);
}

static void put_quad(pc_polymesh *out, pc_index *f, pc_index a, pc_index b, pc_index c, pc_index d) {
    pc_index *corner = out->corner + 4 * (size_t)*f;
    corner[0] = a, corner[1] = b, corner[2] = c, corner[3] = d;
    ++*f;
    out->start[*f] = 4 * *f;
}

static void fill_doubled(pc_polymesh *out, const stripping *s, const strip *it, const pc_index *middle,
                         pc_index centre) {
    const pc_polymesh *q = s->quads;
    pc_index at = 0;
    for (pc_index f = 0; f < q->face_count; f++) {
        const pc_index *v = q->corner + 4 * (size_t)f, *m = middle + 4 * (size_t)f;
        bool one = s->label[2 * f] == it->id, other = s->label[2 * f + 1] == it->id;
        if (one && other) {
            pc_vec3 p = {0, 0, 0};
            for (int k = 0; k < 4; k++)
                p = pc_madd(p, 0.25, pc_vec3_at(q->position, v[k]));
            pc_vec3_put(out->position, centre, p);
            put_quad(out, &at, v[0], m[0], centre, m[3]);
            put_quad(out, &at, m[0], v[1], m[1], centre);
            put_quad(out, &at, centre, m[1], v[2], m[2]);
            put_quad(out, &at, m[3], centre++, m[2], v[3]);
        } else if (one) {
            put_quad(out, &at, v[0], m[0], m[2], v[3]);
            put_quad(out, &at, m[0], v[1], v[2], m[2]);
        } else if (other) {
            put_quad(out, &at, v[0], v[1], m[1], m[3]);
            put_quad(out, &at, m[3], m[1], v[2], v[3]);
        } else {
            put_quad(out, &at, v[0], v[1], v[2], v[3]);
        }
    }
}

static pc_status double_strip(pc_polymesh *out, pc_context *ctx, const stripping *s, const strip *it) {
    pc_status status = PC_OK;
    const pc_polymesh *q = s->quads;
    pc_index *middle = NULL, vertices = q->vertex_count, corners = 4 * q->face_count;
    size_t faces = (size_t)q->face_count + it->passes + it->crossings;
    PC_TRY(pc_new(&middle, ctx, corners));
    for (pc_index c = 0; c < corners; c++) {
        pc_index twin = s->graph.twin[c];
        if (is_crossed(s, it, c)) middle[c] = twin != PC_NONE && twin < c ? middle[twin] : vertices++;
    }
    PC_TRY(pc_polymesh_make(out, ctx, (size_t)vertices + it->crossings, faces, 4 * faces));
    for (pc_index v = 0; v < q->vertex_count; v++)
        pc_vec3_put(out->position, v, pc_vec3_at(q->position, v));
    for (pc_index c = 0; c < corners; c++) {
        if (!is_crossed(s, it, c)) continue;
        pc_vec3 a = pc_vec3_at(q->position, q->corner[c]);
        pc_vec3 b = pc_vec3_at(q->position, q->corner[c - c % 4 + (c + 1) % 4]);
        pc_vec3_put(out->position, middle[c], middle_of(s, c, a, b));
    }
    fill_doubled(out, s, it, middle, vertices);
done:
    pc_free(ctx, middle);
    return status;
}

static bool same_surface(const pc_surface_count *a, const pc_surface_count *b) {
    return a->chi == b->chi && a->loops == b->loops && a->components == b->components &&
           a->overfull_edges + a->clashing_edges + a->broken_faces + a->split_vertices == 0;
}

/* Each edge across the strip becomes a vertex; false where two of them share one, or what is left is another
 * surface. */
static pc_status draw_together(pc_polymesh *out, bool *made, pc_context *ctx, const stripping *s,
                               const strip *it) {
    pc_status status = PC_OK;
    const pc_polymesh *q = s->quads;
    pc_index *into = NULL, corners = 4 * q->face_count;
    uint8_t *border = NULL, *removed = NULL;
    pc_polygraph after = {0};
    PC_TRY(pc_new(&into, ctx, q->vertex_count));
    PC_TRY(pc_new(&border, ctx, q->vertex_count));
    PC_TRY(pc_new(&removed, ctx, q->face_count));
    PC_TRY(pc_polymesh_make(out, ctx, q->vertex_count, q->face_count, corners));
    for (pc_index v = 0; v < q->vertex_count; v++) {
        into[v] = v;
        pc_vec3_put(out->position, v, pc_vec3_at(q->position, v));
    }
    for (pc_index c = 0; c < corners; c++)
        if (s->graph.boundary[c]) border[q->corner[c]] = border[q->corner[c - c % 4 + (c + 1) % 4]] = 1;
    for (pc_index c = 0; c < corners; c++) {
        pc_index twin = s->graph.twin[c], a = q->corner[c], b = q->corner[c - c % 4 + (c + 1) % 4];
        if (!is_crossed(s, it, c) || (twin != PC_NONE && twin < c)) continue;
        if ((border[a] | border[b]) & 2) goto done;
        pc_vec3 p = pc_vec3_at(q->position, a), d = pc_vec3_at(q->position, b);
        if (border[a] == border[b])
            p = middle_of(s, c, p, d);
        else if (border[b])
            p = d;
        pc_vec3_put(out->position, a, p);
        into[b] = a;
        border[a] |= 2, border[b] |= 2;
    }
    for (pc_index c = 0; c < corners; c++) {
        out->corner[c] = into[q->corner[c]];
        removed[c / 4] = removed[c / 4] || is_crossed(s, it, c);
    }
    for (pc_index f = 0; f < q->face_count; f++)
        out->start[f + 1] = 4 * (f + 1);
    PC_TRY(pc_polymesh_compact(out, ctx, removed));
    PC_TRY(pc_polygraph_of_polymesh(&after, ctx, out));
    *made = out->face_count > 0 && same_surface(&after.count, &s->graph.count);
done:
    if (!*made) pc_polymesh_free(out, ctx);
    pc_polygraph_free(&after, ctx);
    pc_free(ctx, into);
    pc_free(ctx, border);
    pc_free(ctx, removed);
    return status;
}

pc_status pc_strips_change(pc_polymesh *changed, bool *made, pc_context *ctx, const pc_polymesh *quads,
                           const pc_ground *ground, double wanted, double tolerance, int rank) {
    pc_status status = PC_OK;
    stripping s = {.quads = quads, .ground = ground};
    *changed = (pc_polymesh){0};
    *made = false;
    for (pc_index f = 0; f < quads->face_count; f++)
        if (quads->start[f + 1] - quads->start[f] != 4) return PC_OK;
    PC_TRY(find_strips(&s, ctx));
    const ranking by = {tolerance, quads->face_count > wanted};
    for (int next = 0; !*made && next < MOST_LOOKS; next++) {
        const strip *it = choose(&s, wanted, &by, next);
        if (!it) break;
        if (by.narrow) {
            PC_TRY(draw_together(changed, made, ctx, &s, it));
            if (!*made || rank-- == 0) continue;
        } else {
            if (rank-- > 0) continue;
            PC_TRY(double_strip(changed, ctx, &s, it));
            *made = true;
            continue;
        }
        pc_polymesh_free(changed, ctx);
        *made = false;
    }
done:
    pc_polygraph_free(&s.graph, ctx);
    pc_free(ctx, s.label);
    pc_free(ctx, s.strip);
    if (status != PC_OK) pc_polymesh_free(changed, ctx);
    return status;
}
