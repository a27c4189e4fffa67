/* The kernels of PGP in both shapes, whole and in ranges, against the plain-C references. */
#include "param_testing.h"
#include "pgp.h"
#include "pgp_launch.h"
#include "reconstruct.h"

static const pc_shape shapes[2] = {PC_SHAPE_CHUNK, PC_SHAPE_ROW};

/* The default device in a shape, its allocation cap lowered to `cap` unless 0; NULL where the machine has
 * none. */
static pc_device *open_device(pc_context *ctx, pc_shape form, size_t cap) {
    pc_device *device = NULL;
    if (pc_device_open(&device, ctx, NULL) != PC_OK ||
        pc_device_require_doubles(device, ctx, "a test") != PC_OK) {
        pc_device_close(device, ctx);
        pc_context_clear_message(ctx);
        return NULL;
    }
    pc_device_set_shape(device, form);
    if (cap) pc_device_set_allocation_cap(device, cap);
    return device;
}

/* References on the host beside the same on a device. */
typedef struct pair {
    shape s;
    double *scale;
    double period;
    pc_device *host, *device;
    pc_coupling expected, got;
    uint64_t seed;
} pair;

static void same_couplings(const pair *p) {
    for (size_t e = 0; e < p->expected.edge_count; e++) {
        assert_int_equal(p->got.turn[e], p->expected.turn[e]);
        float w = p->expected.weight[e],
              size = hypotf(p->expected.advance[2 * e], p->expected.advance[2 * e + 1]);
        if (!(fabsf(p->got.weight[e] - w) <= 1e-5f * (1 + w * w)))
            fail_msg("seed %llu, edge %zu: weight %g, not %g", (unsigned long long)p->seed, e,
                     (double)p->got.weight[e], (double)w);
        for (int k = 0; k < 2; k++)
            if (!(fabsf(p->got.advance[2 * e + k] - p->expected.advance[2 * e + k]) <= 1e-5f * size + 1e-7f))
                fail_msg("seed %llu, edge %zu: advance %g, not %g", (unsigned long long)p->seed, e,
                         (double)p->got.advance[2 * e + k], (double)p->expected.advance[2 * e + k]);
    }
}

static void same_systems(const pair *p, pc_context *ctx, const pc_edge_rows *rows) {
    pc_system expected, got;
    assert_ok(ctx, pc_pgp_assemble(&expected, ctx, p->host, &p->s.mesh, &p->s.adjacency, rows, &p->expected));
    assert_ok(ctx, pc_pgp_assemble(&got, ctx, p->device, &p->s.mesh, &p->s.adjacency, rows, &p->expected));
    assert_ok(ctx, pc_system_check(&got, ctx));
    size_t entries = expected.start[expected.row_count];
    assert_memory_equal(got.start, expected.start, sizeof(pc_index) * (expected.row_count + 1));
    assert_memory_equal(got.column, expected.column, sizeof(pc_index) * entries);
    assert_memory_equal(got.turn, expected.turn, entries);
    for (size_t k = 0; k < 4 * entries; k++)
        if (!(fabs(got.value[k] - expected.value[k]) <= 1e-14 * 20))
            fail_msg("seed %llu, value %zu: %.17g, not %.17g", (unsigned long long)p->seed, k, got.value[k],
                     expected.value[k]);
    for (pc_index i = 0; i < expected.row_count; i++)
        assert_true(fabs(got.diagonal[i] - expected.diagonal[i]) <= 1e-13 * expected.diagonal[i]);
    pc_system_free(&expected, ctx);
    pc_system_free(&got, ctx);
}

static void same_norms(const pair *p, pc_context *ctx, double *phase) {
    double *got = NULL;
    size_t n = p->s.mesh.vertex_count;
    pc_random random = {p->seed};
    assert_ok(ctx, pc_new(&got, ctx, 4 * n));
    for (size_t i = 0; i < 4 * n; i++)
        phase[i] = (2 * pc_random_uniform(&random) - 1) * pow(10, 20 * pc_random_uniform(&random) - 10);
    phase[0] = phase[1] = 0;
    memcpy(got, phase, sizeof(double) * 4 * n);
    assert_ok(ctx, pc_pgp_normalise(phase, ctx, p->host, (pc_index)n));
    assert_ok(ctx, pc_pgp_normalise(got, ctx, p->device, (pc_index)n));
    for (size_t i = 0; i < 4 * n; i++)
        assert_true(fabs(got[i] - phase[i]) <= 1e-15);
    assert_true(got[0] == 1 && got[1] == 0);
    pc_free(ctx, got);
}

static void make_param(pc_param *param, pc_context *ctx, const pc_mesh *mesh) {
    *param = (pc_param){.vertex_count = mesh->vertex_count, .face_count = mesh->face_count};
    assert_ok(ctx, pc_new(&param->coordinate, ctx, 2 * (size_t)mesh->vertex_count));
    assert_ok(ctx, pc_new(&param->turn, ctx, 3 * (size_t)mesh->face_count));
    assert_ok(ctx, pc_new(&param->shift, ctx, 6 * (size_t)mesh->face_count));
    assert_ok(ctx, pc_new(&param->singular, ctx, mesh->face_count));
}

