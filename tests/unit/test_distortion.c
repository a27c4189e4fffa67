/* Stretch and shear of parameterizations that are known: linear maps of a plane, wrapped into periods and
 * turned at random at every vertex. */
#include "distortion.h"
#include "plane_param.h"
#include "synth.h"
#include "vec3.h"

static pc_distortion of_linear_map(pc_context *ctx, const double a[4], uint64_t seed) {
    pc_mesh mesh;
    plane_param p;
    pc_distortion d;
    assert_ok(ctx, pc_synth_plane(&mesh, ctx, 5, 4, 37, 23));
    make_linear_param(&p, ctx, &mesh, a, seed);
    for (pc_index f = 0; f < 10; f++) /* not looked at: must not disturb */
        p.param.singular[f] = PC_DISLOCATION, p.param.shift[6 * f] += 9;
    assert_ok(ctx, pc_distortion_measure(&d, ctx, &mesh, &p.param));
    assert_int_equal(d.dislocations, 10);
    assert_int_equal(d.regular_faces, mesh.face_count - 10);
    free_plane_param(&p, ctx);
    pc_mesh_free(&mesh, ctx);
    return d;
}

static void linear_maps(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 8; seed++) {
        const double rigid[4] = {3 * cos(0.3), 3 * sin(0.3), -3 * sin(0.3), 3 * cos(0.3)};
        pc_distortion d = of_linear_map(ctx, rigid, seed);
        assert_true(fabs(d.stretch - 1) < 1e-6 && d.shear < 1e-6 && d.length_error < 1e-6);
        const double squeezed[4] = {2, 0, 0, 1}; /* singular values 1/2 and 1: sqrt((1/4+1)/2) * sqrt(2) */
        d = of_linear_map(ctx, squeezed, seed);
        assert_true(fabs(d.stretch - sqrt(1.25)) < 1e-6 && d.shear < 1e-6 &&
                    fabs(d.length_error - 0.5) < 1e-6);
        assert_true(fabs(d.stretch_core - sqrt(1.25)) < 1e-6);
        const double sheared[4] = {1, -1, 0, 1}; /* dX/ds = (1,0), dX/dt = (1,1) */
        d = of_linear_map(ctx, sheared, seed);
        assert_true(fabs(d.stretch - sqrt(1.5)) < 1e-6 && fabs(d.shear - sqrt(0.5)) < 1e-6);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(linear_maps, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
