/* The generator of synthetic scans: topology exact, same seed same bytes. */
#include "adjacency.h"
#include "memory.h"
#include "synth.h"
#include "synth_blob.h"
#include "synth_wear.h"
#include "testing.h"

static int euler(pc_context *ctx, const pc_mesh *mesh, pc_index *boundary) {
    pc_adjacency a;
    assert_ok(ctx, pc_mesh_check(mesh, ctx));
    assert_ok(ctx, pc_adjacency_make(&a, ctx, mesh));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        assert_int_not_equal(a.vertex_half[v], PC_NONE);
    int chi = (int)mesh->vertex_count - (int)a.edge_count + (int)mesh->face_count;
    if (boundary) *boundary = a.boundary_edge_count;
    pc_adjacency_free(&a, ctx);
    return chi;
}

static double volume(const pc_mesh *mesh) {
    double sum = 0;
    for (size_t f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * f;
        pc_vec3 a = pc_vec3_at(mesh->position, t[0]), b = pc_vec3_at(mesh->position, t[1]);
        sum += pc_dot(a, pc_cross(b, pc_vec3_at(mesh->position, t[2]))) / 6;
    }
    return sum;
}

static uint64_t digest(const pc_mesh *mesh) {
    uint64_t h = 1469598103934665603u;
    const unsigned char *bytes = (const unsigned char *)mesh->position;
    for (size_t i = 0; i < 24 * (size_t)mesh->vertex_count; i++)
        h = (h ^ bytes[i]) * 1099511628211u;
    for (size_t i = 0; i < 3 * (size_t)mesh->face_count; i++)
        h = (h ^ mesh->triangle[i]) * 1099511628211u;
    return h;
}

static void blobs_have_their_genus(void **state) {
    pc_context *ctx = *state;
    for (pc_index genus = 0; genus <= 7; genus++)
        for (pc_index steps = 6; steps <= 10; steps += 4) {
            pc_mesh mesh;
            pc_index boundary;
            assert_ok(ctx, pc_synth_blob(&mesh, ctx, genus, steps));
            assert_int_equal(euler(ctx, &mesh, &boundary), 2 - 2 * (int)genus);
            assert_int_equal(boundary, 0);
            assert_true(volume(&mesh) > 1);
            pc_mesh_free(&mesh, ctx);
        }
}

static void cube_and_vase_are_spheres(void **state) {
    pc_context *ctx = *state;
    for (pc_index n = 1; n <= 9; n++) {
        pc_mesh mesh;
        pc_index boundary;
        assert_ok(ctx, pc_synth_cube(&mesh, ctx, n));
        assert_int_equal(euler(ctx, &mesh, &boundary), 2);
        assert_int_equal(boundary, 0);
        assert_true(fabs(volume(&mesh) - 8) < 1e-12);
        pc_mesh_free(&mesh, ctx);
        assert_ok(ctx, pc_synth_vase(&mesh, ctx, n, n + 2));
        assert_int_equal(euler(ctx, &mesh, &boundary), 2);
        assert_true(boundary == 0 && volume(&mesh) > 0.1);
        pc_mesh_free(&mesh, ctx);
    }
    const double open[6] = {1, 0, 2, 1, 1, 2};
    pc_mesh mesh;
    pc_index boundary;
    assert_ok(ctx, pc_synth_revolution(&mesh, ctx, open, 3, 10));
    assert_int_equal(euler(ctx, &mesh, &boundary), 0);
    assert_int_equal(boundary, 20);
    pc_mesh_free(&mesh, ctx);
}

static void unwelded_and_soup(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_cube(&mesh, ctx, 3));
    assert_ok(ctx, pc_synth_unweld(&mesh, ctx));
    assert_int_equal(mesh.vertex_count, 3 * mesh.face_count);
    assert_int_equal(euler(ctx, &mesh, NULL), (int)mesh.face_count);
    pc_mesh_free(&mesh, ctx);
    assert_ok(ctx, pc_synth_soup(&mesh, ctx, 40, 500, 3));
    assert_ok(ctx, pc_mesh_check(&mesh, ctx));
    pc_mesh_free(&mesh, ctx);
    assert_int_equal(pc_synth_soup(&mesh, ctx, 2, 5, 3), PC_E_USAGE);
    pc_context_clear_message(ctx);
}

