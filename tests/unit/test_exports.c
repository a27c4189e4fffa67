/* Spline files as others read them: Bezier extraction and patches are evaluated again by scripts of their own
 * and agree with the evaluator to 1e-12; OpenCASCADE reads STEP and IGES, skipped where gmsh is not there. */
#include "bext.h"
#include "gismo.h"
#include "iga.h"
#include "iges.h"
#include "measure.h"
#include "python.h"
#include "spline_samples.h"
#include "step.h"
#include <math.h>

static char folder[64];
static bool skipped;
static const double size = 5;

static int enter_folder(void **state) {
    (void)state;
    (void)snprintf(folder, sizeof folder, "/tmp/percale-exports-XXXXXX");
    return mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static int leave_folder(void **state) {
    (void)state;
    return chdir("/") == 0 && rmdir(folder) == 0 ? 0 : -1;
}

static void passes(const char *script, const char *one, const char *two, const char *three) {
    int result = run_python(script, one, two, three);
    assert_int_equal(unlink(one) + unlink(two) + unlink(three), 0);
    if (result == PYTHON_SKIPS)
        skipped = true;
    else
        assert_int_equal(result, 0);
}

static void put_sample(FILE *file, pc_index where, double u, double v, const pc_tspline *spline,
                       pc_surface_place place) {
    pc_vec3 p = pc_tspline_evaluate(spline, place).p;
    assert_true(fprintf(file, "%u %.17g %.17g %.17g %.17g %.17g\n", where, u, v, p.x, p.y, p.z) > 0);
}

static void extraction_is_read(void **state) {
    pc_context *ctx = *state;
    for (int kind = 0; kind < SAMPLE_COUNT; kind++) {
        pc_tspline spline;
        make_sample_spline(&spline, ctx, kind);
        FILE *points = fopen("points", "w");
        assert_non_null(points);
        assert_true(fprintf(points, "%g\n", size) > 0);
        for (pc_index e = 0; e < spline.basis.element_count; e++)
            for (int i = 0; i < 3; i++) {
                const pc_element *element = spline.basis.element + e;
                double u = i == 2 ? 1 : 0.2 + 0.5 * i, v = i == 2 ? 0 : 0.7 - 0.3 * i;
                pc_surface_place place = {e, element->low[0] + u * (element->high[0] - element->low[0]),
                                          element->low[1] + v * (element->high[1] - element->low[1])};
                put_sample(points, e, u, v, &spline, place);
            }
        assert_int_equal(fclose(points), 0);
        assert_ok(ctx, pc_iga_write(ctx, &spline, "spline.iga", false));
        assert_ok(ctx, pc_bext_write(ctx, &spline, "spline.bext", false));
        passes("tests/readers/check_extraction.py", "points", "spline.iga", "spline.bext");
        pc_tspline_free(&spline, ctx);
    }
}

static void patches_are_read(void **state) {
    pc_context *ctx = *state;
    for (int kind = 0; kind < SAMPLE_COUNT; kind++) {
        pc_tspline spline;
        pc_blocks blocks;
        pc_shell shell;
        make_sample_spline(&spline, ctx, kind);
        assert_ok(ctx, pc_blocks_make(&blocks, ctx, &spline));
        assert_ok(ctx, pc_shell_make(&shell, ctx, &spline));
        FILE *points = fopen("points", "w");
        assert_non_null(points);
        assert_true(fprintf(points, "%g %d\n", size, kind == SAMPLE_PLANE ? -1 : 0) > 0);
        for (pc_index f = 0; f < shell.face_count; f++)
            for (int i = 0; i < 4; i++) {
                double u = i == 3 ? 1 : 0.1 + 0.4 * i, v = i == 3 ? 0 : 0.9 - 0.35 * i;
                put_sample(points, f, u, v, &spline, place_on_shell(&spline, &blocks, f, u, v));
            }
        assert_int_equal(fclose(points), 0);
        assert_ok(ctx, pc_gismo_write(ctx, &shell, "spline.xml", false));
        assert_ok(ctx, pc_iges_write(ctx, &shell, size, "it's a; test, long", "spline.igs", false));
        passes("tests/readers/check_patches.py", "points", "spline.xml", "spline.igs");
        pc_shell_free(&shell, ctx);
        pc_blocks_free(&blocks, ctx);
        pc_tspline_free(&spline, ctx);
    }
}

static void opencascade_reads_them(void **state) {
    pc_context *ctx = *state;
    for (int kind = 0; kind < SAMPLE_COUNT; kind++) {
        pc_tspline spline;
        pc_shell shell;
        pc_measure measure;
        make_sample_spline(&spline, ctx, kind);
        assert_ok(ctx, pc_shell_make(&shell, ctx, &spline));
        assert_ok(ctx, pc_tspline_measure(&measure, ctx, &spline));
        assert_int_equal(measure.closed, kind != SAMPLE_PLANE);
        FILE *expected = fopen("expected", "w");
        assert_non_null(expected);
        assert_true(fprintf(expected, "%u %d %.17g %.17g\n", shell.face_count, measure.closed, measure.area,
                            measure.volume) > 0);
        assert_int_equal(fclose(expected), 0);
        assert_ok(ctx, pc_step_write(ctx, &shell, size, "sample", "spline.step", false));
        assert_ok(ctx, pc_iges_write(ctx, &shell, size, "sample", "spline.igs", false));
        passes("tests/readers/check_cad.py", "expected", "spline.step", "spline.igs");
        pc_shell_free(&shell, ctx);
        pc_tspline_free(&spline, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(extraction_is_read, make_context, free_context),
        cmocka_unit_test_setup_teardown(patches_are_read, make_context, free_context),
        cmocka_unit_test_setup_teardown(opencascade_reads_them, make_context, free_context),
    };
    int failed = cmocka_run_group_tests(tests, enter_folder, leave_folder);
    return failed == 0 && skipped ? PYTHON_SKIPS : failed;
}
