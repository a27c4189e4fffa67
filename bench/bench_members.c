/* What the members of a device gain together: one of them alone, all, and (sub-devices) the undivided device,
 * in turns in one run, on the field and the PGP system of a scan or on those of synthetic tori. A table of
 * Markdown. bench_members [DEVICE [SCAN|VERTICES [SUBDIVISIONS [TOLERANCE]]]] DEVICE is "cpu/2" by default;
 * see pc_device_open. */
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

enum { TURNS = 15, WAYS = 3 };
static const char *const way_names[WAYS] = {"one member", "all members", "undivided"};

/* One way to solve a system, the best of all turns. */
typedef struct way {
    pc_device *device; /* NULL: there is no such way */
    pc_index spread_rows;
    pc_solver *solver;
    double setup, solve, solve_cpu;
    double halo; /* share of the bytes that kernels moved */
    pc_index iterations;
    double *x;
} way;

static pc_status measure_halo(way *w, pc_context *ctx) {
    const pc_kernel_stats *table;
    size_t count;
    double all = 0;
    double halo = 0;
    pc_status status = pc_device_kernel_stats(&table, &count, ctx, w->device);
    for (size_t i = 0; status == PC_OK && i < count; i++) {
        all += table[i].bytes;
        if (strncmp(table[i].name, "halo_", 5) == 0) halo += table[i].bytes;
    }
    w->halo = all > 0 ? halo / all : 0;
    return status;
}

static pc_status make(way *w, pc_context *ctx, const pc_system *system, size_t n) {
    pc_status status = PC_OK;
    pc_solver_options options = PC_SOLVER_DEFAULTS;
    options.spread_rows = w->spread_rows;
    w->solve = w->solve_cpu = INFINITY;
    PC_TRY(pc_new(&w->x, ctx, n));
    PC_TRY(pc_solver_make(&w->solver, ctx, w->device, system, &options));
done:
    return status;
}

static pc_status solve(way *w, pc_context *ctx, const double *b, size_t n, double tolerance) {
    pc_status status = PC_OK;
    pc_solver_stats stats;
    memset(w->x, 0, n * sizeof *w->x);
    pc_device_reset_stats(w->device);
    const double cpu = pc_clock_cpu();
    PC_TRY(pc_solver_solve(w->solver, ctx, w->x, b, tolerance, &stats));
    w->solve_cpu = fmin(w->solve_cpu, pc_clock_cpu() - cpu);
    w->solve = fmin(w->solve, stats.solve_seconds);
    w->setup = stats.setup_seconds;
    w->iterations = stats.iterations;
    PC_TRY(measure_halo(w, ctx));
done:
    return status;
}

static pc_status compare(pc_context *ctx, pc_device *device, const pc_system *system, const char *name,
                         double tolerance) {
    const size_t n = (size_t)system->row_count * (size_t)pc_block_width(system->kind);
    pc_status status = PC_OK;
    pc_random random = {5};
    double *b = NULL;
    pc_device *first = pc_device_member(device, 0);
    way ways[WAYS] = {{.device = first, .spread_rows = PC_NONE},
                      {.device = device},
                      {.device = first != device ? device : NULL, .spread_rows = PC_NONE}};
    PC_TRY(pc_new(&b, ctx, n));
    for (size_t i = 0; i < n; i++)
        b[i] = 2 * pc_random_uniform(&random) - 1;
    for (int k = 0; k < WAYS; k++)
        if (ways[k].device) PC_TRY(make(&ways[k], ctx, system, n));
    for (int turn = 0; turn < TURNS; turn++)
        for (int k = 0; k < WAYS; k++)
            if (ways[k].device) PC_TRY(solve(&ways[k], ctx, b, n, tolerance));
    for (int k = 0; k < WAYS; k++) {
        const way *w = &ways[k];
        if (!w->device) continue;
        printf("| %s | %u | %s | %.2f | %u | %.3f | %.2f | %.3f | %.1f | %s |\n", name, system->row_count,
               way_names[k], w->setup, w->iterations, w->solve, ways[0].solve / w->solve, w->solve_cpu,
               100 * w->halo, memcmp(w->x, ways[0].x, n * sizeof *w->x) == 0 ? "yes" : "NO");
        (void)fflush(stdout);
    }
done:
    for (int k = 0; k < WAYS; k++) {
        pc_solver_free(ways[k].solver, ctx);
        pc_free(ctx, ways[k].x);
    }
    pc_free(ctx, b);
    return status;
}

static pc_status scan_systems(pc_context *ctx, pc_device *device, const char *path, int subdivisions,
                              double tolerance) {
    pc_status status = PC_OK;
    pc_scan_options options = PC_SCAN_OPTIONS_DEFAULTS;
    pc_scan_case scan = {0};
    pc_system system = {0};
    options.subdivisions = subdivisions;
    PC_TRY(pc_scan_case_make(&scan, ctx, path, &options));
    for (int k = 0; k < 2; k++) {
        PC_TRY(k == 0 ? pc_scan_field_system(&system, ctx, device, &scan)
                      : pc_scan_pgp_system(&system, ctx, device, &scan));
        PC_TRY(compare(ctx, device, &system, k == 0 ? "field" : "PGP", tolerance));
        pc_system_free(&system, ctx);
    }
done:
    pc_scan_case_free(&scan, ctx);
    pc_system_free(&system, ctx);
    return status;
}

static pc_status torus_systems(pc_context *ctx, pc_device *device, double vertices, double tolerance) {
    static const char *const names[3] = {"torus, scalar", "torus, field", "torus, PGP"};
    pc_status status = PC_OK;
    pc_system system = {0};
    pc_synth_options options = PC_SYNTH_DEFAULTS;
    options.around = options.across = (pc_index)sqrt(vertices);
    options.combed = true;
    for (int k = 0; k < 3; k++) {
        PC_TRY(pc_synth_torus_system(&system, ctx, (pc_block_kind)k, &options));
        PC_TRY(compare(ctx, device, &system, names[k], tolerance));
        pc_system_free(&system, ctx);
    }
done:
    pc_system_free(&system, ctx);
    return status;
}

int main(int argc, char **argv) {
    pc_status status = PC_OK;
    pc_device *device = NULL;
    pc_context *ctx = pc_context_make();
    if (!ctx) return 1;
    const char *what = argc > 2 ? argv[2] : "250000";
    const int subdivisions = argc > 3 ? (int)strtol(argv[3], NULL, 10) : 0;
    const double tolerance = argc > 4 ? strtod(argv[4], NULL) : 1e-6;
    PC_TRY(pc_device_open(&device, ctx, argc > 1 ? argv[1] : "cpu/2"));
    printf("%s; %d members; %s, %d subdivisions; to %g; best of %d\n\n", pc_device_name(device),
           pc_device_member_count(device), what, subdivisions, tolerance, TURNS);
    printf("| system | rows | solved by | set-up, s | iterations | solve, s | times as fast as one | solve, "
           "CPU s | halo, %% of bytes "
           "| same bytes |\n|---|---|---|---|---|---|---|---|---|---|\n");
    status = strpbrk(what, "./") ? scan_systems(ctx, device, what, subdivisions, tolerance)
                                 : torus_systems(ctx, device, strtod(what, NULL), tolerance);
done:
    if (status != PC_OK) (void)fprintf(stderr, "%s: %s\n", pc_status_name(status), pc_context_message(ctx));
    pc_device_close(device, ctx);
    pc_context_free(ctx);
    return status == PC_OK ? 0 : 1;
}
