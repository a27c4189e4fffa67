#include "upright.h"
#include "memory.h"
#include "upright_memory.h"
#include <string.h>

enum { TURNS = 8, REACHES = 3, MOST_FACES = 24, OFF_SCAN_FROM = 3 };
static const double REACH[REACHES] = {0.08, 0.25, 0.6}; /* steps, in mean edge lengths around the vertex */
static const double LEAST_COSINE = 0.1, LEAST_AREA = 0.02, LEAST_SINE = 0.1;
static const double WORTH = 1e-6; /* a smaller gain is none */

typedef struct uprighting {
    pc_polymesh *quads;
    const pc_ground *ground;
    pc_index *start, *face;  /* per vertex: its faces */
    pc_index *next, *before; /* per vertex: its neighbours along the border, PC_NONE elsewhere */
    pc_vec3 *normal;         /* per vertex: the scan's at its closest point */
    pc_index *hint;          /* per vertex: the scan face it was last on */
    pc_rim_place *place;     /* per border vertex; only where `border_known` */
    uint8_t *border;         /* 1: on a border, 2: the place is known */
    double *penalty;         /* per face, negative: not judged yet */
    uint8_t *folded;         /* per face */
    uint8_t *bent;           /* per face: folded, or a corner turns the wrong way */
    uint8_t *ring;           /* per vertex: 0, or 1 + how far from a folded face */
    uint8_t *stuck;          /* per vertex: has found no better place while all around it stood as it does */
    uint8_t *moved;          /* per vertex */
} uprighting;

enum { FREE, STUCK_ON_SCAN, STUCK }; /* STUCK: off the scan neither */

static pc_vec3 position(const uprighting *u, pc_index v) {
    return pc_vec3_at(u->quads->position, v);
}

static pc_vec3 centre_of(const pc_polymesh *q, pc_index f) {
    pc_vec3 centre = {0, 0, 0};
    for (pc_index c = q->start[f]; c < q->start[f + 1]; c++)
        centre =
            pc_madd(centre, 1.0 / (q->start[f + 1] - q->start[f]), pc_vec3_at(q->position, q->corner[c]));
    return centre;
}

/* `up`: the sum of the scan's normals at the corners. */
static pc_stance judge(const pc_ground *ground, const pc_polymesh *q, pc_index f, pc_vec3 up, pc_index hint) {
    pc_index from = q->start[f], n = q->start[f + 1] - from;
    pc_vec3 first = pc_vec3_at(q->position, q->corner[from]), area = {0, 0, 0};
    pc_bvh_hit hit = pc_bvh_closest(&ground->tree, centre_of(q, f), hint);
    pc_stance s = {.sine = 1};
    double around = 0;
    pc_vec3 corners = pc_unit(up), middle = pc_unit(pc_ground_normal(ground, &hit));
    up = pc_unit(pc_add(up, middle));
    for (pc_index k = 0; k < n; k++) {
        pc_vec3 p = pc_vec3_at(q->position, q->corner[from + k]);
        pc_vec3 a = pc_sub(pc_vec3_at(q->position, q->corner[from + (k + 1) % n]), p);
        pc_vec3 b = pc_sub(pc_vec3_at(q->position, q->corner[from + (k + n - 1) % n]), p);
        double lengths = pc_norm(a) * pc_norm(b);
        area = pc_madd(area, 0.5, pc_cross(pc_sub(p, first), a));
        around += pc_norm(a);
        if (q->corner_flat && q->corner_flat[from + k]) continue;
        s.sine = fmin(s.sine, lengths > 0 ? pc_dot(pc_cross(a, b), up) / lengths : 0);
    }
    s.area = around > 0 ? pc_norm(area) * 16 / (around * around) : 0;
    area = pc_unit(area);
    s.smooth = pc_dot(area, up);
    s.corners = pc_dot(area, corners);
    s.centre = fmin(pc_dot(area, middle), pc_ground_flat_cosine(ground, &hit, area));
    return s;
}

pc_stance pc_upright_judge(const pc_ground *ground, const pc_polymesh *quads, pc_index face) {
    pc_vec3 up = {0, 0, 0};
    for (pc_index c = quads->start[face]; c < quads->start[face + 1]; c++) {
        pc_bvh_hit hit =
            pc_bvh_closest(&ground->tree, pc_vec3_at(quads->position, quads->corner[c]), PC_NONE);
        up = pc_add(up, pc_unit(pc_ground_normal(ground, &hit)));
    }
    return judge(ground, quads, face, up, PC_NONE);
}

