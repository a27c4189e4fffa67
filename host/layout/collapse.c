#include "collapse.h"
#include "memory.h"
#include "vec3.h"
#include <stdlib.h>

enum { MOST_NEIGHBOURS = 64 };

typedef struct collapsing {
    pc_polymesh *quads;
    pc_index *start, *face; /* per vertex: its faces */
    uint8_t *locked;        /* per vertex */
    uint8_t *removed;       /* per face */
} collapsing;

typedef struct ring {
    pc_index vertex[MOST_NEIGHBOURS];
    uint8_t times[MOST_NEIGHBOURS]; /* 2 in the interior: once from either face */
    int count;
    bool border, overflow;
} ring;

static pc_status list_faces(collapsing *c, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_polymesh *q = c->quads;
    PC_TRY(pc_new(&c->start, ctx, (size_t)q->vertex_count + 2));
    PC_TRY(pc_new(&c->face, ctx, q->start[q->face_count]));
    for (pc_index i = 0; i < q->start[q->face_count]; i++)
        c->start[q->corner[i] + 2]++;
    for (pc_index v = 0; v < q->vertex_count; v++)
        c->start[v + 2] += c->start[v + 1];
    for (pc_index f = 0; f < q->face_count; f++)
        for (pc_index i = q->start[f]; i < q->start[f + 1]; i++)
            c->face[c->start[q->corner[i] + 1]++] = f;
done:
    return status;
}

static void add_neighbour(ring *r, pc_index v) {
    for (int i = 0; i < r->count; i++)
        if (r->vertex[i] == v) {
            r->times[i]++;
            return;
        }
    if (r->count == MOST_NEIGHBOURS) {
        r->overflow = true;
        return;
    }
    r->vertex[r->count] = v;
    r->times[r->count++] = 1;
}

static void gather(ring *r, const collapsing *c, pc_index v) {
    const pc_polymesh *q = c->quads;
    r->count = 0, r->border = r->overflow = false;
    for (pc_index i = c->start[v]; i < c->start[v + 1]; i++) {
        pc_index f = c->face[i], from = q->start[f], n = q->start[f + 1] - from;
        for (pc_index k = 0; k < n; k++) {
            if (q->corner[from + k] != v) continue;
            add_neighbour(r, q->corner[from + (k + 1) % n]);
            add_neighbour(r, q->corner[from + (k + n - 1) % n]);
        }
    }
    for (int i = 0; i < r->count; i++)
        if (r->times[i] != 2) r->border = true;
}

/* How far a vertex of so many neighbours is from a regular one. */
static int oddness(int neighbours, bool border) {
    return abs(neighbours - (border ? 3 : 4));
}

/* How far the valences would be from regular after drawing a and d together; -1 where the mesh would not be
 * manifold: they have a common neighbour beside b and e, are both on a border, or leave b or e with too few
 * faces. Where one of two merged edges is on a border the other comes to lie there. */
static int price(const collapsing *c, pc_index a, pc_index b, pc_index d, pc_index e) {
    ring ra, rb, rd, re;
    gather(&ra, c, a), gather(&rb, c, b), gather(&rd, c, d), gather(&re, c, e);
    if (ra.overflow || rd.overflow || rb.overflow || re.overflow || (ra.border && rd.border)) return -1;
    for (int i = 0; i < ra.count; i++)
        for (int j = 0; j < rd.count; j++)
            if (ra.vertex[i] == rd.vertex[j] && ra.vertex[i] != b && ra.vertex[i] != e) return -1;
    for (int i = 0; i < ra.count; i++)
        if (ra.vertex[i] == d) return -1;
    if (rb.count < 3 || re.count < 3) return -1;
    return oddness(ra.count + rd.count - 2, ra.border || rd.border) + oddness(rb.count - 1, rb.border) +
           oddness(re.count - 1, re.border);
}

static bool is_free(const collapsing *c, pc_index v) {
    const pc_polymesh *q = c->quads;
    for (pc_index i = c->start[v]; i < c->start[v + 1]; i++)
        for (pc_index k = q->start[c->face[i]]; k < q->start[c->face[i] + 1]; k++)
            if (c->locked[q->corner[k]]) return false;
    return true;
}

static void lock(collapsing *c, pc_index v) {
    const pc_polymesh *q = c->quads;
    for (pc_index i = c->start[v]; i < c->start[v + 1]; i++)
        for (pc_index k = q->start[c->face[i]]; k < q->start[c->face[i] + 1]; k++)
            c->locked[q->corner[k]] = 1;
}

static bool collapse_face(collapsing *c, pc_index f) {
    pc_polymesh *q = c->quads;
    const pc_index *v = q->corner + q->start[f];
    if (q->start[f + 1] - q->start[f] != 4) return false;
    for (int k = 0; k < 4; k++)
        if (!is_free(c, v[k])) return false;
    int one = price(c, v[0], v[1], v[2], v[3]), other = price(c, v[1], v[2], v[3], v[0]);
    if (one < 0 && other < 0) return false;
    int k = one < 0 || (other >= 0 && other < one);
    pc_index keep = v[k], drop = v[k + 2];
    ring r;
    for (int i = 0; i < 4; i++)
        lock(c, v[i]);
    gather(&r, c, drop);
    bool at_drop = r.border;
    gather(&r, c, keep);
    if (at_drop || !r.border) {
        pc_vec3 p = pc_vec3_at(q->position, keep), d = pc_vec3_at(q->position, drop);
        pc_vec3_put(q->position, keep, at_drop ? d : pc_scale(0.5, pc_add(p, d)));
    }
    for (pc_index i = c->start[drop]; i < c->start[drop + 1]; i++)
        for (pc_index j = q->start[c->face[i]]; j < q->start[c->face[i] + 1]; j++)
            if (q->corner[j] == drop) q->corner[j] = keep;
    c->removed[f] = 1;
    return true;
}

pc_status pc_quads_collapse(pc_polymesh *quads, pc_index *collapsed, pc_context *ctx, const uint8_t *wanted) {
    pc_status status = PC_OK;
    collapsing c = {.quads = quads};
    *collapsed = 0;
    PC_TRY(list_faces(&c, ctx));
    PC_TRY(pc_new(&c.locked, ctx, quads->vertex_count));
    PC_TRY(pc_new(&c.removed, ctx, quads->face_count));
    for (pc_index f = 0; f < quads->face_count; f++)
        if (wanted[f] && collapse_face(&c, f)) ++*collapsed;
    if (*collapsed) PC_TRY(pc_polymesh_compact(quads, ctx, c.removed));
done:
    pc_free(ctx, c.start);
    pc_free(ctx, c.face);
    pc_free(ctx, c.locked);
    pc_free(ctx, c.removed);
    return status;
}
