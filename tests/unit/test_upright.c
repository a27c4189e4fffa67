/* Quads that face against the scan stand up again, in thin sheets and at borders too; what cannot is told. */
#include "memory.h"
#include "random.h"
#include "surface_testing.h"
#include "synth.h"
#include "synth_quads.h"
#include "upright.h"

enum { SIDE = 8 };

static pc_index set_up(pc_polymesh *quads, pc_context *ctx, const pc_ground *ground) {
    const pc_upright_options options = PC_UPRIGHT_DEFAULTS;
    pc_index left, flagged = 0;
    uint8_t *folded;
    assert_ok(ctx, pc_new(&folded, ctx, quads->face_count));
    assert_ok(ctx, pc_upright_make(quads, folded, &left, NULL, ctx, ground, &options));
    for (pc_index f = 0; f < quads->face_count; f++) {
        pc_stance s = pc_upright_judge(ground, quads, f);
        assert_true(pc_upright_is_folded(&s) == (folded[f] != 0));
        flagged += folded[f];
    }
    assert_int_equal(flagged, left);
    pc_free(ctx, folded);
    return left;
}

static bool on_rim(const double *p) {
    return p[0] == 0 || p[0] == SIDE || p[1] == 0 || p[1] == SIDE;
}

static void throw_about(pc_polymesh *quads, pc_random *random, int count) {
    for (int i = 0; i < count; i++) {
        size_t x = 1 + pc_random_next(random) % (SIDE - 1), y = 1 + pc_random_next(random) % (SIDE - 1);
        double *p = quads->position + 3 * (y * (SIDE + 1) + x);
        p[0] = fmin(fmax(p[0] + 3 * (pc_random_uniform(random) - 0.5), 0.1), SIDE - 0.1);
        p[1] = fmin(fmax(p[1] + 3 * (pc_random_uniform(random) - 0.5), 0.1), SIDE - 0.1);
    }
}

/* Vertices of a plane thrown about, border vertices along the border past their neighbours. */
static void folds_in_a_plane(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 30; seed++) {
        pc_mesh scan;
        pc_adjacency adjacency;
        pc_ground ground;
        pc_polymesh quads;
        pc_random random = {seed};
        assert_ok(ctx, pc_synth_plane(&scan, ctx, SIDE, SIDE, 24, 24));
        assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &scan));
        assert_ok(ctx, pc_ground_make(&ground, ctx, &scan, &adjacency));
        assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, SIDE, SIDE, SIDE, SIDE));
        throw_about(&quads, &random, 3);
        uint8_t rim[(SIDE + 1) * (SIDE + 1)];
        for (size_t v = 0; v < quads.vertex_count; v++)
            rim[v] = on_rim(quads.position + 3 * v);
        pc_index left = set_up(&quads, ctx, &ground);
        for (size_t v = 0; v < quads.vertex_count; v++)
            assert_true(rim[v] == on_rim(quads.position + 3 * v));
        if (left) fail_msg("seed %llu: %u faces are folded", (unsigned long long)seed, left);
        pc_polymesh_free(&quads, ctx);
        pc_ground_free(&ground, ctx);
        pc_adjacency_free(&adjacency, ctx);
        pc_mesh_free(&scan, ctx);
    }
}

/* What stands right is left where it is, to the byte. */
static void nothing_moves_in_vain(void **state) {
    pc_context *ctx = *state;
    pc_mesh scan;
    pc_adjacency adjacency;
    pc_ground ground;
    pc_polymesh quads, before;
    assert_ok(ctx, pc_synth_torus(&scan, ctx, 2, 0.8, 60, 30));
    assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &scan));
    assert_ok(ctx, pc_ground_make(&ground, ctx, &scan, &adjacency));
    assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 0.8, 30, 15));
    assert_ok(ctx, pc_synth_quad_torus(&before, ctx, 2, 0.8, 30, 15));
    assert_int_equal(set_up(&quads, ctx, &ground), 0);
    assert_memory_equal(quads.position, before.position, 3 * sizeof(double) * quads.vertex_count);
    pc_polymesh_free(&quads, ctx);
    pc_polymesh_free(&before, ctx);
    pc_ground_free(&ground, ctx);
    pc_adjacency_free(&adjacency, ctx);
    pc_mesh_free(&scan, ctx);
}

/* Of a quad and the same one turned over exactly one stands right. */
static void turned_over_is_told(void **state) {
    pc_context *ctx = *state;
    pc_mesh scan;
    pc_adjacency adjacency;
    pc_ground ground;
    pc_polymesh quads;
    assert_ok(ctx, pc_synth_sphere(&scan, ctx, 12));
    assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &scan));
    assert_ok(ctx, pc_ground_make(&ground, ctx, &scan, &adjacency));
    assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 5));
    for (pc_index f = 0; f < quads.face_count; f++) {
        pc_stance before = pc_upright_judge(&ground, &quads, f);
        pc_index *c = quads.corner + 4 * (size_t)f, b = c[1];
        c[1] = c[3], c[3] = b;
        pc_stance after = pc_upright_judge(&ground, &quads, f);
        assert_true(pc_upright_is_folded(&before) != pc_upright_is_folded(&after));
    }
    pc_polymesh_free(&quads, ctx);
    pc_ground_free(&ground, ctx);
    pc_adjacency_free(&adjacency, ctx);
    pc_mesh_free(&scan, ctx);
}

