#include "report.h"
#include "version.h"
#include <omp.h>
#include <stdio.h>
#include <string.h>

static void put_spread(pc_json *json, const char *key, const pc_spread *spread) {
    pc_json_flat_object(json, key);
    pc_json_number(json, "mean", spread->mean);
    pc_json_number(json, "min", spread->min);
    pc_json_number(json, "q05", spread->q05);
    pc_json_number(json, "median", spread->median);
    pc_json_number(json, "q95", spread->q95);
    pc_json_number(json, "max", spread->max);
    pc_json_close(json);
}

/* Distances as parts of the bounding box' diagonal, as peers tell them. */
static void put_deviation(pc_json *json, const char *key, const pc_deviation *deviation, double diagonal) {
    pc_json_flat_object(json, key);
    pc_json_number(json, "mean", deviation->mean / diagonal);
    pc_json_number(json, "q95", deviation->q95 / diagonal);
    pc_json_number(json, "max", deviation->max / diagonal);
    pc_json_integer(json, "samples", (int64_t)deviation->sample_count);
    pc_json_close(json);
}

static void put_surface(pc_json *json, const char *key, const pc_surface_count *count) {
    pc_json_flat_object(json, key);
    pc_json_integer(json, "vertices", count->vertices);
    pc_json_integer(json, "edges", count->edges);
    pc_json_integer(json, "faces", count->faces);
    pc_json_integer(json, "components", count->components);
    pc_json_integer(json, "euler_number", count->chi);
    pc_json_integer(json, "boundary_loops", count->loops);
    pc_json_integer(json, "boundary_edges", count->boundary_edges);
    pc_json_close(json);
}

static void put_sides(pc_json *json, const char *key, const pc_index *counts) {
    pc_json_flat_object(json, key);
    for (int sides = 1; sides < PC_QUALITY_SIDES; sides++) {
        char name[16];
        (void)snprintf(name, sizeof name, "%d%s", sides, sides + 1 == PC_QUALITY_SIDES ? "+" : "");
        if (counts[sides]) pc_json_integer(json, name, counts[sides]);
    }
    pc_json_close(json);
}

static void put_quality(pc_json *json, const pc_quality *q) {
    put_surface(json, "scan", &q->scan);
    put_surface(json, "quads", &q->quads);
    pc_json_number(json, "quad_percent", q->quad_cell_percent);
    pc_json_number(json, "quad_polygon_percent", q->quad_polygon_percent);
    put_sides(json, "cells_by_sides", q->cells);
    pc_json_integer(json, "t_junctions", q->t_junctions);
    pc_json_integer(json, "irregular_interior_vertices", q->irregular_interior);
    pc_json_integer(json, "irregular_boundary_vertices", q->irregular_boundary);
    put_spread(json, "edge_length", &q->shape.edge_length);
    pc_json_number(json, "edge_length_relative_deviation", q->shape.edge_deviation);
    put_spread(json, "angle_from_right_degrees", &q->shape.angle);
    put_spread(json, "aspect", &q->shape.aspect);
    put_spread(json, "scaled_jacobian", &q->shape.scaled_jacobian);
    pc_json_integer(json, "folded_cells", q->shape.folded_cells);
    put_spread(json, "warp_degrees", &q->shape.warp);
    put_spread(json, "angle_to_field_degrees", &q->field_angle);
    pc_json_number(json, "diagonal", q->diagonal);
    put_deviation(json, "distance_scan_to_quads", &q->scan_to_quads, q->diagonal);
    put_deviation(json, "distance_quads_to_scan", &q->quads_to_scan, q->diagonal);
    pc_json_number(json, "scan_area", q->scan_area);
    pc_json_number(json, "quads_area", q->quads_area);
}

static void put_distortion(pc_json *json, const pc_distortion *d) {
    pc_json_flat_object(json, "parameterization");
    pc_json_number(json, "stretch", d->stretch);
    pc_json_number(json, "stretch_core", d->stretch_core);
    pc_json_number(json, "shear", d->shear);
    pc_json_number(json, "singular_percent", d->singular_percent);
    pc_json_integer(json, "dislocations", d->dislocations);
    pc_json_integer(json, "field_singularities", d->field_singularities);
    pc_json_integer(json, "flipped", d->flipped);
    pc_json_number(json, "length_error", d->length_error);
    pc_json_close(json);
}

void pc_report_put_statistics(pc_json *json, const char *key, const pc_findings *findings) {
    pc_json_object(json, key);
    if (findings->has_distortion) put_distortion(json, &findings->distortion);
    if (findings->has_quality) put_quality(json, &findings->quality);
    if (findings->has_spline) pc_spline_findings_put(json, &findings->spline);
    pc_json_close(json);
}

void pc_report_put_certificate(pc_json *json, const char *key, const pc_certificate *certificate) {
    pc_json_object(json, key);
    pc_json_boolean(json, "passed", certificate->passed);
    pc_json_array(json, "checks");
    for (int i = 0; i < certificate->count; i++) {
        const pc_check *check = &certificate->check[i];
        pc_json_flat_object(json, NULL);
        pc_json_string(json, "name", check->name);
        pc_json_boolean(json, "passed", check->passed);
        pc_json_number(json, "value", check->value);
        pc_json_number(json, "expected", check->expected);
        pc_json_string(json, "note", check->note);
        pc_json_close(json);
    }
    pc_json_close(json);
    pc_json_close(json);
}

