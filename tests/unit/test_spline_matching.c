/* What belongs together of a surface and a scan: places outlive refinement, feet are nearest points, a groove
 * under a face is found, and threads do not matter. */
#include "insertion.h"
#include "matching.h"
#include "memory.h"
#include "spline_samples.h"
#include "synth.h"
#include <math.h>
#include <omp.h>
#include <string.h>

typedef struct scene {
    pc_mesh scan;
    pc_adjacency adjacency;
    pc_target target;
    pc_tspline spline;
} scene;

static void open_scene(scene *s, pc_context *ctx, const pc_polymesh *quads) {
    const pc_tmesh_options options = PC_TMESH_DEFAULTS;
    assert_ok(ctx, pc_adjacency_make(&s->adjacency, ctx, &s->scan));
    assert_ok(ctx, pc_target_make(&s->target, ctx, &s->scan, &s->adjacency));
    assert_ok(ctx, pc_tspline_make(&s->spline, ctx, quads, &options));
}

static void close_scene(scene *s, pc_context *ctx) {
    pc_tspline_free(&s->spline, ctx);
    pc_target_free(&s->target, ctx);
    pc_adjacency_free(&s->adjacency, ctx);
    pc_mesh_free(&s->scan, ctx);
}

static void open_torus(scene *s, pc_context *ctx) {
    pc_polymesh quads;
    assert_ok(ctx, pc_synth_torus(&s->scan, ctx, 2, 1, 96, 48));
    assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 1, 12, 8));
    open_scene(s, ctx, &quads);
    pc_polymesh_free(&quads, ctx);
}

/* Refinement leaves the surface as it is, and every vertex of the scan at its point of it. */
static void places_outlive_refinement(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 5; seed++) {
        scene s = {0};
        pc_matching matching;
        double *before = NULL;
        open_torus(&s, ctx);
        assert_ok(ctx, pc_matching_make(&matching, ctx, &s.spline, &s.target, 5));
        pc_matching_follow(&matching, &s.spline, &s.target, NULL);
        assert_ok(ctx, pc_new(&before, ctx, 3 * (size_t)s.scan.vertex_count));
        for (pc_index v = 0; v < s.scan.vertex_count; v++)
            pc_vec3_put(
                before, v,
                pc_tspline_point(&s.spline, pc_correspondence_place(&matching.vertices, &s.spline, v)));
        refine_at_random(&s.spline, ctx, seed, 4);
        assert_ok(ctx, pc_correspondence_carry(&matching.vertices, ctx, &s.spline.mesh));
        assert_ok(ctx, pc_footpoints_carry(&matching.feet, ctx, &s.spline.mesh));
        assert_int_equal(matching.feet.face_count, s.spline.mesh.face_count);
        for (pc_index v = 0; v < s.scan.vertex_count; v++) {
            const pc_vec3 now =
                pc_tspline_point(&s.spline, pc_correspondence_place(&matching.vertices, &s.spline, v));
            if (!(pc_distance(now, pc_vec3_at(before, v)) < 1e-12))
                fail_msg("seed %d: vertex %u moved by %g", (int)seed, v,
                         pc_distance(now, pc_vec3_at(before, v)));
        }
        pc_matching_free(&matching, ctx);
        pc_free(ctx, before);
        close_scene(&s, ctx);
    }
}

/* Where there is one sheet only, walking downhill ends at what the tree finds, after a refinement too: up to
 * the little by which two triangles can both have a point nearest to what is above their hollow side. */
