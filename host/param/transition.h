/* Exact changes of frame: quarter turns and whole periods, in integers. */
#ifndef PC_TRANSITION_H
#define PC_TRANSITION_H

#include "param.h"

/* p -> S^turn p + PC_PERIOD (a,b), S(s,t) = (t,-s). */
typedef struct pc_transition {
    int turn;
    int64_t a, b;
} pc_transition;

typedef struct pc_point2 {
    int64_t s, t;
} pc_point2;

static inline pc_point2 pc_point2_turned(pc_point2 p, int turn) {
    switch (turn & 3) {
    case 0:
        return p;
    case 1:
        return (pc_point2){p.t, -p.s};
    case 2:
        return (pc_point2){-p.s, -p.t};
    default:
        return (pc_point2){-p.t, p.s};
    }
}

static inline pc_point2 pc_transition_apply(pc_transition g, pc_point2 p) {
    p = pc_point2_turned(p, g.turn);
    return (pc_point2){p.s + g.a * PC_PERIOD, p.t + g.b * PC_PERIOD};
}

/* f after g. */
static inline pc_transition pc_transition_after(pc_transition f, pc_transition g) {
    pc_point2 ab = pc_point2_turned((pc_point2){g.a, g.b}, f.turn);
    return (pc_transition){(f.turn + g.turn) & 3, ab.s + f.a, ab.t + f.b};
}

static inline pc_transition pc_transition_inverse(pc_transition g) {
    int turn = (4 - g.turn) & 3;
    pc_point2 ab = pc_point2_turned((pc_point2){-g.a, -g.b}, turn);
    return (pc_transition){turn, ab.s, ab.t};
}

/* Brings the frame of the head of half-edge h to that of its tail. */
static inline pc_transition pc_transition_of(const pc_param *param, size_t h) {
    return (pc_transition){param->turn[h], param->shift[2 * h], param->shift[2 * h + 1]};
}

/* The corners of a face in the frame of its first corner, closed or not (the third by way of the second's
 * half-edge backwards: half-edge 3f+2). */
static inline void pc_param_corners(pc_point2 corner[3], const pc_param *param, const pc_index *triangle,
                                    size_t face) {
    pc_transition to1 = pc_transition_of(param, 3 * face);
    pc_transition to2 = pc_transition_inverse(pc_transition_of(param, 3 * face + 2));
    const int32_t *c = param->coordinate;
    const size_t v[3] = {triangle[3 * face], triangle[3 * face + 1], triangle[3 * face + 2]};
    corner[0] = (pc_point2){c[2 * v[0]], c[2 * v[0] + 1]};
    corner[1] = pc_transition_apply(to1, (pc_point2){c[2 * v[1]], c[2 * v[1] + 1]});
    corner[2] = pc_transition_apply(to2, (pc_point2){c[2 * v[2]], c[2 * v[2] + 1]});
}

/* Twice the signed area of the triangle p q r. */
static inline int64_t pc_point2_area(pc_point2 p, pc_point2 q, pc_point2 r) {
    return (q.s - p.s) * (r.t - p.t) - (r.s - p.s) * (q.t - p.t);
}

#endif
