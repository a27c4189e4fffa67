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

typedef enum plan_state { UNKNOWN, FOUND, HOPELESS } plan_state;

/* What a dislocation would do: vanish at `face`, or out of the border half-edge `exit`. Ends only vanish, so
 * the nearest one stays the nearest while it is there: nothing is searched for twice. */
typedef struct plan {
    double distance;
    plan_state state; /* HOPELESS: there is no end within reach, and there will be none */
    pc_index start, face, exit;
    pc_point2 burgers; /* on arrival */
    int trail;         /* that has the half-edges on the way, */
    size_t path;       /* from here on */
    size_t path_count;
} plan;

typedef struct trail {
    pc_index *half;
    size_t count, room;
} trail;

struct pc_dislocation_plans {
    plan *plan;
    size_t count;
    trail trail[MOST_WALKERS];
};

typedef struct search {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    pc_param *param;
    const uint8_t *guarded; /* per vertex, or NULL */
    double reach;
    pc_vec3 *centre; /* per face */
    pc_dislocation_plans *plans;
    struct walker *walker;
    int walker_count;
} search;

/* Who searches: several do at the same time, while nothing changes. */
typedef struct walker {
    const search *s;
    label *labels;
    heap_entry *heap;
    size_t heap_count, heap_room;
    pc_index stamp;
    int trail; /* its own */
    pc_status status;
} walker;

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

static bool takes_in(const search *s, pc_index f, pc_point2 burgers) {
    if (is_guarded(s, f)) return false;
    if (s->param->singular[f] == PC_FIELD_SINGULARITY) return true;
    if (s->param->singular[f] != PC_DISLOCATION) return false;
    pc_transition g = around(s->param, f);
    return g.a + burgers.s == 0 && g.b + burgers.t == 0;
}

static void relax(walker *w, pc_index h, double distance, pc_point2 burgers) {
    pc_index face = w->s->adjacency->twin[h] / 3;
    label *l = &w->labels[face];
    if (l->stamp == w->stamp + SETTLED || (l->stamp == w->stamp && l->distance <= distance)) return;
    *l = (label){distance, w->stamp, h, {(int32_t)burgers.s, (int32_t)burgers.t}};
    push(w, distance, face);
}

static pc_point2 burgers_at(const walker *w, pc_index face) {
    const int32_t *b = w->labels[face].burgers;
    return (pc_point2){b[0], b[1]};
}

/* The way that the labels tell. */
static pc_status keep_path(walker *w, plan *p, pc_context *ctx) {
    pc_status status = PC_OK;
    trail *kept = &w->s->plans->trail[w->trail];
    p->path_count = 0;
    for (pc_index f = p->face; w->labels[f].from != PC_NONE; f = w->labels[f].from / 3)
        p->path_count++;
    if (kept->count + p->path_count > kept->room) {
        kept->room = 2 * kept->room + p->path_count;
        PC_TRY(pc_resize(&kept->half, ctx, kept->room));
    }
    p->trail = w->trail;
    p->path = kept->count;
    kept->count += p->path_count;
    pc_index f = p->face;
    for (size_t i = p->path_count; i-- > 0; f = w->labels[f].from / 3)
        kept->half[p->path + i] = w->labels[f].from;
done:
    return status;
}

/* True where the search ends at `face`, which it has settled; otherwise its neighbours are labelled. */
static bool expand(walker *w, plan *p, pc_index face, double distance) {
    const search *s = w->s;
    const pc_point2 burgers = burgers_at(w, face);
    if (face != p->start && takes_in(s, face, burgers)) return true;
    for (pc_index h = 3 * face; h < 3 * face + 3; h++) {
        pc_index twin = s->adjacency->twin[h];
        if (twin == PC_NONE) {
            p->exit = h;
            return true;
        }
        relax(w, h, distance + pc_distance(s->centre[face], s->centre[twin / 3]), carried(s, h, burgers));
    }
    return false;
}

/* Dijkstra over the faces, to the first one that takes the shift in. Where there is none within `reach` the
 * plan stays as it was. */