bool pc_upright_is_folded(const pc_stance *stance) {
    return !(stance->smooth > 0.01 && stance->corners > 0.01 && stance->centre > 0.01 && stance->area > 1e-3);
}

static double lack(double value, double least) {
    return value < least ? (least - value) * (least - value) : 0;
}

static double penalty_of(const pc_stance *s) {
    return (pc_upright_is_folded(s) ? 4 : 0) + 4 * lack(s->smooth, LEAST_COSINE) +
           2 * lack(s->corners, LEAST_COSINE) + 2 * lack(s->centre, LEAST_COSINE) +
           100 * lack(s->area, LEAST_AREA) + lack(s->sine, LEAST_SINE);
}

static pc_stance judge_face(uprighting *u, pc_index f) {
    const pc_polymesh *q = u->quads;
    pc_vec3 up = {0, 0, 0};
    for (pc_index c = q->start[f]; c < q->start[f + 1]; c++)
        up = pc_add(up, u->normal[q->corner[c]]);
    return judge(u->ground, q, f, up, u->hint[q->corner[q->start[f]]]);
}

static double penalty(uprighting *u, pc_index f) {
    if (u->penalty[f] < 0) {
        pc_stance s = judge_face(u, f);
        u->penalty[f] = penalty_of(&s);
        u->folded[f] = pc_upright_is_folded(&s);
        u->bent[f] = u->folded[f] || s.sine <= 0;
    }
    return u->penalty[f];
}

/* What stands around a vertex, and the best place for it so far. */
typedef struct trial {
    pc_index vertex;
    double length; /* mean of the edges around */
    pc_vec3 home, best, best_normal;
    pc_rim_place best_place;
    pc_index best_hint;
    double least; /* penalty of the faces around at the best place */
    bool better;
} trial;

/* Puts the vertex at p for a look. */
static void look(uprighting *u, trial *t, pc_vec3 p, const pc_bvh_hit *hit, pc_rim_place place) {
    pc_index v = t->vertex, old_hint = u->hint[v];
    pc_vec3 old_normal = u->normal[v];
    double sum = 0;
    pc_vec3_put(u->quads->position, v, p);
    u->normal[v] = pc_unit(pc_ground_normal(u->ground, hit));
    u->hint[v] = hit->face;
    for (pc_index i = u->start[v]; i < u->start[v + 1] && sum < t->least; i++) {
        pc_stance s = judge_face(u, u->face[i]);
        sum += penalty_of(&s);
    }
    if (sum < t->least - WORTH) {
        t->least = sum, t->better = true;
        t->best = p, t->best_normal = u->normal[v], t->best_hint = hit->face, t->best_place = place;
    }
    pc_vec3_put(u->quads->position, v, t->home);
    u->normal[v] = old_normal, u->hint[v] = old_hint;
}

static void try_on_scan(uprighting *u, trial *t, pc_vec3 p) {
    const pc_rim_place nowhere = {PC_NONE, 0};
    pc_bvh_hit hit = pc_bvh_closest(&u->ground->tree, p, u->hint[t->vertex]);
    if (hit.face != PC_NONE) look(u, t, hit.point, &hit, nowhere);
}

static void try_off_scan(uprighting *u, trial *t, pc_vec3 p, double reach) {
    const pc_rim_place nowhere = {PC_NONE, 0};
    pc_bvh_hit hit = pc_bvh_closest(&u->ground->tree, p, u->hint[t->vertex]);
    if (hit.face != PC_NONE && hit.distance <= reach * t->length) look(u, t, p, &hit, nowhere);
}

static void try_on_rim(uprighting *u, trial *t, double distance, pc_rim_place stop) {
    pc_rim_place place = pc_ground_rim_walk(u->ground, u->place[t->vertex], distance, stop);
    if (place.edge == PC_NONE) return;
    pc_vec3 p = pc_ground_rim_point(u->ground, place);
    pc_bvh_hit hit = pc_bvh_closest(&u->ground->tree, p, PC_NONE);
    look(u, t, p, &hit, place);
}

static pc_rim_place place_of(uprighting *u, pc_index v) {
    if (u->border[v] == 1) u->place[v] = pc_ground_rim_closest(u->ground, position(u, v)), u->border[v] = 2;
    return u->place[v];
}

