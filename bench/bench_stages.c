/* Time and memory of each stage on one scan, and of each kernel with its bandwidth beside a triad of the same
 * run; then the figures of the result. One JSON object per line. bench_stages SCAN [--edge-factor F]
 * [--device NAME] [--split] */
#include "adjacency.h"
#include "certificate.h"
#include "clock.h"
#include "distortion.h"
#include "field.h"
#include "geometry.h"
#include "memory.h"
#include "quads.h"
#include "quality.h"
#include "refine.h"
#include "repair.h"
#include "scan.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct bench {
    const char *path, *device_name;
    double edge_factor;
    pc_ngons ngons;
    pc_context *ctx;
    pc_device *device;
    pc_mesh raw, scan;
    pc_refined refined;
    pc_adjacency coarse, fine;
    pc_curvature curvature;
    pc_field field;
    pc_param param;
    pc_layout layout;
    pc_polymesh quads;
    double edge_length, triad;
} bench;

typedef struct bench_stage {
    const char *name;
    pc_status (*run)(bench *b);
} bench_stage;

/* GB/s of a[i] = b[i] + s*c[i], the best of five, over arrays of 128 MB. */
static pc_status run_triad(bench *b) {
    enum { ROUNDS = 6 };
    size_t n = (size_t)16 << 20;
    pc_status status = PC_OK;
    double *x = NULL, *y = NULL, *z = NULL;
    PC_TRY(pc_new(&x, b->ctx, n));
    PC_TRY(pc_new(&y, b->ctx, n));
    PC_TRY(pc_new(&z, b->ctx, n));
    for (int round = 0; round < ROUNDS; round++) {
        double start = pc_clock_wall();
#pragma omp parallel for schedule(static)
        for (size_t i = 0; i < n; i++)
            x[i] = y[i] + 3 * z[i];
        double rate = 24.0 * (double)n / (pc_clock_wall() - start) / 1e9;
        if (round > 0 && rate > b->triad) b->triad = rate; /* the first one touches the pages */
        y[round] = x[round];
    }
done:
    pc_free(b->ctx, x);
    pc_free(b->ctx, y);
    pc_free(b->ctx, z);
    return status;
}

static pc_status run_read(bench *b) {
    pc_scan_info info;
    return pc_scan_read(&b->raw, &info, b->ctx, b->path);
}

static pc_status run_repair(bench *b) {
    const pc_repair_options options = PC_REPAIR_DEFAULTS;
    pc_repair_report report;
    pc_status status = pc_repair(&b->scan, &report, b->ctx, &b->raw, &options);
    if (status == PC_OK) pc_repair_report_free(&report, b->ctx);
    return status;
}

static pc_status run_refine(bench *b) {
    pc_refine_options options = PC_REFINE_DEFAULTS;
    pc_status status = PC_OK;
    PC_TRY(pc_adjacency_make(&b->coarse, b->ctx, &b->scan));
    b->edge_length = b->edge_factor * pc_geometry_mean_edge(&b->scan, &b->coarse);
    options.max_edge = 0.45 * b->edge_length;
    PC_TRY(pc_refine(&b->refined, b->ctx, &b->scan, &options));
    PC_TRY(pc_adjacency_make(&b->fine, b->ctx, &b->refined.mesh));
done:
    return status;
}

static pc_status run_curvature(bench *b) {
    const pc_curvature_options options = PC_CURVATURE_DEFAULTS;
    return pc_curvature_make(&b->curvature, b->ctx, b->device, &b->refined.mesh, &b->fine, &options);
}

static pc_status run_field(bench *b) {
    const pc_field_options options = PC_FIELD_DEFAULTS;
    return pc_field_make(&b->field, b->ctx, b->device, &b->refined.mesh, &b->fine, &b->curvature, &options);
}

static pc_status run_param(bench *b) {
    pc_param_options options = PC_PARAM_DEFAULTS;
    pc_param_stats stats;
    options.period_length = b->edge_length;
    return pc_param_make(&b->param, &stats, b->ctx, b->device, &b->refined.mesh, &b->fine, &b->field, NULL,
                         &options);
}

static pc_status run_layout(bench *b) {
    pc_layout_stats stats;
    return pc_layout_make(&b->layout, &stats, b->ctx, &b->refined.mesh, &b->param);
}

static pc_status run_quads(bench *b) {
    return pc_quads_make(&b->quads, b->ctx, &b->layout, b->ngons);
}

static void print_quality(const pc_quality *q, const pc_distortion *d) {
    printf(
        "{\"faces\": %u, \"quad_polygons_percent\": %.2f, \"quad_cells_percent\": %.2f, \"irregular\": %u, "
        "\"t_junctions\": %u, \"boundary\": %u,\n",
        q->quads.faces, q->quad_polygon_percent, q->quad_cell_percent, q->irregular_interior, q->t_junctions,
        q->boundary_vertices);
    printf(" \"stretch\": %.4f, \"stretch_core\": %.4f, \"shear\": %.4f, \"singular_percent\": %.3f,\n",
           d->stretch, d->stretch_core, d->shear, d->singular_percent);
    printf(" \"angle_mean\": %.2f, \"angle_q95\": %.2f, \"edge_deviation\": %.3f, \"aspect_q95\": %.2f, "
           "\"jacobian_min\": %.3f, \"folded\": %u, \"warp_q95\": %.2f, \"field_angle_mean\": %.2f, "
           "\"field_angle_q95\": %.2f,\n",
           q->shape.angle.mean, q->shape.angle.q95, q->shape.edge_deviation, q->shape.aspect.q95,
           q->shape.scaled_jacobian.min, q->shape.folded_cells, q->shape.warp.q95, q->field_angle.mean,
           q->field_angle.q95);
    double s = 100 / q->diagonal;
    printf(" \"scan_to_quads_percent\": [%.4f, %.4f, %.4f], \"quads_to_scan_percent\": [%.4f, %.4f, %.4f]}\n",
           s * q->scan_to_quads.mean, s * q->scan_to_quads.q95, s * q->scan_to_quads.max,
           s * q->quads_to_scan.mean, s * q->quads_to_scan.q95, s * q->quads_to_scan.max);
}

