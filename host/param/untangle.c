#include "untangle.h"
#include "cone.h"
#include "memory.h"
#include "reconstruct.h"
#include "transition.h"
#include <math.h>
#include <stdlib.h>

enum { ROUNDS = 8, PATIENCE = 2, SWEEPS = 40, ACTIVE = 1, WAITING = 2, GRAIN = 4096 };
enum { STILL = PC_PERIOD / 4096 }; /* shorter moves are not worth the neighbours' next one */

typedef struct patch {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    pc_param *param;
    uint8_t *active;  /* per vertex: 0, ACTIVE, and WAITING where a neighbour has moved since its last move */
    uint8_t *tangled; /* per face */
} patch;

static pc_point2 coordinate(const pc_param *param, size_t v) {
    return (pc_point2){param->coordinate[2 * v], param->coordinate[2 * v + 1]};
}

/* A field singularity is tangled where one of its three parts around the cone is flipped. */
static bool is_tangled(const patch *p, pc_index f) {
    pc_point2 cone, corner[3];
    if (p->param->singular[f] == PC_FLIPPED) return true;
    if (p->param->singular[f] != PC_FIELD_SINGULARITY || !pc_cone_point(&cone, p->param, f)) return false;
    pc_param_corners(corner, p->param, p->mesh->triangle, f);
    pc_transition across = pc_transition_of(p->param, 3 * (size_t)f + 1);
    pc_point2 third = pc_transition_apply(
        pc_transition_of(p->param, 3 * (size_t)f),
        pc_transition_apply(across, coordinate(p->param, p->mesh->triangle[3 * (size_t)f + 2])));
    return pc_point2_area(corner[0], corner[1], cone) <= 0 ||
           pc_point2_area(corner[2], corner[0], cone) <= 0 || pc_point2_area(corner[1], third, cone) <= 0;
}

typedef struct mean {
    double s, t, weight;
    pc_point2 seen[64]; /* neighbours in this vertex's frame, to test jumps */
    int count;
} mean;

static void add_to_mean(mean *m, pc_point2 p) {
    m->s += (double)p.s, m->t += (double)p.t, m->weight += 1;
    if (m->count < 64) m->seen[m->count++] = p;
}

/* Of the spoke h, its face's cone if it has one, and the last neighbour of an open fan. */
static void gather(mean *m, const patch *p, pc_index v) {
    const pc_adjacency *a = p->adjacency;
    pc_index first = a->vertex_half[v], h = first;
    while (h != PC_NONE) {
        pc_index back = pc_prev(h);
        pc_point2 cone;
        add_to_mean(
            m, pc_transition_apply(pc_transition_of(p->param, h), coordinate(p->param, pc_head(p->mesh, h))));
        if (p->param->singular[h / 3] == PC_FIELD_SINGULARITY && pc_cone_point(&cone, p->param, h / 3)) {
            size_t base = 3 * (size_t)(h / 3);
            if (h % 3 == 1)
                cone = pc_transition_apply(pc_transition_inverse(pc_transition_of(p->param, base)), cone);
            if (h % 3 == 2) cone = pc_transition_apply(pc_transition_of(p->param, base + 2), cone);
            add_to_mean(m, cone);
        }
        if (a->twin[back] == PC_NONE)
            add_to_mean(m, pc_transition_apply(pc_transition_inverse(pc_transition_of(p->param, back)),
                                               coordinate(p->param, pc_tail(p->mesh, back))));
        h = pc_turn_ccw(a, h);
        if (h == first) break;
    }
}

static void wake_neighbours(const patch *p, pc_index v) {
    const pc_adjacency *a = p->adjacency;
    pc_index first = a->vertex_half[v], h = first;
    do {
        pc_index w = pc_head(p->mesh, h);
        if (p->active[w]) p->active[w] = WAITING;
        h = pc_turn_ccw(a, h);
    } while (h != first);
}

