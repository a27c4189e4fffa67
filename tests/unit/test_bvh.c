/* Closest points: the tree against a plain loop over all triangles. */
#include "bvh.h"
#include "memory.h"
#include "random.h"
#include "synth.h"
#include "synth_blob.h"
#include "synth_wear.h"
#include "testing.h"

static pc_bvh_hit brute_force(const pc_mesh *mesh, pc_vec3 p) {
    pc_bvh_hit hit = {.face = PC_NONE};
    double best = INFINITY;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        double weight[3];
        double d2 =
            pc_closest_on_triangle(weight, p, pc_vec3_at(mesh->position, t[0]),
                                   pc_vec3_at(mesh->position, t[1]), pc_vec3_at(mesh->position, t[2]));
        if (d2 < best) best = d2, hit.face = f;
    }
    hit.distance = sqrt(best);
    return hit;
}

static void compare(pc_context *ctx, const pc_mesh *mesh, pc_vec3 centre, double size, uint64_t seed) {
    pc_bvh bvh;
    pc_random random = {seed};
    assert_ok(ctx, pc_bvh_make(&bvh, ctx, mesh));
    for (int i = 0; i < 400; i++) {
        pc_vec3 p = {pc_random_uniform(&random) - 0.5, pc_random_uniform(&random) - 0.5,
                     pc_random_uniform(&random) - 0.5};
        p = pc_madd(centre, i % 4 == 3 ? 100 * size : size, p);
        if (i % 4 == 1) p = pc_vec3_at(mesh->position, pc_random_next(&random) % mesh->vertex_count);
        pc_index hint = i % 2 ? (pc_index)(pc_random_next(&random) % mesh->face_count) : PC_NONE;
        pc_bvh_hit hit = pc_bvh_closest(&bvh, p, hint), truth = brute_force(mesh, p);
        if (hit.face != truth.face || hit.distance != truth.distance)
            fail_msg("seed %llu, point %d: face %u at %.17g, not %u at %.17g", (unsigned long long)seed, i,
                     hit.face, hit.distance, truth.face, truth.distance);
        double sum = hit.weight[0] + hit.weight[1] + hit.weight[2];
        assert_true(fabs(sum - 1) < 1e-12 &&
                    fabs(pc_distance(hit.point, p) - hit.distance) <= 1e-12 * size + 1e-15 * pc_norm(p));
    }
    pc_bvh_free(&bvh, ctx);
}

static void tree_agrees_with_a_loop(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_blob(&mesh, ctx, 2, 8));
    assert_ok(ctx, pc_synth_noise(&mesh, ctx, 0.2, 1));
    compare(ctx, &mesh, (pc_vec3){1, 0, 0}, 6, 1);
    assert_ok(ctx, pc_synth_needles(&mesh, ctx, 0.3, 2));
    compare(ctx, &mesh, (pc_vec3){1, 0, 0}, 3, 2);
    pc_mesh_free(&mesh, ctx);
    assert_ok(ctx, pc_synth_soup(&mesh, ctx, 300, 1500, 7));
    compare(ctx, &mesh, (pc_vec3){0.5, 0.5, 0.5}, 1, 3);
    pc_mesh_free(&mesh, ctx);
    assert_ok(ctx, pc_synth_plane(&mesh, ctx, 3, 2, 30, 20));
    compare(ctx, &mesh, (pc_vec3){1.5, 1, 0}, 3, 4);
    pc_mesh_free(&mesh, ctx);
}

static void frame_and_size_do_not_matter(void **state) {
    pc_context *ctx = *state;
    const double scales[3] = {1e-25, 1, 1e22}, moves[3] = {0, 5e6, 0};
    for (int i = 0; i < 3; i++) {
        pc_mesh mesh;
        assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 1, 40, 20));
        for (size_t c = 0; c < 3 * (size_t)mesh.vertex_count; c++)
            mesh.position[c] = scales[i] * mesh.position[c] + moves[i];
        compare(ctx, &mesh, (pc_vec3){moves[i], moves[i], moves[i]}, 6 * scales[i], 10 + (uint64_t)i);
        pc_mesh_free(&mesh, ctx);
    }
}

static void small_meshes(void **state) {
    pc_context *ctx = *state;
    for (pc_index faces = 0; faces < 70; faces++) {
        pc_mesh mesh;
        pc_bvh bvh;
        assert_ok(ctx, pc_synth_soup(&mesh, ctx, 9, faces, faces));
        if (faces) {
            compare(ctx, &mesh, (pc_vec3){0.5, 0.5, 0.5}, 2, 100 + faces);
        } else {
            assert_ok(ctx, pc_bvh_make(&bvh, ctx, &mesh));
            assert_int_equal(pc_bvh_closest(&bvh, (pc_vec3){0, 0, 0}, PC_NONE).face, PC_NONE);
            pc_bvh_free(&bvh, ctx);
        }
        pc_mesh_free(&mesh, ctx);
    }
}

static void degenerate_triangles_are_segments(void **state) {
    (void)state;
    double weight[3];
    pc_vec3 a = {0, 0, 0}, b = {2, 0, 0}, c = {1, 0, 0}, p = {1.5, 3, 4};
    assert_true(fabs(pc_closest_on_triangle(weight, p, a, b, c) - 25) < 1e-12);
    assert_true(fabs(pc_closest_on_triangle(weight, p, a, a, a) - 27.25) < 1e-12);
}

static void refused_memory_leaves_nothing(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_bvh bvh;
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 10));
    for (size_t n = 1; n <= 3; n++) {
        pc_memory_fail_at(ctx, n);
        assert_int_equal(pc_bvh_make(&bvh, ctx, &mesh), PC_E_NOMEM);
    }
    pc_memory_fail_at(ctx, 0);
    pc_mesh_free(&mesh, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(tree_agrees_with_a_loop, make_context, free_context),
        cmocka_unit_test_setup_teardown(frame_and_size_do_not_matter, make_context, free_context),
        cmocka_unit_test_setup_teardown(small_meshes, make_context, free_context),
        cmocka_unit_test_setup_teardown(degenerate_triangles_are_segments, make_context, free_context),
        cmocka_unit_test_setup_teardown(refused_memory_leaves_nothing, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
