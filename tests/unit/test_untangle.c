/* Triangles that coordinates flip over are turned back, and nothing else moves. */
#include "plane_param.h"
#include "reconstruct.h"
#include "synth.h"
#include "untangle.h"
#include <math.h>

static pc_index count_flags(const pc_param *param, uint8_t flag) {
    pc_index count = 0;
    for (pc_index f = 0; f < param->face_count; f++)
        count += param->singular[f] == flag;
    return count;
}

static void regular_ones_stay(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_adjacency adjacency;
    plane_param p;
    const double a[4] = {1.5, 0.7, -0.7, 1.5};
    assert_ok(ctx, pc_synth_plane(&mesh, ctx, 3, 2, 30, 20));
    assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &mesh));
    make_linear_param(&p, ctx, &mesh, a, 3);
    size_t size = 2 * sizeof(int32_t) * mesh.vertex_count;
    int32_t *before;
    assert_ok(ctx, pc_new(&before, ctx, 2 * (size_t)mesh.vertex_count));
    memcpy(before, p.param.coordinate, size);
    assert_ok(ctx, pc_untangle(&p.param, ctx, &mesh, &adjacency));
    assert_memory_equal(before, p.param.coordinate, size);
    assert_int_equal(count_flags(&p.param, PC_REGULAR), mesh.face_count);
    pc_free(ctx, before);
    free_plane_param(&p, ctx);
    pc_adjacency_free(&adjacency, ctx);
    pc_mesh_free(&mesh, ctx);
}

/* Moves the coordinates of an interior vertex by about half a period, several edges. */
static void move_one(pc_param *param, const pc_adjacency *adjacency, pc_random *random) {
    size_t v;
    do
        v = pc_random_next(random) % param->vertex_count;
    while (adjacency->vertex_boundary[v]);
    double turn = 6.3 * pc_random_uniform(random);
    param->coordinate[2 * v] += 2 * (int32_t)(0.25 * PC_PERIOD * cos(turn));
    param->coordinate[2 * v + 1] += 2 * (int32_t)(0.25 * PC_PERIOD * sin(turn));
}

static void flipped_triangles_turn_back(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_adjacency adjacency;
    int32_t *shift, *coordinate;
    assert_ok(ctx, pc_synth_plane(&mesh, ctx, 3, 2, 30, 20));
    assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &mesh));
    assert_ok(ctx, pc_new(&shift, ctx, 6 * (size_t)mesh.face_count));
    assert_ok(ctx, pc_new(&coordinate, ctx, 2 * (size_t)mesh.vertex_count));
    for (uint64_t seed = 0; seed < 40; seed++) {
        plane_param p;
        pc_random random = {seed};
        double turn = 6.3 * pc_random_uniform(&random);
        const double a[4] = {1.2 * cos(turn), 1.2 * sin(turn), -1.2 * sin(turn), 1.2 * cos(turn)};
        make_linear_param(&p, ctx, &mesh, a, seed);
        memcpy(shift, p.param.shift, 6 * sizeof *shift * mesh.face_count);
        memcpy(coordinate, p.param.coordinate, 2 * sizeof *coordinate * mesh.vertex_count);
        pc_index moved = 1 + (pc_index)(seed / 10);
        for (pc_index i = 0; i < moved; i++)
            move_one(&p.param, &adjacency, &random);
        pc_reconstruct_flags(&p.param, &mesh);
        pc_index flipped = count_flags(&p.param, PC_FLIPPED), borders_moved = 0;
        assert_ok(ctx, pc_untangle(&p.param, ctx, &mesh, &adjacency));
        pc_index left = mesh.face_count - count_flags(&p.param, PC_REGULAR);
        for (size_t v = 0; v < mesh.vertex_count; v++)
            borders_moved +=
                adjacency.vertex_boundary[v] && (coordinate[2 * v] != p.param.coordinate[2 * v] ||
                                                 coordinate[2 * v + 1] != p.param.coordinate[2 * v + 1]);
        if (flipped == 0 || left || borders_moved)
            fail_msg("seed %llu: %u flipped, %u left, %u border vertices moved", (unsigned long long)seed,
                     flipped, left, borders_moved);
        assert_ok(ctx, pc_param_check(&p.param, ctx, &mesh, &adjacency));
        assert_memory_equal(shift, p.param.shift, 6 * sizeof *shift * mesh.face_count);
        free_plane_param(&p, ctx);
    }
    pc_free(ctx, shift);
    pc_free(ctx, coordinate);
    pc_adjacency_free(&adjacency, ctx);
    pc_mesh_free(&mesh, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(regular_ones_stay, make_context, free_context),
        cmocka_unit_test_setup_teardown(flipped_triangles_turn_back, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
