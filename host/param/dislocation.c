#include "dislocation.h"
#include "coupling.h"
#include "memory.h"
#include "reconstruct.h"
#include "transition.h"
#include "vec3.h"
#include <omp.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROUNDS = 16, LEAST_HEAP = 4096 };
enum { MOST_WALKERS = 4 }; /* each has a label for every face */

/* One search: distances from a dislocation over the faces, its shift carried along. */
typedef struct label {
    double distance;
    pc_index stamp; /* of the search; SETTLED is added where the distance is final */
    pc_index from;  /* half-edge by which the face was entered, in the face before; PC_NONE at the start */
    int32_t burgers[2]; /* whole periods, in the frame of the face's first corner */
} label;

enum { SETTLED = 1, NEXT_STAMP = 2 };

typedef struct heap_entry {
    double distance;
    pc_index face;
} heap_entry;

/* Where a dislocation could vanish: at `face`, or out of the border half-edge `exit`. */
typedef struct ending {
    double distance;
    pc_index face, exit;
    size_t path; /* in the trail, from here on the half-edges on the way */
    size_t path_count;
} ending;

/* The nearest endings of a dislocation, in order. Endings only vanish, and ways do not depend on what has:
 * while one of these is there, nothing has to be searched for again. */
typedef struct plan {
    pc_index start;
    pc_point2 burgers; /* before anything was cancelled */
    int trail;         /* that has the endings, */
    size_t first;      /* from here on */
    size_t count;
    size_t chosen; /* of them */
    bool all;      /* there are no others within reach */
} plan;

typedef struct trail {
    pc_index *half;
    size_t count, room;
    ending *ending;
    size_t ending_count, ending_room;
} trail;

/* Who searches: several do at the same time, while nothing changes. */
typedef struct walker {
    label *labels;
    heap_entry *heap;
    size_t heap_count, heap_room;
    pc_index stamp;
    trail trail;
    pc_status status;
} walker;

struct pc_dislocation_plans {
    plan *plan;
    size_t count;
    pc_index *plan_of; /* per face: one more than its plan, or 0 */
    pc_vec3 *centre;   /* per face */
    walker walker[MOST_WALKERS];
    int walker_count;
};

typedef struct search {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    pc_param *param;
    const uint8_t *guarded; /* per vertex, or NULL */
    double reach;
    pc_dislocation_plans *plans;
} search;

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

static void push(walker *w, double distance, pc_index face) {
    size_t i = w->heap_count++;
    heap_entry entry = {distance, face};
    for (; i > 0 && is_before(entry, w->heap[(i - 1) / 2]); i = (i - 1) / 2)
        w->heap[i] = w->heap[(i - 1) / 2];
    w->heap[i] = entry;
}

static heap_entry pop(walker *w) {
    heap_entry top = w->heap[0], last = w->heap[--w->heap_count];
    size_t i = 0;
    for (;;) {
        size_t child = 2 * i + 1;
        if (child >= w->heap_count) break;
        if (child + 1 < w->heap_count && is_before(w->heap[child + 1], w->heap[child])) child++;
        if (!is_before(w->heap[child], last)) break;
        w->heap[i] = w->heap[child];
        i = child;
    }
    w->heap[i] = last;
    return top;
}

static bool is_guarded(const search *s, pc_index f) {
    const pc_index *t = s->mesh->triangle + 3 * (size_t)f;
    return s->guarded && (s->guarded[t[0]] || s->guarded[t[1]] || s->guarded[t[2]]);
}

/* Whether a shift that arrives could have vanished there before anything was cancelled. */
static bool took_in(const search *s, pc_index f, pc_point2 burgers) {
    const pc_index k = s->plans->plan_of[f];
    if (k) {
        const pc_point2 own = s->plans->plan[k - 1].burgers;
        return own.s + burgers.s == 0 && own.t + burgers.t == 0 && !is_guarded(s, f);
    }
    return s->param->singular[f] == PC_FIELD_SINGULARITY && !is_guarded(s, f);
}

