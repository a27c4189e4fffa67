/* Cubic splines owe the fourth order: the error of a fit to an exact shape falls sixteenfold when all faces
 * are cut in four, away from extraordinary vertices. */
#include "exactfit.h"
#include "insertion.h"
#include "memory.h"
#include "synth_quads.h"
#include "testing.h"

static const pc_tmesh_options making = PC_TMESH_DEFAULTS;

/* Fits, cuts all faces in four, and fits again; the errors from step to step. */
static void refine_uniformly(pc_exact_error *error, int steps, pc_context *ctx, const pc_polymesh *quads,
                             const pc_exact_shape *shape) {
    pc_tspline spline;
    assert_ok(ctx, pc_tspline_make(&spline, ctx, quads, &making));
    for (int i = 0; i < steps; i++) {
        pc_closure_stats stats;
        uint8_t *wish;
        if (i > 0) {
            assert_ok(ctx, pc_new(&wish, ctx, spline.mesh.face_count));
            memset(wish, PC_HALVE_S | PC_HALVE_T, spline.mesh.face_count);
            assert_ok(ctx, pc_insertion_refine(&spline, &stats, ctx, wish));
            pc_free(ctx, wish);
        }
        assert_ok(ctx, pc_exact_fit(&spline, ctx, shape));
        pc_exact_measure(error + i, NULL, NULL, &spline, shape);
        print_message("%s: %u points, max %.2e, rms %.2e, away %.2e\n", shape->name, spline.mesh.vertex_count,
                      error[i].max, error[i].rms, error[i].away_max);
    }
    pc_tspline_free(&spline, ctx);
}

static void a_torus_shows_order_four(void **state) {
    pc_context *ctx = *state;
    pc_polymesh quads;
    pc_exact_error error[3];
    assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 1, 8, 4));
    refine_uniformly(error, 3, ctx, &quads, &pc_exact_torus);
    for (int i = 1; i < 3; i++) {
        assert_true(error[i - 1].max > 13 * error[i].max);
        assert_true(error[i - 1].rms > 13 * error[i].rms);
    }
    assert_true(error[2].max < 1e-4);
    pc_polymesh_free(&quads, ctx);
}

/* Vertices of valence 3 cost an order and a half in the largest error, nothing away from them. */
static void a_sphere_shows_it_away_from_its_corners(void **state) {
    pc_context *ctx = *state;
    pc_polymesh quads;
    pc_exact_error error[3];
    assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 2));
    refine_uniformly(error, 3, ctx, &quads, &pc_exact_sphere);
    assert_true(error[1].away_max > 11 * error[2].away_max);
    assert_true(error[1].rms > 10 * error[2].rms);
    assert_true(error[1].max > 4 * error[2].max);
    pc_polymesh_free(&quads, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_torus_shows_order_four, make_context, free_context),
        cmocka_unit_test_setup_teardown(a_sphere_shows_it_away_from_its_corners, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
