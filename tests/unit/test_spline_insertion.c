/* Random local refinement: the mesh stays analysis-suitable, the basis sums to one and is independent, and
 * the surface does not move. */
#include "continuity.h"
#include "insertion.h"
#include "memory.h"
#include "random.h"
#include "random_quads.h"
#include "suitable.h"
#include "synth_quads.h"
#include "testing.h"
#include <math.h>

static const pc_tmesh_options defaults = PC_TMESH_DEFAULTS;

enum { SAMPLES = 5 };

/* Points of the surface, on a grid in every face. */
static double *sample(pc_context *ctx, const pc_tspline *spline) {
    double *point = NULL;
    assert_ok(ctx, pc_new(&point, ctx, 3 * (size_t)SAMPLES * SAMPLES * spline->mesh.face_count));
    for (pc_index f = 0; f < spline->mesh.face_count; f++)
        for (int i = 0; i < SAMPLES * SAMPLES && !spline->mesh.face[f].ghost; i++) {
            const double *size = spline->mesh.face[f].size;
            double s = size[0] * (i % SAMPLES + 0.5) / SAMPLES;
            double t = size[1] * (i / SAMPLES + 0.5) / SAMPLES;
            pc_vec3_put(point, (size_t)f * SAMPLES * SAMPLES + (size_t)i,
                        pc_tspline_point(spline, pc_tspline_place(spline, f, s, t)));
        }
    return point;
}

/* The largest distance of those points from where the surface is now. */
static double moved(const pc_tspline *spline, pc_index old_faces, const pc_tspline *old,
                    const double *point) {
    double most = 0;
    for (pc_index f = 0; f < spline->mesh.face_count; f++) {
        const pc_tface *face = spline->mesh.face + f;
        if (face->ghost) continue;
        assert_true(face->root < old_faces);
        const double *size = old->mesh.face[face->root].size;
        for (int i = 0; i < SAMPLES * SAMPLES; i++) {
            double s = size[0] * (i % SAMPLES + 0.5) / SAMPLES - face->origin[0];
            double t = size[1] * (i / SAMPLES + 0.5) / SAMPLES - face->origin[1];
            if (s < 0 || t < 0 || s > face->size[0] || t > face->size[1]) continue;
            pc_vec3 p = pc_tspline_point(spline, pc_tspline_place(spline, f, s, t));
            double d = pc_distance(p, pc_vec3_at(point, (size_t)face->root * SAMPLES * SAMPLES + (size_t)i));
            most = fmax(most, d);
        }
    }
    return most;
}

/* Halves about one face of `rarity` at random, several times over. */
static void refine_at_random(pc_context *ctx, const pc_polymesh *quads, uint64_t seed, int rounds,
                             int rarity) {
    pc_random random = {seed};
    pc_tspline spline;
    print_message("seed %llu: ", (unsigned long long)seed);
    assert_ok(ctx, pc_tspline_make(&spline, ctx, quads, &defaults));
    for (size_t i = 0; i < 3 * (size_t)spline.mesh.vertex_count; i++)
        spline.position[i] += 0.1 * pc_random_uniform(&random);
    pc_tspline_update(&spline);
    for (int round = 0; round < rounds; round++) {
        pc_tspline old = spline;
        uint8_t *wish = NULL;
        pc_closure_stats stats;
        pc_basis_facts facts;
        pc_jump jump[PC_JOINT_COUNT];
        pc_tmesh copy;
        double *point = sample(ctx, &spline);
        assert_ok(ctx, pc_tmesh_copy(&copy, ctx, &spline.mesh));
        old.mesh = copy;
        assert_ok(ctx, pc_new(&wish, ctx, spline.mesh.face_count));
        for (pc_index f = 0; f < spline.mesh.face_count; f++)
            if (pc_random_uniform(&random) * rarity < 1)
                wish[f] = (uint8_t)(1 + (int)(3 * pc_random_uniform(&random)));
        assert_ok(ctx, pc_insertion_refine(&spline, &stats, ctx, wish));
        assert_ok(ctx, pc_closure_check(&spline.mesh, ctx));
        assert_ok(ctx, pc_tspline_check(&spline, &facts, ctx));
        double change = moved(&spline, old.mesh.face_count, &old, point);
        pc_continuity_measure(jump, &spline, 3);
        print_message("%u asked, %u cuts, %u T, %u points, moved %.1e; ", stats.asked, stats.cuts,
                      stats.junctions, spline.mesh.vertex_count, change);
        assert_true(change < 1e-12);
        for (int c = 0; c < PC_JOINT_COUNT; c++)
            assert_true(jump[c].gap < 1e-12);
        assert_true(jump[PC_JOINT_REGULAR].normal_max < 1e-6);
        assert_true(jump[PC_JOINT_MIXED].normal_max < 1e-6);
        assert_true(jump[PC_JOINT_CLOSING].normal_max < 1e-6);
        pc_tmesh_free(&copy, ctx);
        pc_free(ctx, wish);
        pc_free(ctx, point);
    }
    print_message("\n");
    pc_tspline_free(&spline, ctx);
}

static void tori(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 3; seed++) {
        pc_polymesh quads;
        assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 1, 12, 8));
        refine_at_random(ctx, &quads, seed, 3, 12);
        pc_polymesh_free(&quads, ctx);
    }
}

static void planes(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 11; seed <= 13; seed++) {
        pc_polymesh quads;
        assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 6, 4, 9, 7));
        refine_at_random(ctx, &quads, seed, 3, 12);
        pc_polymesh_free(&quads, ctx);
    }
}

static void spheres(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 21; seed <= 24; seed++) {
        pc_polymesh quads;
        assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, (pc_index)(seed - 19)));
        refine_at_random(ctx, &quads, seed, 3, 20);
        pc_polymesh_free(&quads, ctx);
    }
}

/* Extraordinary vertices side by side, across faces, and around regular ones. */
static void folded_spheres(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 31; seed <= 33; seed++) {
        pc_polymesh quads;
        make_random_quads(&quads, ctx, seed, 6, (int)(seed - 29) * 6);
        refine_at_random(ctx, &quads, seed, 2, 30);
        pc_polymesh_free(&quads, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(tori, make_context, free_context),
        cmocka_unit_test_setup_teardown(planes, make_context, free_context),
        cmocka_unit_test_setup_teardown(spheres, make_context, free_context),
        cmocka_unit_test_setup_teardown(folded_spheres, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