static void noise_has_its_size(void **state) {
    pc_context *ctx = *state;
    for (int smooth = 0; smooth < 2; smooth++) {
        pc_mesh mesh;
        double square = 0;
        assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 60));
        double edge = pc_synth_mean_edge(&mesh);
        if (smooth)
            assert_ok(ctx, pc_synth_ripple(&mesh, ctx, 0.2, 8, 1));
        else
            assert_ok(ctx, pc_synth_noise(&mesh, ctx, 0.2, 1));
        for (size_t v = 0; v < mesh.vertex_count; v++)
            square += pow(pc_norm(pc_vec3_at(mesh.position, v)) - 1, 2);
        double deviation = sqrt(square / mesh.vertex_count) / edge;
        if (fabs(deviation - 0.2) > (smooth ? 0.05 : 0.01)) fail_msg("deviation %g", deviation);
        pc_mesh_free(&mesh, ctx);
    }
}

static void curved_subdivision_nears_the_sphere(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 8));
    assert_ok(ctx, pc_synth_subdivide(&mesh, ctx, false));
    double flat = volume(&mesh);
    pc_mesh_free(&mesh, ctx);
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 8));
    assert_ok(ctx, pc_synth_subdivide(&mesh, ctx, true));
    assert_int_equal(mesh.face_count, 4 * 512);
    double round = volume(&mesh), exact = 4 * PC_PI / 3;
    assert_true(exact - round < (exact - flat) / 3 && round < exact);
    pc_mesh_free(&mesh, ctx);
}

static void holes_lower_chi_by_one_each(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 20; seed++) {
        pc_mesh mesh;
        pc_index boundary;
        assert_ok(ctx, pc_synth_blob(&mesh, ctx, 2, 10));
        assert_ok(ctx, pc_synth_holes(&mesh, ctx, 9, 40, seed));
        int chi = euler(ctx, &mesh, &boundary);
        if (chi != -2 - 9) fail_msg("seed %llu: chi %d", (unsigned long long)seed, chi);
        assert_true(boundary > 9 * 3);
        pc_mesh_free(&mesh, ctx);
    }
}

static void wear_keeps_topology_and_repeats(void **state) {
    pc_context *ctx = *state;
    uint64_t digests[2] = {0};
    for (int round = 0; round < 2; round++) {
        pc_mesh mesh, other;
        assert_ok(ctx, pc_synth_blob(&mesh, ctx, 3, 8));
        assert_ok(ctx, pc_synth_needles(&mesh, ctx, 0.1, 5));
        assert_ok(ctx, pc_synth_subdivide(&mesh, ctx, true));
        assert_ok(ctx, pc_synth_noise(&mesh, ctx, 0.1, 1));
        assert_ok(ctx, pc_synth_ripple(&mesh, ctx, 0.2, 6, 2));
        assert_ok(ctx, pc_synth_holes(&mesh, ctx, 4, 100, 3));
        assert_ok(ctx, pc_synth_torus(&other, ctx, 2, 1, 20, 10));
        assert_ok(ctx, pc_synth_append(&mesh, ctx, &other, (pc_vec3){0, 9, 0}));
        assert_ok(ctx, pc_synth_shuffle(&mesh, ctx, 4));
        assert_int_equal(euler(ctx, &mesh, NULL), -4 - 4);
        digests[round] = digest(&mesh);
        pc_mesh_free(&other, ctx);
        pc_mesh_free(&mesh, ctx);
    }
    assert_true(digests[0] == digests[1]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(blobs_have_their_genus, make_context, free_context),
        cmocka_unit_test_setup_teardown(cube_and_vase_are_spheres, make_context, free_context),
        cmocka_unit_test_setup_teardown(unwelded_and_soup, make_context, free_context),
        cmocka_unit_test_setup_teardown(noise_has_its_size, make_context, free_context),
        cmocka_unit_test_setup_teardown(curved_subdivision_nears_the_sphere, make_context, free_context),
        cmocka_unit_test_setup_teardown(holes_lower_chi_by_one_each, make_context, free_context),
        cmocka_unit_test_setup_teardown(wear_keeps_topology_and_repeats, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
