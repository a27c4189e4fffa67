/* The solver on the host: right answers, iteration counts, odd systems. */
#include "device.h"
#include "memory.h"
#include "random.h"
#include "solver.h"
#include "systems.h"
#include "testing.h"
#include <math.h>
#include <omp.h>

static const pc_block_kind kinds[3] = {PC_BLOCK_SCALAR, PC_BLOCK_COMPLEX, PC_BLOCK_TURNED};

static void fill(double *x, size_t n, uint64_t seed) {
    pc_random random = {seed};
    for (size_t i = 0; i < n; i++)
        x[i] = 2 * pc_random_uniform(&random) - 1;
}

/* Solves for a random right-hand side; checks the residual by the reference product; returns the iterations.
 */
static pc_index solve_random(pc_context *ctx, const pc_system *system, pc_preconditioner which,
                             double tolerance) {
    size_t n = (size_t)system->row_count * (size_t)pc_block_width(system->kind);
    pc_device *host = NULL;
    pc_solver *solver = NULL;
    pc_solver_stats stats;
    pc_solver_options options = PC_SOLVER_DEFAULTS;
    double *x = NULL;
    double *b = NULL;
    double *y = NULL;
    options.preconditioner = which;
    if (which == PC_PRECONDITION_JACOBI) options.max_iterations = 10000;
    assert_ok(ctx, pc_device_open(&host, ctx, "host"));
    assert_ok(ctx, pc_system_check(system, ctx));
    assert_ok(ctx, pc_new(&x, ctx, n));
    assert_ok(ctx, pc_new(&b, ctx, n));
    assert_ok(ctx, pc_new(&y, ctx, n));
    fill(b, n, 7);
    assert_ok(ctx, pc_solver_make(&solver, ctx, host, system, &options));
    assert_ok(ctx, pc_solver_solve(solver, ctx, x, b, tolerance, &stats));
    pc_system_apply(y, system, x);
    double error = 0;
    double size = 0;
    for (size_t i = 0; i < n; i++) {
        error += (y[i] - b[i]) * (y[i] - b[i]);
        size += b[i] * b[i];
    }
    assert_true(sqrt(error / size) <= 1.01 * tolerance);
    assert_true(fabs(stats.residual - sqrt(error / size)) <= 1e-3 * tolerance);
    pc_solver_free(solver, ctx);
    pc_free(ctx, x);
    pc_free(ctx, b);
    pc_free(ctx, y);
    pc_device_close(host, ctx);
    return stats.iterations;
}

static void torus_takes_few_iterations(void **state) {
    pc_context *ctx = *state;
    for (int k = 0; k < 3; k++) {
        for (pc_index around = 60; around <= 120; around *= 2) {
            pc_synth_options options = PC_SYNTH_DEFAULTS;
            pc_system system;
            options.around = around;
            options.across = around / 2;
            assert_ok(ctx, pc_synth_torus_system(&system, ctx, kinds[k], &options));
            pc_index its = solve_random(ctx, &system, PC_PRECONDITION_MULTIGRID, 1e-6);
            print_message("kind %d, %u rows: %u iterations\n", k, system.row_count, its);
            assert_true(its <= 22);
            pc_system_free(&system, ctx);
        }
    }
}

/* Random frames and representatives only rename the unknowns. */
static void frames_do_not_matter(void **state) {
    pc_context *ctx = *state;
    for (int k = 1; k < 3; k++) {
        pc_index first = 0;
        for (uint64_t seed = 1; seed <= 3; seed++) {
            pc_synth_options options = PC_SYNTH_DEFAULTS;
            pc_system system;
            options.frame_seed = seed;
            options.around = 90;
            options.across = 60;
            options.combed = seed == 1;
            assert_ok(ctx, pc_synth_torus_system(&system, ctx, kinds[k], &options));
            pc_index its = solve_random(ctx, &system, PC_PRECONDITION_MULTIGRID, 1e-6);
            if (seed == 1) first = its;
            assert_true(its + 1 >= first && its <= first + 1);
            pc_system_free(&system, ctx);
        }
    }
}

