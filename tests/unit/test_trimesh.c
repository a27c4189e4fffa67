/* Meshes and their adjacency on shapes of known topology. */
#include "adjacency.h"
#include "memory.h"
#include "synth.h"
#include "testing.h"

static int euler(const pc_mesh *mesh, const pc_adjacency *a) {
    return (int)mesh->vertex_count - (int)a->edge_count + (int)mesh->face_count;
}

static void shapes_have_their_euler_number(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_adjacency a;
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 7));
    assert_ok(ctx, pc_mesh_check(&mesh, ctx));
    assert_ok(ctx, pc_adjacency_make(&a, ctx, &mesh));
    assert_int_equal(euler(&mesh, &a), 2);
    assert_int_equal(a.boundary_edge_count, 0);
    pc_adjacency_free(&a, ctx);
    pc_mesh_free(&mesh, ctx);

    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 1, 20, 10));
    assert_ok(ctx, pc_adjacency_make(&a, ctx, &mesh));
    assert_int_equal(euler(&mesh, &a), 0);
    pc_adjacency_free(&a, ctx);
    pc_mesh_free(&mesh, ctx);

    assert_ok(ctx, pc_synth_cylinder(&mesh, ctx, 2, 12, 5));
    assert_ok(ctx, pc_adjacency_make(&a, ctx, &mesh));
    assert_int_equal(euler(&mesh, &a), 0);
    assert_int_equal(a.boundary_edge_count, 24);
    pc_adjacency_free(&a, ctx);
    pc_mesh_free(&mesh, ctx);
}

static void third_face_on_an_edge_is_refused(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_adjacency a;
    const pc_index faces[9] = {0, 1, 2, 1, 0, 3, 0, 1, 4};
    assert_ok(ctx, pc_mesh_make(&mesh, ctx, 5, 3));
    for (int i = 0; i < 9; i++)
        mesh.triangle[i] = faces[i];
    assert_int_equal(pc_adjacency_make(&a, ctx, &mesh), PC_E_MESH);
    assert_non_null(strstr(pc_context_message(ctx), "0-1"));
    pc_mesh_free(&mesh, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(shapes_have_their_euler_number, make_context, free_context),
        cmocka_unit_test_setup_teardown(third_face_on_an_edge_is_refused, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
