/* T-meshes and their basis before any refinement: grids are B-splines, extraordinary vertices are smooth. */
#include "continuity.h"
#include "memory.h"
#include "random.h"
#include "synth_quads.h"
#include "testing.h"
#include "tspline.h"
#include <math.h>

static const pc_tmesh_options defaults = PC_TMESH_DEFAULTS;

/* A cubic B-spline over knots i-2..i+2, by its closed form. */
static double hat(double x) {
    x = fabs(x);
    return x >= 2 ? 0 : x >= 1 ? (2 - x) * (2 - x) * (2 - x) / 6 : 2.0 / 3 - x * x + x * x * x / 2;
}

static void shuffle(pc_tspline *spline, uint64_t seed) {
    pc_random random = {seed};
    for (size_t i = 0; i < 3 * (size_t)spline->mesh.vertex_count; i++)
        spline->position[i] = pc_random_uniform(&random);
    pc_tspline_update(spline);
}

static void torus_is_a_periodic_spline(void **state) {
    pc_context *ctx = *state;
    const pc_index n = 9, m = 5;
    pc_polymesh quads;
    pc_tspline spline;
    assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 1, n, m));
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    assert_ok(ctx, pc_tspline_check(&spline, NULL, ctx));
    assert_int_equal(spline.basis.element_count, n * m);
    shuffle(&spline, 3);
    /* Each vertex by its corner of some face: the value there is a sum over the 3 x 3 vertices around. */
    for (pc_index f = 0; f < quads.face_count; f++) {
        pc_vec3 sum = {0, 0, 0};
        pc_index h = spline.mesh.face[f].first, v = spline.mesh.half[h].tail;
        sum = pc_scale(hat(0) * hat(0), pc_vec3_at(spline.position, v));
        for (int k = 0; k < 4; k++) {
            pc_index next = pc_thalf_head(&spline.mesh, h);
            pc_index across = pc_thalf_head(&spline.mesh, spline.mesh.half[h].next);
            sum = pc_madd(sum, hat(0) * hat(1), pc_vec3_at(spline.position, next));
            sum = pc_madd(sum, hat(1) * hat(1), pc_vec3_at(spline.position, across));
            h = pc_thalf_ccw(&spline.mesh, h);
        }
        pc_vec3 p = pc_tspline_point(&spline, pc_tspline_place(&spline, f, 0, 0));
        assert_true(pc_distance(p, sum) < 1e-14);
    }
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
}

/* An open grid reaches its border, and is the uniform B-spline of its control points. */
static void plane_is_a_spline(void **state) {
    pc_context *ctx = *state;
    pc_polymesh quads;
    pc_tspline spline;
    pc_random random = {11};
    assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 6, 4, 6, 4));
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    assert_ok(ctx, pc_tspline_check(&spline, NULL, ctx));
    assert_int_equal(spline.mesh.vertex_count, 9 * 7);
    double *place = NULL; /* control points of the identity are their own Greville points */
    assert_ok(ctx, pc_new(&place, ctx, 3 * (size_t)spline.mesh.vertex_count));
    memcpy(place, spline.position, 3 * sizeof(double) * spline.mesh.vertex_count);
    for (pc_index f = 0; f < 24; f++) {
        double s = pc_random_uniform(&random);
        double t = pc_random_uniform(&random);
        pc_surface_point p = pc_tspline_evaluate(&spline, pc_tspline_place(&spline, f, s, t));
        assert_true(pc_norm(pc_sub(pc_cross(p.s, p.t), (pc_vec3){0, 0, 1})) < 1e-14);
        assert_true(pc_norm(p.ss) + pc_norm(p.st) + pc_norm(p.tt) < 1e-13);
    }
    shuffle(&spline, 5);
    for (int i = 0; i < 200; i++) {
        pc_index f = (pc_index)(24 * pc_random_uniform(&random));
        double s = pc_random_uniform(&random);
        double t = pc_random_uniform(&random);
        pc_surface_point p = pc_tspline_evaluate(&spline, pc_tspline_place(&spline, f, s, t));
        pc_vec3 at = {0, 0, 0}, corner[2], sum = {0, 0, 0};
        corner[0] = pc_vec3_at(quads.position, quads.corner[4 * (size_t)f]);
        corner[1] = pc_vec3_at(quads.position, quads.corner[4 * (size_t)f + 1]);
        pc_vec3 along = pc_sub(corner[1], corner[0]);
        at = pc_madd(pc_madd(corner[0], s, along), t, (pc_vec3){-along.y, along.x, 0});
        for (pc_index v = 0; v < spline.mesh.vertex_count; v++)
            sum = pc_madd(sum, hat(at.x - place[3 * v]) * hat(at.y - place[3 * v + 1]),
                          pc_vec3_at(spline.position, v));
        assert_true(pc_distance(p.p, sum) < 1e-14);
    }
    pc_free(ctx, place);
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
}

/* A barrel of rhombs between two poles of valence n, whose neighbours on the n-gons have valence 3. Vertex i
 * of ring k is at the angle of (i + k/2)/n turns. */