/* Copies of a system side by side, `isolated` rows without couplings after each. */
static void repeat(pc_system *out, pc_context *ctx, const pc_system *one, pc_index copies,
                   pc_index isolated) {
    const pc_index n = one->row_count;
    const pc_index m = one->start[n];
    const size_t w = (size_t)pc_block_width(one->kind);
    assert_ok(ctx, pc_system_make(out, ctx, one->kind, copies * (n + isolated), (size_t)copies * m));
    for (pc_index c = 0; c < copies; c++) {
        pc_index row = c * (n + isolated);
        for (pc_index i = 0; i < n + isolated; i++) {
            out->start[row + i + 1] = c * m + (i < n ? one->start[i + 1] : m);
            out->diagonal[row + i] = i < n ? one->diagonal[i] : 1e-3 * (i + 1);
        }
        for (pc_index e = 0; e < m; e++)
            out->column[c * m + e] = row + one->column[e];
        memcpy(out->value + w * c * m, one->value, w * m * sizeof *out->value);
        if (out->turn) memcpy(out->turn + (size_t)c * m, one->turn, m);
    }
}

static void components_and_isolated_rows(void **state) {
    pc_context *ctx = *state;
    for (int k = 0; k < 3; k++) {
        pc_synth_options options = PC_SYNTH_DEFAULTS;
        pc_system one;
        pc_system many;
        options.around = options.across = 12;
        assert_ok(ctx, pc_synth_torus_system(&one, ctx, kinds[k], &options));
        repeat(&many, ctx, &one, 50, 3);
        pc_index its = solve_random(ctx, &many, PC_PRECONDITION_MULTIGRID, 1e-6);
        assert_true(its <= 22);
        pc_system_free(&many, ctx);
        pc_system_free(&one, ctx);
        /* Triangles by the thousand: nothing is left to coarsen after one step. */
        assert_ok(ctx, pc_synth_random_system(&one, ctx, kinds[k], 3, 64, 1.0, 5));
        repeat(&many, ctx, &one, 2000, 1);
        its = solve_random(ctx, &many, PC_PRECONDITION_MULTIGRID, 1e-6);
        assert_true(its <= 30);
        pc_system_free(&many, ctx);
        pc_system_free(&one, ctx);
    }
}

static void tiny_and_diagonal_systems(void **state) {
    pc_context *ctx = *state;
    for (int k = 0; k < 3; k++) {
        for (pc_index rows = 1; rows <= 1000; rows *= 10) {
            pc_system system;
            assert_ok(ctx, pc_system_make(&system, ctx, kinds[k], rows, 0));
            for (pc_index i = 0; i < rows; i++)
                system.diagonal[i] = 1 + i % 7;
            assert_true(solve_random(ctx, &system, PC_PRECONDITION_JACOBI, 1e-10) <= 2);
            (void)solve_random(ctx, &system, PC_PRECONDITION_MULTIGRID, 1e-10);
            pc_system_free(&system, ctx);
        }
        for (pc_index rows = 1; rows < 12; rows++) {
            pc_system system;
            assert_ok(ctx, pc_synth_random_system(&system, ctx, kinds[k], rows, 64, 1.01, rows));
            (void)solve_random(ctx, &system, PC_PRECONDITION_MULTIGRID, 1e-10);
            pc_system_free(&system, ctx);
        }
    }
}

/* Weights as obtuse triangles have them: some couplings repel. The scalar Laplacian stays as easy as ever;
 * rotated ones have low modes at the repelling couplings and take more, but still converge. */
static void negative_couplings(void **state) {
    pc_context *ctx = *state;
    for (int k = 0; k < 3; k++) {
        pc_synth_options options = PC_SYNTH_DEFAULTS;
        pc_system system;
        options.around = options.across = 60;
        options.jitter = 0.5;
        options.least = -1e9;
        assert_ok(ctx, pc_synth_torus_system(&system, ctx, kinds[k], &options));
        pc_index its = solve_random(ctx, &system, PC_PRECONDITION_MULTIGRID, 1e-6);
        print_message("negative couplings, kind %d: %u iterations\n", k, its);
        assert_true(its <= (k == 0 ? 20 : 70));
        pc_system_free(&system, ctx);
    }
}

