/* Scales rise where quads miss the scan or are folded, and nowhere else. */
#include "memory.h"
#include "sizing.h"
#include "synth.h"
#include "synth_quads.h"
#include "synth_wear.h"
#include "testing.h"
#include "vec3.h"

enum { SIDE = 20, STEPS = 80 };

/* A plane with a bump around its centre, and flat quads of edge 1 that miss the bump. */
typedef struct bench {
    pc_mesh scan;
    pc_adjacency adjacency;
    pc_polymesh quads;
    double *scale;
    uint8_t *folded;
    pc_sizing_options options;
    pc_sizing_stats stats;
} bench;

static double from_centre(const pc_mesh *scan, size_t v) {
    return hypot(scan->position[3 * v] - SIDE / 2.0, scan->position[3 * v + 1] - SIDE / 2.0);
}

static void make_bench(bench *b, pc_context *ctx, double bump) {
    const pc_sizing_options options = PC_SIZING_DEFAULTS;
    assert_ok(ctx, pc_synth_plane(&b->scan, ctx, SIDE, SIDE, STEPS, STEPS));
    for (size_t v = 0; v < b->scan.vertex_count; v++) {
        double r = from_centre(&b->scan, v);
        b->scan.position[3 * v + 2] = bump * exp(-r * r);
    }
    assert_ok(ctx, pc_adjacency_make(&b->adjacency, ctx, &b->scan));
    assert_ok(ctx, pc_synth_quad_plane(&b->quads, ctx, SIDE, SIDE, SIDE, SIDE));
    assert_ok(ctx, pc_new(&b->scale, ctx, b->scan.vertex_count));
    assert_ok(ctx, pc_new(&b->folded, ctx, b->quads.face_count));
    for (size_t v = 0; v < b->scan.vertex_count; v++)
        b->scale[v] = 1;
    b->options = options;
    b->options.edge_length = 1;
    b->options.period_length = 1000; /* no edge is too long */
    b->options.gradation = 2;
}

static void free_bench(bench *b, pc_context *ctx) {
    pc_mesh_free(&b->scan, ctx);
    pc_adjacency_free(&b->adjacency, ctx);
    pc_polymesh_free(&b->quads, ctx);
    pc_free(ctx, b->scale);
    pc_free(ctx, b->folded);
}

static void update(bench *b, pc_context *ctx) {
    pc_ground ground;
    assert_ok(ctx, pc_ground_make(&ground, ctx, &b->scan, &b->adjacency));
    assert_ok(ctx, pc_sizing_update(b->scale, &b->stats, ctx, &ground, &b->quads, b->folded, &b->options));
    pc_ground_free(&ground, ctx);
}

/* Between neighbours no scale falls off faster than asked. */
static void is_graded(const bench *b) {
    for (pc_index h = 0; h < 3 * b->scan.face_count; h++) {
        pc_index i = pc_tail(&b->scan, h), j = pc_head(&b->scan, h);
        double along = pc_distance(pc_vec3_at(b->scan.position, i), pc_vec3_at(b->scan.position, j));
        double fall = exp(-along / (b->options.gradation * b->options.edge_length));
        assert_true(b->scale[j] >= 0.998 * fall * b->scale[i]);
    }
}

static void good_quads_want_nothing(void **state) {
    pc_context *ctx = *state;
    bench b;
    make_bench(&b, ctx, 0.9); /* less than the reach of one edge */
    for (size_t v = 0; v < b.scan.vertex_count; v++)
        b.scale[v] = 1 + (v % 2) * 0.05;
    update(&b, ctx);
    assert_int_equal(b.stats.wanting, 0);
    for (size_t v = 0; v < b.scan.vertex_count; v++)
        assert_true(b.scale[v] == 1 + (v % 2) * 0.05);
    free_bench(&b, ctx);
}

