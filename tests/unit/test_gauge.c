/* Measuring again only what has moved finds what measuring everything does, as does beginning with suspects;
 * the nearest points of a part of a surface are those of the whole, and summits are found once each. */
#include "accuracy.h"
#include "matching.h"
#include "memory.h"
#include "samples.h"
#include "scan_scene.h"
#include "spline_samples.h"

/* Moves one control point in `rarity`. */
static void shake(pc_tspline *spline, pc_random *random, double size, int rarity) {
    for (pc_index v = 0; v < spline->mesh.vertex_count; v++)
        if (pc_random_uniform(random) * rarity < 1)
            for (size_t k = 0; k < 3; k++)
                spline->position[3 * (size_t)v + k] += size * (pc_random_uniform(random) - 0.5);
    pc_tspline_update(spline);
}

/* Known faces and those measured now against all of them measured now; the number of known ones. */
static pc_index compare(pc_context *ctx, const pc_tspline *spline, const scene *s, pc_gauge *gauge,
                        double most, unsigned long long seed) {
    const pc_index faces = spline->mesh.face_count;
    pc_accuracy part, all;
    pc_face_error *some = NULL, *every = NULL;
    pc_index known = 0;
    const pc_accuracy_options again = {.per_side = 4, .near = 0.05, .gauge = gauge};
    const pc_accuracy_options anew = {.per_side = 4, .near = 0.05};
    assert_ok(ctx, pc_new(&some, ctx, faces));
    assert_ok(ctx, pc_new(&every, ctx, faces));
    assert_ok(ctx, pc_gauge_update(gauge, ctx, spline));
    for (pc_index f = 0; f < faces; f++)
        known += gauge->face[f].known;
    assert_ok(ctx, pc_accuracy_measure(&part, some, ctx, spline, &s->target, &again));
    assert_ok(ctx, pc_accuracy_measure(&all, every, ctx, spline, &s->target, &anew));
    for (pc_index f = 0; f < faces; f++)
        if (!(fabs(some[f].max - every[f].max) <= most))
            fail_msg("seed %llu: face %u is %.17g off, not %.17g", seed, f, every[f].max, some[f].max);
    assert_true(fabs(part.max - all.max) <= most);
    assert_true(fabs(part.surface_mean - all.surface_mean) <= most);
    assert_true(part.samples == all.samples && part.beyond == all.beyond);
    pc_free(ctx, some);
    pc_free(ctx, every);
    return known;
}

static void what_has_not_moved_stays_known(void **state) {
    pc_context *ctx = *state;
    const double exactly = 0, rounding = 1e-9;
    scene s = {0};
    assert_ok(ctx, pc_synth_torus(&s.scan, ctx, 2, 1, 60, 40));
    open_scene(&s, ctx);
    for (uint64_t seed = 1; seed <= 5; seed++) {
        pc_tspline spline;
        pc_gauge gauge = {0};
        pc_random random = {seed};
        make_sample_quads(&spline, ctx, SAMPLE_TORUS);
        assert_int_equal(compare(ctx, &spline, &s, &gauge, exactly, seed), 0);
        shake(&spline, &random, 0.2, 40);
        const pc_index known = compare(ctx, &spline, &s, &gauge, exactly, seed);
        assert_true(known > 0 && known < spline.mesh.face_count);
        refine_at_random(&spline, ctx, seed, 20);
        assert_ok(ctx, pc_gauge_carry(&gauge, ctx, &spline));
        const pc_index carried = compare(ctx, &spline, &s, &gauge, rounding, seed);
        assert_true(carried > 0 && carried < spline.mesh.face_count);
        shake(&spline, &random, 0.2, 40);
        assert_true(compare(ctx, &spline, &s, &gauge, rounding, seed) > 0);
        pc_gauge_free(&gauge, ctx);
        pc_tspline_free(&spline, ctx);
    }
    close_scene(&s, ctx);
}