/* Around the border of a square of side 8 and back, and never past a stop. */
static void walks_along_a_border(void **state) {
    pc_context *ctx = *state;
    pc_mesh scan;
    pc_adjacency adjacency;
    pc_ground ground;
    const pc_rim_place nowhere = {PC_NONE, 0};
    pc_random random = {3};
    assert_ok(ctx, pc_synth_plane(&scan, ctx, SIDE, SIDE, 10, 7));
    assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &scan));
    assert_ok(ctx, pc_ground_make(&ground, ctx, &scan, &adjacency));
    for (int i = 0; i < 200; i++) {
        pc_vec3 p = {SIDE * pc_random_uniform(&random), SIDE * pc_random_uniform(&random), 0};
        double way = (4 * SIDE - 0.01) * (pc_random_uniform(&random) - 0.5) * 2;
        pc_rim_place from = pc_ground_rim_closest(&ground, p);
        pc_rim_place to = pc_ground_rim_walk(&ground, from, way, nowhere);
        assert_true(to.edge != PC_NONE);
        pc_vec3 end = pc_ground_rim_point(&ground, to);
        double at[3] = {end.x, end.y, end.z};
        assert_true(fabs(at[0]) < 1e-9 || fabs(at[0] - SIDE) < 1e-9 || fabs(at[1]) < 1e-9 ||
                    fabs(at[1] - SIDE) < 1e-9);
        pc_rim_place back = pc_ground_rim_walk(&ground, to, -way, nowhere);
        assert_true(pc_distance(pc_ground_rim_point(&ground, back), pc_ground_rim_point(&ground, from)) <
                    1e-9);
        pc_rim_place half = pc_ground_rim_walk(&ground, from, way / 2, nowhere);
        assert_int_equal(pc_ground_rim_walk(&ground, from, way, half).edge, PC_NONE);
    }
    pc_ground_free(&ground, ctx);
    pc_adjacency_free(&adjacency, ctx);
    pc_mesh_free(&scan, ctx);
}

/* Round after round with some vertices thrown about, and faces taken out: the same places with what the last
 * round knew as without. */
static void memory_changes_nothing(void **state) {
    pc_context *ctx = *state;
    const pc_upright_options options = {1, 2, 0.3}; /* some are left */
    for (uint64_t seed = 0; seed < 30; seed++) {
        pc_mesh scan;
        pc_adjacency adjacency;
        pc_ground ground;
        pc_polymesh quads;
        pc_random random = {seed};
        pc_upright_memory *memory = NULL;
        assert_ok(ctx, pc_synth_plane(&scan, ctx, SIDE, SIDE, 24, 24));
        assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &scan));
        assert_ok(ctx, pc_ground_make(&ground, ctx, &scan, &adjacency));
        assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, SIDE, SIDE, SIDE, SIDE));
        throw_about(&quads, &random, 12);
        for (int round = 0; round < 4; round++) {
            pc_polymesh same;
            pc_index left, left_same;
            uint8_t *folded, *folded_same;
            assert_ok(ctx, pc_polymesh_copy(&same, ctx, &quads));
            assert_ok(ctx, pc_new(&folded, ctx, quads.face_count));
            assert_ok(ctx, pc_new(&folded_same, ctx, quads.face_count));
            assert_ok(ctx, pc_upright_make(&quads, folded, &left, &memory, ctx, &ground, &options));
            assert_ok(ctx, pc_upright_make(&same, folded_same, &left_same, NULL, ctx, &ground, &options));
            if (memcmp(quads.position, same.position, 3 * sizeof(double) * quads.vertex_count) != 0)
                fail_msg("seed %llu: round %d ends elsewhere", (unsigned long long)seed, round);
            assert_int_equal(left, left_same);
            assert_memory_equal(folded, folded_same, quads.face_count);
            memset(folded, 0, quads.face_count);
            folded[pc_random_next(&random) % quads.face_count] = 1;
            assert_ok(ctx, pc_polymesh_compact(&quads, ctx, folded));
            if (round == 1) throw_about(&quads, &random, 1);
            pc_polymesh_free(&same, ctx);
            pc_free(ctx, folded);
            pc_free(ctx, folded_same);
        }
        pc_upright_memory_free(memory, ctx);
        pc_polymesh_free(&quads, ctx);
        pc_ground_free(&ground, ctx);
        pc_adjacency_free(&adjacency, ctx);
        pc_mesh_free(&scan, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(memory_changes_nothing, make_context, free_context),
        cmocka_unit_test_setup_teardown(folds_in_a_plane, make_context, free_context),
        cmocka_unit_test_setup_teardown(nothing_moves_in_vain, make_context, free_context),
        cmocka_unit_test_setup_teardown(turned_over_is_told, make_context, free_context),
        cmocka_unit_test_setup_teardown(walks_along_a_border, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
