/* Places whose matching is spoiled are matched anew, one to one, and kept until the surface is near. */
#include "adapt.h"
#include "fold.h"
#include "spline_samples.h"
#include "synth.h"
#include <math.h>
#include <omp.h>
#include <string.h>

enum { FEET = 5, SIDE = 9 };

typedef struct scene {
    pc_mesh scan;
    pc_adjacency adjacency;
    pc_target target;
    pc_tspline spline;
    pc_matching matching;
    uint8_t *folded;
} scene;

/* A flat scan under flat quads, some of them refined at random. */
static void open_scene(scene *s, pc_context *ctx, uint64_t seed) {
    const pc_tmesh_options options = PC_TMESH_DEFAULTS;
    pc_polymesh quads;
    *s = (scene){0};
    assert_ok(ctx, pc_synth_plane(&s->scan, ctx, SIDE, SIDE, 70, 70));
    assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, SIDE, SIDE, SIDE, SIDE));
    assert_ok(ctx, pc_adjacency_make(&s->adjacency, ctx, &s->scan));
    assert_ok(ctx, pc_target_make(&s->target, ctx, &s->scan, &s->adjacency));
    assert_ok(ctx, pc_tspline_make(&s->spline, ctx, &quads, &options));
    pc_polymesh_free(&quads, ctx);
    assert_ok(ctx, pc_matching_make(&s->matching, ctx, &s->spline, &s->target, FEET));
    refine_at_random(&s->spline, ctx, seed, 8);
    assert_ok(ctx, pc_matching_carry(&s->matching, ctx, &s->spline, &s->target));
    assert_ok(ctx, pc_new(&s->folded, ctx, s->spline.mesh.face_count));
}

static void close_scene(scene *s, pc_context *ctx) {
    pc_free(ctx, s->folded);
    pc_matching_free(&s->matching, ctx);
    pc_tspline_free(&s->spline, ctx);
    pc_target_free(&s->target, ctx);
    pc_adjacency_free(&s->adjacency, ctx);
    pc_mesh_free(&s->scan, ctx);
}

static pc_vec3 point_of_vertex(const scene *s, pc_index v) {
    return pc_tspline_point(&s->spline, pc_correspondence_place(&s->matching.vertices, &s->spline, v));
}

/* All feet of the faces near the middle go to one point, all vertices there to one place. */
static void spoil(scene *s) {
    const pc_vec3 middle = {SIDE / 2.0, SIDE / 2.0, 0};
    pc_spot *spot = s->matching.vertices.spot;
    const pc_spot same = spot[pc_bvh_closest(&s->target.tree, middle, PC_NONE).face / 2];
    const pc_foot *one = NULL;
    for (pc_index v = 0; v < s->scan.vertex_count; v++)
        if (pc_distance(pc_vec3_at(s->scan.position, v), middle) < 1.2) spot[v] = same;
    for (pc_index f = 0; f < s->spline.mesh.face_count; f++) {
        const double *size = s->spline.mesh.face[f].size;
        if (s->spline.mesh.face[f].ghost) continue;
        const pc_vec3 p =
            pc_tspline_point(&s->spline, pc_tspline_place(&s->spline, f, size[0] / 2, size[1] / 2));
        if (pc_distance(p, middle) > 1.2) continue;
        s->folded[f] = 1;
        for (size_t i = 0; i < FEET * FEET; i++) {
            pc_foot *foot = s->matching.feet.foot + FEET * FEET * (size_t)f + i;
            if (!one) one = foot;
            *foot = *one;
        }
    }
    assert_true(one != NULL);
}

/* Twice the area that three points make in the plane. */
static double turn(pc_vec3 a, pc_vec3 b, pc_vec3 c) {
    return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
}

/* Inside the disks that were laid flat. */
static void check_one_to_one(const scene *s, int seed) {
    const pc_spot *spot = s->matching.vertices.spot;
    pc_index triangles = 0, faces = 0;
    for (pc_index t = 0; t < s->scan.face_count; t++) {
        const pc_index *v = s->scan.triangle + 3 * (size_t)t;
        if (!spot[v[0]].held || !spot[v[1]].held || !spot[v[2]].held) continue;
        triangles++;
        const double area =
            turn(point_of_vertex(s, v[0]), point_of_vertex(s, v[1]), point_of_vertex(s, v[2]));
        if (!(area > 0)) fail_msg("seed %d: triangle %u of the scan turns over: %g", seed, t, area);
    }
    for (pc_index f = 0; f < s->spline.mesh.face_count; f++) {
        const pc_foot *foot = s->matching.feet.foot + FEET * FEET * (size_t)f;
        if (s->spline.mesh.face[f].ghost || !foot->held) continue;
        faces++;
        for (int i = 0; i < FEET * (FEET - 1); i++)
            if ((i + 1) % FEET && !(turn(foot[i].point, foot[i + 1].point, foot[i + FEET].point) > 0))
                fail_msg("seed %d: feet of face %u turn over at %d", seed, f, i);
    }
    assert_true(triangles > 300 && faces > 10);
}

