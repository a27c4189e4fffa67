#include "dislocation.h"
#include "coupling.h"
#include "memory.h"
#include "reconstruct.h"
#include "transition.h"
#include "vec3.h"
#include <stdlib.h>

enum { MOST_ROUNDS = 16 };

/* One search: distances from a dislocation over the faces, its shift carried along. */
typedef struct label {
    double distance;
    pc_index stamp;
    pc_index from;     /* half-edge by which the face was entered, in the face before; PC_NONE at the start */
    pc_point2 burgers; /* whole periods, in the frame of the face's first corner */
    bool settled;
} label;

typedef struct heap_entry {
    double distance;
    pc_index face;
} heap_entry;

typedef struct search {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    pc_param *param;
    const uint8_t *guarded; /* per vertex, or NULL */
    double reach;
    pc_vec3 *centre;   /* per face */
    uint8_t *hopeless; /* per face: a dislocation for which there is no end. Others only vanish: there will be
                          none */
    label *labels;
    heap_entry *heap;
    size_t heap_count;
    pc_index stamp;
} search;

/* What a dislocation would do: vanish at `face`, or out of the border half-edge `exit`. */
typedef struct plan {
    double distance;
    pc_index start, face, exit;
} plan;

static pc_transition around(const pc_param *param, pc_index f) {
    size_t h = 3 * (size_t)f;
    return pc_transition_after(
        pc_transition_after(pc_transition_of(param, h), pc_transition_of(param, h + 1)),
        pc_transition_of(param, h + 2));
}

/* Turns a vector from the frame of corner k of face f to that of its first corner, and back. */
static pc_point2 to_first(const pc_param *param, pc_index f, pc_index k, pc_point2 v) {
    size_t h = 3 * (size_t)f;
    return k == 0   ? v
           : k == 1 ? pc_point2_turned(v, param->turn[h])
                    : pc_point2_turned(v, pc_turn_back(param->turn[h + 2]));
}

static pc_point2 from_first(const pc_param *param, pc_index f, pc_index k, pc_point2 v) {
    size_t h = 3 * (size_t)f;
    return k == 0   ? v
           : k == 1 ? pc_point2_turned(v, pc_turn_back(param->turn[h]))
                    : pc_point2_turned(v, param->turn[h + 2]);
}

/* The shift as the face across h sees it. */
static pc_point2 carried(const search *s, pc_index h, pc_point2 burgers) {
    pc_index twin = s->adjacency->twin[h];
    pc_point2 at_tail = from_first(s->param, h / 3, h % 3, burgers);
    return to_first(s->param, twin / 3, twin % 3, pc_point2_turned(at_tail, pc_turn_back(s->param->turn[h])));
}

static pc_vec3 centroid(const pc_mesh *mesh, pc_index f) {
    const pc_index *t = mesh->triangle + 3 * (size_t)f;
    pc_vec3 sum = pc_add(pc_vec3_at(mesh->position, t[0]), pc_vec3_at(mesh->position, t[1]));
    return pc_scale(1.0 / 3, pc_add(sum, pc_vec3_at(mesh->position, t[2])));
}

static bool is_before(heap_entry a, heap_entry b) {
    return a.distance < b.distance || (a.distance == b.distance && a.face < b.face);
}

static void push(search *s, double distance, pc_index face) {
    size_t i = s->heap_count++;
    heap_entry entry = {distance, face};
    for (; i > 0 && is_before(entry, s->heap[(i - 1) / 2]); i = (i - 1) / 2)
        s->heap[i] = s->heap[(i - 1) / 2];
    s->heap[i] = entry;
}

static heap_entry pop(search *s) {
    heap_entry top = s->heap[0], last = s->heap[--s->heap_count];
    size_t i = 0;
    for (;;) {
        size_t child = 2 * i + 1;
        if (child >= s->heap_count) break;
        if (child + 1 < s->heap_count && is_before(s->heap[child + 1], s->heap[child])) child++;
        if (!is_before(s->heap[child], last)) break;
        s->heap[i] = s->heap[child];
        i = child;
    }
    s->heap[i] = last;
    return top;
}

static bool is_guarded(const search *s, pc_index f) {
    const pc_index *t = s->mesh->triangle + 3 * (size_t)f;
    return s->guarded && (s->guarded[t[0]] || s->guarded[t[1]] || s->guarded[t[2]]);
}

static bool takes_in(const search *s, pc_index f, pc_point2 burgers) {
    if (is_guarded(s, f)) return false;
    if (s->param->singular[f] == PC_FIELD_SINGULARITY) return true;
    if (s->param->singular[f] != PC_DISLOCATION) return false;
    pc_transition g = around(s->param, f);
    return g.a + burgers.s == 0 && g.b + burgers.t == 0;
}

static void relax(search *s, pc_index h, double distance, pc_point2 burgers) {
    pc_index face = s->adjacency->twin[h] / 3;
    label *l = &s->labels[face];
    if (l->stamp == s->stamp && (l->settled || l->distance <= distance)) return;
    *l = (label){.distance = distance, .stamp = s->stamp, .from = h, .burgers = burgers};
    push(s, distance, face);
}