/* Not for vertices of the border. */
static void move_vertex(const patch *p, pc_index v) {
    mean m;
    m.s = m.t = m.weight = 0, m.count = 0;
    gather(&m, p, v);
    p->active[v] = ACTIVE;
    if (m.weight == 0) return;
    int64_t s = 2 * llround(m.s / m.weight / 2) + 1, t = 2 * llround(m.t / m.weight / 2) + 1;
    for (int i = 0; i < m.count; i++) {
        int64_t ds = m.seen[i].s - s, dt = m.seen[i].t - t;
        if (ds <= -PC_PERIOD || ds >= PC_PERIOD || dt <= -PC_PERIOD || dt >= PC_PERIOD) return;
    }
    int32_t *at = p->param->coordinate + 2 * (size_t)v;
    if (llabs(s - at[0]) > STILL || llabs(t - at[1]) > STILL) wake_neighbours(p, v);
    at[0] = (int32_t)s, at[1] = (int32_t)t;
}

/* Border vertices stay: the mean would pull them inwards. */
static pc_index activate(patch *p, pc_index *list, int rings) {
    pc_index count = 0;
    for (pc_index f = 0; f < p->mesh->face_count; f++)
        for (int k = 0; k < 3 && p->tangled[f]; k++)
            if (!p->active[p->mesh->triangle[3 * (size_t)f + (size_t)k]]) {
                p->active[p->mesh->triangle[3 * (size_t)f + (size_t)k]] = WAITING;
                list[count++] = p->mesh->triangle[3 * (size_t)f + (size_t)k];
            }
    for (pc_index from = 0; rings > 0; rings--) {
        pc_index to = count;
        for (; from < to; from++) {
            pc_index first = p->adjacency->vertex_half[list[from]], h = first;
            while (h != PC_NONE) {
                pc_index w = pc_head(p->mesh, h);
                if (!p->active[w]) p->active[w] = WAITING, list[count++] = w;
                h = pc_turn_ccw(p->adjacency, h);
                if (h == first) break;
            }
        }
    }
    return count;
}

pc_status pc_untangle(pc_param *param, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    patch p = {.mesh = mesh, .adjacency = adjacency, .param = param};
    pc_index *list = NULL, least = PC_NONE;
    int idle = 0; /* rounds in a row that gained next to nothing */
    PC_TRY(pc_new(&p.active, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&p.tangled, ctx, mesh->face_count));
    PC_TRY(pc_new(&list, ctx, mesh->vertex_count));
    for (int round = 0; round < ROUNDS; round++) {
        pc_index tangled = 0, cones = 0;
#pragma omp parallel for schedule(static, GRAIN)
        for (pc_index f = 0; f < mesh->face_count; f++)
            p.tangled[f] = is_tangled(&p, f);
        pc_index count = activate(&p, list, round);
        for (pc_index f = 0; f < mesh->face_count; f++)
            if (p.tangled[f]) tangled++, cones += param->singular[f] == PC_FIELD_SINGULARITY;
        pc_log(ctx, PC_LOG_DEBUG, "untangle round %d: %u faces tangled, %u of them cones, %u vertices", round,
               tangled, cones, count);
        idle = tangled < 0.99 * least ? 0 : idle + 1;
        if (tangled < least) least = tangled;
        if (count == 0 || idle == PATIENCE) break;
        for (int sweep = 0; sweep < SWEEPS; sweep++) {
            for (pc_index i = 0; i < count; i++)
                if (p.active[list[i]] == WAITING && !adjacency->vertex_boundary[list[i]])
                    move_vertex(&p, list[i]);
            PC_TRY(pc_check_interrupt(ctx));
        }
        for (pc_index i = 0; i < count; i++)
            p.active[list[i]] = 0;
        pc_reconstruct_flags(param, mesh);
    }
done:
    pc_free(ctx, p.active);
    pc_free(ctx, p.tangled);
    pc_free(ctx, list);
    return status;
}