/* The others are measured only where nothing is too far on those. */
static void suspects_come_first(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    pc_tspline spline;
    pc_gauge gauge = {0};
    pc_accuracy all, some;
    const pc_accuracy_options anew = {.per_side = 4, .near = 0.05};
    pc_accuracy_options options = {.per_side = 4, .near = 0.05, .gauge = &gauge};
    pc_random random = {7};
    uint8_t *suspect = NULL;
    pc_face_error *error = NULL;
    assert_ok(ctx, pc_synth_torus(&s.scan, ctx, 2, 1, 60, 40));
    open_scene(&s, ctx);
    make_sample_quads(&spline, ctx, SAMPLE_TORUS);
    shake(&spline, &random, 0.2, 40);
    const pc_index faces = spline.mesh.face_count;
    assert_ok(ctx, pc_new(&suspect, ctx, faces));
    assert_ok(ctx, pc_new(&error, ctx, faces));
    assert_ok(ctx, pc_accuracy_measure(&all, error, ctx, &spline, &s.target, &anew));
    for (pc_index f = 0; f < faces; f++)
        suspect[f] = error[f].max > 0.5 * all.max;
    options.suspect = suspect, options.enough = 0.9 * all.max;
    assert_ok(ctx, pc_accuracy_measure(&some, error, ctx, &spline, &s.target, &options));
    assert_true(some.max == all.max && some.samples < all.samples);
    for (pc_index f = 0; f < faces; f++)
        assert_int_equal(gauge.face[f].known, suspect[f] && !spline.mesh.face[f].ghost);
    options.enough = all.max;
    assert_ok(ctx, pc_accuracy_measure(&some, error, ctx, &spline, &s.target, &options));
    assert_true(some.max == all.max && some.samples == all.samples && some.surface_mean == all.surface_mean);
    pc_free(ctx, suspect);
    pc_free(ctx, error);
    pc_gauge_free(&gauge, ctx);
    pc_tspline_free(&spline, ctx);
    close_scene(&s, ctx);
}

/* The faces of the feet and vertices that have been moved away, and no others. */
static void what_is_far_is_suspect(void **state) {
    pc_context *ctx = *state;
    const double far = 0.05;
    const pc_index shy = 6, lone = 17; /* a face with a far foot, and one with a far vertex */
    scene s = {0};
    pc_polymesh quads;
    pc_tspline spline;
    pc_matching matching;
    const pc_tmesh_options defaults = PC_TMESH_DEFAULTS;
    uint8_t *suspect = NULL;
    open_bump(&s, ctx, 5, 60, 2.5, 2.5, 0, 1);
    assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 5, 5, 5, 5));
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    assert_ok(ctx, pc_matching_make(&matching, ctx, &spline, &s.target, 4));
    assert_ok(ctx, pc_new(&suspect, ctx, spline.mesh.face_count));
    assert_true(!spline.mesh.face[shy].ghost && !spline.mesh.face[lone].ghost);
    matching.feet.foot[16 * shy + 5].point.z += 2 * far;
    pc_index v = 0;
    while (matching.vertices.spot[v].face != lone)
        v++;
    matching.vertices.spot[v].at[0] = spline.mesh.face[lone].size[0] - matching.vertices.spot[v].at[0];
    pc_matching_suspect(suspect, &matching, &spline, &s.target, far);
    for (pc_index f = 0; f < spline.mesh.face_count; f++)
        assert_int_equal(suspect[f], f == shy || f == lone);
    pc_free(ctx, suspect);
    pc_matching_free(&matching, ctx);
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
    close_scene(&s, ctx);
}

/* The elements that are left out are too far away to matter. */
static void near_elements_suffice(void **state) {
    enum { COUNT = 200 };
    pc_context *ctx = *state;
    pc_index left_out = 0;
    for (int kind = 0; kind < SAMPLE_COUNT; kind++) {
        pc_tspline spline;
        pc_facets all, some;
        pc_nearest expected[COUNT], found[COUNT];
        pc_random random = {(uint64_t)kind + 1};
        double point[3 * COUNT], reach = 0;
        make_sample_quads(&spline, ctx, kind);
        for (size_t i = 0; i < COUNT; i++) {
            const pc_index e = (pc_index)(pc_random_uniform(&random) * 0.2 * spline.basis.element_count);
            pc_vec3_put(point, i, pc_tspline_point(&spline, pc_element_place(&spline.basis, e, 0.3, 0.6)));
            point[3 * i + 2] += 0.02 * pc_random_uniform(&random);
        }
        assert_ok(ctx, pc_facets_make(&all, ctx, &spline, 4, false));
        pc_nearest_all(expected, &spline, &all, point, COUNT);
        for (size_t i = 0; i < COUNT; i++)
            reach = fmax(reach, expected[i].distance);
        assert_ok(ctx, pc_facets_make_near(&some, ctx, &spline, 4, point, COUNT, reach));
        pc_nearest_all(found, &spline, &some, point, COUNT);
        for (size_t i = 0; i < COUNT; i++)
            if (found[i].distance != expected[i].distance ||
                found[i].place.element != expected[i].place.element)
                fail_msg("surface %d, point %zu: %.17g from element %u, not %.17g from %u", kind, i,
                         found[i].distance, found[i].place.element, expected[i].distance,
                         expected[i].place.element);
        left_out += all.mesh.face_count - some.mesh.face_count;
        pc_facets_free(&some, ctx);
        pc_facets_free(&all, ctx);
        pc_tspline_free(&spline, ctx);
    }
    assert_true(left_out > 0);
}

