#include "coarsen.h"
#include "memory.h"
#include "vec3.h"
#include <string.h>

enum { MOST_RING = 24, MOST_PASSES = 64 };
static const double LEAST_GAIN = 0.02;   /* of the vertices: a pass that removes fewer is the last */
static const double LEAST_COSINE = 0.5;  /* between a new face and the mean of those it replaces */
static const double LEAST_QUALITY = 0.1; /* of a new face; 1 is equilateral */

/* Who is left. A face that is gone has PC_NONE as its corners. */
typedef struct thinning {
    const pc_mesh *mesh;
    const double *longest;
    const uint8_t *border;
    pc_index *triangle, *twin;
    pc_index
        *out; /* per vertex: a half-edge that leaves it, at a border the one without a twin; PC_NONE: gone */
    pc_index *into;   /* per vertex: where it went, itself while it is there */
    uint8_t *settled; /* per vertex: could not go, and nothing around it has changed since */
} thinning;

static pc_index head_of(const thinning *t, pc_index h) {
    return t->triangle[pc_next(h)];
}

/* The neighbours of an inner vertex, counter-clockwise; 0 where they are too many. */
static int ring_of(pc_index half[MOST_RING], const thinning *t, pc_index v) {
    int count = 0;
    pc_index h = t->out[v];
    do {
        if (count == MOST_RING) return 0;
        half[count++] = h;
        h = t->twin[pc_prev(h)];
    } while (h != t->out[v]);
    return count;
}

/* ---- Which vertices, and where to ---- */

/* 1 for an equilateral triangle with that (doubled) area vector, and 0 without area. */
static double quality(pc_vec3 doubled, pc_vec3 a, pc_vec3 b, pc_vec3 c) {
    const double sides = pc_dot(pc_sub(b, a), pc_sub(b, a)) + pc_dot(pc_sub(c, b), pc_sub(c, b)) +
                         pc_dot(pc_sub(a, c), pc_sub(a, c));
    return sides > 0 ? 2 * sqrt(3) * pc_norm(doubled) / sides : 0;
}

/* The worst new face where v goes to its neighbour k of n, as quality times cosine; 0: not allowed. */
static double worth_of(const pc_vec3 *ring, const double *longest, int n, int k, pc_vec3 normal) {
    double worst = 1;
    const pc_vec3 u = ring[k];
    for (int i = 2; i < n; i++) {
        const int a = (k + i - 1) % n, b = (k + i) % n;
        const pc_vec3 doubled = pc_cross(pc_sub(ring[a], u), pc_sub(ring[b], u));
        const double size = pc_norm(doubled), shape = quality(doubled, u, ring[a], ring[b]);
        const double cosine = size > 0 ? pc_dot(doubled, normal) / size : 0;
        if (shape < LEAST_QUALITY || cosine < LEAST_COSINE) return 0;
        if (i + 1 < n && pc_distance(u, ring[b]) > fmin(longest[k], longest[b])) return 0;
        worst = fmin(worst, shape * cosine);
    }
    return worst;
}

/* The half-edge along which v had best be drawn; PC_NONE: none will do. */
static pc_index best_way(const thinning *t, pc_index v) {
    pc_index half[MOST_RING], best = PC_NONE;
    pc_vec3 ring[MOST_RING], normal = {0, 0, 0};
    double longest[MOST_RING], most = 0;
    const int n = ring_of(half, t, v);
    const pc_vec3 p = pc_vec3_at(t->mesh->position, v);
    for (int k = 0; k < n; k++) {
        const pc_index u = head_of(t, half[k]);
        ring[k] = pc_vec3_at(t->mesh->position, u), longest[k] = t->longest[u];
    }
    for (int k = 0; k < n; k++)
        normal = pc_add(normal, pc_cross(pc_sub(ring[k], p), pc_sub(ring[(k + 1) % n], p)));
    const double size = pc_norm(normal);
    if (!(size > 0)) return PC_NONE;
    normal = pc_scale(1 / size, normal);
    for (int k = 0; k < n; k++) {
        const double worth = worth_of(ring, longest, n, k, normal);
        if (worth > most) most = worth, best = half[k];
    }
    return best;
}

