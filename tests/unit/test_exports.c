/* Spline files as others read them: Bezier extraction and patches are evaluated again by scripts of their own
 * and agree with the evaluator to 1e-12 (skipped where NumPy is not installed). */
#include "bext.h"
#include "cage.h"
#include "file.h"
#include "folder_testing.h"
#include "gismo.h"
#include "iga.h"
#include "iges.h"
#include "python.h"
#include "spline_samples.h"
#include "step.h"
#include <math.h>

static bool skipped;
static const double size = 5;

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

static bool is_at(double x, double y, double where) {
    return fabs(x - where) < 1e-9 && fabs(y - where) < 1e-9;
}

/* Sides of faces that lie on the rim of the plane of the sample. */
static int border_sides(const pc_shell *shell) {
    static const double corner[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    int count = 0;
    for (pc_index f = 0; f < shell->face_count; f++)
        for (int k = 0; k < 4; k++) {
            pc_vec3 a = pc_shell_face_point(shell, f, corner[k][0], corner[k][1]);
            pc_vec3 b = pc_shell_face_point(shell, f, corner[k + 1][0], corner[k + 1][1]);
            count += is_at(a.x, b.x, 0) || is_at(a.x, b.x, 6) || is_at(a.y, b.y, 0) || is_at(a.y, b.y, 4);
        }
    return count;
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
        assert_true(fprintf(points, "%g %d\n", size, kind == SAMPLE_PLANE ? border_sides(&shell) : 0) > 0);
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

static void step_curves_lie_on_surfaces(void **state) {
    pc_context *ctx = *state;
    for (int kind = 0; kind < SAMPLE_COUNT; kind++) {
        pc_tspline spline;
        pc_shell shell;
        char faces[32];
        make_sample_spline(&spline, ctx, kind);
        assert_ok(ctx, pc_shell_make(&shell, ctx, &spline));
        assert_ok(ctx, pc_step_write(ctx, &shell, size, "sample", "spline.step", false));
        (void)snprintf(faces, sizeof faces, "%u", shell.face_count);
        int result = run_python("tests/readers/check_step.py", "spline.step", "5", faces);
        assert_int_equal(unlink("spline.step"), 0);
        skipped |= result == PYTHON_SKIPS;
        if (result != PYTHON_SKIPS) assert_int_equal(result, 0);
        pc_shell_free(&shell, ctx);
        pc_tspline_free(&spline, ctx);
    }
}

/* All writers, by number. */
enum { WRITERS = 6 };

static pc_status write_as(pc_context *ctx, int writer, const pc_tspline *spline, const pc_shell *shell,
                          const char *path, bool force) {
    return writer == 0   ? pc_iga_write(ctx, spline, path, force)
           : writer == 1 ? pc_bext_write(ctx, spline, path, force)
           : writer == 2 ? pc_gismo_write(ctx, shell, path, force)
           : writer == 3 ? pc_iges_write(ctx, shell, size, "x", path, force)
           : writer == 4 ? pc_step_write(ctx, shell, size, "x", path, force)
                         : pc_cage_write(ctx, spline, path, force);
}

static void files_are_kept_and_equal(void **state) {
    pc_context *ctx = *state;
    pc_tspline spline;
    pc_shell shell;
    make_sample_spline(&spline, ctx, SAMPLE_PLANE);
    assert_ok(ctx, pc_shell_make(&shell, ctx, &spline));
    for (int w = 0; w < WRITERS; w++) {
        pc_file one, two;
        assert_ok(ctx, write_as(ctx, w, &spline, &shell, "one", false));
        assert_int_equal(write_as(ctx, w, &spline, &shell, "one", false), PC_E_IO);
        assert_true(strlen(pc_context_message(ctx)) > 0);
        pc_context_clear_message(ctx);
        assert_ok(ctx, write_as(ctx, w, &spline, &shell, "one", true));
        assert_ok(ctx, write_as(ctx, w, &spline, &shell, "two", false));
        assert_ok(ctx, pc_file_open(&one, ctx, "one"));
        assert_ok(ctx, pc_file_open(&two, ctx, "two"));
        assert_int_equal(one.size, two.size);
        assert_memory_equal(one.data, two.data, one.size);
        pc_file_close(&one, ctx);
        pc_file_close(&two, ctx);
        assert_int_equal(unlink("one") + unlink("two"), 0);
    }
    pc_shell_free(&shell, ctx);
    pc_tspline_free(&spline, ctx);
}

/* Each allocation fails once: an error, no file, nothing left alive (which the teardown sees). */
static void lack_of_memory_leaves_nothing(void **state) {
    pc_context *ctx = *state;
    pc_tspline spline;
    pc_shell shell;
    make_sample_quads(&spline, ctx, SAMPLE_PLANE);
    assert_ok(ctx, pc_shell_make(&shell, ctx, &spline));
    for (int w = 0; w < WRITERS; w++) {
        pc_status status = PC_E_NOMEM;
        size_t failed = 0;
        for (size_t n = 1; status != PC_OK; n++) {
            pc_memory_fail_at(ctx, n);
            status = write_as(ctx, w, &spline, &shell, "one", false);
            pc_memory_fail_at(ctx, 0);
            if (status == PC_OK) break;
            assert_int_equal(status, PC_E_NOMEM);
            assert_int_equal(access("one", F_OK), -1);
            pc_context_clear_message(ctx);
            failed++;
        }
        assert_true(failed > 2);
        assert_int_equal(unlink("one"), 0);
    }
    pc_shell_free(&shell, ctx);
    pc_tspline_free(&spline, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(files_are_kept_and_equal, make_context, free_context),
        cmocka_unit_test_setup_teardown(lack_of_memory_leaves_nothing, make_context, free_context),
        cmocka_unit_test_setup_teardown(extraction_is_read, make_context, free_context),
        cmocka_unit_test_setup_teardown(patches_are_read, make_context, free_context),
        cmocka_unit_test_setup_teardown(step_curves_lie_on_surfaces, make_context, free_context),
    };
    int failed = cmocka_run_group_tests(tests, enter_folder, leave_folder);
    return failed == 0 && skipped ? PYTHON_SKIPS : failed;
}
