/* The thickness of shapes that have one everywhere, and of one that has two. */
#include "memory.h"
#include "synth.h"
#include "synth_wear.h"
#include "testing.h"
#include "thickness.h"

/* Of every vertex whose place `picks` (all where NULL), within a share of what is wanted. */
static void assert_thickness(pc_context *ctx, const pc_mesh *mesh, double most, double wanted, double share,
                             bool (*picks)(pc_vec3)) {
    pc_adjacency adjacency;
    pc_ground ground;
    pc_index picked = 0;
    assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, mesh));
    assert_ok(ctx, pc_ground_make(&ground, ctx, mesh, &adjacency));
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        if (picks && !picks(pc_vec3_at(mesh->position, v))) continue;
        const double found = pc_thickness_at(&ground, v, most);
        picked++;
        if (isinf(wanted) ? !isinf(found) : !(fabs(found - wanted) <= share * wanted))
            fail_msg("vertex %u: %g instead of %g", v, found, wanted);
    }
    assert_true(picked > 0);
    pc_ground_free(&ground, ctx);
    pc_adjacency_free(&adjacency, ctx);
}

static void balls_and_pipes(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 20));
    assert_thickness(ctx, &mesh, 2.5, 2, 0.02, NULL);
    assert_thickness(ctx, &mesh, 1.9, INFINITY, 0, NULL); /* farther than asked for */
    pc_mesh_free(&mesh, ctx);
    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 3, 0.5, 200, 60));
    assert_thickness(ctx, &mesh, 2, 1, 0.02, NULL);
    pc_mesh_free(&mesh, ctx);
}

static bool in_the_middle(pc_vec3 p) {
    return fabs(p.x - 1) < 0.5 && fabs(p.y - 1) < 0.5;
}

/* Two sheets one above the other: a wall where they face apart, a gap where they face each other. */
static void walls_and_gaps(void **state) {
    pc_context *ctx = *state;
    for (int gap = 0; gap < 2; gap++) {
        pc_mesh lower, upper;
        assert_ok(ctx, pc_synth_plane(&lower, ctx, 2, 2, 20, 20));
        assert_ok(ctx, pc_synth_plane(&upper, ctx, 2, 2, 23, 17));
        pc_mesh *turned = gap ? &upper : &lower;
        for (pc_index f = 0; f < turned->face_count; f++) {
            pc_index *t = turned->triangle + 3 * (size_t)f, swap = t[1];
            t[1] = t[2], t[2] = swap;
        }
        assert_ok(ctx, pc_synth_append(&lower, ctx, &upper, (pc_vec3){0, 0, 0.1}));
        assert_thickness(ctx, &lower, 1, 0.1, 1e-6, in_the_middle);
        pc_mesh_free(&lower, ctx);
        pc_mesh_free(&upper, ctx);
    }
}

static bool beside_an_edge(pc_vec3 p) {
    return p.z == 1 && p.x > 0.8 && p.x < 0.99 && fabs(p.y) < 0.5;
}

/* The wall around the corner does not count. */
static void edges(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_cube(&mesh, ctx, 20));
    assert_thickness(ctx, &mesh, 1.5, INFINITY, 0, beside_an_edge);
    pc_mesh_free(&mesh, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(balls_and_pipes, make_context, free_context),
        cmocka_unit_test_setup_teardown(walls_and_gaps, make_context, free_context),
        cmocka_unit_test_setup_teardown(edges, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
