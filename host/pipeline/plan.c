#include "plan.h"
#include "geometry.h"
#include <math.h>

/* Measured on the scans of the tests: the program itself with PoCL, and bytes per triangle and quad. */
static const double memory_at_least = 1.2e8, memory_per_triangle = 560, memory_per_quad = 600;
static const double disk_at_least = 5e6, disk_per_triangle = 700, disk_per_quad = 900;
/* Long edges are split until a quad has about this many triangles. */
static const double triangles_per_quad = 25;

double pc_plan_edge(const pc_convert_options *options, double area, double mean_edge) {
    if (options->quads) return sqrt(area / (double)options->quads);
    if (options->edge_length > 0) return options->edge_length;
    if (options->edge_factor > 0) return options->edge_factor * mean_edge;
    /* As if the triangles were equilateral. */
    double triangles = area / (sqrt(0.1875) * mean_edge * mean_edge);
    double least = PC_DEFAULT_LEAST_QUADS;
    if (options->tolerance > 0) least = PC_SPLINE_LEAST_QUADS;
    double edge = fmin(PC_DEFAULT_EDGE_FACTOR * mean_edge, sqrt(area / fmin(least, triangles / 2)));
    /* Half as many: whole cells hold on to the scan with fewer of them. */
    return options->tolerance > 0 && options->keep_ngons ? sqrt(2) * edge : edge;
}

pc_status pc_plan_make(pc_convert_plan *plan, pc_run *run) {
    const pc_mesh *scan = &run->product.scan.mesh;
    pc_adjacency adjacency;
    pc_status status = pc_adjacency_make(&adjacency, run->ctx, scan);
    if (status != PC_OK) return status;
    plan->vertices = scan->vertex_count;
    plan->faces = scan->face_count;
    plan->area = pc_geometry_area(scan);
    plan->mean_edge = pc_geometry_mean_edge(scan, &adjacency);
    plan->edge_length = pc_plan_edge(run->options, plan->area, plan->mean_edge);
    plan->quads = plan->area / (plan->edge_length * plan->edge_length);
    const double triangles = fmax((double)plan->faces, triangles_per_quad * plan->quads);
    plan->memory_bytes = memory_at_least + memory_per_triangle * triangles + memory_per_quad * plan->quads;
    plan->disk_bytes = disk_at_least + disk_per_triangle * triangles + disk_per_quad * plan->quads;
    pc_adjacency_free(&adjacency, run->ctx);
    return PC_OK;
}