static void a_missed_bump_raises_its_scale(void **state) {
    pc_context *ctx = *state;
    bench b;
    make_bench(&b, ctx, 4);
    pc_index missed = 0;
    for (size_t v = 0; v < b.scan.vertex_count; v++)
        missed += b.scan.position[3 * v + 2] > 1;
    update(&b, ctx);
    assert_int_equal(b.stats.wanting, missed);
    is_graded(&b);
    for (size_t v = 0; v < b.scan.vertex_count; v++) {
        double height = b.scan.position[3 * v + 2], r = from_centre(&b.scan, v);
        assert_true(b.scale[v] >= 1 && b.scale[v] <= b.options.growth);
        if (height > 1) assert_true(b.scale[v] > 1.19);
        if (height > 2) assert_true(b.scale[v] == b.options.growth);
        /* The bump is about 1.2 wide; twice as fine falls off to 1 within 2 log 2 edges. */
        if (r > 1.2 + 2 * log(2) + 0.3) assert_true(b.scale[v] == 1);
    }
    for (int i = 0; i < 8; i++)
        update(&b, ctx);
    double most = 0;
    for (size_t v = 0; v < b.scan.vertex_count; v++)
        most = fmax(most, b.scale[v]);
    assert_true(most == b.options.most);
    is_graded(&b);
    free_bench(&b, ctx);
}

static void folded_faces_want_finer_ones(void **state) {
    pc_context *ctx = *state;
    bench b;
    make_bench(&b, ctx, 0);
    b.folded[SIDE * SIDE / 2 + SIDE / 2] = 1; /* centre: half an edge from that of the plane */
    update(&b, ctx);
    assert_true(b.stats.wanting >= 4 && b.stats.wanting <= 12);
    is_graded(&b);
    for (size_t v = 0; v < b.scan.vertex_count; v++) {
        assert_true(b.scale[v] >= 1 && b.scale[v] <= 1.4);
        if (from_centre(&b.scan, v) > 1.5 + 2 * log(1.4) + 0.3) assert_true(b.scale[v] == 1);
    }
    free_bench(&b, ctx);
}

/* No scale makes an edge of the scan half a period long, however much is missed. */
static void edges_limit_scales(void **state) {
    pc_context *ctx = *state;
    bench b;
    make_bench(&b, ctx, 4);
    b.options.period_length = 1.2;
    for (int i = 0; i < 6; i++)
        update(&b, ctx);
    for (pc_index h = 0; h < 3 * b.scan.face_count; h++) {
        pc_index i = pc_tail(&b.scan, h), j = pc_head(&b.scan, h);
        double along = pc_distance(pc_vec3_at(b.scan.position, i), pc_vec3_at(b.scan.position, j));
        double scale = fmax(b.scale[i], b.scale[j]);
        assert_true(scale <= 1 || along * scale < 0.5 * b.options.period_length);
    }
    free_bench(&b, ctx);
}

/* Quads 0.3 off are near enough for a single sheet, not for a wall of half an edge. */
static void thin_walls_want_finer_ones(void **state) {
    pc_context *ctx = *state;
    for (int walls = 0; walls < 2; walls++) {
        bench b;
        pc_mesh other;
        make_bench(&b, ctx, 0);
        assert_ok(ctx, pc_mesh_copy(&other, ctx, &b.scan));
        for (pc_index f = 0; f < other.face_count; f++) {
            pc_index *t = other.triangle + 3 * (size_t)f, swap = t[1];
            t[1] = t[2], t[2] = swap;
        }
        assert_ok(ctx, pc_synth_append(&b.scan, ctx, &other, (pc_vec3){0, 0, -0.5}));
        pc_mesh_free(&other, ctx);
        pc_adjacency_free(&b.adjacency, ctx);
        assert_ok(ctx, pc_adjacency_make(&b.adjacency, ctx, &b.scan));
        assert_ok(ctx, pc_resize(&b.scale, ctx, b.scan.vertex_count));
        for (size_t v = 0; v < b.scan.vertex_count; v++)
            b.scale[v] = 1;
        for (size_t v = 0; v < b.quads.vertex_count; v++)
            b.quads.position[3 * v + 2] = 0.3;
        b.options.walls = walls;
        update(&b, ctx);
        assert_true(walls ? b.stats.wanting > b.scan.vertex_count / 3 : b.stats.wanting == 0);
        free_bench(&b, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(good_quads_want_nothing, make_context, free_context),
        cmocka_unit_test_setup_teardown(a_missed_bump_raises_its_scale, make_context, free_context),
        cmocka_unit_test_setup_teardown(folded_faces_want_finer_ones, make_context, free_context),
        cmocka_unit_test_setup_teardown(edges_limit_scales, make_context, free_context),
        cmocka_unit_test_setup_teardown(thin_walls_want_finer_ones, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