static pc_status find_end(walker *w, plan *p, bool *found, pc_context *ctx, double reach) {
    pc_status status = PC_OK;
    pc_transition g = around(w->s->param, p->start);
    plan made = {.state = FOUND, .start = p->start, .exit = PC_NONE};
    *found = false;
    w->stamp += NEXT_STAMP;
    w->heap_count = 0;
    w->labels[p->start] = (label){0, w->stamp, PC_NONE, {(int32_t)g.a, (int32_t)g.b}};
    push(w, 0, p->start);
    while (w->heap_count && !*found) {
        if (w->heap_count + 3 > w->heap_room) {
            PC_TRY(pc_resize(&w->heap, ctx, 2 * w->heap_room));
            w->heap_room *= 2;
        }
        heap_entry top = pop(w);
        label *l = &w->labels[top.face];
        if (l->stamp == w->stamp + SETTLED || top.distance > l->distance) continue;
        if (top.distance > reach) break;
        l->stamp = w->stamp + SETTLED;
        made.distance = top.distance, made.face = top.face;
        *found = expand(w, &made, top.face, top.distance);
    }
    if (!*found) goto done;
    made.burgers = burgers_at(w, made.face);
    PC_TRY(keep_path(w, &made, ctx));
    *p = made;
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
    pc_transition g = around(s->param, p->start);
    pc_point2 burgers = {g.a, g.b};
    const pc_index *way = s->plans->trail[p->trail].half + p->path;
    for (size_t i = 0; i < p->path_count; i++) {
        move_across(s, way[i], burgers);
        burgers = carried(s, way[i], burgers);
    }
    if (p->exit != PC_NONE) move_across(s, p->exit, burgers);
    flag(s->param, p->start);
    flag(s->param, p->face);
}

static int by_distance(const void *a, const void *b) {
    const plan *p = *(const plan *const *)a, *q = *(const plan *const *)b;
    if (p->distance != q->distance) return p->distance < q->distance ? -1 : 1;
    return p->start < q->start ? -1 : p->start > q->start;
}

static bool is_open(const search *s, pc_index f) {
    return s->param->singular[f] == PC_DISLOCATION && !is_guarded(s, f);
}

/* The end of the plan is still there. */
static bool stands(const search *s, const plan *p) {
    return p->state == FOUND && (p->exit != PC_NONE || takes_in(s, p->face, p->burgers));
}

/* The open dislocations with an end, each with the nearest one. Searches change nothing that others read. */
static pc_status make_plans(plan **open, size_t *open_count, search *s, plan *plans, pc_context *ctx) {
    *open_count = 0;
#pragma omp parallel for schedule(dynamic, 1) num_threads(s->walker_count)
    for (size_t i = 0; i < s->plans->count; i++) {
        plan *p = plans + i;
        walker *w = &s->walker[omp_get_thread_num()];
        bool found;
        if (w->status != PC_OK || !is_open(s, p->start) || p->state == HOPELESS || stands(s, p)) continue;
        w->status = find_end(w, p, &found, ctx, s->reach);
        if (!found) p->state = HOPELESS;
    }
    for (int t = 0; t < s->walker_count; t++)
        if (s->walker[t].status != PC_OK) return s->walker[t].status;
    for (size_t i = 0; i < s->plans->count; i++)
        if (is_open(s, plans[i].start) && plans[i].state == FOUND) open[(*open_count)++] = plans + i;
    return PC_OK;
}

/* The closest first. One whose partner has gone waits for the next round if the next end is farther. */
static pc_status cancel_round(search *s, plan **open, size_t open_count, pc_index *cancelled,
                              pc_context *ctx) {
    pc_status status = PC_OK;
    qsort(open, open_count, sizeof(plan *), by_distance);
    for (size_t i = 0; i < open_count; i++) {
        plan *p = open[i];
        bool found = true;
        if (s->param->singular[p->start] != PC_DISLOCATION) continue;
        if (!stands(s, p)) PC_TRY(find_end(s->walker, p, &found, ctx, fmin(s->reach, 1.5 * p->distance)));
        if (!found) continue;
        bool pair = p->exit == PC_NONE && s->param->singular[p->face] == PC_DISLOCATION;
        carry_out(s, p);
        *cancelled += pair ? 2 : 1;
    }
    PC_TRY(pc_check_interrupt(ctx));
done:
    return status;
}

