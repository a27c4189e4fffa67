/* A device's members solve together: the same bytes as one device, whatever the shape of the kernels and the
 * way rows are dealt out. */
#include "launch.h"
#include "memory.h"
#include "random.h"
#include "shape_testing.h"
#include "solver.h"
#include "systems.h"
#include "testing.h"
#include <math.h>
#include <stdio.h>

extern const char pc_kernel_halo[];

static const pc_block_kind kinds[3] = {PC_BLOCK_SCALAR, PC_BLOCK_COMPLEX, PC_BLOCK_TURNED};

/* The default device as often as asked for in a list, or cut into so many sub-devices; NULL where it cannot
 * be.
 */
static pc_device *open_members(pc_context *ctx, pc_shape shape, int count, bool divided) {
    char wanted[64] = "";
    pc_device_info *infos = NULL;
    pc_device *device = NULL;
    size_t found = 0;
    assert_ok(ctx, pc_device_list(&infos, &found, ctx));
    const pc_device_info *at = infos;
    for (size_t i = found; i-- > 0;)
        if (infos[i].cpu) at = &infos[i];
    if (found > 0 && divided && at->cpu && at->units >= (unsigned)count) {
        (void)snprintf(wanted, sizeof wanted, "%d:%d/%d", at->platform, at->device, count);
    } else if (found > 0 && !divided) {
        for (int k = 0; k < count; k++)
            (void)snprintf(wanted + strlen(wanted), sizeof wanted - strlen(wanted), "%s%d:%d",
                           k > 0 ? "," : "", at->platform, at->device);
    }
    pc_free(ctx, infos);
    if (wanted[0] == '\0') return NULL;
    assert_ok(ctx, pc_device_open(&device, ctx, wanted));
    assert_int_equal(pc_device_member_count(device), count);
    pc_device_set_shape(device, shape);
    return device;
}

static double *random_vector(pc_context *ctx, size_t n, uint64_t seed) {
    pc_random random = {seed};
    double *x = NULL;
    assert_ok(ctx, pc_new(&x, ctx, n));
    for (size_t i = 0; i < n; i++)
        x[i] = 2 * pc_random_uniform(&random) - 1;
    return x;
}

/* What a device finds for a system, then for other values and for another diagonal: three solutions. */
static double *three_solutions(pc_context *ctx, pc_device *device, const pc_system *system,
                               const pc_solver_options *options, pc_index iterations[3]) {
    const size_t n = (size_t)system->row_count * (size_t)pc_block_width(system->kind);
    pc_solver *solver = NULL;
    pc_solver_stats stats;
    double *raised = NULL;
    double *b = random_vector(ctx, n, 5);
    double *x = random_vector(ctx, 3 * n, 6);
    assert_ok(ctx, pc_new(&raised, ctx, system->row_count));
    for (pc_index i = 0; i < system->row_count; i++)
        raised[i] = system->diagonal[i] * (1.01 + 0.01 * sin(i));
    assert_ok(ctx, pc_solver_make(&solver, ctx, device, system, options));
    for (int k = 0; k < 3; k++) {
        if (k == 1) assert_ok(ctx, pc_solver_update(solver, ctx, system));
        if (k == 2) assert_ok(ctx, pc_solver_set_diagonal(solver, ctx, raised));
        assert_ok(ctx, pc_solver_solve(solver, ctx, x + k * n, b, k == 1 ? 0.1 : 1e-5, &stats));
        iterations[k] = stats.iterations;
    }
    pc_solver_free(solver, ctx);
    pc_free(ctx, raised);
    pc_free(ctx, b);
    return x;
}

/* One device against members; `cap` bytes per buffer where it is not 0. */
static void compare(pc_context *ctx, const pc_system *system, pc_shape shape, int count, bool divided,
                    const pc_solver_options *options, size_t cap) {
    const size_t n = 3 * (size_t)system->row_count * (size_t)pc_block_width(system->kind);
    pc_device *one = open_device(ctx, shape);
    pc_device *members = open_members(ctx, shape, count, divided);
    pc_index expected[3];
    pc_index found[3];
    if (one && members) {
        if (cap > 0) pc_device_set_allocation_cap(members, cap);
        double *alone = three_solutions(ctx, one, system, options, expected);
        double *together = three_solutions(ctx, members, system, options, found);
        for (int k = 0; k < 3; k++)
            assert_int_equal(found[k], expected[k]);
        const bool same = memcmp(alone, together, n * sizeof *alone) == 0;
        for (size_t i = 0; !same && i < n; i++) {
            if (alone[i] != together[i] || i + 1 == n)
                fail_msg("kind %d, shape %d, %d members, number %zu: %.17g alone, %.17g together",
                         system->kind, shape, count, i, alone[i], together[i]);
        }
        pc_free(ctx, alone);
        pc_free(ctx, together);
    }
    pc_device_close(one, ctx);
    pc_device_close(members, ctx);
}