static void spoiled_places_are_mended(void **state) {
    pc_context *ctx = *state;
    for (int seed = 1; seed <= 5; seed++) {
        const double tolerance = 0.05;
        scene s;
        pc_index opened, held = 0;
        open_scene(&s, ctx, (uint64_t)seed);
        spoil(&s);
        assert_ok(ctx, pc_folds_open(&s.matching, &opened, ctx, &s.spline, &s.target, s.folded, tolerance));
        assert_int_equal(opened, 1);
        check_one_to_one(&s, seed);
        /* The surface is flat and all is within the tolerance above the scan: they are let go, and end where
         * they belong. */
        pc_matching_follow(&s.matching, &s.spline, &s.target, NULL);
        for (pc_index v = 0; v < s.scan.vertex_count; v++) {
            held += s.matching.vertices.spot[v].held;
            assert_true(pc_distance(point_of_vertex(&s, v), pc_vec3_at(s.scan.position, v)) < 1e-6);
        }
        assert_int_equal(held, 0);
        close_scene(&s, ctx);
    }
}

/* Under a surface that is far away the pairs stay. */
static void pairs_are_held(void **state) {
    pc_context *ctx = *state;
    scene s;
    pc_index held = 0;
    open_scene(&s, ctx, 3);
    spoil(&s);
    assert_ok(ctx, pc_folds_open(&s.matching, NULL, ctx, &s.spline, &s.target, s.folded, 0.05));
    for (pc_index v = 0; v < s.spline.mesh.vertex_count; v++)
        s.spline.position[3 * (size_t)v + 2] += 1;
    pc_tspline_update(&s.spline);
    const pc_index count = s.scan.vertex_count;
    pc_spot *before = NULL;
    assert_ok(ctx, pc_new(&before, ctx, count));
    memcpy(before, s.matching.vertices.spot, count * sizeof *before);
    pc_matching_follow(&s.matching, &s.spline, &s.target, NULL);
    for (pc_index v = 0; v < count; v++) {
        if (!before[v].held) continue;
        held++;
        assert_memory_equal(before + v, s.matching.vertices.spot + v, sizeof *before);
    }
    assert_true(held > 100);
    pc_free(ctx, before);
    close_scene(&s, ctx);
}

static void folds_are_found(void **state) {
    pc_context *ctx = *state;
    scene s;
    pc_face_error *error = NULL;
    const pc_index bad = 40;
    open_scene(&s, ctx, 4);
    assert_ok(ctx, pc_new(&error, ctx, s.spline.mesh.face_count));
    assert_int_equal(pc_folds_find(s.folded, &s.spline, &s.target, &s.matching, NULL, 0.1), 0);
    assert_false(s.spline.mesh.face[bad].ghost);
    s.matching.feet.foot[FEET * FEET * (size_t)bad + 7].opposed = true;
    assert_int_equal(pc_folds_find(s.folded, &s.spline, &s.target, &s.matching, NULL, 0.1), 1);
    assert_int_equal(s.folded[bad], 1);
    assert_int_equal(pc_folds_find(s.folded, &s.spline, &s.target, &s.matching, error, 0.1), 0);
    error[bad].max = 0.2;
    assert_int_equal(pc_folds_find(s.folded, &s.spline, &s.target, &s.matching, error, 0.1), 1);
    pc_free(ctx, error);
    close_scene(&s, ctx);
}

static void threads_do_not_matter(void **state) {
    pc_context *ctx = *state;
    const int usual = omp_get_max_threads();
    scene s[2];
    for (int k = 0; k < 2; k++) {
        omp_set_num_threads(k ? 3 : 1);
        open_scene(s + k, ctx, 5);
        spoil(s + k);
        assert_ok(ctx,
                  pc_folds_open(&s[k].matching, NULL, ctx, &s[k].spline, &s[k].target, s[k].folded, 0.05));
    }
    omp_set_num_threads(usual);
    for (pc_index v = 0; v < s[0].scan.vertex_count; v++) {
        const pc_spot *a = s[0].matching.vertices.spot + v, *b = s[1].matching.vertices.spot + v;
        assert_int_equal(a->face, b->face);
        assert_memory_equal(a->at, b->at, sizeof a->at);
    }
    for (int k = 0; k < 2; k++)
        close_scene(s + k, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(spoiled_places_are_mended, make_context, free_context),
        cmocka_unit_test_setup_teardown(pairs_are_held, make_context, free_context),
        cmocka_unit_test_setup_teardown(folds_are_found, make_context, free_context),
        cmocka_unit_test_setup_teardown(threads_do_not_matter, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
