/* Curl: how large the cells are to be at each vertex, so that the field can be integrated with fewer
 * singularities. */
#include "curl.h"
#include "memory.h"
#include "stage.h"
#include "user_order.h"
#include <stdio.h>

static bool wanted(const pc_convert_options *options) {
    return options->curl_correction;
}

static pc_status make(pc_run *run, pc_json *facts) {
    const pc_held_mesh *held = &run->product.mesh;
    const pc_curl_options options = PC_CURL_DEFAULTS;
    double least = 1;
    pc_status status = pc_new(&run->product.scale, run->ctx, held->mesh.vertex_count);
    if (status == PC_OK)
        status = pc_curl_correct(run->product.scale, run->ctx, run->device, &held->mesh, &held->adjacency,
                                 &run->product.field, &options);
    if (status != PC_OK) return status;
    for (pc_index v = 0; v < held->mesh.vertex_count; v++)
        if (run->product.scale[v] < least) least = run->product.scale[v];
    pc_json_number(facts, "least_scale", least);
    (void)snprintf(run->record[PC_STAGE_CURL].note, sizeof run->record->note,
                   "cells up to %.2f times as large", 1 / least);
    return PC_OK;
}

static pc_status check(pc_run *run) {
    for (pc_index v = 0; v < run->product.mesh.mesh.vertex_count; v++)
        if (!(run->product.scale[v] > 0 && run->product.scale[v] <= 1))
            return pc_fail(run->ctx, PC_E_BUG, "the scale of vertex %u is %g, not in (0,1]", v,
                           run->product.scale[v]);
    return PC_OK;
}

static pc_status save(pc_run *run, pc_store *store) {
    const pc_renumbering to_user = pc_to_user_order(&run->product.mesh);
    double *user;
    pc_status status = pc_renumber_reals(&user, run->ctx, run->product.scale, &to_user);
    if (status == PC_OK)
        status =
            pc_reals_save(store, "curl/scale", user, to_user.vertex_count, "1",
                          "factor of the field's length at each vertex: cells are 1/scale times as large");
    pc_free(run->ctx, user);
    return status;
}

static pc_status load(pc_run *run, pc_store *store) {
    const pc_renumbering from_user = pc_from_user_order(&run->product.mesh);
    size_t vertices = from_user.vertex_count;
    double *user;
    pc_status status = pc_reals_load(&user, &vertices, store, "curl/scale");
    if (status != PC_OK) return status;
    status = pc_renumber_reals(&run->product.scale, run->ctx, user, &from_user);
    pc_free(run->ctx, user);
    return status;
}

static void drop(pc_run *run) {
    pc_free(run->ctx, run->product.scale);
    run->product.scale = NULL;
}

const pc_stage pc_stage_curl = {
    .name = "curl",
    .version = 1,
    .needs = PC_NEEDS(PC_STAGE_MESH) | PC_NEEDS(PC_STAGE_FIELD),
    .wanted = wanted,
    .make = make,
    .check = check,
    .save = save,
    .load = load,
    .drop = drop,
};
