#include "systems.h"
#include "memory.h"
#include "random.h"
#include "vec3.h"
#include <stdlib.h>
#include <string.h>

enum { MOST_NEIGHBOURS = 8 };

typedef struct link {
    pc_index to;
    double weight;
} link;

typedef struct torus {
    const pc_synth_options *options;
    pc_index count;
    double *position;
    double *normal;
    double *frame; /* 3 per vertex: a tangent */
    double *ring;  /* 3 per vertex: the tangent along the rings */
    uint8_t *turn; /* per vertex: its representative */
    link *links;   /* MOST_NEIGHBOURS per vertex */
    uint8_t *degree;
} torus;

static double random_of(uint64_t seed, uint64_t i) {
    return (double)(pc_hash64(pc_hash64(seed) ^ (i * 0x9e3779b97f4a7c15u)) >> 11) * 0x1p-53;
}

static void free_torus(torus *t, pc_context *ctx) {
    pc_free(ctx, t->position);
    pc_free(ctx, t->normal);
    pc_free(ctx, t->frame);
    pc_free(ctx, t->ring);
    pc_free(ctx, t->turn);
    pc_free(ctx, t->links);
    pc_free(ctx, t->degree);
}

/* The ring that has the rows [place * around, (place + 1) * around), and the place of a ring: one ring after
 * the other, or, where neighbours are to stay near, the last one next to the first. */
static pc_index ring_of(const pc_synth_options *o, pc_index place) {
    return !o->folded ? place : place % 2 == 0 ? place / 2 : o->across - 1 - place / 2;
}
static pc_index place_of(const pc_synth_options *o, pc_index ring) {
    return !o->folded ? ring : 2 * ring < o->across ? 2 * ring : 2 * (o->across - 1 - ring) + 1;
}

static void place_vertex(torus *t, pc_index i) {
    const pc_synth_options *o = t->options;
    double u = i % o->around + o->jitter * (random_of(o->seed, 3 * (uint64_t)i) - 0.5);
    double v = ring_of(o, i / o->around) + o->jitter * (random_of(o->seed, 3 * (uint64_t)i + 1) - 0.5);
    double a = 2 * PC_PI * u / o->around;
    double b = 2 * PC_PI * v / o->across;
    const double minor = 0.4;
    pc_vec3 out = {cos(a) * cos(b), sin(a) * cos(b), sin(b)};
    pc_vec3 ring = {-sin(a), cos(a), 0};
    pc_vec3 tube = pc_cross(out, ring);
    double angle = 2 * PC_PI * random_of(o->frame_seed, 3 * (uint64_t)i + 2);
    pc_vec3_put(t->position, i,
                (pc_vec3){cos(a) * (1 + minor * cos(b)), sin(a) * (1 + minor * cos(b)), minor * sin(b)});
    pc_vec3_put(t->normal, i, out);
    pc_vec3_put(t->ring, i, ring);
    pc_vec3_put(t->frame, i, pc_add(pc_scale(cos(angle), ring), pc_scale(sin(angle), tube)));
    t->turn[i] = o->combed ? 0 : (uint8_t)(4 * random_of(o->frame_seed, 3 * (uint64_t)i + 1));
}

static void add_link(torus *t, pc_index i, pc_index j, double weight) {
    link *of = t->links + (size_t)MOST_NEIGHBOURS * i;
    for (int k = 0; k < t->degree[i]; k++) {
        if (of[k].to == j) {
            of[k].weight += weight;
            return;
        }
    }
    of[t->degree[i]++] = (link){j, weight};
}

static void add_face(torus *t, pc_index a, pc_index b, pc_index c) {
    pc_index v[3] = {a, b, c};
    for (int k = 0; k < 3; k++) {
        pc_vec3 p = pc_vec3_at(t->position, v[k]);
        pc_vec3 e = pc_sub(pc_vec3_at(t->position, v[(k + 1) % 3]), p);
        pc_vec3 f = pc_sub(pc_vec3_at(t->position, v[(k + 2) % 3]), p);
        double half_cotangent = 0.5 * pc_dot(e, f) / pc_norm(pc_cross(e, f));
        add_link(t, v[(k + 1) % 3], v[(k + 2) % 3], half_cotangent);
        add_link(t, v[(k + 2) % 3], v[(k + 1) % 3], half_cotangent);
    }
}