/* Unrelated rotations everywhere: singularities at every cycle of the graph. */
static void frustrated_couplings(void **state) {
    pc_context *ctx = *state;
    for (int k = 0; k < 3; k++) {
        pc_system system;
        assert_ok(ctx, pc_synth_random_system(&system, ctx, kinds[k], 5000, 8, 1.0, 3));
        pc_index its = solve_random(ctx, &system, PC_PRECONDITION_MULTIGRID, 1e-8);
        print_message("frustrated, kind %d: %u iterations\n", k, its);
        assert_true(its <= 60);
        pc_system_free(&system, ctx);
    }
}

static void threads_do_not_change_a_byte(void **state) {
    pc_context *ctx = *state;
    for (int k = 0; k < 3; k++) {
        pc_synth_options options = PC_SYNTH_DEFAULTS;
        pc_system system;
        pc_device *host = NULL;
        double *x[2] = {NULL, NULL};
        double *b = NULL;
        options.around = options.across = 40;
        assert_ok(ctx, pc_device_open(&host, ctx, "host"));
        assert_ok(ctx, pc_synth_torus_system(&system, ctx, kinds[k], &options));
        size_t n = (size_t)system.row_count * (size_t)pc_block_width(system.kind);
        assert_ok(ctx, pc_new(&b, ctx, n));
        fill(b, n, 3);
        int before = omp_get_max_threads();
        for (int run = 0; run < 2; run++) {
            pc_solver *solver = NULL;
            omp_set_num_threads(run == 0 ? 1 : 3);
            assert_ok(ctx, pc_new(&x[run], ctx, n));
            assert_ok(ctx, pc_solver_make(&solver, ctx, host, &system, NULL));
            assert_ok(ctx, pc_solver_solve(solver, ctx, x[run], b, 1e-8, NULL));
            pc_solver_free(solver, ctx);
        }
        omp_set_num_threads(before);
        assert_memory_equal(x[0], x[1], n * sizeof(double));
        pc_free(ctx, x[0]);
        pc_free(ctx, x[1]);
        pc_free(ctx, b);
        pc_system_free(&system, ctx);
        pc_device_close(host, ctx);
    }
}

/* New values give the bytes of a fresh solver on the same groups, or nearly its iterations on others. */
static void updates_and_limits(void **state) {
    pc_context *ctx = *state;
    pc_synth_options options = PC_SYNTH_DEFAULTS;
    pc_solver_options limits = {PC_PRECONDITION_MULTIGRID, 3, 0, true};
    pc_solver_stats stats;
    pc_system first;
    pc_system second;
    pc_device *host = NULL;
    pc_solver *solver = NULL;
    double *x = NULL;
    double *b = NULL;
    assert_ok(ctx, pc_device_open(&host, ctx, "host"));
    assert_ok(ctx, pc_synth_torus_system(&first, ctx, PC_BLOCK_COMPLEX, &options));
    options.frame_seed = 99;
    options.shift = 1e-3;
    assert_ok(ctx, pc_synth_torus_system(&second, ctx, PC_BLOCK_COMPLEX, &options));
    size_t n = 2 * (size_t)first.row_count;
    assert_ok(ctx, pc_new(&x, ctx, n));
    assert_ok(ctx, pc_new(&b, ctx, n));
    fill(b, n, 9);
    assert_ok(ctx, pc_solver_make(&solver, ctx, host, &first, NULL));
    assert_ok(ctx, pc_solver_update(solver, ctx, &second));
    assert_ok(ctx, pc_solver_solve(solver, ctx, x, b, 1e-8, &stats));
    assert_true(stats.iterations <= 22);
    /* From the solution nothing is left to do. */
    assert_ok(ctx, pc_solver_solve(solver, ctx, x, b, 1e-7, &stats));
    assert_int_equal(stats.iterations, 0);
    memset(b, 0, n * sizeof *b);
    assert_ok(ctx, pc_solver_solve(solver, ctx, x, b, 1e-7, &stats));
    for (size_t i = 0; i < n; i++)
        assert_true(x[i] == 0);
    pc_solver_free(solver, ctx);
    fill(b, n, 9);
    assert_ok(ctx, pc_solver_make(&solver, ctx, host, &first, &limits));
    assert_int_equal(pc_solver_solve(solver, ctx, x, b, 1e-8, &stats), PC_E_NOCONV);
    assert_int_equal(stats.iterations, 3);
    assert_true(stats.residual > 1e-8 && stats.residual < 1);
    pc_context_clear_message(ctx);
    /* Who can do with less goes on without a message. */
    assert_int_equal(pc_solver_approach(solver, ctx, x, b, 1e-12, 0.5 * stats.residual * 1e-9, &stats),
                     PC_E_NOCONV);
    pc_context_clear_message(ctx);
    assert_ok(ctx, pc_solver_approach(solver, ctx, x, b, 1e-12, 1, &stats));
    assert_true(stats.residual > 1e-12);
    assert_string_equal(pc_context_message(ctx), "");
    pc_solver_free(solver, ctx);
    pc_free(ctx, x);
    pc_free(ctx, b);
    pc_system_free(&first, ctx);
    pc_system_free(&second, ctx);
    pc_device_close(host, ctx);
}

