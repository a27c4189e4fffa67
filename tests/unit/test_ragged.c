/* Ragged holes become smooth or close; borders that somebody has made stay as they are. */
#include "memory.h"
#include "ragged.h"
#include "random.h"
#include "synth.h"
#include "synth_wear.h"
#include "testing.h"
#include "topology.h"
#include <string.h>

static int64_t euler_number(pc_context *ctx, const pc_mesh *mesh, pc_index *loops) {
    pc_adjacency adjacency;
    pc_topology topology;
    assert_ok(ctx, pc_mesh_check(mesh, ctx));
    assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, mesh));
    assert_ok(ctx, pc_topology_make(&topology, ctx, mesh, &adjacency));
    const int64_t chi = topology.chi;
    *loops = topology.loop_count;
    pc_topology_free(&topology, ctx);
    pc_adjacency_free(&adjacency, ctx);
    return chi;
}

static double border_length(pc_context *ctx, const pc_mesh *mesh) {
    pc_adjacency a;
    double sum = 0;
    assert_ok(ctx, pc_adjacency_make(&a, ctx, mesh));
    for (pc_index h = 0; h < 3 * mesh->face_count; h++)
        if (a.twin[h] == PC_NONE)
            sum += pc_distance(pc_vec3_at(mesh->position, pc_tail(mesh, h)),
                               pc_vec3_at(mesh->position, pc_head(mesh, h)));
    pc_adjacency_free(&a, ctx);
    return sum;
}

/* The faces of `before` are the first of `mesh`, and the vertices are the same. */
static void assert_kept(const pc_mesh *mesh, const pc_mesh *before) {
    assert_int_equal(mesh->vertex_count, before->vertex_count);
    assert_memory_equal(mesh->position, before->position,
                        3 * (size_t)before->vertex_count * sizeof *before->position);
    assert_memory_equal(mesh->triangle, before->triangle,
                        3 * (size_t)before->face_count * sizeof *before->triangle);
}

static void make_shape(pc_mesh *mesh, pc_context *ctx, uint64_t seed) {
    if (seed % 3 == 0) assert_ok(ctx, pc_synth_sphere(mesh, ctx, 30));
    if (seed % 3 == 1) assert_ok(ctx, pc_synth_torus(mesh, ctx, 2, 1, 90, 60));
    if (seed % 3 == 2) assert_ok(ctx, pc_synth_plane(mesh, ctx, 3, 2, 60, 40));
}

static void ragged_holes_close_or_get_smooth(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 60; seed++) {
        pc_mesh mesh, before;
        pc_ragged_stats stats;
        pc_index loops, loops_before;
        pc_random random = {pc_hash64(seed)};
        make_shape(&mesh, ctx, seed);
        assert_ok(ctx,
                  pc_synth_holes(&mesh, ctx, 3, (pc_index)(20 + 100 * pc_random_uniform(&random)), seed));
        if (seed % 2) assert_ok(ctx, pc_synth_noise(&mesh, ctx, 0.05, seed));
        assert_ok(ctx, pc_mesh_copy(&before, ctx, &mesh));
        const int64_t chi = euler_number(ctx, &mesh, &loops_before);
        const double length = border_length(ctx, &mesh);
        assert_ok(ctx, pc_ragged_fill(&mesh, &stats, ctx));
        assert_kept(&mesh, &before);
        if (mesh.face_count != before.face_count + stats.faces || stats.faces == 0)
            fail_msg("seed %llu: %u faces added", (unsigned long long)seed, stats.faces);
        if (euler_number(ctx, &mesh, &loops) != chi + stats.closed || loops + stats.closed != loops_before)
            fail_msg("seed %llu: %u holes closed, %u loops left", (unsigned long long)seed, stats.closed,
                     loops);
        if (!(border_length(ctx, &mesh) < length))
            fail_msg("seed %llu: the border is no shorter", (unsigned long long)seed);
        const pc_index faces = mesh.face_count;
        pc_mesh_free(&before, ctx);
        assert_ok(ctx, pc_ragged_fill(&mesh, &stats, ctx)); /* what could be done has been done */
        if (mesh.face_count > faces + faces / 500)
            fail_msg("seed %llu: %u faces added again", (unsigned long long)seed, stats.faces);
        pc_mesh_free(&mesh, ctx);
    }
}

/* A plane of nx squares a row without those of two windows: x, y, width, height. */
static void cut_windows(pc_mesh *mesh, pc_index nx, const pc_index window[2][4]) {
    pc_index kept = 0;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        bool inside = false;
        for (int k = 0; k < 2; k++)
            inside |= f / 2 % nx - window[k][0] < window[k][2] && f / 2 / nx - window[k][1] < window[k][3];
        if (!inside)
            memmove(mesh->triangle + 3 * (size_t)kept++, mesh->triangle + 3 * (size_t)f,
                    3 * sizeof(pc_index));
    }
    mesh->face_count = kept;
}

static void made_borders_stay(void **state) {
    pc_context *ctx = *state;
    pc_ragged_stats stats;
    pc_mesh mesh;
    for (int k = 0; k < 3; k++) {
        if (k == 0) assert_ok(ctx, pc_synth_cylinder(&mesh, ctx, 3, 10, 20));
        if (k == 1) assert_ok(ctx, pc_synth_cylinder(&mesh, ctx, 2, 100, 30));
        if (k == 2) {
            assert_ok(ctx, pc_synth_plane(&mesh, ctx, 4, 2, 40, 20));
            /* A window and a bay. */
            cut_windows(&mesh, 40, (const pc_index[2][4]){{20, 5, 10, 10}, {2, 0, 10, 5}});
        }
        const pc_index faces = mesh.face_count;
        assert_ok(ctx, pc_ragged_fill(&mesh, &stats, ctx));
        if (stats.faces || mesh.face_count != faces) fail_msg("shape %d: %u faces added", k, stats.faces);
        pc_mesh_free(&mesh, ctx);
    }
}

static void closed_surfaces_stay(void **state) {
    pc_context *ctx = *state;
    pc_ragged_stats stats;
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 5));
    assert_ok(ctx, pc_ragged_fill(&mesh, &stats, ctx));
    assert_int_equal(stats.faces, 0);
    pc_mesh_free(&mesh, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(ragged_holes_close_or_get_smooth, make_context, free_context),
        cmocka_unit_test_setup_teardown(made_borders_stay, make_context, free_context),
        cmocka_unit_test_setup_teardown(closed_surfaces_stay, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
