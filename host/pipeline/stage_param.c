/* Parameterization: (s,t) along the field, at a density that gives the wanted number of quads. */
#include "memory.h"
#include "remesh.h"
#include "stage.h"
#include "user_order.h"
#include <stdio.h>

static void put_options(pc_json *json, const pc_convert_options *options) {
    pc_json_integer(json, "seed", (int64_t)options->seed);
    pc_json_integer(json, "quads", (int64_t)options->quads);
    pc_json_boolean(json, "keep_ngons", options->keep_ngons);
    pc_json_boolean(json, "closer", options->closer);
    pc_json_integer(json, "pgp", options->pgp);
    pc_json_boolean(json, "for_spline", options->tolerance > 0);
}

static void put_facts(pc_run *run, pc_json *facts, const pc_remesh_stats *stats) {
    const pc_param_stats *param = &stats->param;
    pc_json_number(facts, "period_length", run->product.param.period_length);
    if (run->options->closer) pc_json_boolean(facts, "closer", true);
    pc_json_integer(facts, "tries", stats->tries);
    pc_json_integer(facts, "tries_on_pilot", stats->pilot_tries);
    pc_json_integer(facts, "refinements", stats->refinements);
    pc_json_number(facts, "finest_scale", stats->finest_scale);
    pc_json_integer(facts, "vertices_wanting_finer", stats->wanting);
    pc_json_number(facts, "energy", param->energy);
    pc_json_integer(facts, "pgp_steps", param->steps);
    pc_json_integer(facts, "pgp_iterations", param->pgp_iterations);
    pc_json_integer(facts, "dislocations_of_pgp", param->raw_dislocations);
    pc_json_integer(facts, "iterations", param->iterations);
    pc_json_integer(facts, "dislocations_cancelled", param->cancelled);
    pc_json_integer(facts, "dislocations", param->dislocations);
    pc_json_integer(facts, "field_singularities", param->field_singularities);
    pc_json_integer(facts, "flipped", param->flipped);
    pc_index singular = param->dislocations + param->field_singularities + param->flipped;
    (void)snprintf(run->record[PC_STAGE_PARAM].note, sizeof run->record->note, "%u singular triangles of %u",
                   singular, run->product.param.face_count);
}

/* A spline can be no better than what it starts from. Where whole cells are the faces, these are larger. */
static void hold_on(pc_remesh_options *options, bool closer) {
    const bool whole = options->ngons == PC_NGONS_KEEP;
    options->reach = closer ? 0.55 : whole ? 0.7 : 0.85;
    options->floor = closer ? 0.3 : whole ? 0.35 : 0.4;
    options->walls = closer;
}

static pc_status remesh(pc_remesh_stats *stats, pc_run *run, const pc_remesh_options *options) {
    pc_held *p = &run->product;
    double *scale = NULL;
    pc_remesh_looked looked;
    pc_status status =
        pc_remesh_make(&p->param, &p->layout, &scale, &looked, stats, run->ctx, run->device, &p->mesh.mesh,
                       &p->mesh.adjacency, &p->field,
                       pc_stage_wanted(PC_STAGE_CURL, run->options) ? p->scale : NULL, options);
    pc_free(run->ctx, scale);
    p->quads = looked.quads, p->quads_stats = looked.stats;
    return status;
}

static pc_status make(pc_run *run, pc_json *facts) {
    const double smaller = 0.75;
    pc_held *p = &run->product;
    pc_remesh_options options = PC_REMESH_DEFAULTS;
    pc_remesh_stats stats;
    pc_status status = PC_OK;
    options.period_length = p->mesh.period;
    options.quads = (double)run->options->quads;
    options.ngons = run->options->keep_ngons ? PC_NGONS_KEEP : PC_NGONS_SPLIT;
    options.seed = run->options->seed;
    options.scheme = (pc_pgp_scheme)run->options->pgp;
    if (run->options->tolerance > 0) hold_on(&options, run->options->closer);
    PC_TRY(remesh(&stats, run, &options));
    if (run->options->closer && stats.refinements == 0) { /* else the same quads as usual */
        pc_param_free(&p->param, run->ctx);
        pc_layout_free(&p->layout, run->ctx);
        pc_polymesh_free(&p->quads, run->ctx);
        options.period_length *= smaller;
        PC_TRY(remesh(&stats, run, &options));
    }
    p->layout_stats = stats.layout;
    put_facts(run, facts, &stats);
done:
    return status;
}

static pc_status check(pc_run *run) {
    return pc_param_check(&run->product.param, run->ctx, &run->product.mesh.mesh,
                          &run->product.mesh.adjacency);
}

static pc_status save(pc_run *run, pc_store *store) {
    const pc_renumbering to_user = pc_to_user_order(&run->product.mesh);
    pc_param user;
    pc_status status = pc_renumber_param(&user, run->ctx, &run->product.param, &to_user);
    if (status == PC_OK) status = pc_param_save(store, "param", &user);
    pc_param_free(&user, run->ctx);
    return status;
}

static pc_status load(pc_run *run, pc_store *store) {
    const pc_renumbering from_user = pc_from_user_order(&run->product.mesh);
    pc_param user;
    pc_status status = pc_param_load(&user, store, "param");
    if (status != PC_OK) return status;
    status = pc_renumber_param(&run->product.param, run->ctx, &user, &from_user);
    pc_param_free(&user, run->ctx);
    return status;
}

static void drop(pc_run *run) {
    pc_param_free(&run->product.param, run->ctx);
}

const pc_stage pc_stage_param = {
    .name = "param",
    .version = 1,
    .needs = PC_NEEDS(PC_STAGE_MESH) | PC_NEEDS(PC_STAGE_FIELD) | PC_NEEDS(PC_STAGE_CURL),
    .options = put_options,
    .make = make,
    .check = check,
    .save = save,
    .load = load,
    .drop = drop,
};
