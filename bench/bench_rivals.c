/* One solver on one system, in a process of its own, for bench/solver.py; prints a line of JSON.
 *   bench_rivals make FILE DEVICE SCAN SUBDIVISIONS field|pgp     write a system
 *   bench_rivals percale|percale32|jacobi|cholmod|boomeramg FILE [DEVICE]   solve it to 1e-6 and to 1e-10
 * percale32 keeps the hierarchy in 32 bits. */
#include "clock.h"
#include "memory.h"
#include "peer_solvers.h"
#include "random.h"
#include "scan_systems.h"
#include "solver.h"
#include "system_file.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static pc_status make(pc_context *ctx, char **arguments) {
    pc_status status = PC_OK;
    pc_device *device = NULL;
    pc_scan_options options = PC_SCAN_OPTIONS_DEFAULTS;
    pc_scan_case scan = {0};
    pc_system system = {0};
    options.subdivisions = atoi(arguments[3]);
    PC_TRY(pc_device_open(&device, ctx, arguments[1]));
    PC_TRY(pc_scan_case_make(&scan, ctx, arguments[2], &options));
    PC_TRY(strcmp(arguments[4], "pgp") == 0 ? pc_scan_pgp_system(&system, ctx, device, &scan)
                                            : pc_scan_field_system(&system, ctx, device, &scan));
    PC_TRY(pc_system_save(&system, ctx, arguments[0]));
    printf("{\"rows\": %u, \"entries\": %u}\n", system.row_count, system.start[system.row_count]);
done:
    pc_system_free(&system, ctx);
    pc_scan_case_free(&scan, ctx);
    pc_device_close(device, ctx);
    return status;
}

static pc_status solve_ours(pc_peer_result *result, pc_context *ctx, const char *device_name,
                            pc_preconditioner which, bool half, const pc_system *system, const double *b,
                            double *x, const double tolerance[2]) {
    const size_t n = system->row_count * (size_t)pc_block_width(system->kind);
    pc_solver_options options = {which, 20000, 0, half};
    pc_status status = PC_OK;
    pc_device *device = NULL;
    pc_solver *solver = NULL;
    PC_TRY(pc_device_open(&device, ctx, device_name));
    /* Not later: what the first run frees, the second may get back without growing. */
    pc_clock_reset_peak();
    result->bytes_before = (double)pc_clock_peak_bytes();
    for (int run = 0; run < 2; run++) {
        /* The first run compiles kernels, if they are not in the cache. */
        pc_solver_free(solver, ctx);
        solver = NULL;
        double cpu = pc_clock_cpu(), wall = pc_clock_wall();
        PC_TRY(pc_solver_make(&solver, ctx, device, system, &options));
        result->setup_cpu = pc_clock_cpu() - cpu, result->setup_wall = pc_clock_wall() - wall;
        if (run == 0) {
            memset(x, 0, n * sizeof *x);
            PC_TRY(pc_solver_solve(solver, ctx, x, b, 0.5, NULL));
        }
    }
    for (int k = 0; k < 2; k++) {
        pc_solver_stats stats;
        memset(x, 0, n * sizeof *x);
        double cpu = pc_clock_cpu(), wall = pc_clock_wall();
        PC_TRY(pc_solver_approach(solver, ctx, x, b, tolerance[k], 1, &stats));
        result->solve_cpu[k] = pc_clock_cpu() - cpu, result->solve_wall[k] = pc_clock_wall() - wall;
        result->iterations[k] = (int)stats.iterations;
        /* The check below is not the solver's. */
        const double peak = (double)pc_clock_peak_bytes();
        if (peak > result->bytes_peak) result->bytes_peak = peak;
        result->residual[k] = pc_peer_residual(system, ctx, b, x);
        pc_clock_reset_peak();
    }
done:
    pc_solver_free(solver, ctx);
    pc_device_close(device, ctx);
    return status;
}

static pc_status solve(pc_context *ctx, const char *method, const char *path, const char *device) {
    const double tolerance[2] = {1e-6, 1e-10};
    pc_status status = PC_OK;
    pc_peer_result r = {0};
    pc_system system = {0};
    double *b = NULL, *x = NULL;
    PC_TRY(pc_system_load(&system, ctx, path));
    const size_t n = system.row_count * (size_t)pc_block_width(system.kind);
    PC_TRY(pc_new(&b, ctx, n));
    PC_TRY(pc_new(&x, ctx, n));
    memset(x, 0, n * sizeof *x);
    for (size_t i = 0; i < n; i++)
        b[i] = (double)(pc_hash64(i) >> 11) * 0x1p-52 - 1;
    pc_clock_reset_peak();
    r.bytes_before = (double)pc_clock_peak_bytes();
    if (strcmp(method, "cholmod") == 0)
        PC_TRY(pc_peer_cholmod(&r, ctx, &system, b, x, tolerance));
    else if (strcmp(method, "boomeramg") == 0)
        PC_TRY(pc_peer_boomeramg(&r, ctx, &system, b, x, tolerance));
    else
        PC_TRY(solve_ours(&r, ctx, device,
                          strcmp(method, "jacobi") == 0 ? PC_PRECONDITION_JACOBI : PC_PRECONDITION_MULTIGRID,
                          strcmp(method, "percale32") != 0, &system, b, x, tolerance));
    printf("{\"method\": \"%s\", \"rows\": %u, \"setup_cpu\": %.4f, \"setup\": %.4f, \"solve_cpu\": [%.4f, "
           "%.4f], \"solve\": [%.4f, %.4f], \"iterations\": [%d, %d], \"residual\": [%.2e, %.2e], "
           "\"bytes\": %.0f}\n",
           method, system.row_count, r.setup_cpu, r.setup_wall, r.solve_cpu[0], r.solve_cpu[1],
           r.solve_wall[0], r.solve_wall[1], r.iterations[0], r.iterations[1], r.residual[0], r.residual[1],
           (r.bytes_peak > 0 ? r.bytes_peak : (double)pc_clock_peak_bytes()) - r.bytes_before);
done:
    pc_system_free(&system, ctx);
    pc_free(ctx, b);
    pc_free(ctx, x);
    return status;
}

int main(int argc, char **argv) {
    pc_context *ctx = pc_context_make();
    if (!ctx) return pc_status_exit_code(PC_E_NOMEM);
    pc_status status = argc == 7 && strcmp(argv[1], "make") == 0 ? make(ctx, argv + 2)
                       : argc == 3 || argc == 4
                           ? solve(ctx, argv[1], argv[2], argc > 3 ? argv[3] : NULL)
                           : pc_fail(ctx, PC_E_USAGE, "see the head of bench/bench_rivals.c");
    if (status != PC_OK) (void)fprintf(stderr, "bench_rivals: %s\n", pc_context_message(ctx));
    pc_context_free(ctx);
    return pc_status_exit_code(status);
}
