/* Convex combination maps of random weights: every point is the mean of those around, and no triangle of a
 * disk turns over. */
#include "convexmap.h"
#include "memory.h"
#include "random.h"
#include "testing.h"
#include <math.h>

enum { SIDE = 40, COUNT = SIDE * SIDE };

static bool is_rim(pc_index v) {
    const pc_index i = v % SIDE, j = v / SIDE;
    return i == 0 || j == 0 || i == SIDE - 1 || j == SIDE - 1;
}

/* A square grid cut into triangles by its ascending diagonals; weights from 1/1000 to 1. */
static void make_map(pc_convexmap *map, pc_context *ctx, pc_random *random) {
    static const int offset[6] = {-SIDE - 1, -SIDE, -1, 1, SIDE, SIDE + 1};
    size_t count = 0;
    assert_ok(ctx, pc_convexmap_make(map, ctx, COUNT, (size_t)6 * COUNT));
    for (pc_index v = 0; v < COUNT; v++) {
        const size_t from = count;
        double total = 0;
        for (int k = 0; k < 6 && !is_rim(v); k++) {
            map->column[count] = (pc_index)((int)v + offset[k]);
            map->weight[count] = pow(10, -3 * pc_random_uniform(random));
            total += map->weight[count++];
        }
        for (size_t e = from; e < count; e++)
            map->weight[e] /= total;
        map->start[v + 1] = count;
    }
}

/* The rim on the unit circle, in order. */
static void fix_rim(double *x) {
    for (pc_index v = 0; v < COUNT; v++) {
        const double p = (double)(v % SIDE) / (SIDE - 1) * 2 - 1;
        const double q = (double)(v / SIDE) / (SIDE - 1) * 2 - 1; /* NOLINT(bugprone-integer-division) */
        const double angle = atan2(q, p);
        x[2 * (size_t)v] = is_rim(v) ? cos(angle) : 0;
        x[2 * (size_t)v + 1] = is_rim(v) ? sin(angle) : 0;
    }
}

static double area(const double *x, pc_index a, pc_index b, pc_index c) {
    const double *p = x + 2 * (size_t)a, *q = x + 2 * (size_t)b, *r = x + 2 * (size_t)c;
    return ((q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])) / 2;
}

static void nothing_turns_over(void **state) {
    pc_context *ctx = *state;
    const double tolerance = 1e-10;
    for (uint64_t seed = 1; seed <= 10; seed++) {
        pc_random random = {seed};
        pc_convexmap map;
        double *x = NULL, total = 0;
        make_map(&map, ctx, &random);
        assert_ok(ctx, pc_new(&x, ctx, 2 * (size_t)COUNT));
        fix_rim(x);
        assert_ok(ctx, pc_convexmap_solve(x, ctx, &map, tolerance));
        for (size_t i = 0; i < 2 * (size_t)COUNT; i++) {
            const pc_index v = (pc_index)(i / 2);
            double mean = is_rim(v) ? x[i] : 0;
            for (size_t e = map.start[v]; e < map.start[v + 1]; e++)
                mean += map.weight[e] * x[2 * (size_t)map.column[e] + i % 2];
            if (!(fabs(mean - x[i]) <= tolerance))
                fail_msg("seed %d: point %u is %g from its mean", (int)seed, v, fabs(mean - x[i]));
        }
        for (pc_index v = 0; v < COUNT; v++) {
            if (v % SIDE == SIDE - 1 || v / SIDE == SIDE - 1) continue;
            const double one = area(x, v, v + 1, v + SIDE + 1), two = area(x, v, v + SIDE + 1, v + SIDE);
            total += one + two;
            if (!(one > -1e-12 && two > -1e-12))
                fail_msg("seed %d: triangles at %u have areas %g and %g", (int)seed, v, one, two);
        }
        assert_true(fabs(total - acos(-1)) < 0.02);
        pc_free(ctx, x);
        pc_convexmap_free(&map, ctx);
    }
}

/* A mean that no number of steps reaches: said, and the best so far is there. */
static void too_much_is_said(void **state) {
    pc_context *ctx = *state;
    pc_random random = {3};
    pc_convexmap map;
    double *x = NULL;
    make_map(&map, ctx, &random);
    assert_ok(ctx, pc_new(&x, ctx, 2 * (size_t)COUNT));
    fix_rim(x);
    assert_int_equal(pc_convexmap_solve(x, ctx, &map, 1e-30), PC_E_NOCONV);
    pc_context_clear_message(ctx);
    assert_true(hypot(x[SIDE * (SIDE + 1)], x[SIDE * (SIDE + 1) + 1]) < 0.9);
    pc_free(ctx, x);
    pc_convexmap_free(&map, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(nothing_turns_over, make_context, free_context),
        cmocka_unit_test_setup_teardown(too_much_is_said, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
