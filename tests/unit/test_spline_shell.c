/* Shells of refined splines: watertight, exact, and in as few faces as there are rectangles. */
#include "spline_samples.h"
#include <math.h>

static const pc_tmesh_options defaults = PC_TMESH_DEFAULTS;

/* Every point of the surface is on a face: the centre of each regular T-mesh face is found on its block. */
static void is_exact(pc_context *ctx, const pc_tspline *spline) {
    pc_blocks blocks;
    assert_ok(ctx, pc_blocks_make(&blocks, ctx, spline));
    pc_shell shell;
    assert_ok(ctx, pc_shell_make(&shell, ctx, spline));
    for (pc_index b = 0; b < blocks.block_count; b++)
        for (pc_index c = 0; c < blocks.block[b].cell_count; c++) {
            const pc_block_cell *cell = blocks.cell + blocks.block[b].cell + c;
            const double *size = spline->mesh.face[cell->face].size;
            double x = 0.3 * size[0], y = 0.6 * size[1];
            double s = cell->origin[0] + (cell->turn == 0   ? x
                                          : cell->turn == 1 ? -y
                                          : cell->turn == 2 ? -x
                                                            : y);
            double t = cell->origin[1] + (cell->turn == 0   ? y
                                          : cell->turn == 1 ? x
                                          : cell->turn == 2 ? -y
                                                            : -x);
            pc_vec3 p = pc_tspline_point(spline, pc_tspline_place(spline, cell->face, x, y));
            pc_vec3 q =
                pc_shell_face_point(&shell, b, s / blocks.block[b].size[0], t / blocks.block[b].size[1]);
            assert_true(pc_distance(p, q) < 1e-13);
        }
    pc_shell_free(&shell, ctx);
    pc_blocks_free(&blocks, ctx);
}

static void a_grid_is_one_face(void **state) {
    pc_context *ctx = *state;
    pc_polymesh quads;
    pc_tspline spline;
    pc_shell shell;
    assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 5, 3, 5, 3));
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    assert_ok(ctx, pc_shell_make(&shell, ctx, &spline));
    assert_ok(ctx, pc_shell_check(&shell, ctx, 5));
    assert_int_equal(shell.face_count, 1);
    assert_int_equal(shell.border_count, 16);
    assert_int_equal(shell.component_count, 1);
    pc_shell_free(&shell, ctx);
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
}

static void refined_shapes_are_watertight(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 9; seed++) {
        pc_polymesh quads;
        pc_tspline spline;
        pc_shell shell;
        print_message("seed %d: ", (int)seed);
        if (seed % 3 == 0)
            assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 1, 12, 8));
        else if (seed % 3 == 1)
            assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, (pc_index)seed / 3 + 2));
        else
            assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 6, 4, 7, 5));
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        if (seed > 3) refine_at_random(&spline, ctx, seed, 15);
        if (seed > 6) refine_at_random(&spline, ctx, seed, 15);
        assert_ok(ctx, pc_shell_make(&shell, ctx, &spline));
        print_message("%u elements, %u faces, %u edges, %u vertices, %u on the border\n",
                      spline.basis.element_count, shell.face_count, shell.edge_count, shell.vertex_count,
                      shell.border_count);
        assert_ok(ctx, pc_shell_check(&shell, ctx, 2));
        assert_int_equal(shell.border_count != 0, seed % 3 == 2);
        int euler = (int)shell.vertex_count - (int)shell.edge_count + (int)shell.face_count;
        assert_int_equal(euler, seed % 3 == 0 ? 0 : seed % 3 == 1 ? 2 : 1);
        assert_int_equal(shell.component_count, 1);
        is_exact(ctx, &spline);
        pc_shell_free(&shell, ctx);
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
    }
}

static void folded_spheres_are_watertight(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 41; seed <= 44; seed++) {
        pc_polymesh quads;
        pc_tspline spline;
        pc_shell shell;
        print_message("seed %d\n", (int)seed);
        make_random_quads(&quads, ctx, seed, 6, 12);
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        refine_at_random(&spline, ctx, seed, 40);
        assert_ok(ctx, pc_shell_make(&shell, ctx, &spline));
        assert_ok(ctx, pc_shell_check(&shell, ctx, 2));
        assert_int_equal(shell.border_count, 0);
        assert_int_equal((int)shell.vertex_count - (int)shell.edge_count + (int)shell.face_count, 2);
        pc_shell_free(&shell, ctx);
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_grid_is_one_face, make_context, free_context),
        cmocka_unit_test_setup_teardown(refined_shapes_are_watertight, make_context, free_context),
        cmocka_unit_test_setup_teardown(folded_spheres_are_watertight, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