static void search_rim(uprighting *u, trial *t) {
    pc_index v = t->vertex;
    if (u->next[v] == PC_NONE || u->before[v] == PC_NONE) return;
    pc_rim_place ahead = place_of(u, u->next[v]), behind = place_of(u, u->before[v]);
    (void)place_of(u, v);
    for (int i = 0; i < REACHES; i++) {
        try_on_rim(u, t, REACH[i] * t->length, ahead);
        try_on_rim(u, t, -REACH[i] * t->length, behind);
    }
}

/* The mean of the neighbours, `length` the mean distance to them. */
static pc_vec3 survey(const uprighting *u, pc_index v, double *length) {
    const pc_polymesh *q = u->quads;
    pc_vec3 sum = {0, 0, 0}, p = position(u, v);
    pc_index count = 0;
    *length = 0;
    for (pc_index i = u->start[v]; i < u->start[v + 1]; i++) {
        pc_index f = u->face[i], from = q->start[f], n = q->start[f + 1] - from;
        for (pc_index k = 0; k < n; k++) {
            if (q->corner[from + k] != v) continue;
            for (pc_index s = 1; s < n; s += n - 2, count++) {
                pc_vec3 w = position(u, q->corner[from + (k + s) % n]);
                sum = pc_add(sum, w);
                *length += pc_distance(p, w);
            }
        }
    }
    *length /= count ? count : 1;
    return count ? pc_scale(1.0 / count, sum) : p;
}

static void search_around(uprighting *u, trial *t, pc_vec3 mean, double reach) {
    pc_vec3 n = u->normal[t->vertex], axis = {0, 0, 0};
    try_on_scan(u, t, mean);
    try_on_scan(u, t, pc_scale(0.5, pc_add(t->home, mean)));
    if (fabs(n.x) < 0.6)
        axis.x = 1;
    else if (fabs(n.y) < 0.6)
        axis.y = 1;
    else
        axis.z = 1;
    pc_vec3 a = pc_unit(pc_cross(n, axis)), b = pc_cross(n, a);
    for (int i = 0; i < REACHES; i++)
        for (int k = 0; k < TURNS; k++) {
            double turn = 2 * PC_PI * (k + 0.5 * (i % 2)) / TURNS, far = REACH[i] * t->length;
            try_on_scan(u, t, pc_madd(pc_madd(t->home, far * cos(turn), a), far * sin(turn), b));
        }
    if (reach == 0) return;
    try_off_scan(u, t, mean, reach);
    for (int i = -2; i <= 2; i++)
        if (i) try_off_scan(u, t, pc_madd(t->home, 0.4 * i * reach * t->length, n), reach);
}

/* What is around a vertex that has moved may move again. */
static void set_free(uprighting *u, pc_index v) {
    const pc_polymesh *q = u->quads;
    for (pc_index i = u->start[v]; i < u->start[v + 1]; i++) {
        u->penalty[u->face[i]] = -1;
        for (pc_index c = q->start[u->face[i]]; c < q->start[u->face[i] + 1]; c++)
            u->stuck[q->corner[c]] = FREE;
    }
}

/* True where the vertex has found a better place. */
static bool improve(uprighting *u, pc_index v, double reach) {
    trial t = {.vertex = v, .home = position(u, v)};
    const uint8_t stuck = reach > 0 ? STUCK : STUCK_ON_SCAN;
    if (u->stuck[v] >= stuck) return false;
    u->stuck[v] = stuck;
    pc_vec3 mean = survey(u, v, &t.length);
    if (u->start[v + 1] - u->start[v] > MOST_FACES) return false;
    for (pc_index i = u->start[v]; i < u->start[v + 1]; i++)
        t.least += penalty(u, u->face[i]);
    if (t.least < WORTH) return false;
    if (u->border[v])
        search_rim(u, &t);
    else
        search_around(u, &t, mean, reach);
    if (!t.better) return false;
    pc_vec3_put(u->quads->position, v, t.best);
    u->normal[v] = t.best_normal, u->hint[v] = t.best_hint;
    u->moved[v] = 1;
    if (u->border[v]) u->place[v] = t.best_place;
    set_free(u, v);
    return true;
}