/* ... and whether it still can. */
static bool stands(const search *s, const ending *e) {
    if (e->exit != PC_NONE) return true;
    return !is_guarded(s, e->face) && (s->param->singular[e->face] == PC_FIELD_SINGULARITY ||
                                       s->param->singular[e->face] == PC_DISLOCATION);
}

static void relax(walker *w, const search *s, pc_index h, double distance, pc_point2 burgers) {
    pc_index face = s->adjacency->twin[h] / 3;
    label *l = &w->labels[face];
    if (l->stamp == w->stamp + SETTLED || (l->stamp == w->stamp && l->distance <= distance)) return;
    *l = (label){distance, w->stamp, h, {(int32_t)burgers.s, (int32_t)burgers.t}};
    push(w, distance, face);
}

static pc_point2 burgers_at(const walker *w, pc_index face) {
    const int32_t *b = w->labels[face].burgers;
    return (pc_point2){b[0], b[1]};
}

/* One more ending of plan p, by the way that the labels tell. */
static pc_status keep(walker *w, plan *p, pc_context *ctx, pc_index face, pc_index exit) {
    pc_status status = PC_OK;
    trail *t = &w->trail;
    ending e = {.distance = w->labels[face].distance, .face = face, .exit = exit, .path = t->count};
    for (pc_index f = face; w->labels[f].from != PC_NONE; f = w->labels[f].from / 3)
        e.path_count++;
    if (t->count + e.path_count > t->room) {
        t->room = 2 * t->room + e.path_count;
        PC_TRY(pc_resize(&t->half, ctx, t->room));
    }
    if (t->ending_count == t->ending_room) {
        t->ending_room = 2 * t->ending_room + 64;
        PC_TRY(pc_resize(&t->ending, ctx, t->ending_room));
    }
    t->count += e.path_count;
    pc_index f = face;
    for (size_t i = e.path_count; i-- > 0; f = w->labels[f].from / 3)
        t->half[e.path + i] = w->labels[f].from;
    t->ending[t->ending_count++] = e;
    p->count++;
done:
    return status;
}

/* Keeps a settled face if p can end there, and labels its neighbours. No way leads on past a border. */
static pc_status expand(walker *w, const search *s, plan *p, pc_context *ctx, pc_index face) {
    pc_status status = PC_OK;
    const pc_vec3 *centre = s->plans->centre;
    const pc_point2 burgers = burgers_at(w, face);
    const double distance = w->labels[face].distance;
    if (face != p->start && took_in(s, face, burgers)) PC_TRY(keep(w, p, ctx, face, PC_NONE));
    for (pc_index h = 3 * face; h < 3 * face + 3; h++) {
        pc_index twin = s->adjacency->twin[h];
        if (twin == PC_NONE) {
            PC_TRY(keep(w, p, ctx, face, h));
            p->all = true;
            break;
        }
        relax(w, s, h, distance + pc_distance(centre[face], centre[twin / 3]), carried(s, h, burgers));
    }
done:
    return status;
}

/* Dijkstra over the faces for the `wanted` nearest endings within reach. */
static pc_status find_endings(walker *w, const search *s, plan *p, pc_context *ctx, size_t wanted) {
    pc_status status = PC_OK;
    p->trail = (int)(w - s->plans->walker);
    p->first = w->trail.ending_count, p->count = 0;
    w->stamp += NEXT_STAMP;
    w->heap_count = 0;
    w->labels[p->start] = (label){0, w->stamp, PC_NONE, {(int32_t)p->burgers.s, (int32_t)p->burgers.t}};
    push(w, 0, p->start);
    while (p->count < wanted && !p->all) {
        if (w->heap_count + 3 > w->heap_room) {
            PC_TRY(pc_resize(&w->heap, ctx, 2 * w->heap_room));
            w->heap_room *= 2;
        }
        if (w->heap_count == 0) break;
        heap_entry top = pop(w);
        label *l = &w->labels[top.face];
        if (l->stamp == w->stamp + SETTLED || top.distance > l->distance) continue;
        if (top.distance > s->reach) break;
        l->stamp = w->stamp + SETTLED;
        PC_TRY(expand(w, s, p, ctx, top.face));
    }
    p->all = p->all || p->count < wanted;
done:
    return status;
}