static void make_barrel(pc_polymesh *quads, pc_context *ctx, pc_index n, pc_index rings) {
    const pc_index last = n * rings;
    assert_ok(ctx, pc_polymesh_make(quads, ctx, (size_t)last + 2, last, 4 * (size_t)last));
    for (pc_index v = 0; v < last; v++) {
        const double angle = 2 * PC_PI * (v % n + 0.5 * (v / n)) / n; /* NOLINT(bugprone-integer-division) */
        pc_vec3_put(quads->position, v, (pc_vec3){cos(angle), sin(angle), v / n});
    }
    pc_vec3_put(quads->position, last, (pc_vec3){0, 0, -1});
    pc_vec3_put(quads->position, last + 1, (pc_vec3){0, 0, rings});
    for (pc_index f = 0; f <= last; f++)
        quads->start[f] = 4 * f;
    for (pc_index f = 0; f < last; f++) { /* below it ring f / n - 1, the pole first */
        const pc_index i = f % n, left = i ? i - 1 : n - 1, k = f / n;
        pc_index *corner = quads->corner + 4 * (size_t)f;
        corner[0] = k ? (k - 1) * n + i : last;
        corner[1] = k * n + i;
        corner[2] = k + 1 < rings ? (k + 1) * n + left : last + 1;
        corner[3] = k * n + left;
    }
}

/* Around a vertex of high valence no face alone shows that the functions of all of them are independent. */
static void faces_show_functions_together(void **state) {
    pc_context *ctx = *state;
    for (pc_index k = 0; k < 4 * 12; k++) {
        const pc_index n = 3 + k % 12, rings = 3 + k / 12;
        pc_polymesh quads;
        pc_tspline spline;
        make_barrel(&quads, ctx, n, rings);
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        if (pc_tspline_check(&spline, NULL, ctx) != PC_OK)
            fail_msg("valence %u, %u rings: %s", n, rings, pc_context_message(ctx));
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
    }
}

/* The sphere of six n x n sides; its eight extraordinary vertices touch each other for n = 1. */
static void spheres_are_smooth(void **state) {
    pc_context *ctx = *state;
    for (pc_index n = 1; n <= 4; n++) {
        double last = 1;
        for (uint8_t depth = 0; depth <= 4; depth++) {
            pc_polymesh quads;
            pc_tspline spline;
            pc_basis_facts facts;
            pc_jump jump[PC_JOINT_COUNT];
            pc_tmesh_options options = {.depth = depth};
            assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, n));
            assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &options));
            pc_status status = pc_tspline_check(&spline, &facts, ctx);
            assert_int_equal(status, n == 1 ? PC_E_MESH : PC_OK);
            pc_continuity_measure(jump, &spline, 5);
            for (int c = 0; c < PC_JOINT_COUNT; c++) {
                assert_true(jump[c].gap < 1e-14);
                if (c < PC_JOINT_SPOKE) assert_true(jump[c].normal_max < 1e-7);
                if (c < PC_JOINT_CLOSING) assert_true(jump[c].curvature_max < 1e-9);
            }
            print_message("sphere %u, depth %d: spokes %.2g rad mean, %.2g max\n", n, depth,
                          jump[PC_JOINT_SPOKE].normal_mean, jump[PC_JOINT_SPOKE].normal_max);
            assert_true(jump[PC_JOINT_SPOKE].normal_max < last);
            last = jump[PC_JOINT_SPOKE].normal_max;
            pc_tspline_free(&spline, ctx);
            pc_polymesh_free(&quads, ctx);
        }
    }
}

/* A rectangle with a T-junction in the middle. */
static void tee_is_a_spline(void **state) {
    pc_context *ctx = *state;
    pc_polymesh quads;
    pc_tspline spline;
    pc_basis_facts facts;
    assert_ok(ctx, pc_synth_quad_tee(&quads, ctx));
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    assert_ok(ctx, pc_tspline_check(&spline, &facts, ctx));
    for (pc_index v = 0; v < spline.mesh.vertex_count; v++)
        assert_false(spline.mesh.vertex[v].extraordinary);
    for (pc_index q = 0; q < quads.vertex_count; q++) {
        double least = INFINITY;
        for (pc_index v = 0; v < spline.mesh.vertex_count; v++)
            least = fmin(least, pc_distance(pc_vec3_at(spline.position, v), pc_vec3_at(quads.position, q)));
        assert_true(least == 0);
    }
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
}

/* Three faces at one edge: quads, and with a triangle. */
static void fins_are_refused(void **state) {
    pc_context *ctx = *state;
    const pc_index corner[12] = {0, 1, 2, 3, 1, 0, 4, 5, 0, 1, 6, 7};
    for (pc_index missing = 0; missing < 2; missing++) {
        pc_polymesh quads;
        pc_tspline spline;
        assert_ok(ctx, pc_polymesh_make(&quads, ctx, 8, 3, 12));
        for (pc_index v = 0; v < 8; v++)
            pc_vec3_put(quads.position, v, (pc_vec3){v % 2, 0.5 * v, v % 3});
        memcpy(quads.corner, corner, sizeof corner);
        for (pc_index f = 0; f <= 3; f++)
            quads.start[f] = f < 3 ? 4 * f : 12 - missing;
        assert_int_equal(pc_tspline_make(&spline, ctx, &quads, &defaults), PC_E_MESH);
        pc_context_clear_message(ctx);
        pc_polymesh_free(&quads, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(torus_is_a_periodic_spline, make_context, free_context),
        cmocka_unit_test_setup_teardown(plane_is_a_spline, make_context, free_context),
        cmocka_unit_test_setup_teardown(faces_show_functions_together, make_context, free_context),
        cmocka_unit_test_setup_teardown(spheres_are_smooth, make_context, free_context),
        cmocka_unit_test_setup_teardown(tee_is_a_spline, make_context, free_context),
        cmocka_unit_test_setup_teardown(fins_are_refused, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