static void checks_find_broken_systems(void **state) {
    pc_context *ctx = *state;
    for (int fault = 0; fault < 5; fault++) {
        pc_system system;
        assert_ok(ctx, pc_synth_random_system(&system, ctx, PC_BLOCK_TURNED, 40, 20, 1.1, 8));
        assert_ok(ctx, pc_system_check(&system, ctx));
        if (fault == 0) system.value[5] += 0.1;
        if (fault == 1) system.diagonal[7] = 0;
        if (fault == 2) system.turn[0] = (uint8_t)((system.turn[0] + 1) % 4);
        if (fault == 3) system.column[1] = system.column[0];
        if (fault == 4) system.value[3] = NAN;
        assert_int_equal(pc_system_check(&system, ctx), PC_E_BUG);
        pc_context_clear_message(ctx);
        pc_system_free(&system, ctx);
    }
}

/* Every allocation may fail: an error comes back and nothing leaks. */
static void memory_may_run_out(void **state) {
    pc_context *ctx = *state;
    pc_synth_options options = PC_SYNTH_DEFAULTS;
    pc_system system;
    pc_device *host = NULL;
    pc_status status = PC_E_NOMEM;
    options.around = options.across = 20;
    assert_ok(ctx, pc_device_open(&host, ctx, "host"));
    assert_ok(ctx, pc_synth_torus_system(&system, ctx, PC_BLOCK_TURNED, &options));
    size_t used = pc_memory_used(ctx);
    for (size_t n = 1; status == PC_E_NOMEM; n++) {
        pc_solver *solver = NULL;
        pc_memory_fail_at(ctx, n);
        status = pc_solver_make(&solver, ctx, host, &system, NULL);
        pc_memory_fail_at(ctx, 0);
        pc_context_clear_message(ctx);
        pc_solver_free(solver, ctx);
        assert_int_equal(pc_memory_used(ctx), used);
    }
    assert_int_equal(status, PC_OK);
    pc_system_free(&system, ctx);
    pc_device_close(host, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(torus_takes_few_iterations, make_context, free_context),
        cmocka_unit_test_setup_teardown(frames_do_not_matter, make_context, free_context),
        cmocka_unit_test_setup_teardown(components_and_isolated_rows, make_context, free_context),
        cmocka_unit_test_setup_teardown(tiny_and_diagonal_systems, make_context, free_context),
        cmocka_unit_test_setup_teardown(negative_couplings, make_context, free_context),
        cmocka_unit_test_setup_teardown(frustrated_couplings, make_context, free_context),
        cmocka_unit_test_setup_teardown(threads_do_not_change_a_byte, make_context, free_context),
        cmocka_unit_test_setup_teardown(updates_and_limits, make_context, free_context),
        cmocka_unit_test_setup_teardown(checks_find_broken_systems, make_context, free_context),
        cmocka_unit_test_setup_teardown(memory_may_run_out, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
