/* Triangles of spline surfaces: without cracks, on the surface from both sides, and VTK reads them (skipped
 * where VTK is not installed). */
#include "adjacency.h"
#include "measure.h"
#include "python.h"
#include "skin.h"
#include "spline_samples.h"
#include "vtkhdf.h"
#include <math.h>

static bool skipped;

static double area_of(const pc_mesh *mesh) {
    double area = 0;
    for (size_t f = 0; f < mesh->face_count; f++) {
        pc_vec3 a = pc_vec3_at(mesh->position, mesh->triangle[3 * f]);
        pc_vec3 b = pc_sub(pc_vec3_at(mesh->position, mesh->triangle[3 * f + 1]), a);
        pc_vec3 c = pc_sub(pc_vec3_at(mesh->position, mesh->triangle[3 * f + 2]), a);
        area += pc_norm(pc_cross(b, c)) / 2;
    }
    return area;
}

/* The point of the triangle's element that is nearest to the vertex, among the corners and middles of its
 * grid: every vertex of a triangle lies on the triangle's own element. */
static void lies_on_its_elements(const pc_tspline *spline, const pc_skin *skin) {
    for (size_t c = 0; c < 3 * (size_t)skin->mesh.face_count; c++) {
        const pc_element *e = spline->basis.element + skin->element[c / 3];
        pc_vec3 p = pc_vec3_at(skin->mesh.position, skin->mesh.triangle[c]);
        double least = INFINITY;
        enum { FINE = 64 };
        for (int j = 0; j <= FINE; j++)
            for (int i = 0; i <= FINE; i++) {
                if (i > 0 && j > 0 && i < FINE && j < FINE && (i % 8 || j % 8)) continue;
                pc_surface_place place = {skin->element[c / 3],
                                          e->low[0] + (e->high[0] - e->low[0]) * i / FINE,
                                          e->low[1] + (e->high[1] - e->low[1]) * j / FINE};
                least = fmin(least, pc_distance(p, pc_tspline_point(spline, place)));
            }
        assert_true(least < 1e-13);
    }
}

static void surfaces_have_no_cracks(void **state) {
    pc_context *ctx = *state;
    for (int kind = 0; kind < SAMPLE_COUNT; kind++) {
        pc_tspline spline;
        pc_skin skin;
        pc_adjacency adjacency;
        pc_measure measure;
        make_sample_spline(&spline, ctx, kind);
        assert_ok(ctx, pc_tspline_measure(&measure, ctx, &spline));
        double error[2];
        for (int i = 0; i < 2; i++) {
            assert_ok(ctx, pc_skin_make(&skin, ctx, &spline, i ? 8 : 4, NULL));
            assert_ok(ctx, pc_mesh_check(&skin.mesh, ctx));
            assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &skin.mesh));
            size_t border = 0, edges = 0, halves = 3 * (size_t)skin.mesh.face_count;
            for (pc_index h = 0; h < halves; h++) {
                border += adjacency.twin[h] == PC_NONE;
                edges += adjacency.twin[h] == PC_NONE || h < adjacency.twin[h];
            }
            long euler = (long)skin.mesh.vertex_count - (long)edges + (long)skin.mesh.face_count;
            assert_int_equal(euler, kind == SAMPLE_TORUS ? 0 : kind == SAMPLE_PLANE ? 1 : 2);
            assert_int_equal(border > 0, kind == SAMPLE_PLANE);
            error[i] = 1 - area_of(&skin.mesh) / measure.area;
            if (i == 0 && kind != SAMPLE_FOLDED) lies_on_its_elements(&spline, &skin);
            for (pc_index v = 0; v < skin.mesh.vertex_count; v++)
                assert_true(fabs(pc_norm(pc_vec3_at(skin.normal, v)) - 1) < 1e-12);
            pc_adjacency_free(&adjacency, ctx);
            pc_skin_free(&skin, ctx);
        }
        print_message("sample %d: area %g, short by %.3g and %.3g of it\n", kind, measure.area, error[0],
                      error[1]);
        assert_true(fabs(error[1]) < 0.35 * fabs(error[0]));
        pc_tspline_free(&spline, ctx);
    }
}