/* Rings 1 to `rings` around the faces that are `wanted`; returns how many those are. */
static pc_index mark(uprighting *u, const uint8_t *wanted, int rings) {
    const pc_polymesh *q = u->quads;
    pc_index count = 0;
    memset(u->ring, 0, q->vertex_count);
    for (pc_index f = 0; f < q->face_count; f++) {
        (void)penalty(u, f);
        if (!wanted[f]) continue;
        count++;
        for (pc_index c = q->start[f]; c < q->start[f + 1]; c++)
            u->ring[q->corner[c]] = 1;
    }
    for (int ring = 1; ring < rings && count; ring++)
        for (pc_index f = 0; f < q->face_count; f++)
            for (pc_index c = q->start[f]; c < q->start[f + 1]; c++)
                if (u->ring[q->corner[c]] == ring) {
                    for (pc_index d = q->start[f]; d < q->start[f + 1]; d++)
                        if (!u->ring[q->corner[d]]) u->ring[q->corner[d]] = (uint8_t)(ring + 1);
                    break;
                }
    return count;
}

/* Rounds until no face is wanted any more, or nothing moves. */
static pc_status sweep(uprighting *u, pc_index *left, pc_context *ctx, const uint8_t *wanted, int rounds,
                       double reach) {
    pc_status status = PC_OK;
    for (int round = 0;; round++) {
        bool moved = false;
        *left = mark(u, wanted, 1 + round / 2);
        if (*left == 0 || round == rounds) break;
        for (pc_index v = 0; v < u->quads->vertex_count; v++)
            if (u->ring[v]) moved = improve(u, v, reach > 0 && round >= OFF_SCAN_FROM ? reach : 0) || moved;
        if (!moved && round >= OFF_SCAN_FROM) break;
        PC_TRY(pc_check_interrupt(ctx));
    }
done:
    return status;
}

static pc_status find_neighbours(uprighting *u, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_polymesh *q = u->quads;
    pc_index corners = q->start[q->face_count];
    PC_TRY(pc_new(&u->start, ctx, (size_t)q->vertex_count + 2));
    PC_TRY(pc_new(&u->face, ctx, corners));
    PC_TRY(pc_new(&u->border, ctx, q->vertex_count));
    PC_TRY(pc_new(&u->next, ctx, q->vertex_count));
    PC_TRY(pc_new(&u->before, ctx, q->vertex_count));
    memset(u->next, 0xff, sizeof(pc_index) * q->vertex_count);
    memset(u->before, 0xff, sizeof(pc_index) * q->vertex_count);
    for (pc_index c = 0; c < corners; c++)
        u->start[q->corner[c] + 2]++;
    for (pc_index v = 0; v < q->vertex_count; v++)
        u->start[v + 2] += u->start[v + 1];
    for (pc_index f = 0; f < q->face_count; f++)
        for (pc_index c = q->start[f]; c < q->start[f + 1]; c++)
            u->face[u->start[q->corner[c] + 1]++] = f;
done:
    return status;
}

/* Whether a face around b runs from b to a. */
static bool runs(const uprighting *u, pc_index b, pc_index a) {
    const pc_polymesh *q = u->quads;
    for (pc_index i = u->start[b]; i < u->start[b + 1]; i++) {
        pc_index f = u->face[i], from = q->start[f], n = q->start[f + 1] - from;
        for (pc_index k = 0; k < n; k++)
            if (q->corner[from + k] == b && q->corner[from + (k + 1) % n] == a) return true;
    }
    return false;
}

static void find_borders(uprighting *u) {
    const pc_polymesh *q = u->quads;
    for (pc_index f = 0; f < q->face_count; f++)
        for (pc_index from = q->start[f], n = q->start[f + 1] - from, k = 0; k < n; k++) {
            pc_index a = q->corner[from + k], b = q->corner[from + (k + 1) % n];
            if (runs(u, b, a)) continue;
            u->border[a] = u->border[b] = 1;
            u->next[a] = b, u->before[b] = a;
        }
}

static pc_status allocate(uprighting *u, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index vertices = u->quads->vertex_count;
    PC_TRY(pc_new(&u->normal, ctx, vertices));
    PC_TRY(pc_new(&u->hint, ctx, vertices));
    PC_TRY(pc_new(&u->place, ctx, vertices));
    PC_TRY(pc_new(&u->ring, ctx, vertices));
    PC_TRY(pc_new(&u->stuck, ctx, vertices));
    PC_TRY(pc_new(&u->moved, ctx, vertices));
    PC_TRY(pc_new(&u->penalty, ctx, u->quads->face_count));
    PC_TRY(pc_new(&u->bent, ctx, u->quads->face_count));
    memset(u->hint, 0xff, sizeof(pc_index) * vertices);
    PC_TRY(find_neighbours(u, ctx));
    find_borders(u);
done:
    return status;
}

