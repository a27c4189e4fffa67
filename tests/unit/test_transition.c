/* Transitions form a group that acts on points, cones are its fixed points, and the phases of a turned system
 * follow the same quarter turns as the coordinates. */
#include "cone.h"
#include "coupling.h"
#include "random.h"
#include "system.h"
#include "testing.h"
#include "transition.h"
#include "vec3.h"

enum { ROUNDS = 2000 };

static int64_t whole(pc_random *random, int64_t most) {
    return (int64_t)(pc_random_next(random) % (uint64_t)(2 * most + 1)) - most;
}

static pc_transition random_transition(pc_random *random) {
    int turn = (int)(pc_random_next(random) % 4);
    return (pc_transition){turn, whole(random, 1000), whole(random, 1000)};
}

static pc_point2 random_point(pc_random *random) {
    return (pc_point2){whole(random, (int64_t)1 << 40), whole(random, (int64_t)1 << 40)};
}

static bool same(pc_transition f, pc_transition g) {
    return f.turn == g.turn && f.a == g.a && f.b == g.b;
}

static bool same_point(pc_point2 p, pc_point2 q) {
    return p.s == q.s && p.t == q.t;
}

static void group_laws(void **state) {
    (void)state;
    const pc_transition one = {0, 0, 0};
    for (uint64_t seed = 0; seed < ROUNDS; seed++) {
        pc_random random = {seed};
        pc_transition f = random_transition(&random), g = random_transition(&random),
                      h = random_transition(&random);
        pc_point2 p = random_point(&random);
        pc_transition inverse = pc_transition_inverse(f);
        bool laws[] = {
            same(pc_transition_after(f, inverse), one),
            same(pc_transition_after(inverse, f), one),
            same(pc_transition_inverse(inverse), f),
            same(pc_transition_after(f, one), f) && same(pc_transition_after(one, f), f),
            same(pc_transition_after(f, pc_transition_after(g, h)),
                 pc_transition_after(pc_transition_after(f, g), h)),
            same(pc_transition_inverse(pc_transition_after(f, g)),
                 pc_transition_after(pc_transition_inverse(g), inverse)),
            same_point(pc_transition_apply(pc_transition_after(f, g), p),
                       pc_transition_apply(f, pc_transition_apply(g, p))),
            same_point(pc_transition_apply(inverse, pc_transition_apply(f, p)), p),
        };
        for (size_t k = 0; k < sizeof laws / sizeof *laws; k++)
            if (!laws[k]) fail_msg("seed %llu: law %zu does not hold", (unsigned long long)seed, k);
    }
}

/* Areas keep under transitions; four quarter turns are none. */
static void turns_are_rotations(void **state) {
    (void)state;
    for (uint64_t seed = 0; seed < ROUNDS; seed++) {
        pc_random random = {seed};
        pc_transition f = random_transition(&random);
        pc_point2 p[3], q[3], r;
        for (int k = 0; k < 3; k++) {
            p[k] = (pc_point2){whole(&random, 1 << 28), whole(&random, 1 << 28)};
            q[k] = pc_transition_apply(f, p[k]);
        }
        r = p[0];
        for (int k = 0; k < 4; k++)
            r = pc_point2_turned(r, 1);
        double s = 0.25, t = 0.75;
        pc_point2 quarters = pc_point2_turned((pc_point2){1, 3}, f.turn);
        pc_turn_pair(&s, &t, f.turn);
        if (pc_point2_area(p[0], p[1], p[2]) != pc_point2_area(q[0], q[1], q[2]) || !same_point(r, p[0]) ||
            !same_point(pc_point2_turned(p[1], f.turn), pc_point2_turned(p[1], f.turn + 4)) ||
            4 * s != (double)quarters.s || 4 * t != (double)quarters.t)
            fail_msg("seed %llu: a turn is no rotation", (unsigned long long)seed);
    }
}

