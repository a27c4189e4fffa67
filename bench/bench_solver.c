/* Time and iterations of the solver: block-Jacobi against multigrid.
 * On the field and the PGP system of scans, given by a path with a dot or a slash:
 *   bench_solver device SCAN [subdivisions [tolerance [jacobi 0|1]]]
 * on synthetic tori:
 *   bench_solver [device [kind 0..2 [vertices [tolerance [jacobi 0|1 [jitter [least weight]]]]]]] */
#include "clock.h"
#include "memory.h"
#include "random.h"
#include "scan_systems.h"
#include "solver.h"
#include "systems.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void print_kernels(pc_context *ctx, pc_device *device) {
    const pc_kernel_stats *table;
    size_t count;
    if (pc_device_kernel_stats(&table, &count, ctx, device) != PC_OK) return;
    for (size_t i = 0; i < count; i++)
        printf("    %-28s %8llu  %9.4f s  %7.2f GB/s\n", table[i].name, (unsigned long long)table[i].count,
               table[i].seconds, 1e-9 * table[i].bytes / table[i].seconds);
    pc_device_reset_stats(device);
}

static pc_status run(pc_context *ctx, pc_device *device, const pc_system *system, pc_preconditioner which,
                     double tolerance) {
    const size_t n = (size_t)system->row_count * (size_t)pc_block_width(system->kind);
    pc_status status = PC_OK;
    pc_solver *solver = NULL;
    pc_solver_options options = PC_SOLVER_DEFAULTS;
    pc_solver_stats stats = {0};
    double *x = NULL;
    double *b = NULL;
    pc_random random = {5};
    options.preconditioner = which;
    pc_memory_reset_peak(ctx);
    PC_TRY(pc_new(&x, ctx, n));
    PC_TRY(pc_new(&b, ctx, n));
    for (size_t i = 0; i < n; i++)
        b[i] = 2 * pc_random_uniform(&random) - 1;
    size_t before = pc_memory_used(ctx);
    double cpu = pc_clock_cpu();
    PC_TRY(pc_solver_make(&solver, ctx, device, system, &options));
    double setup_peak = (double)(pc_memory_peak(ctx) - before);
    double cpu_setup = pc_clock_cpu() - cpu;
    status = pc_solver_solve(solver, ctx, x, b, tolerance, &stats);
    double cpu_solve = pc_clock_cpu() - cpu - cpu_setup;
    printf("  CPU: set-up %.3f s, solve %.3f s\n", cpu_setup, cpu_solve);
    printf("  %-9s setup %.3f s, %u iterations, solve %.3f s, residual %.2e, host memory %.0f B/row (set-up "
           "%.0f)\n",
           which == PC_PRECONDITION_JACOBI ? "jacobi" : "multigrid", stats.setup_seconds, stats.iterations,
           stats.solve_seconds, stats.residual, (double)(pc_memory_used(ctx) - before) / system->row_count,
           setup_peak / system->row_count);
    if (status == PC_OK && which == PC_PRECONDITION_MULTIGRID) {
        PC_TRY(pc_solver_update(solver, ctx, system));
        PC_TRY(pc_solver_solve(solver, ctx, x, b, 0.5, &stats));
        printf("  update %.3f s\n", stats.setup_seconds);
    }
    print_kernels(ctx, device);
done:
    pc_solver_free(solver, ctx);
    pc_free(ctx, x);
    pc_free(ctx, b);
    return status;
}

static void to_stderr(void *user, pc_log_level level, const char *line) {
    (void)level;
    (void)fprintf(user, "%s\n", line);
}

static pc_status scan_systems(pc_context *ctx, pc_device *device, const char *path, int subdivisions,
                              double tolerance, bool jacobi) {
    pc_status status = PC_OK;
    pc_scan_options options = PC_SCAN_OPTIONS_DEFAULTS;
    pc_scan_case scan = {0};
    pc_system system = {0};
    options.subdivisions = subdivisions;
    PC_TRY(pc_scan_case_make(&scan, ctx, path, &options));
    for (int k = 0; k < 2; k++) {
        PC_TRY(k == 0 ? pc_scan_field_system(&system, ctx, device, &scan)
                      : pc_scan_pgp_system(&system, ctx, device, &scan));
        pc_device_reset_stats(device);
        printf("%s, %s, %s, %u rows, tolerance %g\n", path, pc_device_name(device), k == 0 ? "field" : "pgp",
               system.row_count, tolerance);
        PC_TRY(run(ctx, device, &system, PC_PRECONDITION_MULTIGRID, tolerance));
        if (jacobi) PC_TRY(run(ctx, device, &system, PC_PRECONDITION_JACOBI, tolerance));
        pc_system_free(&system, ctx);
    }
done:
    pc_scan_case_free(&scan, ctx);
    pc_system_free(&system, ctx);
    return status;
}

int main(int argc, char **argv) {
    pc_status status = PC_OK;
    pc_device *device = NULL;
    pc_system system = {0};
    pc_context *ctx = pc_context_make();
    pc_synth_options options = PC_SYNTH_DEFAULTS;
    if (!ctx) return 1;
    pc_context_set_log(ctx, to_stderr, stderr, getenv("PERCALE_DEBUG") ? PC_LOG_DEBUG : PC_LOG_WARNING);
    int kind = argc > 2 ? (int)strtol(argv[2], NULL, 10) : 1;
    double vertices = argc > 3 ? strtod(argv[3], NULL) : 1e5;
    double tolerance = argc > 4 ? strtod(argv[4], NULL) : 1e-6;
    bool jacobi = argc > 5 && (int)strtol(argv[5], NULL, 10);
    options.around = options.across = (pc_index)sqrt(vertices);
    options.combed = true;
    if (argc > 6) options.jitter = strtod(argv[6], NULL);
    if (argc > 7) options.least = strtod(argv[7], NULL);
    PC_TRY(pc_device_open(&device, ctx, argc > 1 ? argv[1] : "host"));
    if (argc > 2 && strpbrk(argv[2], "./")) {
        status = scan_systems(ctx, device, argv[2], argc > 3 ? (int)strtol(argv[3], NULL, 10) : 0, tolerance,
                              jacobi);
        goto done;
    }
    PC_TRY(pc_synth_torus_system(&system, ctx, (pc_block_kind)kind, &options));
    printf("%s, kind %d, %u rows, tolerance %g\n", pc_device_name(device), kind, system.row_count, tolerance);
    PC_TRY(run(ctx, device, &system, PC_PRECONDITION_MULTIGRID, tolerance));
    if (jacobi) PC_TRY(run(ctx, device, &system, PC_PRECONDITION_JACOBI, tolerance));
done:
    if (status != PC_OK) (void)fprintf(stderr, "%s: %s\n", pc_status_name(status), pc_context_message(ctx));
    pc_system_free(&system, ctx);
    pc_device_close(device, ctx);
    pc_context_free(ctx);
    return status == PC_OK ? 0 : 1;
}