/* Inner vertices no two of which are neighbours, in order. */
static pc_index choose(pc_index *chosen, uint8_t *blocked, const thinning *t) {
    pc_index count = 0;
    memset(blocked, 0, t->mesh->vertex_count);
    for (pc_index v = 0; v < t->mesh->vertex_count; v++) {
        pc_index half[MOST_RING];
        if (t->out[v] == PC_NONE || t->border[v] || t->settled[v] || blocked[v]) continue;
        const int n = ring_of(half, t, v);
        for (int k = 0; k < n; k++)
            blocked[head_of(t, half[k])] = 1;
        if (n) chosen[count++] = v;
    }
    return count;
}

/* ---- Collapsing ---- */

static int degree(const thinning *t, pc_index v) {
    int count = 0;
    pc_index h = t->out[v];
    do {
        count++;
        h = t->twin[pc_prev(h)];
    } while (h != PC_NONE && h != t->out[v]);
    return count + (h == PC_NONE);
}

static bool is_neighbour(const thinning *t, pc_index u, pc_index x) {
    pc_index h = t->out[u];
    do {
        if (head_of(t, h) == x || t->triangle[pc_prev(h)] == x) return true;
        h = t->twin[pc_prev(h)];
    } while (h != PC_NONE && h != t->out[u]);
    return false;
}

/* The surface stays one: the two ends have no neighbours in common but those of the two faces that go, and
 * these keep enough of theirs. */
static bool is_allowed(const thinning *t, pc_index way) {
    pc_index half[MOST_RING];
    const pc_index v = t->triangle[way], u = head_of(t, way);
    const pc_index left = t->triangle[pc_prev(way)], right = t->triangle[pc_prev(t->twin[way])];
    const int n = ring_of(half, t, v);
    if (degree(t, left) <= 3 || degree(t, right) <= 3) return false;
    for (int k = 0; k < n; k++) {
        const pc_index x = head_of(t, half[k]);
        if (x != u && x != left && x != right && is_neighbour(t, u, x)) return false;
    }
    return n > 3;
}

/* Takes out the face of `h`, whose two other sides become one edge. */
static void close_face(thinning *t, pc_index h) {
    const pc_index face = h - h % 3, after = t->twin[pc_next(h)], before = t->twin[pc_prev(h)];
    if (after != PC_NONE) t->twin[after] = before;
    if (before != PC_NONE) t->twin[before] = after;
    for (pc_index k = face; k < face + 3; k++)
        t->triangle[k] = PC_NONE;
}

/* Draws the tail of `way` into its head. */
static void collapse(thinning *t, pc_index way) {
    pc_index half[MOST_RING];
    const pc_index back = t->twin[way], v = t->triangle[way], u = t->triangle[back];
    const pc_index left = t->triangle[pc_prev(way)], right = t->triangle[pc_prev(back)];
    const pc_index to_left = t->twin[pc_prev(way)]; /* v -> left, soon u -> left */
    const int n = ring_of(half, t, v);
    if (t->out[u] == pc_next(way) || t->out[u] == back) t->out[u] = to_left;
    if (t->out[left] == pc_prev(way)) t->out[left] = t->twin[pc_next(way)];
    if (t->out[right] == pc_prev(back)) t->out[right] = t->twin[pc_next(back)];
    for (int k = 0; k < n; k++) {
        t->settled[head_of(t, half[k])] = 0;
        t->triangle[half[k]] = u;
    }
    close_face(t, way);
    close_face(t, back);
    t->out[v] = PC_NONE, t->into[v] = u;
}

