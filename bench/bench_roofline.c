/* Every kernel of the solver against the triad of the same run: bytes moved, GB/s, share of the roof.
 * usage: bench_roofline [device [vertices [repeats]]] */
#include "memory.h"
#include "random.h"
#include "solver.h"
#include "systems.h"
#include "triad.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char *const kind_names[3] = {"scalar", "complex", "turned"};

static pc_status solve(pc_context *ctx, pc_device *device, const pc_system *system) {
    const size_t n = (size_t)system->row_count * (size_t)pc_block_width(system->kind);
    pc_status status = PC_OK;
    pc_solver *solver = NULL;
    double *x = NULL;
    double *b = NULL;
    PC_TRY(pc_new(&x, ctx, n));
    PC_TRY(pc_new(&b, ctx, n));
    for (size_t i = 0; i < n; i++)
        b[i] = (double)(pc_hash64(i) >> 11) * 0x1p-53 - 0.5;
    PC_TRY(pc_solver_make(&solver, ctx, device, system, NULL));
    /* Once to compile, once to measure. */
    PC_TRY(pc_solver_solve(solver, ctx, x, b, 1e-2, NULL));
    for (size_t i = 0; i < n; i++)
        x[i] = 0;
    pc_device_reset_stats(device);
    PC_TRY(pc_solver_solve(solver, ctx, x, b, 1e-6, NULL));
done:
    pc_solver_free(solver, ctx);
    pc_free(ctx, x);
    pc_free(ctx, b);
    return status;
}

static pc_status report(pc_context *ctx, pc_device *device, double before) {
    enum { TRIAD = 8 << 20, REPEATS = 20 };
    const pc_kernel_stats *table;
    size_t count;
    double after;
    double seconds = 0;
    double bytes = 0;
    pc_status status = pc_device_kernel_stats(&table, &count, ctx, device);
    if (status != PC_OK) return status;
    for (size_t i = 0; i < count; i++) {
        double rate = 1e-9 * table[i].bytes / table[i].seconds;
        printf("  %-22s %6llu launches %9.2f ms %9.1f MB %7.2f GB/s  %.2f\n", table[i].name,
               (unsigned long long)table[i].count, 1e3 * table[i].seconds, 1e-6 * table[i].bytes, rate,
               rate / before);
        seconds += table[i].seconds;
        bytes += table[i].bytes;
    }
    printf("  %-22s %15s %9.2f ms %9.1f MB %7.2f GB/s  %.2f\n", "all", "", 1e3 * seconds, 1e-6 * bytes,
           1e-9 * bytes / seconds, 1e-9 * bytes / seconds / before);
    status = pc_triad(&after, ctx, device, TRIAD, REPEATS);
    printf("  triad before %.2f, after %.2f GB/s\n", before, after);
    return status;
}

int main(int argc, char **argv) {
    enum { TRIAD = 8 << 20, REPEATS = 20 };
    pc_status status = PC_OK;
    pc_device *device = NULL;
    pc_system system = {0};
    pc_synth_options options = PC_SYNTH_DEFAULTS;
    pc_context *ctx = pc_context_make();
    if (!ctx) return 1;
    double vertices = argc > 2 ? strtod(argv[2], NULL) : 1000000;
    int repeats = argc > 3 ? (int)strtol(argv[3], NULL, 10) : 1;
    options.around = options.across = (pc_index)sqrt(vertices);
    options.combed = options.folded = true;
    PC_TRY(pc_device_open(&device, ctx, argc > 1 ? argv[1] : NULL));
    if (pc_device_is_host(device)) {
        status = pc_fail(ctx, PC_E_USAGE, "kernels are measured on OpenCL devices only");
        goto done;
    }
    for (int k = 0; k < 3 * repeats; k++) {
        double roof;
        PC_TRY(pc_synth_torus_system(&system, ctx, (pc_block_kind)(k % 3), &options));
        PC_TRY(pc_triad(&roof, ctx, device, TRIAD, REPEATS));
        printf("%s, %s, %u rows: share of the triad's %.2f GB/s\n", pc_device_name(device), kind_names[k % 3],
               system.row_count, roof);
        PC_TRY(solve(ctx, device, &system));
        PC_TRY(report(ctx, device, roof));
        pc_system_free(&system, ctx);
    }
done:
    if (status != PC_OK) (void)fprintf(stderr, "%s: %s\n", pc_status_name(status), pc_context_message(ctx));
    pc_system_free(&system, ctx);
    pc_device_close(device, ctx);
    pc_context_free(ctx);
    return pc_status_exit_code(status);
}
