/* Collapsed quads leave manifolds of the same Euler number. */
#include "collapse.h"
#include "doublet.h"
#include "memory.h"
#include "random.h"
#include "surface_testing.h"
#include "synth_quads.h"
#include "vec3.h"

static pc_index collapse(pc_polymesh *mesh, pc_context *ctx, const uint8_t *wanted) {
    pc_index collapsed = PC_NONE;
    assert_ok(ctx, pc_quads_collapse(mesh, &collapsed, ctx, wanted));
    return collapsed;
}

/* One face, one vertex, two edges fewer; the vertex that is left stands between the two. */
static void one_quad_of_a_grid(void **state) {
    pc_context *ctx = *state;
    enum { SIDE = 5 };
    uint8_t wanted[SIDE * SIDE] = {0};
    pc_polymesh mesh;
    assert_ok(ctx, pc_synth_quad_plane(&mesh, ctx, SIDE, SIDE, SIDE, SIDE));
    pc_surface_count before = is_manifold(ctx, &mesh, 1, 0);
    wanted[SIDE * 2 + 2] = 1;
    assert_int_equal(collapse(&mesh, ctx, wanted), 1);
    pc_surface_count after = is_manifold(ctx, &mesh, 1, 0);
    assert_int_equal(after.faces + 1, before.faces);
    assert_int_equal(after.vertices + 1, before.vertices);
    assert_int_equal(after.edges + 2, before.edges);
    assert_int_equal(after.boundary_edges, before.boundary_edges);
    pc_index in_middle = 0;
    for (pc_index v = 0; v < mesh.vertex_count; v++)
        in_middle += pc_distance(pc_vec3_at(mesh.position, v), (pc_vec3){2.5, 2.5, 0}) < 1e-12;
    assert_int_equal(in_middle, 1);
    pc_polymesh_free(&mesh, ctx);
}

/* Nothing is flagged, or all corners are on a border: the mesh stays to the byte. */
static void refusals(void **state) {
    pc_context *ctx = *state;
    for (int kind = 0; kind < 3; kind++) {
        uint8_t wanted[9];
        pc_polymesh mesh, before;
        pc_index nx = kind == 2 ? 3 : 1 + 8 * (pc_index)kind, ny = kind == 2 ? 3 : 1;
        memset(wanted, kind != 2, sizeof wanted);
        assert_ok(ctx, pc_synth_quad_plane(&mesh, ctx, 3, 1, nx, ny));
        assert_ok(ctx, pc_synth_quad_plane(&before, ctx, 3, 1, nx, ny));
        assert_int_equal(collapse(&mesh, ctx, wanted), 0);
        assert_int_equal(mesh.face_count, before.face_count);
        assert_int_equal(mesh.vertex_count, before.vertex_count);
        assert_memory_equal(mesh.corner, before.corner, 4 * sizeof(pc_index) * mesh.face_count);
        assert_memory_equal(mesh.position, before.position, 3 * sizeof(double) * mesh.vertex_count);
        pc_polymesh_free(&mesh, ctx);
        pc_polymesh_free(&before, ctx);
    }
}

/* The vertex of a quad that is on a border stays there. */
static void borders_keep_their_place(void **state) {
    pc_context *ctx = *state;
    for (pc_index f = 0; f < 36; f++) {
        uint8_t wanted[36] = {0};
        pc_polymesh mesh;
        assert_ok(ctx, pc_synth_quad_plane(&mesh, ctx, 6, 6, 6, 6));
        wanted[f] = 1;
        collapse(&mesh, ctx, wanted);
        pc_surface_count count = is_manifold(ctx, &mesh, 1, f);
        assert_int_equal(count.boundary_edges, 24);
        pc_index on_border = 0;
        for (size_t v = 0; v < mesh.vertex_count; v++) {
            double x = mesh.position[3 * v], y = mesh.position[3 * v + 1];
            on_border += x == 0 || x == 6 || y == 0 || y == 6;
        }
        assert_int_equal(on_border, 24);
        pc_polymesh_free(&mesh, ctx);
    }
}

static int64_t make_shape(pc_polymesh *mesh, pc_context *ctx, uint64_t seed) {
    pc_index size = 2 + (pc_index)(seed / 3 % 5);
    if (seed % 3 == 0) {
        assert_ok(ctx, pc_synth_quad_torus(mesh, ctx, 2, 1, 3 * size, 2 * size));
        return 0;
    }
    if (seed % 3 == 1) {
        assert_ok(ctx, pc_synth_quad_sphere(mesh, ctx, size));
        return 2;
    }
    assert_ok(ctx, pc_synth_quad_plane(mesh, ctx, 2, 1, 3 * size, 2 * size));
    return 1;
}

/* Random flags, again and again on what is left, with doublets removed in between every other time. */
static void random_flags(void **state) {
    pc_context *ctx = *state;
    pc_index total = 0;
    for (uint64_t seed = 0; seed < 300; seed++) {
        pc_random random = {seed};
        pc_polymesh mesh;
        int64_t chi = make_shape(&mesh, ctx, seed);
        double share = seed % 5 == 0 ? 1 : 0.02 + 0.4 * pc_random_uniform(&random);
        for (int round = 0; round < 12; round++) {
            pc_index faces = mesh.face_count, vertices = mesh.vertex_count, doublets = 0;
            uint8_t *wanted;
            assert_ok(ctx, pc_new(&wanted, ctx, faces));
            for (pc_index f = 0; f < faces; f++)
                wanted[f] = pc_random_uniform(&random) < share;
            pc_index collapsed = collapse(&mesh, ctx, wanted);
            pc_free(ctx, wanted);
            is_manifold(ctx, &mesh, chi, seed);
            if (mesh.face_count + collapsed != faces || mesh.vertex_count + collapsed != vertices)
                fail_msg("seed %llu: %u faces, %u vertices left of %u, %u after %u collapses",
                         (unsigned long long)seed, mesh.face_count, mesh.vertex_count, faces, vertices,
                         collapsed);
            if (seed % 2) assert_ok(ctx, pc_doublets_remove(&mesh, &doublets, ctx, false));
            is_manifold(ctx, &mesh, chi, seed);
            total += collapsed;
        }
        pc_polymesh_free(&mesh, ctx);
    }
    assert_true(total > 3000);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(one_quad_of_a_grid, make_context, free_context),
        cmocka_unit_test_setup_teardown(refusals, make_context, free_context),
        cmocka_unit_test_setup_teardown(borders_keep_their_place, make_context, free_context),
        cmocka_unit_test_setup_teardown(random_flags, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
