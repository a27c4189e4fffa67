/* Strips of quads doubled or drawn together: the count comes nearer, the surface stays the same. */
#include "memory.h"
#include "random.h"
#include "strips.h"
#include "surface_testing.h"
#include "synth_quads.h"
#include "vec3.h"

static bool change(pc_polymesh *mesh, pc_context *ctx, double wanted, double tolerance, int rank) {
    pc_polymesh changed;
    bool made;
    assert_ok(ctx, pc_strips_change(&changed, &made, ctx, mesh, NULL, wanted, tolerance, rank));
    assert_true(made == (changed.face_count > 0));
    if (!made) return false;
    pc_polymesh_free(mesh, ctx);
    *mesh = changed;
    return true;
}

/* Rows of five and columns of three: one more or one fewer, the one that fits. */
static void rows_and_columns(void **state) {
    pc_context *ctx = *state;
    static const struct {
        double wanted;
        pc_index faces, border;
    } cases[] = {{18, 18, 18}, {20, 20, 18}, {12, 12, 14}, {10, 10, 14}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        pc_polymesh mesh;
        assert_ok(ctx, pc_synth_quad_plane(&mesh, ctx, 5, 3, 5, 3));
        assert_true(change(&mesh, ctx, cases[i].wanted, 0.01, 0));
        pc_surface_count count = is_manifold(ctx, &mesh, 1, i);
        assert_int_equal(count.faces, cases[i].faces);
        assert_int_equal(count.boundary_edges, cases[i].border);
        assert_int_equal(count.loops, 1);
        pc_polymesh_free(&mesh, ctx);
    }
}

/* A count that is met, and one that no strip comes nearer to. */
static void nothing_to_do(void **state) {
    pc_context *ctx = *state;
    static const double wanted[] = {15, 16, 14};
    for (size_t i = 0; i < 3; i++) {
        pc_polymesh mesh;
        assert_ok(ctx, pc_synth_quad_plane(&mesh, ctx, 5, 3, 5, 3));
        assert_false(change(&mesh, ctx, wanted[i], 0.01, 0));
        pc_polymesh_free(&mesh, ctx);
    }
}

/* A face that is no quad: refused. */
static void polygons_are_left_alone(void **state) {
    pc_context *ctx = *state;
    pc_polymesh mesh;
    assert_ok(ctx, pc_synth_quad_tee(&mesh, ctx));
    assert_false(change(&mesh, ctx, 100, 0.01, 0));
    pc_polymesh_free(&mesh, ctx);
}

/* The cross of two strips of a quad sphere: doubling one that goes around adds 4n, whatever its rank. */
static void around_a_sphere(void **state) {
    pc_context *ctx = *state;
    enum { SIDE = 4, FACES = 6 * SIDE * SIDE, STRIP = 4 * SIDE, STRIPS = 3 * SIDE };
    for (int rank = 0; rank <= STRIPS; rank++) {
        pc_polymesh mesh;
        assert_ok(ctx, pc_synth_quad_sphere(&mesh, ctx, SIDE));
        bool made = change(&mesh, ctx, FACES + STRIP, 0.05, rank);
        assert_true(made == (rank < STRIPS));
        pc_surface_count count = is_manifold(ctx, &mesh, 2, (uint64_t)rank);
        assert_int_equal(count.faces, made ? FACES + STRIP : FACES);
        pc_polymesh_free(&mesh, ctx);
    }
}

/* Up and down to random counts, on tori, spheres and planes: never worse, always the same surface. */
static void random_counts(void **state) {
    pc_context *ctx = *state;
    pc_index changes = 0;
    for (uint64_t seed = 0; seed < 120; seed++) {
        pc_random random = {seed};
        pc_polymesh mesh;
        int64_t chi = seed % 3 == 0 ? 0 : seed % 3 == 1 ? 2 : 1;
        if (chi == 0) assert_ok(ctx, pc_synth_quad_torus(&mesh, ctx, 2, 1, 12, 9));
        if (chi == 2) assert_ok(ctx, pc_synth_quad_sphere(&mesh, ctx, 5));
        if (chi == 1) assert_ok(ctx, pc_synth_quad_plane(&mesh, ctx, 2, 1, 13, 11));
        for (int step = 0; step < 8; step++) {
            double wanted = (0.4 + 1.6 * pc_random_uniform(&random)) * mesh.face_count;
            double miss = fabs(mesh.face_count / wanted - 1);
            if (!change(&mesh, ctx, wanted, 0.05, (int)(pc_random_next(&random) % 3))) continue;
            changes++;
            is_manifold(ctx, &mesh, chi, seed);
            if (fabs(mesh.face_count / wanted - 1) >= miss)
                fail_msg("seed %llu: %u faces for %g, a miss of %g before", (unsigned long long)seed,
                         mesh.face_count, wanted, miss);
        }
        pc_polymesh_free(&mesh, ctx);
    }
    assert_true(changes > 500);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(rows_and_columns, make_context, free_context),
        cmocka_unit_test_setup_teardown(nothing_to_do, make_context, free_context),
        cmocka_unit_test_setup_teardown(polygons_are_left_alone, make_context, free_context),
        cmocka_unit_test_setup_teardown(around_a_sphere, make_context, free_context),
        cmocka_unit_test_setup_teardown(random_counts, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
