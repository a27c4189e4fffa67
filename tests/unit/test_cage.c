/* Cages: an implementation of Catmull and Clark's rules in Python finds the spline surface as their limit. */
#include "cage.h"
#include "measure.h"
#include "python.h"
#include "spline_samples.h"

static bool skipped;

/* How far the samples may be from points of the limit: nothing but rounding where all knot intervals are
 * equal; else those points lie elsewhere on it, with some hundredths between them. */
static const struct {
    int kind;
    bool refined;
    double tolerance; /* of the diagonal */
} cases[] = {
    {SAMPLE_TORUS, false, 1e-12}, {SAMPLE_SPHERE, false, 1e-12}, {SAMPLE_PLANE, false, 4e-3},
    {SAMPLE_SPHERE, true, 2e-2},  {SAMPLE_PLANE, true, 2e-2},
};

static void make(pc_tspline *spline, pc_context *ctx, int kind, bool refined) {
    make_sample_quads(spline, ctx, kind);
    if (refined) refine_at_random(spline, ctx, 7, 15);
}

static void put(FILE *file, pc_vec3 p, bool meets) {
    assert_true(fprintf(file, "%.17g %.17g %.17g %d\n", p.x, p.y, p.z, meets) > 0);
}

/* The spline's points at the vertices of real faces, in their order. */
static void put_vertices(FILE *file, const pc_tspline *spline, bool exact) {
    const pc_tmesh *mesh = &spline->mesh;
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_index real = PC_NONE;
        bool border = false;
        for (pc_index h = 0; h < mesh->half_count; h++) {
            if (mesh->half[h].tail != v) continue;
            pc_index f = mesh->half[h].face;
            bool inside = f != PC_NONE && !mesh->face[f].ghost;
            if (inside) real = h;
            border |= !inside;
        }
        if (real == PC_NONE) continue;
        double at[2];
        pc_thalf_place(at, mesh, real);
        pc_surface_place place = pc_tspline_place(spline, mesh->half[real].face, at[0], at[1]);
        put(file, pc_tspline_point(spline, place), exact || border);
    }
}

static void limit_is_the_surface(void **state) {
    pc_context *ctx = *state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        pc_tspline spline;
        pc_polymesh cage;
        char points[64], obj[64];
        (void)snprintf(points, sizeof points, "/tmp/percale-cage-%ld", (long)getpid());
        (void)snprintf(obj, sizeof obj, "/tmp/percale-cage-%ld.obj", (long)getpid());
        make(&spline, ctx, cases[i].kind, cases[i].refined);
        assert_ok(ctx, pc_cage_make(&cage, ctx, &spline));
        FILE *file = fopen(points, "w");
        assert_non_null(file);
        assert_true(fprintf(file, "5 %g %u\n", cases[i].tolerance, cage.vertex_count) > 0);
        put_vertices(file, &spline, cases[i].tolerance < 1e-6);
        for (pc_index f = 0; f < spline.mesh.face_count; f++)
            for (int k = 0; k < 16 && !spline.mesh.face[f].ghost; k++) {
                const int line = k / 4;
                double s = spline.mesh.face[f].size[0] * (k % 4) / 4;
                double t = spline.mesh.face[f].size[1] * line / 4;
                put(file, pc_tspline_point(&spline, pc_tspline_place(&spline, f, s, t)), false);
            }
        assert_int_equal(fclose(file), 0);
        assert_ok(ctx, pc_cage_write(ctx, &spline, obj, false));
        assert_int_equal(pc_cage_write(ctx, &spline, obj, false), PC_E_IO); /* it is there */
        pc_context_clear_message(ctx);
        int result = run_python("tests/readers/check_cage.py", points, obj, "3");
        assert_int_equal(unlink(points) + unlink(obj), 0);
        skipped = result == PYTHON_SKIPS;
        if (!skipped) assert_int_equal(result, 0);
        pc_polymesh_free(&cage, ctx);
        pc_tspline_free(&spline, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(limit_is_the_surface, make_context, free_context),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    return failed == 0 && skipped ? PYTHON_SKIPS : failed;
}
