/* Parameterizations that are known: maps of a plane, wrapped into periods and turned at random at every
 * vertex. */
#ifndef PC_PLANE_PARAM_H
#define PC_PLANE_PARAM_H

#include "memory.h"
#include "random.h"
#include "testing.h"
#include "transition.h"
#include <math.h>

typedef struct plane_param {
    pc_param param;
    pc_point2 *global; /* per vertex: its place in the plane, odd */
    int *frame;        /* per vertex: the quarter turns of its frame against the plane's */
} plane_param;

/* What the plane's (s,t) periods, 2 per vertex, become in frames of their own. The mesh needs no edge of a
 * period or more. */
static inline void make_plane_param(plane_param *p, pc_context *ctx, const pc_mesh *mesh,
                                    const double *periods, uint64_t seed) {
    pc_param *param = &p->param;
    pc_random random = {seed};
    *param =
        (pc_param){.vertex_count = mesh->vertex_count, .face_count = mesh->face_count, .period_length = 1};
    assert_ok(ctx, pc_new(&param->coordinate, ctx, 2 * (size_t)mesh->vertex_count));
    assert_ok(ctx, pc_new(&param->turn, ctx, 3 * (size_t)mesh->face_count));
    assert_ok(ctx, pc_new(&param->shift, ctx, 6 * (size_t)mesh->face_count));
    assert_ok(ctx, pc_new(&param->singular, ctx, mesh->face_count));
    assert_ok(ctx, pc_new(&p->global, ctx, mesh->vertex_count));
    assert_ok(ctx, pc_new(&p->frame, ctx, mesh->vertex_count));
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        p->global[v] =
            (pc_point2){llround(periods[2 * v] * PC_PERIOD) | 1, llround(periods[2 * v + 1] * PC_PERIOD) | 1};
        p->frame[v] = (int)(pc_random_next(&random) % 4);
        pc_point2 own = pc_point2_turned(p->global[v], p->frame[v]);
        param->coordinate[2 * v] = (int32_t)(own.s & (PC_PERIOD - 1));
        param->coordinate[2 * v + 1] = (int32_t)(own.t & (PC_PERIOD - 1));
    }
    for (pc_index h = 0; h < 3 * mesh->face_count; h++) {
        size_t i = pc_tail(mesh, h), j = pc_head(mesh, h);
        const int32_t *c = param->coordinate;
        pc_point2 jump = {p->global[j].s - p->global[i].s, p->global[j].t - p->global[i].t};
        jump = pc_point2_turned(jump, p->frame[i]);
        param->turn[h] = (uint8_t)((p->frame[i] - p->frame[j] + 4) % 4);
        pc_point2 own = pc_point2_turned((pc_point2){c[2 * j], c[2 * j + 1]}, param->turn[h]);
        int64_t s = c[2 * i] + jump.s - own.s, t = c[2 * i + 1] + jump.t - own.t;
        assert_true(s % PC_PERIOD == 0 && t % PC_PERIOD == 0);
        param->shift[2 * h] = (int32_t)(s / PC_PERIOD);
        param->shift[2 * h + 1] = (int32_t)(t / PC_PERIOD);
    }
}

/* (s,t) = A (x,y). */
static inline void make_linear_param(plane_param *p, pc_context *ctx, const pc_mesh *mesh, const double a[4],
                                     uint64_t seed) {
    double *periods;
    assert_ok(ctx, pc_new(&periods, ctx, 2 * (size_t)mesh->vertex_count));
    for (size_t i = 0; i < 2 * (size_t)mesh->vertex_count; i++)
        periods[i] =
            a[2 * (i % 2)] * mesh->position[i / 2 * 3] + a[2 * (i % 2) + 1] * mesh->position[i / 2 * 3 + 1];
    make_plane_param(p, ctx, mesh, periods, seed);
    pc_free(ctx, periods);
}

static inline void free_plane_param(plane_param *p, pc_context *ctx) {
    pc_param_free(&p->param, ctx);
    pc_free(ctx, p->global);
    pc_free(ctx, p->frame);
}

#endif
