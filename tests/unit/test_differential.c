/* Normals and principal curvatures from derivatives, on surfaces for which they are known. */
#include "differential.h"
#include "random.h"
#include "testing.h"

/* A torus of radii 2 and 1 with parameters sheared against the lines of curvature: u = s + shear*t, v = t. */
static pc_surface_point torus(double s, double t, double shear) {
    const double u = s + shear * t, v = t, cu = cos(u), su = sin(u), cv = cos(v), sv = sin(v), r = 2 + cv;
    pc_vec3 uu = {-r * cu, -r * su, 0}, uv = {sv * su, -sv * cu, 0}, vv = {-cv * cu, -cv * su, -sv};
    pc_vec3 du = {-r * su, r * cu, 0}, dv = {-sv * cu, -sv * su, cv};
    return (pc_surface_point){.p = {r * cu, r * su, sv},
                              .s = du,
                              .t = pc_madd(dv, shear, du),
                              .ss = uu,
                              .st = pc_madd(uv, shear, uu),
                              .tt = pc_madd(pc_madd(vv, 2 * shear, uv), shear * shear, uu)};
}

static void tori(void **state) {
    (void)state;
    pc_random random = {1};
    for (int i = 0; i < 1000; i++) {
        double s = 6 * pc_random_uniform(&random), t = 6 * pc_random_uniform(&random), k[2];
        pc_surface_point at = torus(s, t, 2 * pc_random_uniform(&random) - 1);
        double around = cos(t) / (2 + cos(t)); /* less than 1, the curvature of the tube */
        pc_vec3 n = pc_surface_normal(&at);
        pc_vec3 ring = pc_scale(2 / hypot(at.p.x, at.p.y), (pc_vec3){at.p.x, at.p.y, 0});
        assert_true(pc_distance(n, pc_sub(at.p, ring)) < 1e-12);
        assert_true(pc_surface_curvatures(k, &at));
        assert_true(fabs(k[0] - 1) < 1e-12 && fabs(k[1] - around) < 1e-12);
    }
}

/* At an umbilic neither is worse than rounding, as the roots of a quadratic would be. */
static void spheres(void **state) {
    (void)state;
    pc_random random = {2};
    for (int i = 0; i < 1000; i++) {
        double u = 6 * pc_random_uniform(&random), v = 2.8 * pc_random_uniform(&random) - 1.4, k[2];
        const double cu = cos(u), su = sin(u), cv = cos(v), sv = sin(v), r = 3;
        pc_surface_point at = {.p = {r * cv * cu, r * cv * su, r * sv},
                               .s = {-r * cv * su, r * cv * cu, 0},
                               .t = {-r * sv * cu, -r * sv * su, r * cv},
                               .ss = {-r * cv * cu, -r * cv * su, 0},
                               .st = {r * sv * su, -r * sv * cu, 0},
                               .tt = {-r * cv * cu, -r * cv * su, -r * sv}};
        assert_true(pc_surface_curvatures(k, &at));
        assert_true(fabs(k[0] - 1 / r) < 1e-14 && fabs(k[1] - 1 / r) < 1e-14 && k[0] >= k[1]);
    }
}

static void degenerate_points_have_none(void **state) {
    (void)state;
    double k[2];
    pc_surface_point at = {.s = {1, 0, 0}, .t = {2, 0, 0}, .ss = {0, 0, 1}};
    assert_false(pc_surface_curvatures(k, &at));
    assert_true(k[0] == 0 && k[1] == 0 && pc_norm(pc_surface_normal(&at)) == 0);
    at = (pc_surface_point){.t = {0, 1, 0}};
    assert_false(pc_surface_curvatures(k, &at));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tori),
        cmocka_unit_test(spheres),
        cmocka_unit_test(degenerate_points_have_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