static const ending *ending_of(const search *s, const plan *p) {
    return s->plans->walker[p->trail].trail.ending + p->first + p->chosen;
}

typedef enum choice { NOTHING, CHOSEN, UNKNOWN } choice;

/* Chooses the nearest ending within `limit` that is still there. UNKNOWN: there may be others. */
static choice choose(const search *s, plan *p, double limit) {
    const ending *e = p->count ? s->plans->walker[p->trail].trail.ending + p->first : NULL;
    for (p->chosen = 0; p->chosen < p->count; p->chosen++) {
        if (e[p->chosen].distance > limit) return NOTHING;
        if (stands(s, e + p->chosen)) return CHOSEN;
    }
    return p->all ? NOTHING : UNKNOWN;
}

/* Searches on until that is known. */
static pc_status search_on(choice *found, walker *w, const search *s, plan *p, pc_context *ctx,
                           double limit) {
    pc_status status = PC_OK;
    while (*found == UNKNOWN) {
        PC_TRY(find_endings(w, s, p, ctx, p->count ? 8 * p->count : 1));
        *found = choose(s, p, limit);
    }
done:
    return status;
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

static void carry_out(search *s, const plan *p) {
    const ending *e = ending_of(s, p);
    const pc_index *way = s->plans->walker[p->trail].trail.half + e->path;
    pc_point2 burgers = p->burgers;
    for (size_t i = 0; i < e->path_count; i++) {
        move_across(s, way[i], burgers);
        burgers = carried(s, way[i], burgers);
    }
    if (e->exit != PC_NONE) move_across(s, e->exit, burgers);
    flag(s->param, p->start);
    flag(s->param, e->face);
}

/* An open dislocation and how far it has to go. */
typedef struct candidate {
    double distance;
    plan *plan;
} candidate;

static int by_distance(const void *a, const void *b) {
    const candidate *p = a, *q = b;
    if (p->distance != q->distance) return p->distance < q->distance ? -1 : 1;
    return p->plan->start < q->plan->start ? -1 : p->plan->start > q->plan->start;
}

static bool is_open(const search *s, pc_index f) {
    return s->param->singular[f] == PC_DISLOCATION && !is_guarded(s, f);
}

/* The open dislocations with an ending, each with the nearest one. Searches change nothing that others read.
 */
static pc_status make_plans(candidate *open, size_t *open_count, search *s, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_dislocation_plans *plans = s->plans;
    choice *found = NULL;
    *open_count = 0;
    PC_TRY(pc_new(&found, ctx, plans->count));
    for (size_t i = 0; i < plans->count; i++)
        found[i] = is_open(s, plans->plan[i].start) ? choose(s, plans->plan + i, s->reach) : NOTHING;
#pragma omp parallel for schedule(dynamic, 1) num_threads(plans->walker_count)
    for (size_t i = 0; i < plans->count; i++) {
        walker *w = &plans->walker[omp_get_thread_num()];
        if (w->status == PC_OK) w->status = search_on(&found[i], w, s, plans->plan + i, ctx, s->reach);
    }
    for (int t = 0; t < plans->walker_count; t++)
        PC_TRY(plans->walker[t].status);
    for (size_t i = 0; i < plans->count; i++)
        if (found[i] == CHOSEN)
            open[(*open_count)++] = (candidate){ending_of(s, plans->plan + i)->distance, plans->plan + i};
done:
    pc_free(ctx, found);
    return status;
}

/* The closest first. One whose partner has gone waits for the next round if the next ending is farther. */
static pc_status cancel_round(search *s, candidate *open, size_t open_count, pc_index *cancelled,
                              pc_context *ctx) {
    pc_status status = PC_OK;
    qsort(open, open_count, sizeof *open, by_distance);
    for (size_t i = 0; i < open_count; i++) {
        plan *p = open[i].plan;
        const double limit = fmin(s->reach, 1.5 * open[i].distance);
        if (s->param->singular[p->start] != PC_DISLOCATION) continue;
        choice found = stands(s, ending_of(s, p)) ? CHOSEN : choose(s, p, limit);
        PC_TRY(search_on(&found, s->plans->walker, s, p, ctx, limit));
        if (found != CHOSEN) continue;
        const ending *e = ending_of(s, p);
        const bool pair = e->exit == PC_NONE && s->param->singular[e->face] == PC_DISLOCATION;
        carry_out(s, p);
        *cancelled += pair ? 2 : 1;
    }
    PC_TRY(pc_check_interrupt(ctx));
done:
    return status;
}

static pc_status cancel(search *s, pc_index *cancelled, pc_context *ctx) {
    pc_status status = PC_OK;
    candidate *open = NULL;
    size_t open_count;
    PC_TRY(pc_new(&open, ctx, s->plans->count));
    for (int round = 0; round < MOST_ROUNDS; round++) {
        pc_index before = *cancelled;
        PC_TRY(make_plans(open, &open_count, s, ctx));
        PC_TRY(cancel_round(s, open, open_count, cancelled, ctx));
        if (*cancelled == before) break;
    }
done:
    pc_free(ctx, open);
    return status;
}

static pc_status list_dislocations(search *s, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_dislocation_plans *plans = s->plans;
    size_t count = 0;
    for (pc_index f = 0; f < s->mesh->face_count; f++)
        count += is_open(s, f);
    PC_TRY(pc_new(&plans->plan, ctx, count));
    PC_TRY(pc_new(&plans->plan_of, ctx, s->mesh->face_count));
    for (pc_index f = 0; f < s->mesh->face_count; f++) {
        if (!is_open(s, f)) continue;
        const pc_transition g = around(s->param, f);
        plans->plan[plans->count++] = (plan){.start = f, .burgers = {g.a, g.b}};
        plans->plan_of[f] = (pc_index)plans->count;
    }
done:
    return status;
}

static pc_status make_walkers(pc_dislocation_plans *plans, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    const int threads = omp_get_max_threads();
    plans->walker_count = threads < MOST_WALKERS ? threads : MOST_WALKERS;
    for (int t = 0; t < plans->walker_count; t++) {
        walker *w = &plans->walker[t];
        w->heap_room = LEAST_HEAP;
        PC_TRY(pc_new(&w->labels, ctx, mesh->face_count));
        PC_TRY(pc_new(&w->heap, ctx, w->heap_room));
    }
    PC_TRY(pc_new(&plans->centre, ctx, mesh->face_count));
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < mesh->face_count; f++)
        plans->centre[f] = centroid(mesh, f);
done:
    return status;
}