/* A flat surface, and a scan with a bump between the feet of one face. */
static void summits_become_samples(void **state) {
    pc_context *ctx = *state;
    const double tolerance = 0.008;
    scene s = {0};
    pc_polymesh quads;
    pc_tspline spline;
    pc_matching matching;
    pc_gauge gauge = {0};
    pc_accuracy accuracy;
    pc_samples before, after;
    const pc_tmesh_options defaults = PC_TMESH_DEFAULTS;
    const pc_accuracy_options measuring = {.per_side = 6, .near = 0, .gauge = &gauge};
    uint8_t *unseen = NULL;
    open_bump(&s, ctx, 5, 120, 2.5, 2.5, 0.01, 0.006);
    assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 5, 5, 5, 5));
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    assert_ok(ctx,
              pc_matching_make(&matching, ctx, &spline, &s.target, 4)); /* none in the middle of a face */
    pc_matching_follow(&matching, &spline, &s.target, NULL);
    assert_ok(ctx, pc_accuracy_measure(&accuracy, NULL, ctx, &spline, &s.target, &measuring));
    assert_true(accuracy.surface_max > tolerance);
    assert_ok(ctx, pc_new(&unseen, ctx, spline.mesh.face_count));
    assert_ok(ctx, pc_samples_make(&before, ctx, &spline, &s.target, &matching, 0, NULL));
    assert_ok(ctx,
              pc_summits_find(&matching.summits, unseen, ctx, &spline, &matching.feet, &gauge, tolerance));
    assert_int_equal(matching.summits.places.count, 1);
    assert_int_equal(unseen[matching.summits.places.spot[0].face], 1);
    pc_summits_follow(&matching.summits, &spline, &s.target, NULL);
    assert_true(hypot(matching.summits.foot[0].point.x - 2.5, matching.summits.foot[0].point.y - 2.5) < 0.1);
    assert_true(matching.summits.foot[0].point.z > tolerance);
    assert_ok(ctx, pc_samples_make(&after, ctx, &spline, &s.target, &matching, 0, NULL));
    assert_int_equal(after.count, before.count + 1);
    assert_ok(ctx,
              pc_summits_find(&matching.summits, unseen, ctx, &spline, &matching.feet, &gauge, tolerance));
    assert_int_equal(matching.summits.places.count, 1); /* it is known */
    refine_at_random(&spline, ctx, 3, 2);
    const pc_vec3 foot = matching.summits.foot[0].point;
    assert_ok(ctx, pc_matching_carry(&matching, ctx, &spline, &s.target));
    assert_true(pc_distance(foot, matching.summits.foot[0].point) < 1e-9);
    pc_samples_free(&before, ctx);
    pc_samples_free(&after, ctx);
    pc_free(ctx, unseen);
    pc_gauge_free(&gauge, ctx);
    pc_matching_free(&matching, ctx);
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
    close_scene(&s, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_has_not_moved_stays_known, make_context, free_context),
        cmocka_unit_test_setup_teardown(suspects_come_first, make_context, free_context),
        cmocka_unit_test_setup_teardown(what_is_far_is_suspect, make_context, free_context),
        cmocka_unit_test_setup_teardown(near_elements_suffice, make_context, free_context),
        cmocka_unit_test_setup_teardown(summits_become_samples, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