static void put_options(pc_json *json, const pc_convert_options *options) {
    static const char *const borders[] = {"off", "auto", "all"};
    pc_json_object(json, "options");
    if (options->quads)
        pc_json_integer(json, "quads", (int64_t)options->quads);
    else if (options->edge_length > 0)
        pc_json_number(json, "edge_length", options->edge_length);
    else if (options->edge_factor > 0)
        pc_json_number(json, "edge_factor", options->edge_factor);
    if (options->tolerance > 0) {
        pc_json_exact(json, "tolerance", options->tolerance);
        pc_json_boolean(json, "tolerance_relative", options->tolerance_relative);
        pc_json_integer(json, "max_control_points", options->max_control_points);
    }
    pc_json_string(json, "ngons", options->keep_ngons ? "keep" : "split");
    pc_json_string(json, "device", options->device ? options->device : "default");
    pc_json_boolean(json, "curl_correction", options->curl_correction);
    pc_json_string(json, "to", pc_stage_title(options->last));
    pc_json_boolean(json, "strict", options->strict);
    pc_json_integer(json, "min_component", options->min_component);
    pc_json_string(json, "ragged", options->keep_ragged ? "keep" : "fill");
    if (options->smoothness >= 0) pc_json_number(json, "smoothness", options->smoothness);
    pc_json_string(json, "align_borders", borders[options->align_borders]);
    pc_json_string(json, "pgp", options->pgp ? "newton" : "normalise");
    pc_json_integer(json, "parts", options->parts);
    pc_json_integer(json, "threads", omp_get_max_threads());
    pc_json_integer(json, "seed", (int64_t)options->seed);
    pc_json_close(json);
}

static void put_stages(pc_json *json, const pc_run *run) {
    static const char *const states[] = {"pending", "skipped", "made", "kept"};
    double total = 0;
    size_t peak = 0;
    pc_json_array(json, "stages");
    for (int id = 0; id < PC_STAGE_COUNT; id++) {
        const pc_stage_record *record = &run->record[id];
        if (record->state == PC_STAGE_SKIPPED || id == PC_STAGE_EXPORT) continue;
        pc_json_object(json, NULL);
        pc_json_string(json, "name", pc_stage_title((pc_stage_id)id));
        pc_json_string(json, "state", states[record->state]);
        if (record->state == PC_STAGE_MADE) {
            pc_json_number(json, "seconds", record->wall_seconds);
            pc_json_number(json, "cpu_seconds", record->cpu_seconds);
            pc_json_integer(json, "peak_bytes", (int64_t)record->resident_peak);
            pc_json_integer(json, "peak_allocated_bytes", (int64_t)record->counted_peak);
        }
        pc_json_string(json, "note", record->note);
        if (record->facts) pc_json_raw(json, "facts", record->facts);
        pc_json_close(json);
        total += record->wall_seconds;
        if (record->resident_peak > peak) peak = record->resident_peak;
    }
    pc_json_close(json);
    pc_json_number(json, "seconds", total);
    pc_json_integer(json, "peak_bytes", (int64_t)peak);
}

static void put_kernels(pc_json *json, const pc_run *run) {
    pc_json_array(json, "kernels");
    for (size_t i = 0; i < run->kernel_count; i++) {
        const pc_kernel_stats *stats = &run->kernels[i].stats;
        pc_json_flat_object(json, NULL);
        pc_json_string(json, "stage", pc_stage_title(run->kernels[i].stage));
        pc_json_string(json, "name", stats->name);
        pc_json_integer(json, "launches", (int64_t)stats->count);
        pc_json_number(json, "seconds", stats->seconds);
        pc_json_number(json, "bytes", stats->bytes);
        pc_json_number(json, "gigabytes_per_second",
                       stats->seconds > 0 ? 1e-9 * stats->bytes / stats->seconds : 0);
        pc_json_close(json);
    }
    pc_json_close(json);
}

pc_status pc_report_make(pc_json *json, const pc_run *run, const pc_findings *findings) {
    pc_json_object(json, NULL);
    pc_json_string(json, "program", "percale");
    pc_json_string(json, "version", pc_version());
    pc_json_object(json, "input");
    pc_json_string(json, "path", run->scan_path);
    pc_json_integer(json, "bytes", (int64_t)run->input_bytes);
    pc_json_string(json, "sha256", run->input_sha256);
    pc_json_close(json);
    put_options(json, run->options);
    pc_json_string(json, "device", pc_device_name(run->device));
    put_stages(json, run);
    put_kernels(json, run);
    pc_report_put_statistics(json, "statistics", findings);
    if (findings->has_quality) pc_report_put_certificate(json, "certificate", &findings->certificate);
    pc_json_close(json);
    return pc_json_end(json);
}
