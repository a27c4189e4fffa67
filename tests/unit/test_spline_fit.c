/* Fits on shapes with known answers: what a spline can be is found again, scale does not matter, and errors
 * fall as cubic splines owe. */
#include "adapt.h"
#include "insertion.h"
#include "memory.h"
#include "synth.h"
#include "synth_quads.h"
#include "testing.h"
#include <math.h>

static const pc_tmesh_options defaults = PC_TMESH_DEFAULTS;

typedef struct scene {
    pc_mesh scan;
    pc_adjacency adjacency;
    pc_target target;
    pc_device *host;
} scene;

static void open_scene(scene *s, pc_context *ctx) {
    assert_ok(ctx, pc_adjacency_make(&s->adjacency, ctx, &s->scan));
    assert_ok(ctx, pc_target_make(&s->target, ctx, &s->scan, &s->adjacency));
    assert_ok(ctx, pc_device_open(&s->host, ctx, "host"));
}

static void close_scene(scene *s, pc_context *ctx) {
    pc_device_close(s->host, ctx);
    pc_target_free(&s->target, ctx);
    pc_adjacency_free(&s->adjacency, ctx);
    pc_mesh_free(&s->scan, ctx);
}

/* The assembled system is that of the energy: its solution for targets on a spline is that spline. */
static void a_spline_is_found_again(void **state) {
    pc_context *ctx = *state;
    pc_polymesh quads;
    pc_tspline spline;
    pc_system system;
    pc_sample *sample = NULL;
    double *right = NULL;
    double *product = NULL;
    uint8_t *wish = NULL;
    pc_closure_stats closed;
    const pc_index each = 16;
    assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 4));
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    assert_ok(ctx, pc_new(&wish, ctx, spline.mesh.face_count));
    wish[3] = PC_HALVE_S, wish[40] = PC_HALVE_T, wish[50] = PC_HALVE_S | PC_HALVE_T;
    assert_ok(ctx, pc_insertion_refine(&spline, &closed, ctx, wish));
    size_t count = (size_t)each * spline.basis.element_count;
    size_t rows = spline.mesh.vertex_count;
    assert_ok(ctx, pc_new(&sample, ctx, count));
    for (size_t i = 0; i < count; i++) {
        const pc_element *e = spline.basis.element + i / each;
        size_t k = i % each;
        double s = ((double)(k % 4) + 0.5) / 4;
        double t = ((double)(k / 4) + 0.5) / 4; /* NOLINT(bugprone-integer-division) */
        sample[i].place = (pc_surface_place){(pc_index)(i / each), e->low[0] + s * (e->high[0] - e->low[0]),
                                             e->low[1] + t * (e->high[1] - e->low[1])};
        sample[i].target = pc_tspline_point(&spline, sample[i].place);
        sample[i].weight = 1.0 / each;
    }
    assert_ok(ctx, pc_energy_assemble(&system, &right, ctx, &spline, sample, count, 0, NULL));
    assert_ok(ctx, pc_system_check(&system, ctx));
    assert_ok(ctx, pc_new(&product, ctx, 2 * rows));
    for (size_t k = 0; k < 3; k++) {
        for (size_t v = 0; v < rows; v++)
            product[rows + v] = spline.position[3 * v + k];
        pc_system_apply(product, &system, product + rows);
        for (size_t v = 0; v < rows; v++)
            assert_true(fabs(product[v] - right[k * rows + v]) < 1e-13);
    }
    pc_system_free(&system, ctx);
    pc_free(ctx, right);
    pc_free(ctx, product);
    pc_free(ctx, sample);
    pc_free(ctx, wish);
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
}

/* Errors against a torus at its vertices, which are exact: fourth order. */
static void torus_converges(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    double before = 0;
    assert_ok(ctx, pc_synth_torus(&s.scan, ctx, 2, 1, 96, 48));
    open_scene(&s, ctx);
    for (pc_index n = 1; n <= 2; n++) {
        pc_polymesh quads;
        pc_tspline spline;
        pc_fit_options options = PC_FIT_DEFAULTS;
        pc_fit_stats stats;
        pc_accuracy accuracy;
        assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 1, 12 * n, 6 * n));
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        pc_correspondence correspondence;
        assert_ok(ctx, pc_correspondence_make(&correspondence, ctx, &spline, &s.target, true));
        options.fairness = 1e-8, options.per_side = 0; /* vertices only */
        assert_ok(ctx, pc_fit(&spline, &stats, ctx, s.host, &s.target, &correspondence, &options));
        assert_ok(ctx, pc_accuracy_measure(&accuracy, NULL, ctx, &spline, &s.target, NULL, 5));
        pc_correspondence_free(&correspondence, ctx);
        print_message("torus of %u points: max %.3g, mean %.3g; %u iterations\n", spline.mesh.vertex_count,
                      accuracy.scan_max, accuracy.scan_mean, stats.iterations);
        assert_int_equal(stats.torn, 0);
        if (n > 1) assert_true(before / accuracy.scan_max > 11);
        before = accuracy.scan_max;
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
    }
    close_scene(&s, ctx);
}