static pc_status thin_out(thinning *t, pc_context *ctx, pc_index left) {
    pc_status status = PC_OK;
    const pc_index n = t->mesh->vertex_count;
    pc_index *chosen = NULL, *way = NULL;
    uint8_t *blocked = NULL;
    PC_TRY(pc_new(&chosen, ctx, n));
    PC_TRY(pc_new(&way, ctx, n));
    PC_TRY(pc_new(&blocked, ctx, n));
    for (int pass = 0; pass < MOST_PASSES; pass++) {
        pc_index count = choose(chosen, blocked, t), gone = 0;
        PC_TRY(pc_check_interrupt(ctx));
#pragma omp parallel for schedule(dynamic, 256)
        for (pc_index i = 0; i < count; i++)
            way[i] = best_way(t, chosen[i]);
        for (pc_index i = 0; i < count; i++) {
            t->settled[chosen[i]] = 1;
            if (way[i] == PC_NONE || !is_allowed(t, way[i])) continue;
            collapse(t, way[i]);
            gone++;
        }
        left -= gone;
        if (gone < LEAST_GAIN * left) break;
    }
done:
    pc_free(ctx, chosen);
    pc_free(ctx, way);
    pc_free(ctx, blocked);
    return status;
}

/* ---- The mesh of what is left ---- */

static pc_status gather(pc_coarse *coarse, pc_context *ctx, const thinning *t) {
    pc_status status = PC_OK;
    const pc_mesh *mesh = t->mesh;
    pc_index vertices = 0, faces = 0;
    PC_TRY(pc_new(&coarse->into, ctx, mesh->vertex_count));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        vertices += t->out[v] != PC_NONE;
    for (pc_index f = 0; f < mesh->face_count; f++)
        faces += t->triangle[3 * (size_t)f] != PC_NONE;
    PC_TRY(pc_mesh_make(&coarse->mesh, ctx, vertices, faces));
    PC_TRY(pc_new(&coarse->source, ctx, vertices));
    vertices = faces = 0;
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        if (t->out[v] == PC_NONE) continue;
        pc_vec3_put(coarse->mesh.position, vertices, pc_vec3_at(mesh->position, v));
        coarse->into[v] = vertices;
        coarse->source[vertices++] = v;
    }
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        if (t->out[v] != PC_NONE) continue;
        pc_index end = v;
        while (t->into[end] != end)
            end = t->into[end] = t->into[t->into[end]];
        coarse->into[v] = end == v ? PC_NONE : coarse->into[end];
    }
    for (pc_index f = 0; f < mesh->face_count; f++) {
        const pc_index *corner = t->triangle + 3 * (size_t)f;
        if (*corner == PC_NONE) continue;
        for (size_t k = 0; k < 3; k++)
            coarse->mesh.triangle[3 * (size_t)faces + k] = coarse->into[corner[k]];
        faces++;
    }
done:
    return status;
}

pc_status pc_coarsen(pc_coarse *coarse, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency,
                     const double *longest) {
    pc_status status = PC_OK;
    const size_t halves = 3 * (size_t)mesh->face_count;
    const pc_index n = mesh->vertex_count;
    thinning t = {.mesh = mesh, .longest = longest, .border = adjacency->vertex_boundary};
    *coarse = (pc_coarse){0};
    PC_TRY(pc_new(&t.triangle, ctx, halves));
    PC_TRY(pc_new(&t.twin, ctx, halves));
    PC_TRY(pc_new(&t.out, ctx, n));
    PC_TRY(pc_new(&t.into, ctx, n));
    PC_TRY(pc_new(&t.settled, ctx, n));
    memcpy(t.triangle, mesh->triangle, halves * sizeof *t.triangle);
    memcpy(t.twin, adjacency->twin, halves * sizeof *t.twin);
    memcpy(t.out, adjacency->vertex_half, n * sizeof *t.out);
    for (pc_index v = 0; v < n; v++)
        t.into[v] = v;
    PC_TRY(thin_out(&t, ctx, n));
    PC_TRY(gather(coarse, ctx, &t));
done:
    pc_free(ctx, t.triangle);
    pc_free(ctx, t.twin);
    pc_free(ctx, t.out);
    pc_free(ctx, t.into);
    pc_free(ctx, t.settled);
    if (status != PC_OK) pc_coarse_free(coarse, ctx);
    return status;
}

void pc_coarse_free(pc_coarse *coarse, pc_context *ctx) {
    pc_mesh_free(&coarse->mesh, ctx);
    pc_free(ctx, coarse->source);
    pc_free(ctx, coarse->into);
    *coarse = (pc_coarse){0};
}
