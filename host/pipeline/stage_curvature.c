/* Curvature: the normal-cycle tensor at each vertex. */
#include "stage.h"
#include "user_order.h"
#include <stdio.h>

static pc_status make(pc_run *run, pc_json *facts) {
    pc_curvature *curvature = &run->product.curvature;
    const pc_held_mesh *held = &run->product.mesh;
    const pc_curvature_options options = PC_CURVATURE_DEFAULTS;
    pc_status status =
        pc_curvature_make(curvature, run->ctx, run->device, &held->mesh, &held->adjacency, &options);
    if (status != PC_OK) return status;
    pc_json_number(facts, "radius", curvature->radius);
    (void)snprintf(run->record[PC_STAGE_CURVATURE].note, sizeof run->record->note, "radius %.4g",
                   curvature->radius);
    return PC_OK;
}

static pc_status check(pc_run *run) {
    return pc_curvature_check(&run->product.curvature, run->ctx);
}

static pc_status save(pc_run *run, pc_store *store) {
    const pc_renumbering to_user = pc_to_user_order(&run->product.mesh);
    pc_curvature user;
    pc_status status = pc_renumber_curvature(&user, run->ctx, &run->product.curvature, &to_user);
    if (status == PC_OK) status = pc_curvature_save(store, "curvature", &user);
    pc_curvature_free(&user, run->ctx);
    return status;
}

static pc_status load(pc_run *run, pc_store *store) {
    const pc_renumbering from_user = pc_from_user_order(&run->product.mesh);
    pc_curvature user;
    pc_status status = pc_curvature_load(&user, store, "curvature");
    if (status != PC_OK) return status;
    status = pc_renumber_curvature(&run->product.curvature, run->ctx, &user, &from_user);
    pc_curvature_free(&user, run->ctx);
    return status;
}

static void drop(pc_run *run) {
    pc_curvature_free(&run->product.curvature, run->ctx);
}

const pc_stage pc_stage_curvature = {
    .name = "curvature",
    .version = 1,
    .needs = PC_NEEDS(PC_STAGE_MESH),
    .make = make,
    .check = check,
    .save = save,
    .load = load,
    .drop = drop,
};
