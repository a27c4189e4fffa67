/* A finished run of percale as a T-spline: control points, errors, rounds and times.
 * bench_spline OUT [TOLERANCE of the diagonal, default 0.002] [FAIRNESS] [DEPTH] [ROUNDS]; writes
 * OUT/surface.step too
 */
#include "adapt.h"
#include "clock.h"
#include "continuity.h"
#include "doublet.h"
#include "memory.h"
#include "products.h"
#include "step.h"
#include <stdio.h>
#include <stdlib.h>

typedef struct input {
    pc_mesh mesh;
    pc_adjacency adjacency;
    pc_polymesh quads;
    pc_target target;
} input;

static pc_status load(input *in, pc_context *ctx, const char *folder) {
    pc_status status = PC_OK;
    pc_store *store = NULL;
    pc_index removed;
    char path[4096];
    (void)snprintf(path, sizeof path, "%s/stages/mesh.h5", folder);
    PC_TRY(pc_store_open(&store, ctx, path));
    PC_TRY(pc_mesh_load(&in->mesh, store, "mesh"));
    pc_store_close(store), store = NULL;
    (void)snprintf(path, sizeof path, "%s/stages/quads.h5", folder);
    PC_TRY(pc_store_open(&store, ctx, path));
    PC_TRY(pc_polymesh_load(&in->quads, store, "quads"));
    PC_TRY(pc_doublets_remove(&in->quads, &removed, ctx, true));
    PC_TRY(pc_adjacency_make(&in->adjacency, ctx, &in->mesh));
    PC_TRY(pc_target_make(&in->target, ctx, &in->mesh, &in->adjacency));
done:
    pc_store_close(store);
    return status;
}

static void drop(input *in, pc_context *ctx) {
    pc_target_free(&in->target, ctx);
    pc_polymesh_free(&in->quads, ctx);
    pc_adjacency_free(&in->adjacency, ctx);
    pc_mesh_free(&in->mesh, ctx);
}

static void print_continuity(const pc_tspline *spline) {
    pc_jump jump[PC_JOINT_COUNT];
    pc_continuity_measure(jump, spline, 3);
    for (int c = 0; c < PC_JOINT_COUNT; c++)
        printf("{\"joint\": \"%s\", \"samples\": %u, \"gap\": %.2g, \"normal_mean_deg\": %.3g, "
               "\"normal_max_deg\": %.3g, \"curvature_mean\": %.2g, \"curvature_max\": %.2g}\n",
               pc_joint_name((pc_joint)c), jump[c].sample_count, jump[c].gap,
               jump[c].normal_mean * 180 / PC_PI, jump[c].normal_max * 180 / PC_PI, jump[c].curvature_mean,
               jump[c].curvature_max);
}

static pc_status write_step(pc_context *ctx, const pc_tspline *spline, double size, const char *folder) {
    pc_status status = PC_OK;
    pc_shell shell = {0};
    char path[4096];
    double begin = pc_clock_wall();
    (void)snprintf(path, sizeof path, "%s/surface.step", folder);
    PC_TRY(pc_shell_make(&shell, ctx, spline));
    PC_TRY(pc_shell_check(&shell, ctx, size));
    double made = pc_clock_wall();
    PC_TRY(pc_step_write(ctx, &shell, size, "surface", path, true));
    printf("{\"step\": \"%s\", \"faces\": %u, \"edges\": %u, \"vertices\": %u, \"borders\": %u, \"shell_s\": "
           "%.2f, \"write_s\": %.2f}\n",
           path, shell.face_count, shell.edge_count, shell.vertex_count, shell.border_count, made - begin,
           pc_clock_wall() - made);
done:
    pc_shell_free(&shell, ctx);
    return status;
}

static void log_line(void *user, pc_log_level level, const char *line) {
    (void)user, (void)level;
    (void)fprintf(stderr, "%s\n", line);
}

static pc_status measure(pc_context *ctx, int argc, char **argv) {
    pc_status status = PC_OK;
    input in = {0};
    pc_tspline spline = {0};
    pc_device *device = NULL;
    pc_tmesh_options making = PC_TMESH_DEFAULTS;
    pc_adapt_options options = PC_ADAPT_DEFAULTS;
    pc_adapt_stats stats = {0};
    pc_basis_facts facts;
    if (argc > 3) options.fit.fairness = strtod(argv[3], NULL);
    if (argc > 4) making.depth = (uint8_t)strtoul(argv[4], NULL, 10);
    if (argc > 5) options.max_rounds = (int)strtol(argv[5], NULL, 10);
    pc_context_set_log(ctx, log_line, NULL, PC_LOG_DEBUG);
    PC_TRY(load(&in, ctx, argv[1]));
    PC_TRY(pc_device_open(&device, ctx, "host"));
    options.tolerance = (argc > 2 ? strtod(argv[2], NULL) : 0.002) * in.target.diagonal;
    double begin = pc_clock_wall();
    PC_TRY(pc_tspline_make(&spline, ctx, &in.quads, &making));
    double made = pc_clock_wall();
    status = pc_adapt(&spline, &stats, ctx, device, &in.target, &options);
    double end = pc_clock_wall();
    if (status != PC_OK && status != PC_E_NOCONV) goto done;
    const double percent = 100 / in.target.diagonal;
    printf(
        "{\"bench\": \"spline\", \"faces\": %u, \"quads\": %u, \"first_points\": %u, \"first_max_percent\": "
        "%.4f, \"points\": %u, \"junctions\": %u, \"rounds\": %d, \"max_percent\": %.4f, "
        "\"scan_max_percent\": %.4f, \"surface_max_percent\": %.4f, \"mean_percent\": %.5f, \"elements\": "
        "%u, \"make_s\": %.2f, \"adapt_s\": %.2f}\n",
        in.mesh.face_count, in.quads.face_count, stats.first_points, stats.first_max * percent,
        spline.mesh.vertex_count, stats.junctions, stats.rounds, stats.accuracy.max * percent,
        stats.accuracy.scan_max * percent, stats.accuracy.surface_max * percent,
        stats.accuracy.scan_mean * percent, spline.basis.element_count, made - begin, end - made);
    print_continuity(&spline);
    PC_TRY(write_step(ctx, &spline, in.target.diagonal, argv[1]));
    PC_TRY(pc_closure_check(&spline.mesh, ctx));
    PC_TRY(pc_tspline_check(&spline, &facts, ctx));
    printf("{\"worst_sum\": %.2g, \"least_pivot\": %.2g, \"unused\": %u}\n", facts.worst_sum,
           facts.least_pivot, facts.unused_vertices);
done:
    if (status != PC_OK) (void)fprintf(stderr, "bench_spline: %s\n", pc_context_message(ctx));
    pc_tspline_free(&spline, ctx);
    drop(&in, ctx);
    pc_device_close(device, ctx);
    return status;
}

int main(int argc, char **argv) {
    pc_context *ctx = argc > 1 ? pc_context_make() : NULL;
    if (!ctx) return pc_status_exit_code(argc > 1 ? PC_E_NOMEM : PC_E_USAGE);
    pc_status status = measure(ctx, argc, argv);
    pc_context_free(ctx);
    return pc_status_exit_code(status);
}