/* True where all faces around are those that were around the vertex `old`. */
static bool stands_among_the_same(const uprighting *u, pc_index v, const pc_upright_memory *m, pc_index old,
                                  const pc_index *face) {
    bool same = u->start[v + 1] - u->start[v] == m->start[old + 1] - m->start[old];
    for (pc_index i = u->start[v]; same && i < u->start[v + 1]; i++)
        same = face[u->face[i]] != PC_NONE;
    return same;
}

/* Normals and penalties: remembered ones where nothing has moved. */
static pc_status look_at_all(uprighting *u, pc_context *ctx, const pc_upright_memory *m) {
    pc_status status = PC_OK;
    const pc_index vertices = u->quads->vertex_count, faces = u->quads->face_count;
    pc_index *vertex = NULL, *face = NULL;
    PC_TRY(pc_new(&vertex, ctx, vertices));
    PC_TRY(pc_new(&face, ctx, faces));
    memset(vertex, 0xff, sizeof *vertex * vertices);
    memset(face, 0xff, sizeof *face * faces);
    if (m) PC_TRY(pc_upright_memory_match(vertex, face, ctx, m, u->quads));
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < vertices; v++) {
        const pc_index old = vertex[v];
        if (m && old != PC_NONE) {
            u->normal[v] = m->normal[old], u->hint[v] = m->hint[old];
            if (stands_among_the_same(u, v, m, old, face)) u->stuck[v] = m->stuck[old];
            continue;
        }
        pc_bvh_hit hit = pc_bvh_closest(&u->ground->tree, position(u, v), PC_NONE);
        u->normal[v] = pc_unit(pc_ground_normal(u->ground, &hit));
        u->hint[v] = hit.face;
    }
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < faces; f++) {
        const pc_index old = face[f];
        u->penalty[f] = m && old != PC_NONE ? m->penalty[old] : -1;
        if (m && old != PC_NONE) u->folded[f] = m->folded[old], u->bent[f] = m->bent[old];
        (void)penalty(u, f);
    }
done:
    pc_free(ctx, vertex);
    pc_free(ctx, face);
    return status;
}

/* Hands over what the memory wants. */
static pc_status keep(pc_upright_memory **memory, pc_context *ctx, uprighting *u) {
    pc_status status = PC_OK;
    pc_upright_memory *m = NULL;
    pc_upright_memory_free(*memory, ctx);
    *memory = NULL;
    PC_TRY(pc_new(&m, ctx, 1));
    PC_TRY(pc_polymesh_copy(&m->quads, ctx, u->quads));
    PC_TRY(pc_new(&m->folded, ctx, u->quads->face_count));
    memcpy(m->folded, u->folded, u->quads->face_count);
    m->start = u->start, m->face = u->face, u->start = u->face = NULL;
    m->moved = u->moved, m->stuck = u->stuck, u->moved = u->stuck = NULL;
    m->normal = u->normal, m->hint = u->hint, u->normal = NULL, u->hint = NULL;
    m->penalty = u->penalty, m->bent = u->bent, u->penalty = NULL, u->bent = NULL;
    *memory = m, m = NULL;
done:
    pc_upright_memory_free(m, ctx);
    return status;
}

pc_status pc_upright_make(pc_polymesh *quads, uint8_t *folded, pc_index *left, pc_upright_memory **memory,
                          pc_context *ctx, const pc_ground *ground, const pc_upright_options *options) {
    pc_status status = PC_OK;
    uprighting u = {.quads = quads, .ground = ground};
    u.folded = folded;
    *left = 0;
    PC_TRY(allocate(&u, ctx));
    PC_TRY(look_at_all(&u, ctx, memory ? *memory : NULL));
    PC_TRY(sweep(&u, left, ctx, u.bent, options->bent_rounds, 0));
    PC_TRY(sweep(&u, left, ctx, u.folded, options->rounds, options->reach));
    if (memory) PC_TRY(keep(memory, ctx, &u));
done:
    pc_free(ctx, u.start), pc_free(ctx, u.face);
    pc_free(ctx, u.next), pc_free(ctx, u.before);
    pc_free(ctx, u.normal), pc_free(ctx, u.hint);
    pc_free(ctx, u.place), pc_free(ctx, u.border);
    pc_free(ctx, u.penalty), pc_free(ctx, u.ring);
    pc_free(ctx, u.bent), pc_free(ctx, u.stuck);
    pc_free(ctx, u.moved);
    return status;
}
