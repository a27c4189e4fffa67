/* OpenCASCADE reads STEP and IGES: as many faces as written, closed shells, area and volume of the spline
 * itself. Skipped where gmsh is not installed. */
#include "folder_testing.h"
#include "iges.h"
#include "measure.h"
#include "python.h"
#include "spline_samples.h"
#include "step.h"

static bool skipped;
static const double size = 5;

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
        int result = run_python("tests/readers/check_cad.py", "expected", "spline.step", "spline.igs");
        assert_int_equal(unlink("expected") + unlink("spline.step") + unlink("spline.igs"), 0);
        skipped = result == PYTHON_SKIPS;
        if (!skipped) assert_int_equal(result, 0);
        pc_shell_free(&shell, ctx);
        pc_tspline_free(&spline, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(opencascade_reads_them, make_context, free_context),
    };
    int failed = cmocka_run_group_tests(tests, enter_folder, leave_folder);
    return failed == 0 && skipped ? PYTHON_SKIPS : failed;
}