/* M^turn X of a turned system with one entry of value 1, as in the row of X's neighbour. */
static void apply_turn(pc_context *ctx, double y[4], const double x[4], int turn) {
    pc_system system;
    double in[8] = {0, 0, 0, 0, x[0], x[1], x[2], x[3]}, out[8];
    assert_ok(ctx, pc_system_make(&system, ctx, PC_BLOCK_TURNED, 2, 2));
    for (pc_index k = 0; k < 2; k++) {
        system.start[k + 1] = k + 1;
        system.column[k] = 1 - k;
    }
    system.turn[0] = (uint8_t)turn;
    system.value[0] = system.value[2] = 1;
    pc_system_apply(out, &system, in);
    memcpy(y, out, 4 * sizeof *y);
    pc_system_free(&system, ctx);
}

/* The phases of turned coordinates are M^turn times the phases, and M^4 = 1. */
static void phases_turn_as_coordinates(void **state) {
    for (uint64_t seed = 0; seed < 200; seed++) {
        pc_random random = {seed};
        pc_point2 p = {whole(&random, PC_PERIOD), whole(&random, PC_PERIOD)};
        double unit = 2 * PC_PI / PC_PERIOD, y[4];
        double x[4] = {cos(unit * (double)p.s), sin(unit * (double)p.s), cos(unit * (double)p.t),
                       sin(unit * (double)p.t)};
        for (int turn = 0; turn < 4; turn++) {
            pc_point2 q = pc_point2_turned(p, turn);
            apply_turn(*state, y, x, turn);
            if (!(fabs(y[0] - cos(unit * (double)q.s)) < 1e-12 &&
                  fabs(y[1] - sin(unit * (double)q.s)) < 1e-12 &&
                  fabs(y[2] - cos(unit * (double)q.t)) < 1e-12 &&
                  fabs(y[3] - sin(unit * (double)q.t)) < 1e-12))
                fail_msg("seed %llu: M^%d is not S^%d", (unsigned long long)seed, turn, turn);
        }
        memcpy(y, x, sizeof y);
        for (int k = 0; k < 4; k++)
            apply_turn(*state, y, y, 1);
        assert_memory_equal(x, y, sizeof x);
    }
}

static void put(pc_param *param, size_t h, pc_transition g) {
    param->turn[h] = (uint8_t)g.turn;
    param->shift[2 * h] = (int32_t)g.a;
    param->shift[2 * h + 1] = (int32_t)g.b;
}

/* Once around a triangle leaves its cone where it is; the cone seen from each corner is one point. */
static void cones_are_fixed_points(void **state) {
    (void)state;
    for (uint64_t seed = 0; seed < ROUNDS; seed++) {
        pc_random random = {seed};
        uint8_t turn[3];
        int32_t shift[6];
        pc_param param = {.vertex_count = 3, .face_count = 1, .turn = turn, .shift = shift};
        pc_transition once = {0, 0, 0};
        pc_point2 cone;
        for (size_t h = 0; h < 3; h++) {
            put(&param, h, random_transition(&random));
            once = pc_transition_after(once, pc_transition_of(&param, h));
        }
        bool found = pc_cone_point(&cone, &param, 0);
        if (found != (once.turn != 0) || (found && !same_point(pc_transition_apply(once, cone), cone)))
            fail_msg("seed %llu: the cone moves", (unsigned long long)seed);
        if (!found) continue;
        /* Begun at the next corner: the same point in that corner's frame. */
        pc_point2 expected = pc_transition_apply(pc_transition_inverse(pc_transition_of(&param, 0)), cone);
        pc_transition first = pc_transition_of(&param, 0);
        put(&param, 0, pc_transition_of(&param, 1));
        put(&param, 1, pc_transition_of(&param, 2));
        put(&param, 2, first);
        if (!pc_cone_point(&cone, &param, 0) || !same_point(cone, expected))
            fail_msg("seed %llu: the cone depends on the first corner", (unsigned long long)seed);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(group_laws, make_context, free_context),
        cmocka_unit_test_setup_teardown(turns_are_rotations, make_context, free_context),
        cmocka_unit_test_setup_teardown(phases_turn_as_coordinates, make_context, free_context),
        cmocka_unit_test_setup_teardown(cones_are_fixed_points, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