static pc_status run_figures(bench *b) {
    pc_status status = PC_OK;
    pc_quality q;
    pc_distortion d;
    pc_certificate c;
    pc_certificate_options options = PC_CERTIFICATE_DEFAULTS;
    const pc_quality_input input = {.scan = &b->refined.mesh, .quads = &b->quads, .field = &b->field};
    PC_TRY(pc_quality_measure(&q, b->ctx, &input));
    PC_TRY(pc_distortion_measure(&d, b->ctx, &b->refined.mesh, &b->param));
    options.edge_length = b->edge_length;
    pc_certificate_make(&c, &q, &b->field, &options);
    print_quality(&q, &d);
    for (int i = 0; i < c.count; i++)
        if (!c.check[i].passed)
            printf("{\"failed\": \"%s\", \"value\": %g, \"expected\": %g, \"note\": \"%s\"}\n",
                   c.check[i].name, c.check[i].value, c.check[i].expected, c.check[i].note);
done:
    return status;
}

static pc_status print_kernels(bench *b) {
    const pc_kernel_stats *table = NULL;
    size_t count = 0;
    pc_status status = pc_device_kernel_stats(&table, &count, b->ctx, b->device);
    for (size_t i = 0; i < count && status == PC_OK; i++) {
        double rate = table[i].seconds > 0 ? table[i].bytes / table[i].seconds / 1e9 : 0;
        printf("{\"kernel\": \"%s\", \"launches\": %llu, \"seconds\": %.4f, \"gb_per_s\": %.2f, "
               "\"of_triad\": %.2f}\n",
               table[i].name, (unsigned long long)table[i].count, table[i].seconds, rate, rate / b->triad);
    }
    return status;
}

static pc_status run_stages(bench *b) {
    static const bench_stage stages[] = {
        {"triad", run_triad},     {"read", run_read},           {"repair", run_repair},
        {"refine", run_refine},   {"curvature", run_curvature}, {"field", run_field},
        {"param", run_param},     {"layout", run_layout},       {"quads", run_quads},
        {"figures", run_figures},
    };
    pc_status status = PC_OK;
    PC_TRY(pc_device_open(&b->device, b->ctx, b->device_name));
    for (size_t i = 0; i < sizeof stages / sizeof stages[0]; i++) {
        double wall = pc_clock_wall(), cpu = pc_clock_cpu();
        pc_memory_reset_peak(b->ctx);
        PC_TRY(stages[i].run(b));
        printf("{\"stage\": \"%s\", \"seconds\": %.3f, \"cpu_seconds\": %.3f, \"peak_mb\": %.1f",
               stages[i].name, pc_clock_wall() - wall, pc_clock_cpu() - cpu,
               (double)pc_memory_peak(b->ctx) / 1e6);
        if (i == 0) printf(", \"gb_per_s\": %.2f", b->triad);
        printf("}\n");
    }
    printf(
        "{\"scan\": \"%s\", \"device\": \"%s\", \"triangles\": %u, \"refined\": %u, \"resident_mb\": %.1f}\n",
        b->path, pc_device_name(b->device), b->scan.face_count, b->refined.mesh.face_count,
        (double)pc_clock_peak_bytes() / 1e6);
    PC_TRY(print_kernels(b));
done:
    return status;
}

static void free_products(bench *b) {
    pc_mesh_free(&b->raw, b->ctx);
    pc_mesh_free(&b->scan, b->ctx);
    pc_refined_free(&b->refined, b->ctx);
    pc_adjacency_free(&b->coarse, b->ctx);
    pc_adjacency_free(&b->fine, b->ctx);
    pc_curvature_free(&b->curvature, b->ctx);
    pc_field_free(&b->field, b->ctx);
    pc_param_free(&b->param, b->ctx);
    pc_layout_free(&b->layout, b->ctx);
    pc_polymesh_free(&b->quads, b->ctx);
    pc_device_close(b->device, b->ctx);
}

int main(int argc, char **argv) {
    bench b = {.edge_factor = 10, .ngons = PC_NGONS_KEEP};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--split") == 0)
            b.ngons = PC_NGONS_SPLIT;
        else if (strcmp(argv[i], "--edge-factor") == 0 && i + 1 < argc)
            b.edge_factor = strtod(argv[++i], NULL);
        else if (strcmp(argv[i], "--device") == 0 && i + 1 < argc)
            b.device_name = argv[++i];
        else
            b.path = argv[i];
    }
    if (!b.path || !(b.edge_factor > 0)) {
        (void)fputs("bench_stages SCAN [--edge-factor F] [--device NAME] [--split]\n", stderr);
        return pc_status_exit_code(PC_E_USAGE);
    }
    b.ctx = pc_context_make();
    if (!b.ctx) return pc_status_exit_code(PC_E_NOMEM);
    pc_status status = run_stages(&b);
    if (status != PC_OK) (void)fprintf(stderr, "bench_stages: %s\n", pc_context_message(b.ctx));
    free_products(&b);
    pc_context_free(b.ctx);
    return pc_status_exit_code(status);
}