static void feet_are_nearest_points(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    pc_matching matching;
    open_torus(&s, ctx);
    assert_ok(ctx, pc_matching_make(&matching, ctx, &s.spline, &s.target, 5));
    refine_at_random(&s.spline, ctx, 9, 4);
    assert_ok(ctx, pc_matching_carry(&matching, ctx, &s.spline, &s.target));
    for (pc_index f = 0; f < s.spline.mesh.face_count; f++)
        for (int i = 0; i < 25; i++) {
            double at[2];
            const pc_foot *foot = matching.feet.foot + 25 * (size_t)f + i;
            pc_footpoints_at(at, &matching.feet, f, i);
            const pc_vec3 p = pc_tspline_point(&s.spline, pc_tspline_place(&s.spline, f, at[0], at[1]));
            const pc_bvh_hit hit = pc_bvh_closest(&s.target.tree, p, PC_NONE);
            assert_false(foot->opposed);
            assert_true(pc_distance(foot->point, pc_footpoints_point(&s.scan, foot)) < 1e-15);
            const double more = pc_distance(p, foot->point) - hit.distance;
            if (!(more > -1e-12 && more < 5e-3)) fail_msg("face %u, foot %d: %g farther", f, i, more);
        }
    pc_matching_free(&matching, ctx);
    close_scene(&s, ctx);
}

/* A deep groove under the quads that bridge it: the nearest points of these all lie near its rims, and
 * yet some feet stand in it, and the vertices at its bottom belong to the face above. */
static void a_groove_is_found(void **state) {
    pc_context *ctx = *state;
    const double width = 0.42, depth = 1.2;
    scene s = {0};
    pc_polymesh quads;
    pc_matching matching;
    pc_index deep = 0, away = 0;
    assert_ok(ctx, pc_synth_plane(&s.scan, ctx, 3, 3, 90, 90));
    for (pc_index v = 0; v < s.scan.vertex_count; v++) {
        double *p = s.scan.position + 3 * (size_t)v;
        const double across = fabs(p[0] - 1.5), along = (p[1] - 1.5) / 0.9;
        if (across < width && fabs(along) < 1) p[2] = -depth * (1 - across / width) * (1 - along * along);
    }
    assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 3, 3, 3, 3));
    open_scene(&s, ctx, &quads);
    assert_ok(ctx, pc_matching_make(&matching, ctx, &s.spline, &s.target, 5));
    for (size_t i = 0; i < 25 * (size_t)matching.feet.face_count; i++)
        deep += matching.feet.foot[i].triangle != PC_NONE && matching.feet.foot[i].point.z < -depth / 2;
    for (pc_index v = 0; v < s.scan.vertex_count; v++) {
        const pc_spot *spot = matching.vertices.spot + v;
        const double *x = s.scan.position + 3 * (size_t)v;
        pc_index corner[4];
        pc_tface_corners(corner, &s.spline.mesh, spot->face);
        for (int k = 0; k < 4; k++)
            away += x[2] < 0 && fabs(s.spline.position[3 * (size_t)corner[k]] - x[0]) > 1;
    }
    print_message("%u feet in the groove\n", deep);
    assert_true(deep >= 3 && away == 0);
    pc_matching_free(&matching, ctx);
    pc_polymesh_free(&quads, ctx);
    close_scene(&s, ctx);
}

static void threads_do_not_matter(void **state) {
    pc_context *ctx = *state;
    const int usual = omp_get_max_threads();
    scene s = {0};
    pc_matching matching[2];
    open_torus(&s, ctx);
    for (int k = 0; k < 2; k++) {
        omp_set_num_threads(k ? 3 : 1);
        assert_ok(ctx, pc_matching_make(matching + k, ctx, &s.spline, &s.target, 5));
        pc_matching_follow(matching + k, &s.spline, &s.target, NULL);
    }
    omp_set_num_threads(usual);
    for (size_t i = 0; i < 25 * (size_t)s.spline.mesh.face_count; i++) {
        const pc_foot *a = matching[0].feet.foot + i, *b = matching[1].feet.foot + i;
        assert_int_equal(a->triangle, b->triangle);
        assert_memory_equal(&a->point, &b->point, sizeof a->point);
    }
    assert_memory_equal(matching[0].vertices.spot, matching[1].vertices.spot,
                        s.scan.vertex_count * sizeof(pc_spot));
    for (int k = 0; k < 2; k++)
        pc_matching_free(matching + k, ctx);
    close_scene(&s, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(places_outlive_refinement, make_context, free_context),
        cmocka_unit_test_setup_teardown(feet_are_nearest_points, make_context, free_context),
        cmocka_unit_test_setup_teardown(a_groove_is_found, make_context, free_context),
        cmocka_unit_test_setup_teardown(threads_do_not_matter, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
