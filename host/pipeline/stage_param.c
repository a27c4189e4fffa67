/* Parameterization: (s,t) along the field, at a density that gives the wanted number of quads. */
#include "quads.h"
#include "stage.h"
#include "user_order.h"
#include <math.h>
#include <stdio.h>

/* The count follows the density but for jumps of a row of cells; more tries than this gain nothing. */
enum { MOST_TRIES = 6 };
static const double close_enough = 0.02; /* the promise is 5 % */

static void put_options(pc_json *json, const pc_convert_options *options) {
    pc_json_integer(json, "seed", (int64_t)options->seed);
    pc_json_integer(json, "quads", (int64_t)options->quads);
    if (options->quads) pc_json_boolean(json, "keep_ngons", options->keep_ngons);
}

typedef struct attempt {
    double period, count, miss; /* |count/wanted - 1| */
} attempt;

static pc_status parameterize(pc_run *run, double period, pc_param_stats *stats) {
    pc_held *p = &run->product;
    pc_param_options options = PC_PARAM_DEFAULTS;
    options.period_length = period, options.seed = run->options->seed;
    const double *scale = pc_stage_wanted(PC_STAGE_CURL, run->options) ? p->scale : NULL;
    pc_layout_free(&p->layout, run->ctx);
    pc_param_free(&p->param, run->ctx);
    return pc_param_make(&p->param, stats, run->ctx, run->device, &p->mesh.mesh, &p->mesh.adjacency,
                         &p->field, scale, &options);
}

static pc_status count_quads(pc_run *run, double *count) {
    pc_held *p = &run->product;
    pc_status status = pc_layout_make(&p->layout, &p->layout_stats, run->ctx, &p->mesh.mesh, &p->param);
    if (status == PC_OK)
        *count =
            (double)pc_quads_count(&p->layout, run->options->keep_ngons ? PC_NGONS_KEEP : PC_NGONS_SPLIT);
    return status;
}

/* The period to try next: the count goes with its inverse square, but never leave what is bracketed. */
static double next_period(const attempt *now, double wanted, double *too_short, double *too_long) {
    if (now->count > wanted)
        *too_short = fmax(*too_short, now->period);
    else
        *too_long = fmin(*too_long, now->period);
    double next = now->period * sqrt(now->count / wanted);
    return next > *too_short && next < *too_long ? next : sqrt(*too_short * *too_long);
}

/* Solves again with a corrected density until the count fits, and keeps the best try. */
static pc_status meet_count(pc_run *run, pc_param_stats *stats, int *tries) {
    const double wanted = (double)run->options->quads;
    double too_short = 0, too_long = INFINITY;
    attempt best = {.miss = INFINITY}, now = {.period = run->product.mesh.period};
    pc_status status = PC_OK;
    for (*tries = 1;; ++*tries) {
        PC_TRY(parameterize(run, now.period, stats));
        PC_TRY(count_quads(run, &now.count));
        now.miss = fabs(now.count / wanted - 1);
        pc_log(run->ctx, PC_LOG_INFO, "cells of side %.5g give %.0f quads of %.0f", now.period, now.count,
               wanted);
        if (now.miss < best.miss) best = now;
        if (now.miss <= close_enough || *tries == MOST_TRIES) break;
        now.period = next_period(&now, wanted, &too_short, &too_long);
    }
    if (best.period != now.period) {
        PC_TRY(parameterize(run, best.period, stats));
        PC_TRY(count_quads(run, &now.count));
    }
done:
    return status;
}

static pc_status make(pc_run *run, pc_json *facts) {
    pc_param_stats stats = {0};
    int tries = 1;
    pc_status status = run->options->quads ? meet_count(run, &stats, &tries)
                                           : parameterize(run, run->product.mesh.period, &stats);
    if (status != PC_OK) return status;
    pc_index singular = stats.dislocations + stats.field_singularities + stats.flipped;
    pc_json_number(facts, "period_length", run->product.param.period_length);
    pc_json_integer(facts, "tries", tries);
    pc_json_number(facts, "energy", stats.energy);
    pc_json_integer(facts, "iterations", stats.iterations);
    pc_json_integer(facts, "dislocations", stats.dislocations);
    pc_json_integer(facts, "field_singularities", stats.field_singularities);
    pc_json_integer(facts, "flipped", stats.flipped);
    (void)snprintf(run->record[PC_STAGE_PARAM].note, sizeof run->record->note, "%u singular triangles of %u",
                   singular, run->product.param.face_count);
    return PC_OK;
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