static int by_target(const void *a, const void *b) {
    pc_index x = ((const link *)a)->to;
    pc_index y = ((const link *)b)->to;
    return (x > y) - (x < y);
}

static pc_status make_torus(torus *t, pc_context *ctx, const pc_synth_options *options) {
    pc_status status = PC_OK;
    const pc_index nu = options->around;
    const pc_index nv = options->across;
    *t = (torus){.options = options, .count = nu * nv};
    PC_TRY(pc_new(&t->position, ctx, 3 * (size_t)t->count));
    PC_TRY(pc_new(&t->normal, ctx, 3 * (size_t)t->count));
    PC_TRY(pc_new(&t->frame, ctx, 3 * (size_t)t->count));
    PC_TRY(pc_new(&t->ring, ctx, 3 * (size_t)t->count));
    PC_TRY(pc_new(&t->turn, ctx, t->count));
    PC_TRY(pc_new(&t->links, ctx, MOST_NEIGHBOURS * (size_t)t->count));
    PC_TRY(pc_new(&t->degree, ctx, t->count));
    for (pc_index i = 0; i < t->count; i++)
        place_vertex(t, i);
    for (pc_index i = 0; i < t->count; i++) {
        pc_index u = i % nu;
        pc_index v = i / nu;
        pc_index right = v * nu + (u + 1) % nu;
        pc_index above = place_of(options, (ring_of(options, v) + 1) % nv);
        pc_index up = above * nu + u;
        pc_index both = above * nu + (u + 1) % nu;
        if (random_of(options->seed, 3 * (uint64_t)i + 2) < 0.5) {
            add_face(t, i, right, both);
            add_face(t, i, both, up);
        } else {
            add_face(t, i, right, up);
            add_face(t, right, both, up);
        }
    }
    for (pc_index i = 0; i < t->count; i++)
        qsort(t->links + (size_t)MOST_NEIGHBOURS * i, t->degree[i], sizeof(link), by_target);
done:
    return status;
}

/* Angle of `to` seen from `from` in the tangent plane with this normal. */
static double angle_between(pc_vec3 normal, pc_vec3 from, pc_vec3 to) {
    return atan2(pc_dot(normal, pc_cross(from, to)), pc_dot(from, to));
}

/* 4 times the angle from i's frame to j's, both measured against the edge between them. */
static double frame_angle(const torus *t, pc_index i, pc_index j) {
    pc_vec3 edge = pc_sub(pc_vec3_at(t->position, j), pc_vec3_at(t->position, i));
    double at_i = angle_between(pc_vec3_at(t->normal, i), pc_vec3_at(t->frame, i), edge);
    double at_j = angle_between(pc_vec3_at(t->normal, j), pc_vec3_at(t->frame, j), edge);
    return 4 * (at_i - at_j);
}

static void turned_block(double *value, uint8_t *turn, const torus *t, pc_index i, pc_index j,
                         double weight) {
    pc_vec3 edge = pc_sub(pc_vec3_at(t->position, j), pc_vec3_at(t->position, i));
    double mean_edge = 2 * PC_PI / t->options->around;
    pc_vec3 k = pc_scale(0.5, pc_add(pc_vec3_at(t->ring, i), pc_vec3_at(t->ring, j)));
    pc_vec3 n = pc_unit(pc_add(pc_vec3_at(t->normal, i), pc_vec3_at(t->normal, j)));
    double frequency = 2 * PC_PI / (t->options->period * mean_edge);
    double s = -frequency * pc_dot(k, edge);
    double u = -frequency * pc_dot(pc_cross(n, k), edge);
    double a[4] = {-weight * cos(s), -weight * sin(s), -weight * cos(u), -weight * sin(u)};
    for (int turns = t->turn[i]; turns > 0; turns--) {
        /* M diag(p,q) = diag(q, conj p) M */
        double p[2] = {a[0], a[1]};
        a[0] = a[2];
        a[1] = a[3];
        a[2] = p[0];
        a[3] = -p[1];
    }
    memcpy(value, a, sizeof a);
    *turn = (uint8_t)((t->turn[i] + 4 - t->turn[j]) & 3);
}

