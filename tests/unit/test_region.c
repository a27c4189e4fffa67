/* Parts of a surface that a fit works on: what moves has all of its surroundings looked at, and the rest
 * stays. */
#include "fit.h"
#include "memory.h"
#include "random.h"
#include "region.h"
#include "synth.h"
#include "synth_quads.h"
#include "testing.h"
#include <math.h>
#include <string.h>

static const pc_tmesh_options defaults = PC_TMESH_DEFAULTS;

/* Every face with a function of a control point that moves is looked at, and no other; the faces that are too
 * far can move with all their functions. */
static void check_region(const pc_region *region, const pc_tspline *spline, const double *far, double limit,
                         uint64_t seed) {
    const pc_basis *basis = &spline->basis;
    for (pc_index f = 0; f < basis->face_count; f++) {
        bool moves = false, all = true;
        for (size_t k = basis->start[basis->face_start[f]]; k < basis->start[basis->face_start[f + 1]]; k++) {
            moves |= region->free[basis->point[k]];
            all &= region->free[basis->point[k]];
        }
        if (region->active[f] != moves || (far[f] > limit && !all))
            fail_msg("seed %d: face %u is active: %d, has free points: %d, all: %d", (int)seed, f,
                     region->active[f], moves, all);
    }
}

static void surroundings_are_active(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        pc_random random = {seed};
        pc_polymesh quads;
        pc_tspline spline;
        pc_region region;
        double *far = NULL;
        assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 9));
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        assert_ok(ctx, pc_new(&far, ctx, spline.mesh.face_count));
        for (pc_index f = 0; f < spline.mesh.face_count; f++)
            far[f] = pc_random_uniform(&random);
        const double limit = 1 - pow(0.5, (double)(seed % 12)); /* from all of them to next to none */
        assert_ok(ctx, pc_region_make(&region, ctx, &spline, far, limit));
        check_region(&region, &spline, far, limit, seed);
        pc_region_free(&region, ctx);
        assert_ok(ctx, pc_region_make(&region, ctx, &spline, far, 1));
        assert_int_equal(region.points, 0);
        assert_int_equal(region.faces, 0);
        pc_region_free(&region, ctx);
        pc_free(ctx, far);
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
    }
}

/* A control point of a sphere's surface is pulled out: the fit brings it back, and all that is not near stays
 * as it is, bit for bit. */
static void a_fit_leaves_the_rest_alone(void **state) {
    pc_context *ctx = *state;
    pc_mesh scan;
    pc_adjacency adjacency;
    pc_target target;
    pc_device *host;
    pc_polymesh quads;
    pc_tspline spline;
    pc_matching matching;
    pc_fit_options options = PC_FIT_DEFAULTS;
    pc_fit_stats stats;
    double *before = NULL;
    pc_index moved = 0;
    assert_ok(ctx, pc_synth_sphere(&scan, ctx, 40));
    assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &scan));
    assert_ok(ctx, pc_target_make(&target, ctx, &scan, &adjacency));
    assert_ok(ctx, pc_device_open(&host, ctx, "host"));
    assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 16));
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    assert_ok(ctx, pc_matching_make(&matching, ctx, &spline, &target, 5));
    options.within = 0.01;
    assert_ok(ctx, pc_fit(&spline, &stats, ctx, host, &target, &matching, &options));
    assert_true(stats.max < options.within);
    const size_t numbers = 3 * (size_t)spline.mesh.vertex_count;
    assert_ok(ctx, pc_new(&before, ctx, numbers));
    memcpy(before, spline.position, numbers * sizeof *before);
    const pc_index pulled = spline.mesh.vertex_count / 2;
    for (size_t k = 0; k < 3; k++)
        spline.position[3 * (size_t)pulled + k] *= 1.2;
    pc_tspline_update(&spline);
    options.rough = false;
    assert_ok(ctx, pc_fit(&spline, &stats, ctx, host, &target, &matching, &options));
    assert_true(stats.rounds > 0 && stats.max < options.within);
    for (pc_index v = 0; v < spline.mesh.vertex_count; v++) {
        const double *now = spline.position + 3 * (size_t)v;
        const double away = pc_distance(pc_vec3_at(before, v), pc_vec3_at(before, pulled));
        if (away > 1 && memcmp(now, before + 3 * (size_t)v, 3 * sizeof *now) != 0)
            fail_msg("control point %u, %g away, has moved", v, away);
        moved += memcmp(now, before + 3 * (size_t)v, 3 * sizeof *now) != 0;
    }
    print_message("%u of %u control points moved in %d rounds\n", moved, spline.mesh.vertex_count,
                  stats.rounds);
    assert_true(moved > 8 && moved < spline.mesh.vertex_count / 4);
    pc_free(ctx, before);
    pc_matching_free(&matching, ctx);
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
    pc_device_close(host, ctx);
    pc_target_free(&target, ctx);
    pc_adjacency_free(&adjacency, ctx);
    pc_mesh_free(&scan, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(surroundings_are_active, make_context, free_context),
        cmocka_unit_test_setup_teardown(a_fit_leaves_the_rest_alone, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
