/* The solver on the host: right answers, iteration counts, odd systems. */
#include "device.h"
#include "memory.h"
#include "random.h"
#include "solver.h"
#include "systems.h"
#include "testing.h"
#include <math.h>

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
        for (pc_index around = 60; around <= 240; around *= 2) {
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(torus_takes_few_iterations, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
