#include "curvature.h"
#include "memory.h"
#include "ring.h"
#include "vec3.h"
#include <stdbool.h>
#include <string.h>

/* What a vertex carries through the averaging: 6 of the tensor, area, sum of |beta||e|, 3 of area times
 * normal. */
enum { AREA = 6, ROUGH = 7, NORMAL = 8, LUMP = 12 };

typedef struct averaging {
    pc_context *ctx;
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    pc_ring ring;
    double *bend; /* per edge: beta |e|, 0 on a boundary */
    double *lump;
    double *other;
    double step; /* edges longer than this are walked less often */
    int passes;
} averaging;

static pc_vec3 face_normal(const pc_mesh *mesh, pc_index face) {
    const pc_index *t = mesh->triangle + 3 * (size_t)face;
    pc_vec3 a = pc_vec3_at(mesh->position, t[0]);
    pc_vec3 b = pc_vec3_at(mesh->position, t[1]), c = pc_vec3_at(mesh->position, t[2]);
    return pc_cross(pc_sub(b, a), pc_sub(c, a));
}

static double edge_bend(const pc_mesh *mesh, pc_index h, pc_index twin) {
    if (twin == PC_NONE) return 0;
    pc_vec3 e =
        pc_sub(pc_vec3_at(mesh->position, pc_head(mesh, h)), pc_vec3_at(mesh->position, pc_tail(mesh, h)));
    pc_vec3 n = pc_unit(face_normal(mesh, h / 3)), m = pc_unit(face_normal(mesh, twin / 3));
    double length = pc_norm(e);
    if (!(length > 0)) return 0;
    return atan2(pc_dot(pc_cross(n, m), e) / length, pc_dot(n, m)) * length;
}

static double mean_edge(const pc_mesh *mesh, const pc_adjacency *a) {
    double sum = 0;
    for (pc_index e = 0; e < a->edge_count; e++) {
        pc_index h = a->edge_half[e];
        sum += pc_distance(pc_vec3_at(mesh->position, pc_head(mesh, h)),
                           pc_vec3_at(mesh->position, pc_tail(mesh, h)));
    }
    return a->edge_count ? sum / a->edge_count : 0;
}

static void add_edge(double *lump, pc_vec3 e, double bend) {
    pc_vec3 u = pc_unit(e);
    double half = 0.5 * bend;
    lump[0] += half * u.x * u.x;
    lump[1] += half * u.x * u.y;
    lump[2] += half * u.x * u.z;
    lump[3] += half * u.y * u.y;
    lump[4] += half * u.y * u.z;
    lump[5] += half * u.z * u.z;
    lump[ROUGH] += fabs(half);
}

static void add_face(double *lump, pc_vec3 n) {
    lump[AREA] += pc_norm(n) / 6;
    lump[NORMAL] += n.x / 6;
    lump[NORMAL + 1] += n.y / 6;
    lump[NORMAL + 2] += n.z / 6;
}

/* Half of each edge's term and a third of each triangle's area go to a vertex. */
static void gather_vertex(double *lump, const averaging *av, pc_index v) {
    const pc_mesh *mesh = av->mesh;
    const pc_ring *ring = &av->ring;
    pc_vec3 p = pc_vec3_at(mesh->position, v);
    memset(lump, 0, LUMP * sizeof(double));
    for (pc_index k = ring->start[v]; k < ring->start[v + 1]; k++) {
        pc_index h = ring->half[k];
        add_edge(lump, pc_sub(pc_vec3_at(mesh->position, ring->vertex[k]), p),
                 av->bend[av->adjacency->edge[h]]);
        if (pc_tail(mesh, h) == v) add_face(lump, face_normal(mesh, h / 3));
    }
}

