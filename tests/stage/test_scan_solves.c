/* Iterations of the solver on the field and the PGP system of real scans, kept exactly: they do not depend on
 * the machine's speed or load. PERCALE_SCANS=all adds the larger ones. */
#include "memory.h"
#include "random.h"
#include "scan_systems.h"
#include "solver.h"
#include "testing.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct scan_count {
    const char *file;
    pc_index field, pgp; /* iterations to 1e-6 */
    bool large;
} scan_count;

static const scan_count counts[] = {
    {"wingnut.obj", 8, 9, false},         {"decimated-max.obj", 9, 9, false},
    {"fertility.off", 8, 9, false},       {"fandisk.off", 8, 9, false},
    {"rocker-arm.obj", 9, 9, false},      {"spot.obj", 8, 9, false},
    {"camelhead.off", 10, 9, false},      {"stanford-bunny.obj", 10, 9, true},
    {"nefertiti-lowres.obj", 9, 9, true}, {"botijo.obj", 10, 10, true},
    {"tower_holes.obj", 10, 9, true},
};

static pc_index iterations(pc_context *ctx, pc_device *device, const pc_system *system) {
    const size_t n = system->row_count * (size_t)pc_block_width(system->kind);
    pc_solver *solver = NULL;
    pc_solver_stats stats;
    double *b = NULL, *x = NULL;
    assert_ok(ctx, pc_new(&b, ctx, n));
    assert_ok(ctx, pc_new(&x, ctx, n));
    for (size_t i = 0; i < n; i++)
        b[i] = (double)(pc_hash64(i) >> 11) * 0x1p-52 - 1;
    assert_ok(ctx, pc_solver_make(&solver, ctx, device, system, NULL));
    assert_ok(ctx, pc_solver_solve(solver, ctx, x, b, 1e-6, &stats));
    pc_solver_free(solver, ctx);
    pc_free(ctx, b);
    pc_free(ctx, x);
    return stats.iterations;
}

static void scan_takes(pc_context *ctx, pc_device *device, const char *path, const scan_count *expected) {
    const pc_scan_options options = PC_SCAN_OPTIONS_DEFAULTS;
    pc_scan_case scan;
    pc_system system;
    assert_ok(ctx, pc_scan_case_make(&scan, ctx, path, &options));
    assert_ok(ctx, pc_scan_field_system(&system, ctx, device, &scan));
    pc_index field = iterations(ctx, device, &system);
    pc_system_free(&system, ctx);
    assert_ok(ctx, pc_scan_pgp_system(&system, ctx, device, &scan));
    pc_index pgp = iterations(ctx, device, &system);
    pc_system_free(&system, ctx);
    pc_scan_case_free(&scan, ctx);
    print_message("%s: field %u, pgp %u iterations\n", expected->file, field, pgp);
    if (field != expected->field || pgp != expected->pgp)
        fail_msg("%s: expected field %u, pgp %u iterations", expected->file, expected->field, expected->pgp);
}

static void scans_take_their_iterations(void **state) {
    pc_context *ctx = *state;
    const char *data = getenv("PERCALE_DATA");
    const char *wanted = getenv("PERCALE_SCANS");
    pc_device *host = NULL;
    char path[4096];
    int found = 0;
    assert_ok(ctx, pc_device_open(&host, ctx, "host"));
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        bool named = wanted && strcmp(wanted, counts[k].file) == 0;
        if (wanted && !named && strcmp(wanted, "all") != 0) continue;
        if (!wanted && counts[k].large) continue;
        (void)snprintf(path, sizeof path, "%s/%s", data && *data ? data : "../shared/data", counts[k].file);
        if (access(path, R_OK) != 0) continue;
        scan_takes(ctx, host, path, &counts[k]);
        found++;
    }
    pc_device_close(host, ctx);
    if (found == 0) skip();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(scans_take_their_iterations, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