pc_status pc_dislocations_cancel(pc_param *param, pc_index *cancelled, pc_dislocation_plans **known,
                                 pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency,
                                 const uint8_t *guarded, double reach) {
    pc_status status = PC_OK;
    pc_dislocation_plans *own = NULL, **plans = known ? known : &own;
    search s = {.mesh = mesh, .adjacency = adjacency, .param = param, .guarded = guarded, .reach = reach};
    *cancelled = 0;
    if (!*plans) {
        PC_TRY(pc_new(plans, ctx, 1));
        s.plans = *plans;
        PC_TRY(make_walkers(s.plans, ctx, mesh));
        PC_TRY(list_dislocations(&s, ctx));
    }
    s.plans = *plans;
    PC_TRY(cancel(&s, cancelled, ctx));
    pc_reconstruct_flags(param, mesh);
done:
    pc_dislocation_plans_free(own, ctx);
    return status;
}

void pc_dislocation_plans_free(pc_dislocation_plans *plans, pc_context *ctx) {
    if (!plans) return;
    for (int t = 0; t < MOST_WALKERS; t++) {
        walker *w = &plans->walker[t];
        pc_free(ctx, w->labels);
        pc_free(ctx, w->heap);
        pc_free(ctx, w->trail.half);
        pc_free(ctx, w->trail.ending);
    }
    pc_free(ctx, plans->plan);
    pc_free(ctx, plans->plan_of);
    pc_free(ctx, plans->centre);
    pc_free(ctx, plans);
}