static void average_vertex(double *out, const averaging *av, const double *in, pc_index v) {
    const pc_ring *ring = &av->ring;
    const double *position = av->mesh->position;
    pc_vec3 p = pc_vec3_at(position, v);
    double sum[LUMP], total = 1, step2 = av->step * av->step;
    memcpy(sum, in + LUMP * (size_t)v, sizeof sum);
    for (pc_index k = ring->start[v]; k < ring->start[v + 1]; k++) {
        pc_vec3 e = pc_sub(pc_vec3_at(position, ring->vertex[k]), p);
        double d2 = pc_dot(e, e), w = d2 > step2 ? step2 / d2 : 1;
        const double *x = in + LUMP * (size_t)ring->vertex[k];
        for (int c = 0; c < LUMP; c++)
            sum[c] += w * x[c];
        total += w;
    }
    for (int c = 0; c < LUMP; c++)
        out[c] = sum[c] / total;
}

static pc_status average_on_host(averaging *av) {
    pc_index n = av->mesh->vertex_count;
#pragma omp parallel for schedule(static)
    for (pc_index e = 0; e < av->adjacency->edge_count; e++) {
        pc_index h = av->adjacency->edge_half[e];
        av->bend[e] = edge_bend(av->mesh, h, av->adjacency->twin[h]);
    }
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < n; v++)
        gather_vertex(av->lump + LUMP * (size_t)v, av, v);
    for (int pass = 0; pass < av->passes; pass++) {
        pc_status status = pc_check_interrupt(av->ctx);
        if (status != PC_OK) return status;
#pragma omp parallel for schedule(static)
        for (pc_index v = 0; v < n; v++)
            average_vertex(av->other + LUMP * (size_t)v, av, av->lump, v);
        double *swap = av->lump;
        av->lump = av->other;
        av->other = swap;
    }
    return PC_OK;
}

/* Any two unit vectors that make a right-handed frame with the unit vector n. */
static void tangent_basis(pc_vec3 *b1, pc_vec3 *b2, pc_vec3 n) {
    pc_vec3 axis = fabs(n.x) < 0.6 ? (pc_vec3){1, 0, 0} : (pc_vec3){0, 1, 0};
    *b1 = pc_unit(pc_cross(axis, n));
    *b2 = pc_cross(n, *b1);
}

static double bilinear(const double *t, pc_vec3 u, pc_vec3 v) {
    return u.x * (t[0] * v.x + t[1] * v.y + t[2] * v.z) + u.y * (t[1] * v.x + t[3] * v.y + t[4] * v.z) +
           u.z * (t[2] * v.x + t[4] * v.y + t[5] * v.z);
}

/* Coherence of pure noise shrinks with the number of passes: measured on planes with white noise along z. */
static double noise_coherence(int passes) {
    return 0.35 / (1.0 + passes);
}

static double trust(double k1, double k2, double rough, double flat, int passes) {
    double sum = fabs(k1) + fabs(k2), apart = k1 - k2;
    if (!(apart > 0)) return 0;
    double anisotropy = apart / (sum + flat);
    double coherence = rough > 0 ? apart / rough : 0, ratio = coherence / noise_coherence(passes);
    ratio *= ratio;
    double w = anisotropy * ratio / (ratio + 4);
    return w < 1 ? w : 1;
}

static void principal(pc_curvature *c, const double *lump, pc_index v, double flat, int passes) {
    double area = lump[AREA] > 0 ? lump[AREA] : 1, *tensor = c->tensor + 6 * (size_t)v;
    pc_vec3 n = pc_unit((pc_vec3){lump[NORMAL], lump[NORMAL + 1], lump[NORMAL + 2]}), b1, b2;
    if (!(pc_dot(n, n) > 0.5)) n = (pc_vec3){0, 0, 1};
    for (int k = 0; k < 6; k++)
        tensor[k] = lump[k] / area;
    tangent_basis(&b1, &b2, n);
    double a = bilinear(tensor, b1, b1), b = bilinear(tensor, b1, b2), d = bilinear(tensor, b2, b2);
    double mean = 0.5 * (a + d), apart = hypot(0.5 * (a - d), b);
    /* The larger eigenvalue's eigenvector is where the surface bends least: k1 lies across it. */
    double angle = 0.5 * atan2(2 * b, a - d) + 0.5 * PC_PI;
    pc_vec3_put(c->normal, v, n);
    pc_vec3_put(c->direction, v, pc_unit(pc_madd(pc_scale(cos(angle), b1), sin(angle), b2)));
    c->value[2 * (size_t)v] = mean + apart;
    c->value[2 * (size_t)v + 1] = mean - apart;
    c->weight[v] = trust(mean + apart, mean - apart, lump[ROUGH] / area, flat, passes);
}

