/* The outer schemes of PGP beside each other on one scan, from the same field: singular triangles before and
 * after cancelling, energy, irregular vertices of the quads, CPU seconds. One JSON object per scheme and
 * line. bench_pgp SCAN|SHAPE [--edge-factor F] [--device NAME] [--subdivide N] [--ripple A] [--curl on|off]
 * [--cancel PERIODS] [--pgp A,B,...] SHAPE: plane, cylinder, torus, sphere, vase, blob3. A scheme is
 * "normalise", "newton", or "normalise:STEPS:FIRST_REACH:LAST_REACH:TOLERANCE". */
#include "adjacency.h"
#include "clock.h"
#include "curl.h"
#include "distortion.h"
#include "field.h"
#include "geometry.h"
#include "memory.h"
#include "plan.h"
#include "quality.h"
#include "refine.h"
#include "remesh.h"
#include "repair.h"
#include "scan.h"
#include "synth.h"
#include "synth_blob.h"
#include "synth_wear.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct bench {
    const char *path, *device_name, *schemes;
    double edge_factor, ripple, cancel_reach;
    int subdivide;
    bool curl;
    bool verbose;
    pc_context *ctx;
    pc_device *device;
    pc_mesh scan;
    pc_refined refined;
    pc_adjacency adjacency;
    pc_field field;
    double *scale; /* by curl correction, or NULL */
    double period;
} bench;

static pc_status read_scan(bench *b) {
    pc_status status = PC_OK;
    pc_scan_info info;
    pc_mesh raw = {0};
    const pc_repair_options options = PC_REPAIR_DEFAULTS;
    pc_repair_report report;
    PC_TRY(pc_scan_read(&raw, &info, b->ctx, b->path));
    PC_TRY(pc_repair(&b->scan, &report, b->ctx, &raw, &options));
    pc_repair_report_free(&report, b->ctx);
done:
    pc_mesh_free(&raw, b->ctx);
    return status;
}

static pc_status make_shape(bench *b) {
    const char *name = b->path;
    if (strcmp(name, "plane") == 0) return pc_synth_plane(&b->scan, b->ctx, 2, 1, 200, 100);
    if (strcmp(name, "cylinder") == 0) return pc_synth_cylinder(&b->scan, b->ctx, 4, 160, 100);
    if (strcmp(name, "torus") == 0) return pc_synth_torus(&b->scan, b->ctx, 2, 0.8, 250, 100);
    if (strcmp(name, "sphere") == 0) return pc_synth_sphere(&b->scan, b->ctx, 60);
    if (strcmp(name, "vase") == 0) return pc_synth_vase(&b->scan, b->ctx, 200, 120);
    if (strcmp(name, "blob3") == 0) return pc_synth_blob(&b->scan, b->ctx, 3, 30);
    return read_scan(b);
}

static pc_status prepare(bench *b) {
    pc_status status = PC_OK;
    pc_adjacency coarse = {0};
    pc_curvature curvature = {0};
    pc_refine_options refine = PC_REFINE_DEFAULTS;
    const pc_curvature_options curvature_options = PC_CURVATURE_DEFAULTS;
    pc_field_options field_options = PC_FIELD_DEFAULTS;
    const pc_convert_options wish = {.edge_factor = b->edge_factor}; /* 0: the program's default */
    PC_TRY(pc_device_open(&b->device, b->ctx, b->device_name));
    PC_TRY(make_shape(b));
    for (int k = 0; k < b->subdivide; k++)
        PC_TRY(pc_synth_subdivide(&b->scan, b->ctx, true));
    if (b->ripple > 0) PC_TRY(pc_synth_ripple(&b->scan, b->ctx, b->ripple, 6, 1));
    PC_TRY(pc_adjacency_make(&coarse, b->ctx, &b->scan));
    double mean = pc_geometry_mean_edge(&b->scan, &coarse);
    b->period = 2 * pc_plan_edge(&wish, pc_geometry_area(&b->scan), mean);
    refine.max_edge = 0.25 * b->period;
    PC_TRY(pc_refine(&b->refined, b->ctx, &b->scan, &refine));
    PC_TRY(pc_adjacency_make(&b->adjacency, b->ctx, &b->refined.mesh));
    PC_TRY(pc_curvature_make(&curvature, b->ctx, b->device, &b->refined.mesh, &b->adjacency,
                             &curvature_options));
    field_options.feature_length = fmax(4 * mean, 0.75 * b->period); /* as the program's field stage */
    PC_TRY(pc_field_make(&b->field, b->ctx, b->device, &b->refined.mesh, &b->adjacency, &curvature,
                         &field_options));
    if (b->curl) {
        const pc_curl_options curl_options = PC_CURL_DEFAULTS;
        PC_TRY(pc_new(&b->scale, b->ctx, b->refined.mesh.vertex_count));
        PC_TRY(pc_curl_correct(b->scale, b->ctx, b->device, &b->refined.mesh, &b->adjacency, &b->field,
                               &curl_options));
    }
done:
    pc_adjacency_free(&coarse, b->ctx);
    pc_curvature_free(&curvature, b->ctx);
    return status;
}

static void read_scheme(pc_pgp_options *o, const char *text) {
    o->scheme = strncmp(text, "newton", 6) == 0 ? PC_PGP_NEWTON : PC_PGP_NORMALISE;
    if (o->scheme == PC_PGP_NORMALISE && text[strcspn(text, ":,")] == ':')
        (void)sscanf(text + strcspn(text, ":"), ":%d:%lf:%lf:%lf", &o->steps, &o->first_reach, &o->last_reach,
                     &o->tolerance);
}

