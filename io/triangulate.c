#include "triangulate.h"
#include "memory.h"
#include "vec3.h"
#include <math.h>

void pc_cutter_free(pc_cutter *cutter, pc_context *ctx) {
    pc_free(ctx, cutter->plane);
    pc_free(ctx, cutter->worth);
    pc_free(ctx, cutter->corner);
    pc_free(ctx, cutter->next);
    pc_free(ctx, cutter->prev);
    *cutter = (pc_cutter){0};
}

static pc_status make_room(pc_cutter *cutter, pc_context *ctx, size_t sides) {
    pc_status status = PC_OK;
    if (sides <= cutter->capacity) return PC_OK;
    pc_cutter_free(cutter, ctx);
    size_t room = sides + sides / 2;
    PC_TRY(pc_new(&cutter->plane, ctx, 2 * room));
    PC_TRY(pc_new(&cutter->worth, ctx, room));
    PC_TRY(pc_new(&cutter->corner, ctx, room));
    PC_TRY(pc_new(&cutter->next, ctx, room));
    PC_TRY(pc_new(&cutter->prev, ctx, room));
    cutter->capacity = room;
done:
    return status;
}

/* Newell's normal: twice the vector area, whatever the polygon's shape. */
static pc_vec3 normal_of(const pc_cutter *cutter, size_t sides, const double *position) {
    pc_vec3 origin = pc_vec3_at(position, cutter->corner[0]);
    pc_vec3 normal = {0, 0, 0};
    for (size_t i = 1; i + 1 < sides; i++) {
        pc_vec3 p = pc_sub(pc_vec3_at(position, cutter->corner[i]), origin);
        pc_vec3 q = pc_sub(pc_vec3_at(position, cutter->corner[i + 1]), origin);
        normal = pc_add(normal, pc_cross(p, q));
    }
    double length = pc_norm(normal);
    if (!(length > 0 && length < HUGE_VAL)) return (pc_vec3){0, 0, 1};
    return pc_scale(1 / length, normal);
}

static void project(pc_cutter *cutter, size_t sides, const double *position) {
    pc_vec3 z = normal_of(cutter, sides, position);
    pc_vec3 axis = fabs(z.x) < 0.6 ? (pc_vec3){1, 0, 0} : (pc_vec3){0, 1, 0};
    pc_vec3 x = pc_unit(pc_cross(axis, z));
    pc_vec3 y = pc_cross(z, x);
    pc_vec3 origin = pc_vec3_at(position, cutter->corner[0]);
    for (size_t i = 0; i < sides; i++) {
        pc_vec3 d = pc_sub(pc_vec3_at(position, cutter->corner[i]), origin);
        cutter->plane[2 * i] = pc_dot(d, x);
        cutter->plane[2 * i + 1] = pc_dot(d, y);
    }
}

static double turn(const double *a, const double *b, const double *c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static double square(const double *a, const double *b) {
    double x = b[0] - a[0];
    double y = b[1] - a[1];
    return x * x + y * y;
}

/* 1 for an equilateral triangle, 0 for a flat one, negative for one that is turned over. */
static double quality(const double *a, const double *b, const double *c) {
    double sum = square(a, b) + square(b, c) + square(c, a);
    return sum > 0 ? 3.4641016151377544 * turn(a, b, c) / sum : 0;
}

/* The two ways to cut a quad; a corner that looks inwards makes a turned triangle in the wrong one. */
static void cut_quad(const pc_cutter *cutter, pc_index *triangle) {
    const double *p = cutter->plane;
    const pc_index *c = cutter->corner;
    double even = fmin(quality(p, p + 2, p + 4), quality(p, p + 4, p + 6));
    double odd = fmin(quality(p + 2, p + 4, p + 6), quality(p + 2, p + 6, p));
    const pc_index cut[2][6] = {{c[0], c[1], c[2], c[0], c[2], c[3]}, {c[1], c[2], c[3], c[1], c[3], c[0]}};
    for (int i = 0; i < 6; i++)
        triangle[i] = cut[odd > even][i];
}

static bool same_point(const double *a, const double *b) {
    return a[0] == b[0] && a[1] == b[1];
}

/* An ear turns left and holds no other corner; only corners that do not turn left can lie in one. */
static double worth_of(const pc_cutter *cutter, pc_index i) {
    const double *plane = cutter->plane;
    const double *a = plane + 2 * (size_t)cutter->prev[i];
    const double *b = plane + 2 * (size_t)i;
    const double *c = plane + 2 * (size_t)cutter->next[i];
    double worth = quality(a, b, c);
    if (!(worth > 0)) return worth < 0 ? worth - 4 : -2;
    for (pc_index j = cutter->next[cutter->next[i]]; j != cutter->prev[i]; j = cutter->next[j]) {
        const double *p = plane + 2 * (size_t)j;
        if (turn(a, b, p) < 0 || turn(b, c, p) < 0 || turn(c, a, p) < 0) continue;
        if (same_point(p, a) || same_point(p, b) || same_point(p, c)) continue;
        if (turn(plane + 2 * (size_t)cutter->prev[j], p, plane + 2 * (size_t)cutter->next[j]) <= 0)
            return worth - 2;
    }
    return worth;
}

/* Takes the best ear each time. Where a polygon crosses itself and has none, the least bad corner goes. */
static void clip_ears(pc_cutter *cutter, pc_index *triangle, size_t sides) {
    pc_index first = 0;
    for (size_t i = 0; i < sides; i++)
        cutter->worth[i] = worth_of(cutter, (pc_index)i);
    for (size_t left = sides; left > 2; left--, triangle += 3) {
        pc_index best = first;
        for (pc_index i = cutter->next[first]; i != first; i = cutter->next[i])
            if (cutter->worth[i] > cutter->worth[best]) best = i;
        pc_index before = cutter->prev[best];
        pc_index after = cutter->next[best];
        triangle[0] = cutter->corner[before];
        triangle[1] = cutter->corner[best];
        triangle[2] = cutter->corner[after];
        cutter->next[before] = after;
        cutter->prev[after] = before;
        first = after;
        cutter->worth[before] = worth_of(cutter, before);
        cutter->worth[after] = worth_of(cutter, after);
    }
}

pc_status pc_cutter_cut(pc_cutter *cutter, pc_context *ctx, pc_index *triangle, size_t sides,
                        const double *position) {
    pc_status status = PC_OK;
    if (sides > PC_CUTTER_LIMIT)
        return pc_fail(ctx, PC_E_FORMAT,
                       "a face has %zu corners, more than %d: cut it into smaller ones first", sides,
                       PC_CUTTER_LIMIT);
    PC_TRY(make_room(cutter, ctx, sides));
    cutter->corner[0] = triangle[0];
    cutter->corner[1] = triangle[1];
    for (size_t i = 2; i < sides; i++)
        cutter->corner[i] = triangle[3 * (i - 2) + 2];
    for (size_t i = 0; i < sides; i++) {
        cutter->next[i] = (pc_index)(i + 1 < sides ? i + 1 : 0);
        cutter->prev[i] = (pc_index)(i > 0 ? i - 1 : sides - 1);
    }
    project(cutter, sides, position);
    if (sides == 4)
        cut_quad(cutter, triangle);
    else
        clip_ears(cutter, triangle, sides);
done:
    return status;
}
