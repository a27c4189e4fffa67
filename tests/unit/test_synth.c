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
        for (pc_index steps = 6; steps <= 14; steps += 4) {
            pc_mesh mesh;
            pc_index boundary;
            assert_ok(ctx, pc_synth_blob(&mesh, ctx, genus, steps));
            assert_int_equal(euler(ctx, &mesh, &boundary), 2 - 2 * (int)genus);
            assert_int_equal(boundary, 0);
            assert_true(volume(&mesh) > 1);
            print_message("genus %u, %u steps: %u faces\n", genus, steps, mesh.face_count);
            pc_mesh_free(&mesh, ctx);
        }
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
        cmocka_unit_test_setup_teardown(holes_lower_chi_by_one_each, make_context, free_context),
        cmocka_unit_test_setup_teardown(wear_keeps_topology_and_repeats, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
