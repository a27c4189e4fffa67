/* Distances between surfaces with known answers. */
#include "deviation.h"
#include "memory.h"
#include "random.h"
#include "synth.h"
#include "synth_wear.h"
#include "testing.h"
#include <omp.h>
#include <stdlib.h>

static int by_value(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (x[0] > y[0]) - (x[0] < y[0]);
}

static void quantile_agrees_with_sorting(void **state) {
    (void)state;
    for (uint64_t seed = 0; seed < 30; seed++) {
        enum { N = 500 };
        pc_random random = {pc_hash64(seed)};
        double pair[N][2], value[N], weight[N], total = 0, sum = 0, fraction = pc_random_uniform(&random);
        for (int i = 0; i < N; i++) {
            value[i] = pair[i][0] = i % 5 ? pc_random_uniform(&random) * pow(10, (int)(seed % 7) - 3) : 0;
            weight[i] = pair[i][1] = (double)(pc_random_next(&random) % 4); /* whole: exact in any order */
            total += weight[i];
        }
        qsort(pair, N, sizeof pair[0], by_value);
        int at = 0;
        while (at < N - 1 && sum + pair[at][1] < fraction * total)
            sum += pair[at++][1];
        if (pc_weighted_quantile(value, weight, N, fraction) != pair[at][0])
            fail_msg("seed %llu, fraction %g", (unsigned long long)seed, fraction);
    }
    assert_true(pc_weighted_quantile(NULL, NULL, 0, 0.5) == 0);
}

static void parallel_planes(void **state) {
    pc_context *ctx = *state;
    pc_mesh low, high;
    pc_bvh tree;
    pc_deviation d;
    assert_ok(ctx, pc_synth_plane(&low, ctx, 3, 2, 5, 3));
    assert_ok(ctx, pc_synth_plane(&high, ctx, 3, 2, 17, 9));
    for (size_t v = 0; v < high.vertex_count; v++)
        high.position[3 * v + 2] = 0.25;
    assert_ok(ctx, pc_bvh_make(&tree, ctx, &low));
    pc_deviation_options options = {.spacing = 0.05, .least = 1};
    assert_ok(ctx, pc_deviation_measure(&d, NULL, ctx, &high, &tree, &options));
    assert_true(fabs(d.mean - 0.25) < 1e-14 && fabs(d.q95 - 0.25) < 1e-14 && fabs(d.max - 0.25) < 1e-14);
    assert_true(d.sample_count > high.vertex_count + high.face_count);
    pc_bvh_free(&tree, ctx);
    pc_mesh_free(&low, ctx);
    pc_mesh_free(&high, ctx);
}

/* A square of side 1 beside a wall through x = 0: the distance of a point is its x. */
static void ramp_has_mean_half(void **state) {
    pc_context *ctx = *state;
    pc_mesh square, wall;
    pc_bvh tree;
    pc_deviation d;
    assert_ok(ctx, pc_synth_plane(&square, ctx, 1, 1, 3, 2));
    assert_ok(ctx, pc_synth_plane(&wall, ctx, 8, 8, 2, 2));
    for (size_t v = 0; v < wall.vertex_count; v++) {
        double *p = wall.position + 3 * v;
        p[2] = p[0] - 4, p[0] = 0, p[1] -= 4;
    }
    assert_ok(ctx, pc_bvh_make(&tree, ctx, &wall));
    pc_deviation_options options = {.spacing = 0.01};
    assert_ok(ctx, pc_deviation_measure(&d, NULL, ctx, &square, &tree, &options));
    assert_true(fabs(d.mean - 0.5) < 1e-3);
    assert_true(fabs(d.q95 - 0.95) < 0.01);
    assert_true(d.max == 1 && d.worst.x == 1);
    options.spacing = 0; /* the vertices alone, weighted by the area around them */
    assert_ok(ctx, pc_deviation_measure(&d, NULL, ctx, &square, &tree, &options));
    assert_int_equal(d.sample_count, square.vertex_count);
    assert_true(fabs(d.mean - 0.5) < 0.02);
    pc_bvh_free(&tree, ctx);
    pc_mesh_free(&square, ctx);
    pc_mesh_free(&wall, ctx);
}

/* A coarse sphere lies inside the fine one by r (1 - cos) at most: both directions see it. */
static void labels_and_threads(void **state) {
    pc_context *ctx = *state;
    pc_mesh two, sphere;
    pc_bvh tree;
    pc_deviation d[2];
    double most[2][2];
    assert_ok(ctx, pc_synth_sphere(&sphere, ctx, 20));
    assert_ok(ctx, pc_mesh_copy(&two, ctx, &sphere));
    assert_ok(ctx, pc_synth_append(&two, ctx, &sphere, (pc_vec3){3, 0, 0}));
    pc_index *label;
    assert_ok(ctx, pc_new(&label, ctx, two.face_count));
    for (pc_index f = sphere.face_count; f < two.face_count; f++)
        label[f] = 1;
    assert_ok(ctx, pc_bvh_make(&tree, ctx, &sphere));
    pc_deviation_options options = {.spacing = 0.03, .label = label, .label_count = 2};
    for (int i = 0; i < 2; i++) {
        omp_set_num_threads(i ? 3 : 1);
        assert_ok(ctx, pc_deviation_measure(&d[i], most[i], ctx, &two, &tree, &options));
    }
    assert_memory_equal(&d[0], &d[1], sizeof d[0]);
    assert_true(most[0][0] < 1e-15 && most[0][0] == most[1][0]);
    assert_true(fabs(most[0][1] - 3) < 1e-12 && fabs(d[0].worst.x - 4) < 1e-12);
    pc_free(ctx, label);
    pc_bvh_free(&tree, ctx);
    pc_mesh_free(&two, ctx);
    pc_mesh_free(&sphere, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(quantile_agrees_with_sorting, make_context, free_context),
        cmocka_unit_test_setup_teardown(parallel_planes, make_context, free_context),
        cmocka_unit_test_setup_teardown(ramp_has_mean_half, make_context, free_context),
        cmocka_unit_test_setup_teardown(labels_and_threads, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
