#include "normalcycle.h"
#include "memory.h"
#include "vec3.h"
#include <string.h>

/* What a vertex carries through the averaging: 6 of the tensor, area, sum of |beta||e|, 3 of area times
 * normal. */
enum { AREA = 6, ROUGH = 7, NORMAL = 8, REACH = 11, LUMP = 12 };

typedef struct averaging {
    pc_context *ctx;
    const pc_normalcycle *work;
    double *bend; /* per edge: beta |e|, 0 on a boundary */
    double *lump;
    double *other;
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

static double walk_weight(pc_vec3 e, double step) {
    double d2 = pc_dot(e, e);
    return d2 > step * step ? step * step / d2 : 1;
}

/* Half of each edge's term and a third of each triangle's area go to a vertex. */
static void gather_vertex(double *lump, const averaging *av, pc_index v) {
    const pc_mesh *mesh = av->work->mesh;
    const pc_ring *ring = av->work->ring;
    pc_vec3 p = pc_vec3_at(mesh->position, v);
    memset(lump, 0, LUMP * sizeof(double));
    lump[REACH] = 1;
    for (pc_index k = ring->start[v]; k < ring->start[v + 1]; k++) {
        pc_index h = ring->half[k];
        pc_vec3 e = pc_sub(pc_vec3_at(mesh->position, ring->vertex[k]), p);
        lump[REACH] += walk_weight(e, av->work->step);
        add_edge(lump, e, av->bend[av->work->adjacency->edge[h]]);
        if (pc_tail(mesh, h) == v) add_face(lump, face_normal(mesh, h / 3));
    }
}

/* Symmetric weights: the window is then as smooth in space as the walk, whatever the valences. */
static void average_vertex(double *out, const averaging *av, const double *in, pc_index v) {
    const pc_ring *ring = av->work->ring;
    const double *position = av->work->mesh->position, *own = in + LUMP * (size_t)v;
    pc_vec3 p = pc_vec3_at(position, v);
    double sum[REACH] = {0}, total = 0;
    for (pc_index k = ring->start[v]; k < ring->start[v + 1]; k++) {
        const double *x = in + LUMP * (size_t)ring->vertex[k];
        double w = walk_weight(pc_sub(pc_vec3_at(position, ring->vertex[k]), p), av->work->step) /
                   fmax(own[REACH], x[REACH]);
        for (int c = 0; c < REACH; c++)
            sum[c] += w * x[c];
        total += w;
    }
    for (int c = 0; c < REACH; c++)
        out[c] = sum[c] + (1 - total) * own[c];
    out[REACH] = own[REACH];
}

static void start_lumps(averaging *av) {
    const pc_adjacency *a = av->work->adjacency;
#pragma omp parallel for schedule(static)
    for (pc_index e = 0; e < a->edge_count; e++)
        av->bend[e] = edge_bend(av->work->mesh, a->edge_half[e], a->twin[a->edge_half[e]]);
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < av->work->mesh->vertex_count; v++)
        gather_vertex(av->lump + LUMP * (size_t)v, av, v);
}

static pc_status average(averaging *av, int passes) {
    for (int pass = 0; pass < passes; pass++) {
        pc_status status = pc_check_interrupt(av->ctx);
        if (status != PC_OK) return status;
#pragma omp parallel for schedule(static)
        for (pc_index v = 0; v < av->work->mesh->vertex_count; v++)
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

static double trust(double k1, double k2, double rough, double flat, double noise) {
    double sum = fabs(k1) + fabs(k2), apart = k1 - k2;
    if (!(apart > 0)) return 0;
    double anisotropy = apart / (sum + flat);
    double coherence = rough > 0 ? apart / rough : 0, ratio = coherence / noise;
    ratio *= ratio;
    double w = anisotropy * ratio / (ratio + 4);
    return w < 1 ? w : 1;
}

static void principal(pc_curvature *c, const double *lump, pc_index v, const pc_normalcycle_level *level,
                      double prefer) {
    double area = lump[AREA] > 0 ? lump[AREA] : 1, *tensor = c->tensor + 6 * (size_t)v;
    pc_vec3 n = pc_unit((pc_vec3){lump[NORMAL], lump[NORMAL + 1], lump[NORMAL + 2]}), b1, b2;
    if (!(pc_dot(n, n) > 0.5)) n = (pc_vec3){0, 0, 1};
    tangent_basis(&b1, &b2, n);
    double a = bilinear(lump, b1, b1) / area, b = bilinear(lump, b1, b2) / area,
           d = bilinear(lump, b2, b2) / area;
    double mean = 0.5 * (a + d), apart = hypot(0.5 * (a - d), b);
    double weight = trust(mean + apart, mean - apart, lump[ROUGH] / area, level->flat, level->noise);
    if (prefer > 0 && !(weight > prefer * c->weight[v])) return;
    for (int k = 0; k < 6; k++)
        tensor[k] = lump[k] / area;
    /* The larger eigenvalue's eigenvector is where the surface bends least: k1 lies across it. */
    double angle = 0.5 * atan2(2 * b, a - d) + 0.5 * PC_PI;
    pc_vec3_put(c->normal, v, n);
    pc_vec3_put(c->direction, v, pc_unit(pc_madd(pc_scale(cos(angle), b1), sin(angle), b2)));
    c->value[2 * (size_t)v] = mean + apart;
    c->value[2 * (size_t)v + 1] = mean - apart;
    c->weight[v] = weight;
}

pc_status pc_normalcycle_ref(pc_curvature *curvature, pc_context *ctx, const pc_normalcycle *work) {
    pc_status status = PC_OK;
    averaging av = {.ctx = ctx, .work = work};
    size_t n = work->mesh->vertex_count;
    PC_TRY(pc_new(&av.bend, ctx, work->adjacency->edge_count));
    PC_TRY(pc_new(&av.lump, ctx, LUMP * n));
    PC_TRY(pc_new(&av.other, ctx, LUMP * n));
    start_lumps(&av);
    for (int k = 0; k < work->level_count; k++) {
        const pc_normalcycle_level *level = work->level + k;
        PC_TRY(average(&av, level->passes - (k > 0 ? level[-1].passes : 0)));
#pragma omp parallel for schedule(static)
        for (pc_index v = 0; v < work->mesh->vertex_count; v++)
            principal(curvature, av.lump + LUMP * (size_t)v, v, level, k > 0 ? PC_NORMALCYCLE_PREFER : 0);
    }
done:
    pc_free(ctx, av.bend);
    pc_free(ctx, av.lump);
    pc_free(ctx, av.other);
    return status;
}