static void fill_row(pc_system *s, const torus *t, pc_index i) {
    const double least = t->options->least;
    pc_index e = s->start[i];
    s->diagonal[i] = 0;
    for (int k = 0; k < t->degree[i]; k++, e++) {
        const link *l = &t->links[(size_t)MOST_NEIGHBOURS * i + (size_t)k];
        double weight = l->weight > least ? l->weight : least;
        s->column[e] = l->to;
        s->diagonal[i] += weight;
        if (s->kind == PC_BLOCK_SCALAR) {
            s->value[e] = -weight;
        } else if (s->kind == PC_BLOCK_COMPLEX) {
            double angle = frame_angle(t, i, l->to);
            s->value[2 * (size_t)e] = -weight * cos(angle);
            s->value[2 * (size_t)e + 1] = -weight * sin(angle);
        } else {
            turned_block(s->value + 4 * (size_t)e, &s->turn[e], t, i, l->to, weight);
        }
    }
    s->start[i + 1] = e;
}

pc_status pc_synth_torus_system(pc_system *system, pc_context *ctx, pc_block_kind kind,
                                const pc_synth_options *options) {
    pc_status status = PC_OK;
    torus t = {0};
    size_t entries = 0;
    double total = 0;
    *system = (pc_system){0};
    PC_TRY(make_torus(&t, ctx, options));
    for (pc_index i = 0; i < t.count; i++)
        entries += t.degree[i];
    PC_TRY(pc_system_make(system, ctx, kind, t.count, entries));
    for (pc_index i = 0; i < t.count; i++)
        fill_row(system, &t, i);
    for (pc_index i = 0; i < t.count; i++)
        total += system->diagonal[i];
    for (pc_index i = 0; i < t.count; i++)
        system->diagonal[i] += options->shift * total / t.count;
done:
    free_torus(&t, ctx);
    return status;
}

/* Whether i and j > i are linked: both ends can tell. */
static bool linked(pc_index i, pc_index j, pc_index rows, pc_index degree, uint64_t seed) {
    if (i % 17 == 3 || j % 17 == 3) return false;
    uint64_t pair = (uint64_t)(i < j ? i : j) * rows + (i < j ? j : i);
    double chance = (double)degree / (rows < 64 ? rows : 64);
    return (i < j ? j - i : i - j) <= 32 && random_of(seed, pair) < chance;
}

static void random_block(pc_system *s, pc_index e, pc_index i, pc_index j, uint64_t seed) {
    uint64_t pair = (uint64_t)(i < j ? i : j) * s->row_count + (i < j ? j : i);
    int w = pc_block_width(s->kind);
    double *v = s->value + (size_t)w * e;
    int turn = (int)(4 * random_of(seed + 9, pair));
    for (int k = 0; k < w; k++)
        v[k] = 2 * random_of(seed + 1 + (uint64_t)k, pair) - 1;
    if (i > j) {
        /* The transpose of diag(p,q) M^t is M^-t diag(conj p, conj q). */
        for (int k = 1; k < w; k += 2)
            v[k] = -v[k];
        if (s->kind == PC_BLOCK_TURNED) {
            turn = (4 - turn) & 3;
            for (int t = turn; t > 0; t--) {
                double p[2] = {v[0], v[1]};
                v[0] = v[2];
                v[1] = v[3];
                v[2] = p[0];
                v[3] = -p[1];
            }
        }
    }
    if (s->kind == PC_BLOCK_TURNED) s->turn[e] = (uint8_t)turn;
}

pc_status pc_synth_random_system(pc_system *system, pc_context *ctx, pc_block_kind kind, pc_index rows,
                                 pc_index degree, double dominance, uint64_t seed) {
    size_t entries = 0;
    for (pc_index i = 0; i < rows; i++) {
        for (pc_index j = i > 32 ? i - 32 : 0; j < rows && j <= i + 32; j++)
            entries += j != i && linked(i, j, rows, degree, seed);
    }
    pc_status status = pc_system_make(system, ctx, kind, rows, entries);
    if (status != PC_OK) return status;
    pc_index e = 0;
    int w = pc_block_width(kind);
    for (pc_index i = 0; i < rows; i++) {
        double total = 0;
        for (pc_index j = i > 32 ? i - 32 : 0; j < rows && j <= i + 32; j++) {
            if (j == i || !linked(i, j, rows, degree, seed)) continue;
            system->column[e] = j;
            random_block(system, e, i, j, seed);
            for (int k = 0; k < w; k++)
                total += fabs(system->value[(size_t)w * e + (size_t)k]);
            e++;
        }
        system->diagonal[i] = dominance * total + 0.1;
        system->start[i + 1] = e;
    }
    return PC_OK;
}
