#include "support.h"
#include "memory.h"
#include "ray.h"

/* A face in the frame of a vertex: its point p is at origin + R^turn p there, R a quarter turn. */
typedef struct pc_placement {
    pc_index face;
    int turn;
    double origin[2];
} pc_placement;

typedef struct walk {
    const pc_tmesh *mesh;
    pc_support *scratch;
    size_t first, count; /* placements of this quadrant are from `first` on */
    const double *s, *t;
    double low[2], high[2]; /* the quadrant to cover */
} walk;

static void rotate(double to[2], int turn, const double from[2]) {
    double x = from[0], y = from[1];
    to[0] = turn == 0 ? x : turn == 1 ? -y : turn == 2 ? -x : y;
    to[1] = turn == 0 ? y : turn == 1 ? x : turn == 2 ? -y : -x;
}

/* Places the face of half-edge h such that h leaves the point `at` in direction d (quarters). */
static pc_placement place(const pc_tmesh *mesh, pc_index h, int d, const double at[2]) {
    pc_placement p = {.face = mesh->half[h].face, .turn = (d - mesh->half[h].side) & 3};
    double local[2], turned[2];
    pc_thalf_place(local, mesh, h);
    rotate(turned, p.turn, local);
    p.origin[0] = at[0] - turned[0];
    p.origin[1] = at[1] - turned[1];
    return p;
}

static bool overlaps(const walk *w, const pc_placement *p) {
    double far[2];
    rotate(far, p->turn, w->mesh->face[p->face].size);
    for (int k = 0; k < 2; k++) {
        double a = p->origin[k], b = a + far[k], low = a < b ? a : b, high = a < b ? b : a;
        if (high <= w->low[k] || low >= w->high[k]) return false;
    }
    return true;
}

static bool is_listed(const walk *w, const pc_placement *p, size_t from, size_t to) {
    for (size_t i = from; i < to; i++) {
        const pc_placement *q = w->scratch->placement + i;
        if (q->face == p->face && q->turn == p->turn && q->origin[0] == p->origin[0] &&
            q->origin[1] == p->origin[1])
            return true;
    }
    return false;
}

static pc_status visit(walk *w, pc_context *ctx, pc_index h, int d, const double at[2]) {
    pc_status status = PC_OK;
    if (w->mesh->half[h].face == PC_NONE) return PC_OK;
    pc_placement p = place(w->mesh, h, d, at);
    if (!overlaps(w, &p)) return PC_OK;
    if (is_listed(w, &p, w->first, w->count)) return PC_OK;
    if (w->count == w->scratch->room) {
        PC_TRY(pc_resize(&w->scratch->placement, ctx, 2 * w->scratch->room + 64));
        w->scratch->room = 2 * w->scratch->room + 64;
    }
    w->scratch->placement[w->count++] = p;
done:
    return status;
}

/* Where the tail of h is in the frame of the vertex. */
static void locate(double at[2], const pc_tmesh *mesh, const pc_placement *p, pc_index h) {
    double local[2];
    pc_thalf_place(local, mesh, h);
    rotate(at, p->turn, local);
    at[0] += p->origin[0], at[1] += p->origin[1];
}

/* An extraordinary vertex inside of the quadrant, around which coordinates would depend on the way. */
static bool is_in_the_way(const walk *w, pc_index v, const double at[2]) {
    return w->mesh->vertex[v].extraordinary && at[0] > w->low[0] && at[0] < w->high[0] && at[1] > w->low[1] &&
           at[1] < w->high[1];
}

static pc_status visit_neighbours(walk *w, pc_context *ctx, size_t i) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = w->mesh;
    pc_placement p = w->scratch->placement[i];
    pc_index first = mesh->face[p.face].first, h = first;
    do {
        const pc_thalf *e = mesh->half + h;
        double tail[2], head[2];
        locate(tail, mesh, &p, h);
        locate(head, mesh, &p, e->next);
        if (!is_in_the_way(w, e->tail, tail) && !is_in_the_way(w, pc_thalf_head(mesh, h), head))
            PC_TRY(visit(w, ctx, e->twin, (e->side + p.turn + 2) & 3, head));
        h = e->next;
    } while (h != first);