static void skip_without_device(pc_context *ctx) {
    pc_device *device = open_device(ctx, PC_SHAPE_CHUNK);
    if (!device) skip();
    pc_device_close(device, ctx);
}

static void members_solve_like_one_device(void **state) {
    pc_context *ctx = *state;
    skip_without_device(ctx);
    for (int k = 0; k < 3; k++) {
        pc_system system;
        pc_synth_options torus = PC_SYNTH_DEFAULTS;
        torus.around = 130, torus.across = 101;
        assert_ok(ctx, pc_synth_torus_system(&system, ctx, kinds[k], &torus));
        for (int s = 0; s < 2; s++) {
            /* One, two or all levels are spread. */
            const int count = 2 + (k + s) % 2;
            pc_solver_options options = PC_SOLVER_DEFAULTS;
            options.spread_rows = count == 3 ? 4000 : s == 0 ? 500 : 1;
            compare(ctx, &system, shapes[s], count, false, &options, 0);
        }
        pc_system_free(&system, ctx);
    }
}

static void sub_devices_solve_like_one_device(void **state) {
    pc_context *ctx = *state;
    skip_without_device(ctx);
    for (int k = 1; k < 3; k++) {
        pc_system system;
        pc_synth_options torus = PC_SYNTH_DEFAULTS;
        torus.around = 161, torus.across = 109;
        assert_ok(ctx, pc_synth_torus_system(&system, ctx, kinds[k], &torus));
        compare(ctx, &system, PC_SHAPE_CHUNK, 2, true, NULL, 0);
        pc_system_free(&system, ctx);
    }
}

/* Without multigrid, and with matrices split below a cap. */
static void other_ways_to_solve(void **state) {
    pc_context *ctx = *state;
    pc_system system;
    pc_synth_options torus = PC_SYNTH_DEFAULTS;
    pc_solver_options jacobi = {PC_PRECONDITION_JACOBI, 10000, 1000, true};
    pc_solver_options options = PC_SOLVER_DEFAULTS;
    skip_without_device(ctx);
    torus.around = torus.across = 91, torus.shift = 0.1;
    options.spread_rows = 1000;
    for (int s = 0; s < 2; s++) {
        assert_ok(ctx, pc_synth_torus_system(&system, ctx, PC_BLOCK_TURNED, &torus));
        compare(ctx, &system, shapes[s], 2, false, &jacobi, 0);
        compare(ctx, &system, shapes[s], 2, false, &options,
                4 * (size_t)system.row_count * sizeof(double) * 4);
        pc_system_free(&system, ctx);
    }
}

/* Rows that couple to any other, rows that couple to none, fewer blocks than members, no last level. */
static void random_systems_on_members(void **state) {
    pc_context *ctx = *state;
    static const pc_index sizes[] = {1, 9, 4097, 9011};
    pc_solver_options options = PC_SOLVER_DEFAULTS;
    skip_without_device(ctx);
    options.spread_rows = 1;
    for (int k = 0; k < 12; k += 1 + (k >= 6)) {
        pc_system system;
        assert_ok(
            ctx, pc_synth_random_system(&system, ctx, kinds[k % 3], sizes[k / 3], 5, 1.05, 70 + (uint64_t)k));
        compare(ctx, &system, shapes[k % 2], k < 6 ? 2 : 3, false, &options, 0);
        pc_system_free(&system, ctx);
    }
}