/* In rounds. What the first one finds is kept for a later call. */
static pc_status cancel(search *s, pc_index *cancelled, pc_context *ctx) {
    pc_status status = PC_OK;
    plan *plans = NULL, **open = NULL;
    size_t open_count;
    PC_TRY(pc_new(&plans, ctx, s->plans->count));
    PC_TRY(pc_new(&open, ctx, s->plans->count)); /* NOLINT(bugprone-sizeof-expression): pointers */
    memcpy(plans, s->plans->plan, s->plans->count * sizeof *plans);
    for (int round = 0; round < MOST_ROUNDS; round++) {
        pc_index before = *cancelled;
        PC_TRY(make_plans(open, &open_count, s, plans, ctx));
        if (round == 0) memcpy(s->plans->plan, plans, s->plans->count * sizeof *plans);
        PC_TRY(cancel_round(s, open, open_count, cancelled, ctx));
        if (*cancelled == before) break;
    }
done:
    pc_free(ctx, plans);
    pc_free(ctx, open);
    return status;
}

static pc_status list_dislocations(search *s, pc_context *ctx) {
    pc_status status = PC_OK;
    size_t count = 0;
    for (pc_index f = 0; f < s->mesh->face_count; f++)
        count += is_open(s, f);
    PC_TRY(pc_new(&s->plans->plan, ctx, count));
    for (pc_index f = 0; f < s->mesh->face_count; f++)
        if (is_open(s, f)) s->plans->plan[s->plans->count++].start = f;
done:
    return status;
}

static pc_status make_walkers(search *s, pc_context *ctx) {
    pc_status status = PC_OK;
    const int threads = omp_get_max_threads();
    s->walker_count = threads < MOST_WALKERS ? threads : MOST_WALKERS;
    PC_TRY(pc_new(&s->walker, ctx, s->walker_count));
    for (int t = 0; t < s->walker_count; t++) {
        walker *w = &s->walker[t];
        *w = (walker){.s = s, .trail = t, .heap_room = LEAST_HEAP};
        PC_TRY(pc_new(&w->labels, ctx, s->mesh->face_count));
        PC_TRY(pc_new(&w->heap, ctx, w->heap_room));
    }
done:
    return status;
}

static void free_walkers(search *s, pc_context *ctx) {
    for (int t = 0; s->walker && t < s->walker_count; t++) {
        pc_free(ctx, s->walker[t].labels);
        pc_free(ctx, s->walker[t].heap);
    }
    pc_free(ctx, s->walker);
}

pc_status pc_dislocations_cancel(pc_param *param, pc_index *cancelled, pc_dislocation_plans **known,
                                 pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency,
                                 const uint8_t *guarded, double reach) {
    pc_status status = PC_OK;
    pc_dislocation_plans *own = NULL, **plans = known ? known : &own;
    search s = {.mesh = mesh, .adjacency = adjacency, .param = param, .guarded = guarded, .reach = reach};
    *cancelled = 0;
    PC_TRY(pc_new(&s.centre, ctx, mesh->face_count));
    PC_TRY(make_walkers(&s, ctx));
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < mesh->face_count; f++)
        s.centre[f] = centroid(mesh, f);
    if (!*plans) {
        PC_TRY(pc_new(plans, ctx, 1));
        s.plans = *plans;
        PC_TRY(list_dislocations(&s, ctx));
    }
    s.plans = *plans;
    PC_TRY(cancel(&s, cancelled, ctx));
    pc_reconstruct_flags(param, mesh);
done:
    pc_dislocation_plans_free(own, ctx);
    pc_free(ctx, s.centre);
    free_walkers(&s, ctx);
    return status;
}

void pc_dislocation_plans_free(pc_dislocation_plans *plans, pc_context *ctx) {
    if (!plans) return;
    pc_free(ctx, plans->plan);
    for (int t = 0; t < MOST_WALKERS; t++)
        pc_free(ctx, plans->trail[t].half);
    pc_free(ctx, plans);
}
