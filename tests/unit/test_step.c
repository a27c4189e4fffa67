/* STEP files: what a reader counts in them, references that resolve, and the same bytes every time. */
#include "file.h"
#include "memory.h"
#include "step.h"
#include "synth_quads.h"
#include "testing.h"
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static const pc_tmesh_options defaults = PC_TMESH_DEFAULTS;

static size_t occurrences(const char *text, const char *what) {
    size_t count = 0;
    for (const char *at = strstr(text, what); at; at = strstr(at + 1, what))
        count++;
    return count;
}

/* Entities are numbered 1, 2, 3... and every reference is to one of them. */
static void references_resolve(const char *text) {
    size_t entities = occurrences(text, ";\n#");
    size_t next = 1;
    const char *line = strstr(text, "DATA;\n") + 6;
    for (; *line == '#'; line = strchr(line, '\n') + 1) {
        assert_int_equal(strtoul(line + 1, NULL, 10), next++);
        const char *end = strchr(line, '\n');
        for (const char *at = memchr(line + 1, '#', (size_t)(end - line - 1)); at;
             at = memchr(at + 1, '#', (size_t)(end - at - 1))) {
            unsigned long reference = strtoul(at + 1, NULL, 10);
            assert_true(reference >= 1 && reference <= entities + 1);
        }
    }
    assert_int_equal(strncmp(line, "ENDSEC;\nEND-ISO-10303-21;\n", 26), 0);
    assert_true(next > entities);
}

/* Where entity `number` begins. */
static const char *entity(const char *text, size_t number) {
    char key[32];
    (void)snprintf(key, sizeof key, "\n#%zu=", number);
    const char *at = strstr(text, key);
    assert_true(at != NULL);
    return at + strlen(key);
}

/* The control points of the curves, in the order of the edges. */
static void curves_are_theirs(const char *text, const pc_shell *shell) {
    const char curve[] = "=B_SPLINE_CURVE_WITH_KNOTS('',3,(";
    const char *at = text;
    for (pc_index e = 0; e < shell->edge_count; e++) {
        const pc_shell_edge *edge = shell->edge + e;
        at = strstr(at, curve);
        assert_true(at != NULL);
        at += strlen(curve);
        for (pc_index i = 0; i < edge->point_count; i++) {
            char *end;
            const char *p = entity(text, strtoul(at + 1, &end, 10)) + strlen("CARTESIAN_POINT('',(");
            at = end + 1;
            for (size_t k = 0; k < 3; k++, p = end + 1) {
                const double x = strtod(p, &end);
                assert_true(x == shell->point[3 * (edge->point + i) + k]);
            }
        }
    }
}

static char *written(pc_context *ctx, const pc_tspline *spline, const char *path) {
    pc_shell shell;
    pc_file file;
    char *text = NULL;
    assert_ok(ctx, pc_shell_make(&shell, ctx, spline));
    assert_ok(ctx, pc_shell_check(&shell, ctx, 2));
    assert_ok(ctx, pc_step_write(ctx, &shell, 2, "it's a (test)", path, true));
    assert_ok(ctx, pc_file_open(&file, ctx, path));
    assert_ok(ctx, pc_new(&text, ctx, file.size + 1));
    memcpy(text, file.data, file.size);
    pc_file_close(&file, ctx);
    assert_int_equal(occurrences(text, "=ADVANCED_FACE("), shell.face_count);
    assert_int_equal(occurrences(text, "=B_SPLINE_SURFACE_WITH_KNOTS("), shell.face_count);
    assert_int_equal(occurrences(text, "=EDGE_CURVE("), shell.edge_count);
    assert_int_equal(occurrences(text, "=VERTEX_POINT("), shell.vertex_count);
    assert_int_equal(occurrences(text, "=ORIENTED_EDGE("), 2 * shell.edge_count - shell.border_count);
    assert_int_equal(occurrences(text, "=SURFACE_CURVE("), shell.edge_count);
    assert_int_equal(occurrences(text, "=PCURVE("), 2 * shell.edge_count - shell.border_count);
    references_resolve(text);
    /* Curves have the control points of a side of a surface, on closed ones most of them, and lines of the
     * parameters are shared. */
    size_t points = shell.vertex_count + 1 + occurrences(text, "=LINE("), own = 0;
    for (pc_index f = 0; f < shell.face_count; f++)
        points += (size_t)shell.face[f].point_count[0] * shell.face[f].point_count[1];
    for (pc_index e = 0; e < shell.edge_count; e++)
        own += shell.edge[e].point_count;
    assert_in_range(occurrences(text, "=CARTESIAN_POINT("), points,
                    points + (shell.border_count ? own : own / 2));
    assert_in_range(occurrences(text, "=LINE("), 1, occurrences(text, "=PCURVE("));
    curves_are_theirs(text, &shell);
    pc_shell_free(&shell, ctx);
    return text;
}

static void solids_and_sheets(void **state) {
    pc_context *ctx = *state;
    char path[] = "/tmp/percale_step_XXXXXX";
    int descriptor = mkstemp(path);
    assert_true(descriptor >= 0);
    (void)close(descriptor);
    for (int open = 0; open < 2; open++) {
        pc_polymesh quads;
        pc_tspline spline;
        if (open)
            assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 3, 2, 3, 2));
        else
            assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 3));
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        char *text = written(ctx, &spline, path);
        char *again = written(ctx, &spline, path);
        assert_string_equal(text, again);
        assert_int_equal(occurrences(text, "=MANIFOLD_SOLID_BREP("), !open);
        assert_int_equal(occurrences(text, "=CLOSED_SHELL("), !open);
        assert_int_equal(occurrences(text, "=SHELL_BASED_SURFACE_MODEL("), open);
        assert_int_equal(occurrences(text, "it_s a (test)"), 3);
        pc_free(ctx, text);
        pc_free(ctx, again);
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
    }
    (void)unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(solids_and_sheets, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
