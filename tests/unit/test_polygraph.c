/* What a polygon mesh is as a surface, whole and broken; polygons as triangles. */
#include "memory.h"
#include "polygraph.h"
#include "polysurface.h"
#include "synth.h"
#include "synth_blob.h"
#include "synth_quads.h"
#include "synth_wear.h"
#include "testing.h"
#include "vec3.h"

static pc_surface_count count_of(pc_context *ctx, const pc_polymesh *mesh) {
    pc_polygraph graph;
    assert_ok(ctx, pc_polygraph_of_polymesh(&graph, ctx, mesh));
    pc_surface_count count = graph.count;
    for (pc_index c = 0; c < graph.corner_count; c++)
        if (graph.twin[c] != PC_NONE) assert_int_equal(graph.twin[graph.twin[c]], c);
    pc_polygraph_free(&graph, ctx);
    return count;
}

static void assert_manifold(const pc_surface_count *c) {
    assert_int_equal(c->overfull_edges, 0);
    assert_int_equal(c->clashing_edges, 0);
    assert_int_equal(c->split_vertices, 0);
    assert_int_equal(c->broken_faces, 0);
    assert_int_equal(c->unused_vertices, 0);
}

static void whole_meshes(void **state) {
    pc_context *ctx = *state;
    pc_polymesh mesh;
    pc_surface_count c;
    assert_ok(ctx, pc_synth_quad_torus(&mesh, ctx, 2, 1, 12, 7));
    c = count_of(ctx, &mesh);
    assert_manifold(&c);
    assert_true(c.chi == 0 && c.loops == 0 && c.components == 1 && c.edges == 2 * 12 * 7);
    pc_polymesh_free(&mesh, ctx);
    assert_ok(ctx, pc_synth_quad_sphere(&mesh, ctx, 5));
    c = count_of(ctx, &mesh);
    assert_manifold(&c);
    assert_true(c.chi == 2 && c.loops == 0 && c.components == 1);
    pc_polymesh_free(&mesh, ctx);
    assert_ok(ctx, pc_synth_quad_tee(&mesh, ctx));
    c = count_of(ctx, &mesh);
    assert_manifold(&c);
    assert_true(c.chi == 1 && c.loops == 1 && c.edges == 10 && c.boundary_edges == 7);
    pc_polymesh_free(&mesh, ctx);
}

static void triangles_with_holes_and_pieces(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh, other;
    pc_polygraph graph;
    assert_ok(ctx, pc_synth_blob(&mesh, ctx, 3, 8));
    assert_ok(ctx, pc_synth_holes(&mesh, ctx, 5, 30, 9));
    assert_ok(ctx, pc_synth_cylinder(&other, ctx, 1, 9, 3));
    assert_ok(ctx, pc_synth_append(&mesh, ctx, &other, (pc_vec3){0, 9, 0}));
    assert_ok(ctx, pc_synth_shuffle(&mesh, ctx, 1));
    assert_ok(ctx, pc_polygraph_of_mesh(&graph, ctx, &mesh));
    assert_manifold(&graph.count);
    assert_true(graph.count.chi == -4 - 5 && graph.count.loops == 5 + 2 && graph.count.components == 2);
    assert_int_equal(graph.face_component[0], 0);
    pc_polygraph_free(&graph, ctx);
    pc_mesh_free(&other, ctx);
    pc_mesh_free(&mesh, ctx);
}

static void faults_are_counted(void **state) {
    pc_context *ctx = *state;
    pc_polymesh mesh;
    pc_surface_count c;
    assert_ok(ctx, pc_synth_quad_torus(&mesh, ctx, 2, 1, 9, 8));
    pc_index *quad = mesh.corner + 40, keep = quad[1];
    quad[1] = quad[3], quad[3] = keep; /* a flipped face clashes with its four neighbours */
    c = count_of(ctx, &mesh);
    assert_int_equal(c.clashing_edges, 4);
    quad[3] = quad[1], quad[1] = keep;

    mesh.face_count--; /* the last face is missing: one loop of four */
    c = count_of(ctx, &mesh);
    assert_true(c.loops == 1 && c.boundary_edges == 4 && c.chi == -1);
    mesh.face_count++;

    memcpy(mesh.corner, mesh.corner + 40, 4 * sizeof *quad); /* a doubled face in the place of another */
    c = count_of(ctx, &mesh);
    assert_int_equal(c.overfull_edges, 4);
    assert_int_equal(c.boundary_edges, 4);
    pc_polymesh_free(&mesh, ctx);

    assert_ok(ctx, pc_synth_quad_plane(&mesh, ctx, 2, 2, 2, 2));
    mesh.corner[4] = mesh.corner[5]; /* a repeated vertex */
    c = count_of(ctx, &mesh);
    assert_int_equal(c.broken_faces, 1);
    mesh.corner[7] = 99;
    pc_polygraph graph;
    assert_int_equal(pc_polygraph_of_polymesh(&graph, ctx, &mesh), PC_E_BUG);
    pc_context_clear_message(ctx);
    pc_polymesh_free(&mesh, ctx);
}