/* The same sphere a thousand times as large gives the same surface a thousand times as large. */
static void scale_does_not_matter(void **state) {
    pc_context *ctx = *state;
    pc_adapt_stats stats[2];
    pc_index points[2];
    for (int k = 0; k < 2; k++) {
        scene s = {0};
        pc_polymesh quads;
        pc_tspline spline;
        pc_adapt_options options = PC_ADAPT_DEFAULTS;
        double scale = k ? 1024 : 1; /* exact in binary */
        assert_ok(ctx, pc_synth_sphere(&s.scan, ctx, 16));
        assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 2));
        for (size_t i = 0; i < 3 * (size_t)s.scan.vertex_count; i++)
            s.scan.position[i] *= scale;
        for (size_t i = 0; i < 3 * (size_t)quads.vertex_count; i++)
            quads.position[i] *= scale;
        open_scene(&s, ctx);
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        options.tolerance = 6e-3 * scale;
        assert_ok(ctx, pc_adapt(&spline, &stats[k], ctx, s.host, &s.target, &options));
        assert_ok(ctx, pc_tspline_check(&spline, NULL, ctx));
        assert_ok(ctx, pc_closure_check(&spline.mesh, ctx));
        points[k] = spline.mesh.vertex_count;
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
        close_scene(&s, ctx);
    }
    print_message("sphere: %u points, %.3g\n", points[0], stats[0].accuracy.max);
    assert_int_equal(points[0], points[1]);
    assert_true(fabs(stats[1].accuracy.max / stats[0].accuracy.max / 1024 - 1) < 1e-6);
}

/* A bent sheet: the surface reaches its border. */
static void borders_are_reached(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    pc_polymesh quads;
    pc_tspline spline;
    pc_adapt_options options = PC_ADAPT_DEFAULTS;
    pc_adapt_stats stats;
    assert_ok(ctx, pc_synth_plane(&s.scan, ctx, 2, 1, 24, 12));
    for (pc_index v = 0; v < s.scan.vertex_count; v++) {
        double *p = s.scan.position + 3 * (size_t)v;
        p[2] = 0.3 * sin(2 * p[0]) * cos(3 * p[1]);
    }
    assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 2, 1, 6, 3));
    for (pc_index v = 0; v < quads.vertex_count; v++) {
        double *p = quads.position + 3 * (size_t)v;
        p[2] = 0.3 * sin(2 * p[0]) * cos(3 * p[1]);
    }
    open_scene(&s, ctx);
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    options.tolerance = 6e-3; /* the facets of the scan are up to half of that off */
    assert_ok(ctx, pc_adapt(&spline, &stats, ctx, s.host, &s.target, &options));
    assert_ok(ctx, pc_tspline_check(&spline, NULL, ctx));
    print_message("sheet: %u points, %.3g\n", spline.mesh.vertex_count, stats.accuracy.max);
    assert_true(stats.accuracy.scan_max <= 6e-3); /* the scan's border vertices too */
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
    close_scene(&s, ctx);
}

/* A budget that is too small is an honest failure. */
static void budgets_are_kept(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    pc_polymesh quads;
    pc_tspline spline;
    pc_adapt_options options = PC_ADAPT_DEFAULTS;
    pc_adapt_stats stats;
    assert_ok(ctx, pc_synth_sphere(&s.scan, ctx, 16));
    assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 2));
    open_scene(&s, ctx);
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    options.tolerance = 0, options.max_points = 10;
    assert_int_equal(pc_adapt(&spline, &stats, ctx, s.host, &s.target, &options), PC_E_NOCONV);
    assert_int_equal(spline.mesh.vertex_count, 26);
    assert_true(stats.accuracy.max > 0);
    assert_non_null(strstr(pc_context_message(ctx), "26 control points"));
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
    close_scene(&s, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_spline_is_found_again, make_context, free_context),
        cmocka_unit_test_setup_teardown(torus_converges, make_context, free_context),
        cmocka_unit_test_setup_teardown(scale_does_not_matter, make_context, free_context),
        cmocka_unit_test_setup_teardown(borders_are_reached, make_context, free_context),
        cmocka_unit_test_setup_teardown(budgets_are_kept, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