static pc_status new_arrays(pc_curvature *c, pc_context *ctx, size_t n) {
    pc_status status = PC_OK;
    PC_TRY(pc_new(&c->normal, ctx, 3 * n));
    PC_TRY(pc_new(&c->tensor, ctx, 6 * n));
    PC_TRY(pc_new(&c->value, ctx, 2 * n));
    PC_TRY(pc_new(&c->direction, ctx, 3 * n));
    PC_TRY(pc_new(&c->weight, ctx, n));
done:
    return status;
}

pc_status pc_curvature_make(pc_curvature *curvature, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                            const pc_adjacency *adjacency, const pc_curvature_options *options) {
    pc_status status = PC_OK;
    averaging av = {.ctx = ctx, .mesh = mesh, .adjacency = adjacency};
    size_t n = mesh->vertex_count;
    (void)device;
    *curvature = (pc_curvature){.vertex_count = mesh->vertex_count, .mean_edge = mean_edge(mesh, adjacency)};
    curvature->radius = options->radius > 0 ? options->radius : options->radius_edges * curvature->mean_edge;
    double rings = curvature->mean_edge > 0 ? curvature->radius / curvature->mean_edge : 0;
    av.passes = 1 + (int)(rings * rings / 1.71);
    av.step = curvature->mean_edge;
    PC_TRY(new_arrays(curvature, ctx, n));
    PC_TRY(pc_ring_make(&av.ring, ctx, mesh, adjacency));
    PC_TRY(pc_new(&av.bend, ctx, adjacency->edge_count));
    PC_TRY(pc_new(&av.lump, ctx, LUMP * n));
    PC_TRY(pc_new(&av.other, ctx, LUMP * n));
    PC_TRY(average_on_host(&av));
    double flat = curvature->radius > 0 ? options->flatness / curvature->radius : 0;
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        principal(curvature, av.lump + LUMP * (size_t)v, v, flat, av.passes);
done:
    pc_ring_free(&av.ring, ctx);
    pc_free(ctx, av.bend);
    pc_free(ctx, av.lump);
    pc_free(ctx, av.other);
    if (status != PC_OK) pc_curvature_free(curvature, ctx);
    return status;
}

void pc_curvature_free(pc_curvature *curvature, pc_context *ctx) {
    if (!curvature) return;
    pc_free(ctx, curvature->normal);
    pc_free(ctx, curvature->tensor);
    pc_free(ctx, curvature->value);
    pc_free(ctx, curvature->direction);
    pc_free(ctx, curvature->weight);
    *curvature = (pc_curvature){0};
}

pc_status pc_curvature_check(const pc_curvature *c, pc_context *ctx) {
    for (pc_index v = 0; v < c->vertex_count; v++) {
        pc_vec3 n = pc_vec3_at(c->normal, v), d = pc_vec3_at(c->direction, v);
        const double *k = c->value + 2 * (size_t)v;
        bool good = isfinite(k[0]) && isfinite(k[1]) && k[0] >= k[1] && c->weight[v] >= 0 &&
                    c->weight[v] <= 1 && fabs(pc_norm(n) - 1) < 1e-6 && fabs(pc_norm(d) - 1) < 1e-6 &&
                    fabs(pc_dot(n, d)) < 1e-6;
        if (!good) return pc_fail(ctx, PC_E_BUG, "curvature of vertex %u is not sound", v);
    }
    return PC_OK;
}