/* Rows out of and into a vector, for all row sizes, against plain C. */
static void halo_kernels_match_their_reference(void **state) {
    pc_context *ctx = *state;
    enum { ROWS = 1000, COUNT = 371, MOST = 8 };
    pc_device *device = open_device(ctx, PC_SHAPE_CHUNK);
    pc_kernel *kernel[2] = {NULL, NULL};
    uint32_t vector[ROWS * MOST];
    uint32_t result[ROWS * MOST];
    uint32_t place[COUNT];
    if (!device) skip();
    for (pc_index i = 0; i < ROWS * MOST; i++)
        vector[i] = (uint32_t)pc_hash64(i);
    for (pc_index i = 0; i < COUNT; i++)
        place[i] = (i * 37 + 5) % ROWS;
    assert_ok(ctx, pc_kernel_get(&kernel[0], ctx, device, pc_kernel_halo, "halo_gather"));
    assert_ok(ctx, pc_kernel_get(&kernel[1], ctx, device, pc_kernel_halo, "halo_scatter"));
    for (uint32_t words = 1; words <= MOST; words *= 2) {
        for (int back = 0; back < 2; back++) {
            pc_buffer *from = NULL;
            pc_buffer *to = NULL;
            pc_buffer *at = NULL;
            assert_ok(ctx, pc_buffer_from(&from, ctx, device, vector, sizeof vector));
            assert_ok(ctx, pc_buffer_zeroed(&to, ctx, device, sizeof result));
            assert_ok(ctx, pc_buffer_from(&at, ctx, device, place, sizeof place));
            assert_ok(ctx, pc_kernel_run(
                               ctx, kernel[back], (size_t)COUNT * words, 0, 0,
                               PC_ARGS(PC_BUF(from), PC_BUF(at), PC_BUF(to), PC_U32(COUNT), PC_U32(words))));
            assert_ok(ctx, pc_buffer_read(result, ctx, to, 0, sizeof result));
            uint32_t expected[ROWS * MOST] = {0};
            for (pc_index i = 0; i < COUNT; i++)
                for (uint32_t w = 0; w < words; w++)
                    expected[back ? place[i] * words + w : i * words + w] =
                        vector[back ? i * words + w : place[i] * words + w];
            assert_memory_equal(result, expected, sizeof result);
            pc_buffer_free(from, ctx);
            pc_buffer_free(to, ctx);
            pc_buffer_free(at, ctx);
        }
    }
    pc_device_close(device, ctx);
}

/* Every allocation of set-up and solve may fail: an error comes back and nothing leaks. */
static void memory_may_run_out(void **state) {
    pc_context *ctx = *state;
    pc_system system;
    pc_synth_options torus = PC_SYNTH_DEFAULTS;
    pc_solver_options options = PC_SOLVER_DEFAULTS;
    pc_device *device = open_members(ctx, PC_SHAPE_CHUNK, 2, false);
    pc_status status = PC_E_NOMEM;
    size_t used = 0;
    if (!device) skip();
    torus.around = torus.across = 30;
    options.spread_rows = 1;
    assert_ok(ctx, pc_synth_torus_system(&system, ctx, PC_BLOCK_TURNED, &torus));
    const size_t n = 4 * (size_t)system.row_count;
    double *b = random_vector(ctx, n, 3);
    double *x = random_vector(ctx, n, 4);
    /* The first time without failures: it takes the kernels, which the device keeps. */
    for (size_t k = 0; status == PC_E_NOMEM; k++) {
        pc_solver *solver = NULL;
        pc_memory_fail_at(ctx, k);
        status = pc_solver_make(&solver, ctx, device, &system, &options);
        if (status == PC_OK) status = pc_solver_solve(solver, ctx, x, b, 1e-3, NULL);
        pc_memory_fail_at(ctx, 0);
        pc_context_clear_message(ctx);
        pc_solver_free(solver, ctx);
        if (k == 0) {
            assert_int_equal(status, PC_OK);
            status = PC_E_NOMEM;
            used = pc_memory_used(ctx);
        }
        assert_int_equal(pc_memory_used(ctx), used);
    }
    assert_int_equal(status, PC_OK);
    pc_free(ctx, b);
    pc_free(ctx, x);
    pc_system_free(&system, ctx);
    pc_device_close(device, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(halo_kernels_match_their_reference, make_context, free_context),
        cmocka_unit_test_setup_teardown(members_solve_like_one_device, make_context, free_context),
        cmocka_unit_test_setup_teardown(sub_devices_solve_like_one_device, make_context, free_context),
        cmocka_unit_test_setup_teardown(other_ways_to_solve, make_context, free_context),
        cmocka_unit_test_setup_teardown(random_systems_on_members, make_context, free_context),
        cmocka_unit_test_setup_teardown(memory_may_run_out, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