/* Coordinates to rounding; from the same coordinates, small or of any size, the same transitions. */
static void same_coordinates(const pair *p, pc_context *ctx, const double *phase) {
    pc_param expected, got;
    const pc_mesh *mesh = &p->s.mesh;
    size_t n = 2 * (size_t)mesh->vertex_count, halves = 3 * (size_t)mesh->face_count;
    pc_random random = {p->seed + 1};
    make_param(&expected, ctx, mesh);
    make_param(&got, ctx, mesh);
    assert_ok(ctx, pc_reconstruct(&expected, ctx, p->host, mesh, &p->s.adjacency, &p->expected, phase));
    assert_ok(ctx, pc_reconstruct(&got, ctx, p->device, mesh, &p->s.adjacency, &p->expected, phase));
    assert_ok(ctx, pc_param_check(&got, ctx, mesh, &p->s.adjacency));
    for (size_t i = 0; i < n; i++) {
        int32_t apart = (got.coordinate[i] - expected.coordinate[i]) & (PC_PERIOD - 1);
        assert_true(apart <= 2 || apart >= PC_PERIOD - 2);
    }
    for (int round = 0; round < 3; round++) {
        for (size_t i = 0; i < n; i++) {
            int32_t x = (int32_t)(pc_random_next(&random) >> (round == 1 ? 40 : 33)) - (1 << 22);
            expected.coordinate[i] = got.coordinate[i] = round == 0 ? expected.coordinate[i] : (x | 1);
        }
        pc_reconstruct_shifts(&expected, mesh, &p->s.adjacency, &p->expected);
        assert_ok(ctx, pc_pgp_launch_shifts(&got, ctx, p->device, mesh, &p->s.adjacency, &p->expected));
        assert_memory_equal(got.turn, expected.turn, halves);
        assert_memory_equal(got.shift, expected.shift, 2 * sizeof(int32_t) * halves);
        pc_reconstruct_flags(&got, mesh);
        assert_ok(ctx, pc_param_check(&got, ctx, mesh, &p->s.adjacency));
    }
    pc_param_free(&expected, ctx);
    pc_param_free(&got, ctx);
}

static void compare(pc_context *ctx, int kind, pc_shape form, bool scaled, bool split) {
    pair p = {.seed = 70 + (uint64_t)kind, .host = open_host(ctx)};
    pc_edge_rows rows = {0};
    double *phase = NULL;
    make_mesh(&p.s.mesh, ctx, kind, p.seed);
    finish_shape(&p.s, ctx, p.host);
    /* Room for what is read in any order, but for a fraction of the system only. */
    p.device = open_device(ctx, form, split ? 8 * (size_t)p.s.adjacency.edge_count : 0);
    p.period = 3.1 * p.s.longest_edge;
    if (p.device) {
        pc_random random = {p.seed};
        pc_index n = p.s.mesh.vertex_count;
        assert_ok(ctx, pc_new(&p.scale, ctx, n));
        assert_ok(ctx, pc_new(&phase, ctx, 4 * (size_t)n));
        for (pc_index v = 0; v < n; v++)
            p.scale[v] = 0.25 + 0.75 * pc_random_uniform(&random);
        assert_ok(ctx, pc_coupling_make(&p.expected, ctx, p.host, &p.s.mesh, &p.s.adjacency, &p.s.field,
                                        scaled ? p.scale : NULL, p.period));
        assert_ok(ctx, pc_coupling_make(&p.got, ctx, p.device, &p.s.mesh, &p.s.adjacency, &p.s.field,
                                        scaled ? p.scale : NULL, p.period));
        assert_ok(ctx, pc_edge_rows_make(&rows, ctx, &p.s.mesh, &p.s.adjacency));
        same_couplings(&p);
        same_systems(&p, ctx, &rows);
        same_norms(&p, ctx, phase);
        same_coordinates(&p, ctx, phase);
        pc_edge_rows_free(&rows, ctx);
    }
    pc_free(ctx, p.scale);
    pc_free(ctx, phase);
    pc_coupling_free(&p.expected, ctx);
    pc_coupling_free(&p.got, ctx);
    free_shape(&p.s, ctx);
    pc_device_close(p.device, ctx);
    pc_device_close(p.host, ctx);
}

static void kernels_match_their_references(void **state) {
    for (int kind = 0; kind < SHAPE_KINDS; kind++)
        for (int k = 0; k < 2; k++)
            compare(*state, kind, shapes[k], kind % 2 == k, false);
}

static void ranges_match_too(void **state) {
    compare(*state, 3, PC_SHAPE_CHUNK, true, true);
    compare(*state, 7, PC_SHAPE_ROW, false, true);
}

/* The whole parameterization on a device has as many singular triangles of each kind as the host's. */
static void whole_stage_on_a_device(void **state) {
    pc_context *ctx = *state;
    shape s = {0};
    pc_device *devices[2] = {open_host(ctx), open_device(ctx, PC_SHAPE_CHUNK, 0)};
    pc_param_options options = PC_PARAM_DEFAULTS;
    pc_param_stats stats[2];
    memset(stats, 0, sizeof stats);
    make_mesh(&s.mesh, ctx, 1, 5);
    finish_shape(&s, ctx, devices[0]);
    options.period_length = 2.5 * s.longest_edge;
    for (int k = 0; k < 2 && devices[k]; k++) {
        pc_param param;
        assert_ok(ctx, pc_param_make(&param, &stats[k], ctx, devices[k], &s.mesh, &s.adjacency, &s.field,
                                     NULL, &options));
        assert_ok(ctx, pc_param_check(&param, ctx, &s.mesh, &s.adjacency));
        pc_param_free(&param, ctx);
    }
    if (devices[1]) {
        assert_int_equal(stats[0].field_singularities, stats[1].field_singularities);
        assert_true(fabs(stats[0].energy - stats[1].energy) <= 1e-3 * stats[0].energy);
    }
    free_shape(&s, ctx);
    pc_device_close(devices[0], ctx);
    pc_device_close(devices[1], ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(kernels_match_their_references, make_context, free_context),
        cmocka_unit_test_setup_teardown(ranges_match_too, make_context, free_context),
        cmocka_unit_test_setup_teardown(whole_stage_on_a_device, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