/* The torus' control points lie on it; the surface of uniform cubics is a little inside. */
static void measures_are_right(void **state) {
    pc_context *ctx = *state;
    double error[2][2];
    for (int i = 0; i < 2; i++) {
        const pc_tmesh_options options = PC_TMESH_DEFAULTS;
        pc_polymesh quads;
        pc_tspline spline;
        pc_measure measure;
        assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 1, i ? 48 : 24, i ? 32 : 16));
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &options));
        assert_ok(ctx, pc_tspline_measure(&measure, ctx, &spline));
        const double pi = 3.14159265358979323846;
        assert_true(measure.closed);
        error[i][0] = 8 * pi * pi / measure.area - 1;
        error[i][1] = 4 * pi * pi / measure.volume - 1;
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
    }
    for (int k = 0; k < 2; k++) {
        assert_true(error[0][k] > 0 && error[0][k] < 0.08);
        assert_true(fabs(error[0][k] / error[1][k] - 4) < 0.2);
    }
}

/* The triangles of one face cover its parameters once, and lie on faces that are wanted. */
static void parts_are_covered(void **state) {
    pc_context *ctx = *state;
    for (int kind = 0; kind < SAMPLE_COUNT; kind++) {
        pc_tspline spline;
        pc_skin skin;
        uint8_t *wanted;
        double *area;
        make_sample_spline(&spline, ctx, kind);
        const pc_index faces = spline.mesh.face_count;
        assert_ok(ctx, pc_new(&wanted, ctx, faces));
        assert_ok(ctx, pc_new(&area, ctx, faces));
        for (pc_index f = 0; f < faces; f++)
            wanted[f] = f % 5 < 2;
        assert_ok(ctx, pc_skin_make(&skin, ctx, &spline, 4, wanted));
        for (pc_index t = 0; t < skin.mesh.face_count; t++) {
            const double *c = skin.corner + 6 * (size_t)t;
            const pc_index f = spline.basis.element[skin.element[t]].face;
            const double twice = (c[2] - c[0]) * (c[5] - c[1]) - (c[4] - c[0]) * (c[3] - c[1]);
            assert_true(wanted[f] && twice > 0);
            area[f] += twice / 2;
        }
        for (pc_index f = 0; f < faces; f++) {
            const double *size = spline.mesh.face[f].size;
            const double all = wanted[f] && !spline.mesh.face[f].ghost ? size[0] * size[1] : 0;
            if (!(fabs(area[f] - all) <= 1e-12 * (1 + all)))
                fail_msg("surface %d: %g of %g of face %u are covered", kind, area[f], all, f);
        }
        pc_free(ctx, wanted);
        pc_free(ctx, area);
        pc_skin_free(&skin, ctx);
        pc_tspline_free(&spline, ctx);
    }
}

static void vtk_reads_it(void **state) {
    pc_context *ctx = *state;
    pc_tspline spline;
    pc_skin skin;
    double *distance;
    char path[2][64];
    const pc_store_options options = {.force = true};
    make_sample_spline(&spline, ctx, SAMPLE_SPHERE);
    assert_ok(ctx, pc_skin_make(&skin, ctx, &spline, 4, NULL));
    assert_ok(ctx, pc_new(&distance, ctx, skin.mesh.vertex_count));
    for (pc_index v = 0; v < skin.mesh.vertex_count; v++)
        distance[v] = pc_norm(pc_vec3_at(skin.mesh.position, v));
    for (int i = 0; i < 2; i++) {
        (void)snprintf(path[i], sizeof path[i], "/tmp/percale-skin-%ld-%d.hdf", (long)getpid(), i);
        assert_ok(ctx, pc_vtkhdf_write_surface(ctx, path[i], &spline, &skin, i ? NULL : distance, &options));
    }
    char elements[32];
    (void)snprintf(elements, sizeof elements, "%u", spline.basis.element_count);
    int result = run_python("tests/readers/check_surface.py", path[0], path[1], elements);
    assert_int_equal(unlink(path[0]) + unlink(path[1]), 0);
    skipped = result == PYTHON_SKIPS;
    if (!skipped) assert_int_equal(result, 0);
    pc_free(ctx, distance);
    pc_skin_free(&skin, ctx);
    pc_tspline_free(&spline, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(surfaces_have_no_cracks, make_context, free_context),
        cmocka_unit_test_setup_teardown(measures_are_right, make_context, free_context),
        cmocka_unit_test_setup_teardown(parts_are_covered, make_context, free_context),
        cmocka_unit_test_setup_teardown(vtk_reads_it, make_context, free_context),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    return failed == 0 && skipped ? PYTHON_SKIPS : failed;
}
