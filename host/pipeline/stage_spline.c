/* Spline: a T-spline surface over the quads, within the tolerance of the scan. */
#include "doublet.h"
#include "memory.h"
#include "spline_store.h"
#include "stage.h"
#include <stdio.h>
#include <string.h>

static bool wanted(const pc_convert_options *options) {
    return options->tolerance > 0;
}

static void put_options(pc_json *json, const pc_convert_options *options) {
    pc_json_exact(json, "tolerance", options->tolerance);
    pc_json_boolean(json, "tolerance_relative", options->tolerance_relative);
    pc_json_integer(json, "max_control_points", options->max_control_points);
}

/* More control points than the scan has triangles, about, would draw its noise. */
static pc_index most_points(const pc_run *run) {
    pc_index asked = run->options->max_control_points;
    return asked ? asked : 2 * run->product.mesh.scan_vertex_count;
}

static void put_facts(pc_json *facts, const pc_held_spline *spline) {
    const pc_adapt_stats *stats = &spline->stats;
    pc_json_integer(facts, "control_points", spline->surface.mesh.vertex_count);
    pc_json_integer(facts, "faces", spline->surface.mesh.face_count);
    pc_json_integer(facts, "t_junctions", stats->junctions);
    pc_json_integer(facts, "rounds", stats->rounds);
    pc_json_integer(facts, "first_control_points", stats->first_points);
    pc_json_number(facts, "first_error", stats->first_max);
    pc_json_number(facts, "error", stats->accuracy.max);
    pc_json_number(facts, "tolerance", spline->tolerance);
    pc_json_integer(facts, "samples", (int64_t)stats->fit.samples);
    if (spline->earlier_error > 0) pc_json_number(facts, "error_of_other_try", spline->earlier_error);
}

/* The quads as a control mesh: no vertex inside may be between two of them only. */
static pc_status start_surface(pc_run *run) {
    const pc_tmesh_options making = PC_TMESH_DEFAULTS;
    pc_polymesh control = {0};
    pc_index removed;
    pc_status status = PC_OK;
    PC_TRY(pc_polymesh_copy(&control, run->ctx, &run->product.quads));
    PC_TRY(pc_doublets_remove(&control, &removed, run->ctx, true));
    PC_TRY(pc_tspline_make(&run->product.spline.surface, run->ctx, &control, &making));
done:
    pc_polymesh_free(&control, run->ctx);
    return status;
}

static pc_status make(pc_run *run, pc_json *facts) {
    const pc_held_mesh *held = &run->product.mesh;
    pc_held_spline *spline = &run->product.spline;
    pc_adapt_options options = PC_ADAPT_DEFAULTS;
    pc_target target = {0};
    pc_status status = PC_OK;
    PC_TRY(pc_target_make(&target, run->ctx, &held->mesh, &held->adjacency));
    spline->diagonal = target.diagonal;
    spline->earlier_error = run->earlier_error;
    spline->tolerance = run->options->tolerance * (run->options->tolerance_relative ? target.diagonal : 1);
    options.tolerance = spline->tolerance;
    options.max_points = most_points(run);
    PC_TRY(start_surface(run));
    status = pc_adapt(&spline->surface, &spline->stats, run->ctx, run->device, &target, &options);
    /* The surface that was reached is worth having; the certificate tells what it misses. */
    if (status == PC_E_NOCONV && spline->stats.accuracy.max > 0) {
        pc_context_clear_message(run->ctx);
        status = PC_OK;
    }
    PC_TRY(status);
    put_facts(facts, spline);
    (void)snprintf(run->record[PC_STAGE_SPLINE].note, sizeof run->record->note,
                   "%u control points, %.3g %% of the diagonal off at most",
                   spline->surface.mesh.vertex_count, 100 * spline->stats.accuracy.max / spline->diagonal);
done:
    pc_target_free(&target, run->ctx);
    return status;
}

static pc_status check(pc_run *run) {
    return pc_tspline_check(&run->product.spline.surface, &run->product.spline.facts, run->ctx);
}

typedef struct named_real {
    const char *name;
    double *value;
} named_real;

/* What is kept of the stats, as attributes of the group. */
enum { REALS = 9, COUNTS = 6 };

static const char *const count_names[COUNTS] = {"rounds",  "first_control_points",   "t_junctions",
                                                "samples", "samples_beyond_borders", "full"};

static void name_reals(named_real named[REALS], pc_held_spline *spline) {
    pc_accuracy *a = &spline->stats.accuracy;
    const named_real all[REALS] = {{"tolerance", &spline->tolerance},
                                   {"diagonal", &spline->diagonal},
                                   {"error", &a->max},
                                   {"scan_error", &a->scan_max},
                                   {"surface_error", &a->surface_max},
                                   {"scan_error_mean", &a->scan_mean},
                                   {"surface_error_mean", &a->surface_mean},
                                   {"first_error", &spline->stats.first_max},
                                   {"error_of_other_try", &spline->earlier_error}};
    memcpy(named, all, sizeof all);
}

static pc_status save(pc_run *run, pc_store *store) {
    pc_held_spline *spline = &run->product.spline;
    const pc_adapt_stats *stats = &spline->stats;
    const int64_t count[COUNTS] = {stats->rounds,
                                   stats->first_points,
                                   stats->junctions,
                                   (int64_t)stats->accuracy.samples,
                                   (int64_t)stats->accuracy.beyond,
                                   stats->full};
    named_real real[REALS];
    pc_status status = PC_OK;
    PC_TRY(pc_tspline_save(store, "spline", &spline->surface));
    name_reals(real, spline);
    for (int i = 0; i < REALS; i++)
        PC_TRY(pc_store_set_real(store, "spline", real[i].name, *real[i].value));
    for (int i = 0; i < COUNTS; i++)
        PC_TRY(pc_store_set_int(store, "spline", count_names[i], count[i]));
done:
    return status;
}

static void drop(pc_run *run) {
    pc_tspline_free(&run->product.spline.surface, run->ctx);
}

static pc_status load(pc_run *run, pc_store *store) {
    pc_held_spline *spline = &run->product.spline;
    pc_adapt_stats *stats = &spline->stats;
    int64_t count[COUNTS];
    named_real real[REALS];
    pc_status status = PC_OK;
    PC_TRY(pc_tspline_load(&spline->surface, store, "spline"));
    name_reals(real, spline);
    for (int i = 0; i < REALS; i++)
        PC_TRY(pc_store_get_real(real[i].value, store, "spline", real[i].name));
    for (int i = 0; i < COUNTS; i++)
        PC_TRY(pc_store_get_int(count + i, store, "spline", count_names[i]));
    stats->rounds = (int)count[0];
    stats->first_points = (pc_index)count[1];
    stats->junctions = (pc_index)count[2];
    stats->accuracy.samples = (size_t)count[3];
    stats->accuracy.beyond = (size_t)count[4];
    stats->full = count[5] != 0;
    PC_TRY(pc_tspline_check(&spline->surface, &spline->facts, run->ctx));
done:
    if (status != PC_OK) drop(run);
    return status;
}

const pc_stage pc_stage_spline = {
    .name = "spline",
    .version = 1,
    .needs = PC_NEEDS(PC_STAGE_MESH) | PC_NEEDS(PC_STAGE_QUADS),
    .wanted = wanted,
    .options = put_options,
    .make = make,
    .check = check,
    .save = save,
    .load = load,
    .drop = drop,
};