done:
    return status;
}

/* The knots in the frame of the face. */
static pc_footprint print_of(const pc_placement *p, pc_index v, const double s[5], const double t[5]) {
    pc_footprint f = {.face = p->face, .vertex = v};
    for (int i = 0; i < 5; i++) {
        int j = 4 - i;
        const double *o = p->origin;
        f.s[i] = p->turn == 0   ? s[i] - o[0]
                 : p->turn == 1 ? t[i] - o[1]
                 : p->turn == 2 ? o[0] - s[j]
                                : o[1] - t[j];
        f.t[i] = p->turn == 0   ? t[i] - o[1]
                 : p->turn == 1 ? o[0] - s[j]
                 : p->turn == 2 ? o[1] - t[j]
                                : s[i] - o[0];
    }
    return f;
}

/* Covers the quadrant, and appends what no quadrant before it (they share frames) has appended. */
static pc_status finish(walk *w, pc_footprints *to, pc_context *ctx, pc_index v) {
    pc_status status = PC_OK;
    for (size_t i = w->first; i < w->count; i++)
        PC_TRY(visit_neighbours(w, ctx, i));
    for (size_t i = w->first; i < w->count; i++) {
        const pc_placement *p = w->scratch->placement + i;
        if (w->mesh->face[p->face].ghost || pc_tface_is_irregular(w->mesh, p->face)) continue;
        if (is_listed(w, p, 0, w->first)) continue;
        if (to->count == to->room) {
            PC_TRY(pc_resize(&to->at, ctx, 2 * to->room + 64));
            to->room = 2 * to->room + 64;
        }
        to->at[to->count++] = print_of(p, v, w->s, w->t);
    }
    w->first = w->count;
done:
    return status;
}

static pc_status append_regular(pc_footprints *to, pc_support *scratch, pc_context *ctx, const pc_tmesh *mesh,
                                pc_index v) {
    pc_status status = PC_OK;
    const double zero[2] = {0, 0};
    double s[5], t[5];
    pc_star star;
    pc_star_make(&star, mesh, v);
    pc_star_knots(s, t, mesh, &star);
    walk w = {.mesh = mesh, .scratch = scratch, .s = s, .t = t};
    for (int quadrant = 0; quadrant < 4; quadrant++) {
        bool left = quadrant == 1 || quadrant == 2, below = quadrant >= 2;
        w.low[0] = left ? s[0] : 0, w.high[0] = left ? 0 : s[4];
        w.low[1] = below ? t[0] : 0, w.high[1] = below ? 0 : t[4];
        for (int d = 0; d < 4; d++)
            if (star.ray[d].way == PC_RAY_ALONG) PC_TRY(visit(&w, ctx, star.ray[d].half, d, zero));
        PC_TRY(finish(&w, to, ctx, v));
    }
done:
    return status;
}

pc_status pc_support_append(pc_footprints *to, pc_support *scratch, pc_context *ctx, const pc_tmesh *mesh,
                            pc_index v) {
    pc_status status = PC_OK;
    const double zero[2] = {0, 0};
    pc_index first = mesh->vertex[v].out, h = first;
    if (!mesh->vertex[v].extraordinary) return append_regular(to, scratch, ctx, mesh, v);
    do { /* each corner is a quadrant in a frame of its own */
        double s[5], t[5];
        pc_sector_knots(s, t, mesh, h);
        walk w = {.mesh = mesh, .scratch = scratch, .s = s, .t = t, .high = {s[4], t[4]}};
        PC_TRY(visit(&w, ctx, h, 0, zero));
        PC_TRY(finish(&w, to, ctx, v));
        h = pc_thalf_ccw(mesh, h);
    } while (h != first);
done:
    return status;
}

void pc_support_free(pc_support *scratch, pc_context *ctx) {
    pc_free(ctx, scratch->placement);
    *scratch = (pc_support){0};
}

void pc_footprints_free(pc_footprints *footprints, pc_context *ctx) {
    pc_free(ctx, footprints->at);
    *footprints = (pc_footprints){0};
}
