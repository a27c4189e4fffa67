/* Folded quads stand upright after relaxing, and everything stays on the scan. */
#include "bvh.h"
#include "memory.h"
#include "random.h"
#include "relax.h"
#include "surface_testing.h"
#include "synth.h"
#include "synth_quads.h"
#include "vec3.h"

enum { SIDE = 8 };

typedef struct bench {
    pc_mesh scan;
    pc_adjacency adjacency;
    pc_polymesh quads;
    pc_relax_stats stats;
    pc_index folded;
} bench;

static void make_plane(bench *b, pc_context *ctx) {
    assert_ok(ctx, pc_synth_plane(&b->scan, ctx, SIDE, SIDE, 30, 30));
    assert_ok(ctx, pc_adjacency_make(&b->adjacency, ctx, &b->scan));
    assert_ok(ctx, pc_synth_quad_plane(&b->quads, ctx, SIDE, SIDE, SIDE, SIDE));
}

static void free_bench(bench *b, pc_context *ctx) {
    pc_polymesh_free(&b->quads, ctx);
    pc_adjacency_free(&b->adjacency, ctx);
    pc_mesh_free(&b->scan, ctx);
}

static void relax(bench *b, pc_context *ctx) {
    const pc_relax_options options = PC_RELAX_DEFAULTS;
    uint8_t *folded;
    pc_ground ground;
    assert_ok(ctx, pc_ground_make(&ground, ctx, &b->scan, &b->adjacency));
    assert_ok(ctx, pc_new(&folded, ctx, b->quads.face_count));
    assert_ok(ctx, pc_relax(&b->quads, &b->stats, folded, ctx, &ground, &options));
    pc_ground_free(&ground, ctx);
    b->folded = 0;
    for (pc_index f = 0; f < b->quads.face_count; f++)
        b->folded += folded[f];
    pc_free(ctx, folded);
}

static double farthest_from_scan(const bench *b, pc_context *ctx) {
    pc_bvh tree;
    double farthest = 0;
    assert_ok(ctx, pc_bvh_make(&tree, ctx, &b->scan));
    for (pc_index v = 0; v < b->quads.vertex_count; v++)
        farthest = fmax(farthest, pc_bvh_closest(&tree, pc_vec3_at(b->quads.position, v), PC_NONE).distance);
    pc_bvh_free(&tree, ctx);
    return farthest;
}

static bool on_border(const double *p) {
    return p[0] == 0 || p[0] == SIDE || p[1] == 0 || p[1] == SIDE;
}

/* Of a quad in the plane z = 0: every corner turns left. */
static bool is_convex(const pc_polymesh *quads, size_t f) {
    for (size_t k = 0; k < 4; k++) {
        const pc_index *c = quads->corner + 4 * f;
        pc_vec3 p = pc_vec3_at(quads->position, c[k]);
        pc_vec3 a = pc_sub(pc_vec3_at(quads->position, c[(k + 1) % 4]), p);
        pc_vec3 d = pc_sub(pc_vec3_at(quads->position, c[(k + 3) % 4]), p);
        if (pc_cross(a, d).z <= 0) return false;
    }
    return true;
}

static void clean_grid_keeps_its_border(void **state) {
    pc_context *ctx = *state;
    bench b;
    make_plane(&b, ctx);
    pc_random random = {5};
    for (size_t v = 0; v < b.quads.vertex_count; v++) { /* uneven, but nothing is bad */
        double *p = b.quads.position + 3 * v;
        bool on_x = p[0] > 0 && p[0]<SIDE, on_y = p[1]> 0 && p[1] < SIDE;
        if (on_x) p[0] += 0.4 * (pc_random_uniform(&random) - 0.5);
        if (on_y) p[1] += 0.4 * (pc_random_uniform(&random) - 0.5);
    }
    double before[3 * (SIDE + 1) * (SIDE + 1)];
    memcpy(before, b.quads.position, sizeof before);
    relax(&b, ctx);
    assert_true(b.stats.bad_before == 0 && b.stats.bad_after == 0 && b.folded == 0);
    for (size_t v = 0; v < b.quads.vertex_count; v++)
        if (on_border(before + 3 * v))
            assert_true(pc_distance(pc_vec3_at(before, v), pc_vec3_at(b.quads.position, v)) < 1e-12);
    free_bench(&b, ctx);
}

/* One vertex is moved over its neighbours, or some at random. */
static void folded_quads_stand_up(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 40; seed++) {
        bench b;
        pc_random random = {seed};
        make_plane(&b, ctx);
        size_t moved = 1 + seed / 10;
        for (size_t i = 0; i < moved; i++) {
            size_t x = 1 + pc_random_next(&random) % (SIDE - 1), y = 1 + pc_random_next(&random) % (SIDE - 1);
            double *p = b.quads.position + 3 * (y * (SIDE + 1) + x), turn = 6.3 * pc_random_uniform(&random);
            p[0] = fmin(fmax(p[0] + 1.6 * cos(turn), 0.1), SIDE - 0.1);
            p[1] = fmin(fmax(p[1] + 1.6 * sin(turn), 0.1), SIDE - 0.1);
        }
        pc_index bent = 0;
        for (size_t f = 0; f < b.quads.face_count; f++)
            bent += !is_convex(&b.quads, f);
        relax(&b, ctx);
        pc_index left = 0;
        for (size_t f = 0; f < b.quads.face_count; f++)
            left += !is_convex(&b.quads, f);
        double off = farthest_from_scan(&b, ctx);
        if (bent == 0 || b.stats.bad_before < bent || b.stats.bad_after || b.folded || left || off > 1e-12)
            fail_msg("seed %llu: %u bent, %u bad before, %u bad, %u folded, %u bent after, %g off",
                     (unsigned long long)seed, bent, b.stats.bad_before, b.stats.bad_after, b.folded, left,
                     off);
        is_manifold(ctx, &b.quads, 1, seed);
        free_bench(&b, ctx);
    }
}

/* On a curved scan vertices slide along it. */
static void stays_on_a_torus(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 10; seed++) {
        bench b;
        pc_random random = {seed};
        assert_ok(ctx, pc_synth_torus(&b.scan, ctx, 2, 0.8, 60, 30));
        assert_ok(ctx, pc_adjacency_make(&b.adjacency, ctx, &b.scan));
        assert_ok(ctx, pc_synth_quad_torus(&b.quads, ctx, 2, 0.8, 30, 15));
        for (int i = 0; i < 6; i++) {
            size_t v = pc_random_next(&random) % b.quads.vertex_count;
            for (size_t k = 0; k < 3; k++)
                b.quads.position[3 * v + k] += 1.2 * (pc_random_uniform(&random) - 0.5);
        }
        relax(&b, ctx);
        double off = farthest_from_scan(&b, ctx);
        if (b.stats.bad_after || b.folded || off > 1e-12)
            fail_msg("seed %llu: %u bad, %u folded, %g off the scan", (unsigned long long)seed,
                     b.stats.bad_after, b.folded, off);
        free_bench(&b, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(clean_grid_keeps_its_border, make_context, free_context),
        cmocka_unit_test_setup_teardown(folded_quads_stand_up, make_context, free_context),
        cmocka_unit_test_setup_teardown(stays_on_a_torus, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