/* Dijkstra over the faces, to the first one that takes the shift in. */
static bool find_end(search *s, plan *found, pc_index start) {
    pc_transition g = around(s->param, start);
    s->stamp++;
    s->heap_count = 0;
    s->labels[start] = (label){.stamp = s->stamp, .from = PC_NONE, .burgers = {g.a, g.b}};
    push(s, 0, start);
    while (s->heap_count) {
        heap_entry top = pop(s);
        label *l = &s->labels[top.face];
        if (l->settled || top.distance > l->distance) continue;
        l->settled = true;
        *found = (plan){top.distance, start, top.face, PC_NONE};
        if (top.distance > s->reach) return false;
        if (top.face != start && takes_in(s, top.face, l->burgers)) return true;
        pc_vec3 here = s->centre[top.face];
        for (pc_index h = 3 * top.face; h < 3 * top.face + 3; h++) {
            pc_index twin = s->adjacency->twin[h];
            if (twin == PC_NONE) {
                found->exit = h;
                return true;
            }
            relax(s, h, top.distance + pc_distance(here, s->centre[twin / 3]), carried(s, h, l->burgers));
        }
    }
    return false;
}

static void add_shift(pc_param *param, const pc_adjacency *adjacency, pc_index h, pc_point2 shift) {
    pc_transition g = pc_transition_of(param, h);
    g.a += shift.s, g.b += shift.t;
    param->shift[2 * (size_t)h] = (int32_t)g.a, param->shift[2 * (size_t)h + 1] = (int32_t)g.b;
    pc_index twin = adjacency->twin[h];
    if (twin == PC_NONE) return;
    g = pc_transition_inverse(g);
    param->shift[2 * (size_t)twin] = (int32_t)g.a, param->shift[2 * (size_t)twin + 1] = (int32_t)g.b;
}

/* Across h the face's shift goes over to its neighbour. */
static void move_across(search *s, pc_index h, pc_point2 burgers) {
    pc_point2 at_tail = from_first(s->param, h / 3, h % 3, burgers);
    add_shift(s->param, s->adjacency, h, (pc_point2){-at_tail.s, -at_tail.t});
}

static void flag(pc_param *param, pc_index f) {
    pc_transition g = around(param, f);
    param->singular[f] = g.turn ? PC_FIELD_SINGULARITY : g.a || g.b ? PC_DISLOCATION : PC_REGULAR;
}

/* Carries out the plan that find_end has just made; its labels tell the way back. */
static void carry_out(search *s, const plan *p) {
    if (p->exit != PC_NONE) move_across(s, p->exit, s->labels[p->face].burgers);
    for (pc_index f = p->face; s->labels[f].from != PC_NONE;) {
        pc_index h = s->labels[f].from;
        f = h / 3;
        move_across(s, h, s->labels[f].burgers);
    }
    flag(s->param, p->start);
    flag(s->param, p->face);
}

static int by_distance(const void *a, const void *b) {
    const plan *p = a, *q = b;
    if (p->distance != q->distance) return p->distance < q->distance ? -1 : 1;
    return p->start < q->start ? -1 : p->start > q->start;
}

static bool is_open(const search *s, pc_index f) {
    return s->param->singular[f] == PC_DISLOCATION && !s->hopeless[f] && !is_guarded(s, f);
}

static pc_status cancel_round(search *s, pc_index *cancelled, pc_context *ctx) {
    pc_status status = PC_OK;
    plan *plans = NULL;
    size_t count = 0;
    for (pc_index f = 0; f < s->mesh->face_count; f++)
        count += is_open(s, f);
    PC_TRY(pc_new(&plans, ctx, count));
    count = 0;
    for (pc_index f = 0; f < s->mesh->face_count; f++)
        if (is_open(s, f)) {
            s->hopeless[f] = !find_end(s, &plans[count], f);
            count += !s->hopeless[f];
        }
    qsort(plans, count, sizeof *plans, by_distance);
    /* Others may have come closer or gone: each plan is made anew before it is carried out, and waits where
     * its partner has gone and the next one is farther. */
    for (size_t i = 0; i < count; i++) {
        plan now;
        if (s->param->singular[plans[i].start] != PC_DISLOCATION) continue;
        s->hopeless[plans[i].start] = !find_end(s, &now, plans[i].start);
        if (s->hopeless[plans[i].start] || now.distance > 1.5 * plans[i].distance) continue;
        bool pair = now.exit == PC_NONE && s->param->singular[now.face] == PC_DISLOCATION;
        carry_out(s, &now);
        *cancelled += pair ? 2 : 1;
    }
    PC_TRY(pc_check_interrupt(ctx));
done:
    pc_free(ctx, plans);
    return status;
}

pc_status pc_dislocations_cancel(pc_param *param, pc_index *cancelled, pc_context *ctx, const pc_mesh *mesh,
                                 const pc_adjacency *adjacency, const uint8_t *guarded, double reach) {
    pc_status status = PC_OK;
    search s = {.mesh = mesh, .adjacency = adjacency, .param = param, .guarded = guarded, .reach = reach};
    *cancelled = 0;
    PC_TRY(pc_new(&s.centre, ctx, mesh->face_count));
    PC_TRY(pc_new(&s.hopeless, ctx, mesh->face_count));
    PC_TRY(pc_new(&s.labels, ctx, mesh->face_count));
    PC_TRY(pc_new(&s.heap, ctx, 4 * (size_t)mesh->face_count));
    for (pc_index f = 0; f < mesh->face_count; f++)
        s.centre[f] = centroid(mesh, f);
    for (int round = 0; round < MOST_ROUNDS; round++) {
        pc_index before = *cancelled;
        PC_TRY(cancel_round(&s, cancelled, ctx));
        if (*cancelled == before) break;
    }
    pc_reconstruct_flags(param, mesh);
done:
    pc_free(ctx, s.centre);
    pc_free(ctx, s.hopeless);
    pc_free(ctx, s.labels);
    pc_free(ctx, s.heap);
    return status;
}