static pc_status run_scheme(bench *b, const char *text) {
    pc_status status = PC_OK;
    pc_param param = {0};
    pc_layout layout = {0};
    pc_polymesh quads = {0};
    pc_ground ground = {0};
    pc_param_options options = PC_PARAM_DEFAULTS;
    pc_param_stats stats;
    pc_layout_stats laid;
    pc_remesh_quads_stats made;
    pc_quality q;
    pc_distortion d;
    read_scheme(&options.pgp, text);
    options.period_length = b->period;
    options.cancel_reach = b->cancel_reach;
    double cpu = pc_clock_cpu();
    PC_TRY(pc_param_make(&param, &stats, b->ctx, b->device, &b->refined.mesh, &b->adjacency, &b->field,
                         b->scale, &options));
    cpu = pc_clock_cpu() - cpu;
    PC_TRY(pc_layout_make(&layout, &laid, b->ctx, &b->refined.mesh, &param));
    PC_TRY(pc_ground_make(&ground, b->ctx, &b->refined.mesh, &b->adjacency));
    PC_TRY(pc_remesh_quads(&quads, NULL, &made, b->ctx, &layout, PC_NGONS_SPLIT, 0, &ground));
    const pc_quality_input input = {.scan = &b->refined.mesh, .quads = &quads, .field = &b->field};
    PC_TRY(pc_quality_measure(&q, b->ctx, &input));
    PC_TRY(pc_distortion_measure(&d, b->ctx, &b->refined.mesh, &param));
    printf("{\"scan\": \"%s\", \"triangles\": %u, \"scheme\": \"%.*s\", \"steps\": %u, \"iterations\": %u, "
           "\"energy\": %.6g, \"raw_dislocations\": %u, \"raw_flipped\": %u, \"cones\": %u, "
           "\"dislocations\": %u, \"flipped\": %u, \"quads\": %u, \"irregular\": %u, "
           "\"stretch\": %.4f, \"stretch_core\": %.4f, \"shear\": %.4f, \"singular_percent\": %.3f, "
           "\"pgp_cpu_seconds\": %.2f, \"param_cpu_seconds\": %.2f}\n",
           b->path, b->scan.face_count, (int)strcspn(text, ","), text, stats.steps, stats.pgp_iterations,
           stats.energy, stats.raw_dislocations, stats.raw_flipped, stats.field_singularities,
           stats.dislocations, stats.flipped, quads.face_count, q.irregular_interior, d.stretch,
           d.stretch_core, d.shear, d.singular_percent, stats.pgp_cpu_seconds, cpu);
    (void)fflush(stdout);
done:
    pc_param_free(&param, b->ctx);
    pc_layout_free(&layout, b->ctx);
    pc_polymesh_free(&quads, b->ctx);
    pc_ground_free(&ground, b->ctx);
    return status;
}

static pc_status run(bench *b) {
    pc_status status = prepare(b);
    for (const char *s = b->schemes; status == PC_OK; s += strcspn(s, ",") + 1) {
        status = run_scheme(b, s);
        if (!s[strcspn(s, ",")]) break;
    }
    return status;
}

static bool read_line(bench *b, int argc, char **argv) {
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        i += strncmp(argv[i], "--", 2) == 0;
        const char *name = argv[i > 1 && argv[i - 1][0] == '-' ? i - 1 : i];
        if (strcmp(name, "--edge-factor") == 0)
            b->edge_factor = strtod(value, NULL);
        else if (strcmp(name, "--cancel") == 0)
            b->cancel_reach = strtod(value, NULL);
        else if (strcmp(name, "--curl") == 0)
            b->curl = strcmp(value, "off") != 0;
        else if (strcmp(name, "--device") == 0)
            b->device_name = value;
        else if (strcmp(name, "--subdivide") == 0)
            b->subdivide = (int)strtol(value, NULL, 10);
        else if (strcmp(name, "--ripple") == 0)
            b->ripple = strtod(value, NULL);
        else if (strcmp(name, "--pgp") == 0)
            b->schemes = value;
        else if (name[0] == '-')
            return false;
        else
            b->path = name;
    }
    return b->path && b->edge_factor >= 0;
}

static void log_line(void *user, pc_log_level level, const char *text) {
    (void)user, (void)level;
    (void)fprintf(stderr, "%s\n", text);
}

static const pc_param_options defaults = PC_PARAM_DEFAULTS;

int main(int argc, char **argv) {
    bench b = {.cancel_reach = defaults.cancel_reach, .schemes = "normalise,newton"};
    if (!read_line(&b, argc, argv)) {
        (void)fputs("bench_pgp SCAN|SHAPE [--edge-factor F] [--device NAME] [--subdivide N] [--ripple A] "
                    "[--curl on|off] [--cancel PERIODS] [--pgp "
                    "A,B,...]\n",
                    stderr);
        return pc_status_exit_code(PC_E_USAGE);
    }
    b.ctx = pc_context_make();
    if (!b.ctx) return pc_status_exit_code(PC_E_NOMEM);
    if (getenv("PERCALE_LOG")) pc_context_set_log(b.ctx, log_line, NULL, PC_LOG_DEBUG);
    pc_status status = run(&b);
    if (status != PC_OK) (void)fprintf(stderr, "bench_pgp: %s\n", pc_context_message(b.ctx));
    pc_mesh_free(&b.scan, b.ctx);
    pc_refined_free(&b.refined, b.ctx);
    pc_adjacency_free(&b.adjacency, b.ctx);
    pc_field_free(&b.field, b.ctx);
    pc_free(b.ctx, b.scale);
    pc_device_close(b.device, b.ctx);
    pc_context_free(b.ctx);
    return pc_status_exit_code(status);
}
