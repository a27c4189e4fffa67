/* Mesh: the scan with long edges split, in an order that keeps neighbours close in memory. */
#include "geometry.h"
#include "memory.h"
#include "refine.h"
#include "stage.h"
#include <math.h>
#include <stdio.h>

/* Edges longer than this part of a cell's side are split: PGP needs less than a half, and the density may rise. */
static const double longest_part = 0.25;

static void put_options(pc_json *json, const pc_convert_options *options) {
    pc_json_integer(json, "quads", (int64_t)options->quads);
    pc_json_exact(json, "edge_length", options->edge_length);
    pc_json_exact(json, "edge_factor", options->edge_factor);
    pc_json_boolean(json, "keep_ngons", options->keep_ngons);
}

double pc_wanted_edge(const pc_convert_options *options, double area, double mean_edge) {
    if (options->quads) return sqrt(area / (double)options->quads);
    return options->edge_length > 0 ? options->edge_length : options->edge_factor * mean_edge;
}

static pc_status measure(pc_run *run, const pc_mesh *scan) {
    pc_held_mesh *held = &run->product.mesh;
    pc_adjacency adjacency;
    pc_status status = pc_adjacency_make(&adjacency, run->ctx, scan);
    if (status != PC_OK) return status;
    held->area = pc_geometry_area(scan);
    held->mean_edge = pc_geometry_mean_edge(scan, &adjacency);
    pc_adjacency_free(&adjacency, run->ctx);
    if (!(held->area > 0))
        return pc_fail(run->ctx, PC_E_MESH, "%s: the area of the surface is zero", run->scan_path);
    /* Cells that are split become quads of half their side. */
    double edge = pc_wanted_edge(run->options, held->area, held->mean_edge);
    held->period = run->options->keep_ngons ? edge : 2 * edge;
    return PC_OK;
}
