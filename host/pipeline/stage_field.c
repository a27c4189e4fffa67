/* Field: smooth crosses along the curvature. */
#include "memory.h"
#include "singularity.h"
#include "stage.h"
#include "user_order.h"
#include <math.h>
#include <stdio.h>

static pc_field_options field_options(const pc_convert_options *wish) {
    pc_field_options options = PC_FIELD_DEFAULTS;
    if (wish->smoothness >= 0) options.smoothness = wish->smoothness;
    options.borders = (pc_border_rule)wish->align_borders;
    return options;
}

static void put_options(pc_json *json, const pc_convert_options *wish) {
    const pc_field_options options = field_options(wish);
    pc_json_exact(json, "smoothness", options.smoothness);
    pc_json_integer(json, "align_borders", options.borders);
}

static void put_facts(pc_run *run, pc_json *facts) {
    const pc_field *field = &run->product.field;
    int64_t sum = 0, loop_sum = 0, positive = 0;
    for (pc_index f = 0; f < field->face_count; f++) {
        sum += field->index[f];
        positive += field->index[f] > 0;
    }
    for (pc_index l = 0; l < field->loop_count; l++)
        loop_sum += field->loop_index[l];
    pc_index count = pc_singularity_count(field);
    pc_json_integer(facts, "symmetry", field->symmetry);
    pc_json_integer(facts, "singularities", count);
    pc_json_integer(facts, "positive", positive);
    pc_json_integer(facts, "index_sum", sum);
    pc_json_integer(facts, "loop_index_sum", loop_sum);
    (void)snprintf(run->record[PC_STAGE_FIELD].note, sizeof run->record->note, "%u singularities", count);
}

/* Nothing after this stage but the export reads the curvature, which loads it again; this one does without
 * the largest part of it. */
static void drop_tensors(pc_run *run) {
    pc_curvature *curvature = &run->product.curvature;
    pc_free(run->ctx, curvature->tensor);
    pc_free(run->ctx, curvature->normal);
    curvature->tensor = curvature->normal = NULL;
}

static pc_status make(pc_run *run, pc_json *facts) {
    const pc_held_mesh *held = &run->product.mesh;
    pc_field_options options = field_options(run->options);
    /* Features smaller than a cell only cost singularities; a horn a few cells around needs all of its own.
     */
    options.feature_length = fmax(4 * held->mean_edge, 0.75 * held->period);
    drop_tensors(run);
    pc_status status = pc_field_make(&run->product.field, run->ctx, run->device, &held->mesh,
                                     &held->adjacency, &run->product.curvature, &options);
    if (status == PC_OK) put_facts(run, facts);
    return status;
}

static pc_status check(pc_run *run) {
    return pc_field_check(&run->product.field, run->ctx, &run->product.mesh.mesh,
                          &run->product.mesh.adjacency);
}

static pc_status save(pc_run *run, pc_store *store) {
    const pc_renumbering to_user = pc_to_user_order(&run->product.mesh);
    pc_field user;
    pc_status status = pc_renumber_field(&user, run->ctx, &run->product.field, &to_user);
    if (status == PC_OK) status = pc_field_save(store, "field", &user);
    pc_field_free(&user, run->ctx);
    return status;
}

static pc_status load(pc_run *run, pc_store *store) {
    const pc_renumbering from_user = pc_from_user_order(&run->product.mesh);
    pc_field user;
    pc_status status = pc_field_load(&user, store, "field");
    if (status != PC_OK) return status;
    status = pc_renumber_field(&run->product.field, run->ctx, &user, &from_user);
    pc_field_free(&user, run->ctx);
    return status;
}

static void drop(pc_run *run) {
    pc_field_free(&run->product.field, run->ctx);
}

const pc_stage pc_stage_field = {
    .name = "field",
    .version = 1,
    .needs = PC_NEEDS(PC_STAGE_MESH) | PC_NEEDS(PC_STAGE_CURVATURE),
    .options = put_options,
    .make = make,
    .check = check,
    .save = save,
    .load = load,
    .drop = drop,
};