static void bow_tie_has_two_fans(void **state) {
    pc_context *ctx = *state;
    pc_polymesh mesh;
    assert_ok(ctx, pc_synth_quad_plane(&mesh, ctx, 2, 2, 2, 2));
    memcpy(mesh.corner + 4, mesh.corner + 12,
           4 * sizeof *mesh.corner); /* the two faces on the diagonal stay */
    mesh.face_count = 2;
    pc_surface_count c = count_of(ctx, &mesh);
    assert_int_equal(c.split_vertices, 1);
    assert_int_equal(c.components, 2);
    assert_int_equal(c.unused_vertices, 2);
    assert_int_equal(c.loops, 2);
    pc_polymesh_free(&mesh, ctx);
}

static void soup_never_crashes(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 50; seed++) {
        pc_mesh mesh;
        pc_polygraph graph;
        assert_ok(ctx, pc_synth_soup(&mesh, ctx, 5 + (pc_index)seed, 60, seed));
        assert_ok(ctx, pc_polygraph_of_mesh(&graph, ctx, &mesh));
        pc_surface_count c = graph.count;
        assert_true(c.vertices + c.unused_vertices == mesh.vertex_count && c.edges <= 180 &&
                    c.components > 0);
        pc_polygraph_free(&graph, ctx);
        pc_mesh_free(&mesh, ctx);
    }
}

static double area_of(const pc_mesh *mesh, double *least_up) {
    double sum = 0;
    *least_up = INFINITY;
    for (size_t f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * f;
        pc_vec3 a = pc_vec3_at(mesh->position, t[0]), b = pc_vec3_at(mesh->position, t[1]);
        pc_vec3 n = pc_cross(pc_sub(b, a), pc_sub(pc_vec3_at(mesh->position, t[2]), a));
        sum += pc_norm(n) / 2;
        *least_up = fmin(*least_up, n.z);
    }
    return sum;
}

static void triangles_cover_polygons(void **state) {
    pc_context *ctx = *state;
    pc_polymesh mesh;
    pc_mesh cut;
    pc_index *source;
    double least;
    assert_ok(ctx, pc_synth_quad_tee(&mesh, ctx));
    assert_ok(ctx, pc_polysurface_make(&cut, &source, ctx, &mesh));
    assert_int_equal(cut.face_count, 7);
    assert_true(fabs(area_of(&cut, &least) - 2) < 1e-12 && least > 0.1);
    assert_true(source[0] == 0 && source[2] == 0 && source[3] == 1 && source[6] == 2);
    pc_free(ctx, source);
    pc_mesh_free(&cut, ctx);
    pc_polymesh_free(&mesh, ctx);

    /* An arrow head: only one diagonal stays inside. */
    static const double arrow[12] = {0, 0, 0, 1, -1, 0, 0, 2, 0, -1, -1, 0};
    for (pc_index turn = 0; turn < 4; turn++) {
        assert_ok(ctx, pc_synth_quad_plane(&mesh, ctx, 1, 1, 1, 1));
        memcpy(mesh.position, arrow, sizeof arrow);
        for (pc_index k = 0; k < 4; k++)
            mesh.corner[k] = (k + turn) % 4;
        assert_ok(ctx, pc_polysurface_make(&cut, NULL, ctx, &mesh));
        assert_true(fabs(area_of(&cut, &least) - 2) < 1e-12 && least > 0);
        pc_mesh_free(&cut, ctx);
        pc_polymesh_free(&mesh, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(whole_meshes, make_context, free_context),
        cmocka_unit_test_setup_teardown(triangles_with_holes_and_pieces, make_context, free_context),
        cmocka_unit_test_setup_teardown(faults_are_counted, make_context, free_context),
        cmocka_unit_test_setup_teardown(bow_tie_has_two_fans, make_context, free_context),
        cmocka_unit_test_setup_teardown(soup_never_crashes, make_context, free_context),
        cmocka_unit_test_setup_teardown(triangles_cover_polygons, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
