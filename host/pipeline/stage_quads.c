/* Quads: the polygons of the layout's cells. */
#include "remesh.h"
#include "stage.h"
#include <stdio.h>

static void put_options(pc_json *json, const pc_convert_options *options) {
    pc_json_boolean(json, "keep_ngons", options->keep_ngons);
    pc_json_integer(json, "quads", (int64_t)options->quads);
}

static pc_status make_quads(pc_run *run) {
    pc_held *p = &run->product;
    pc_ground ground;
    pc_status status = pc_ground_make(&ground, run->ctx, &p->mesh.mesh, &p->mesh.adjacency);
    if (status == PC_OK)
        status = pc_remesh_quads(&p->quads, NULL, &p->quads_stats, run->ctx, &p->layout,
                                 run->options->keep_ngons ? PC_NGONS_KEEP : PC_NGONS_SPLIT,
                                 (double)run->options->quads, &ground);
    pc_ground_free(&ground, run->ctx);
    return status;
}

/* The parameterization has looked at quads already; those of the layout that was taken over stay. */
static pc_status make(pc_run *run, pc_json *facts) {
    const pc_polymesh *quads = &run->product.quads;
    const pc_remesh_quads_stats *made = &run->product.quads_stats;
    pc_index four = 0;
    pc_status status = quads->face_count ? PC_OK : make_quads(run);
    if (status != PC_OK) return status;
    for (pc_index f = 0; f < quads->face_count; f++) {
        pc_index sides = 0;
        for (pc_index c = quads->start[f]; c < quads->start[f + 1]; c++)
            sides += !(quads->corner_flat && quads->corner_flat[c]);
        four += sides == 4;
    }
    pc_json_integer(facts, "vertices", quads->vertex_count);
    pc_json_integer(facts, "faces", quads->face_count);
    pc_json_integer(facts, "quads", four);
    pc_json_integer(facts, "doublets_removed", made->doublets);
    pc_json_integer(facts, "collapsed", made->collapsed);
    pc_json_integer(facts, "upside_down", made->folded);
    pc_json_integer(facts, "strips_changed", made->strips);
    pc_json_integer(facts, "badly_shaped_before", made->relaxed.bad_before);
    pc_json_integer(facts, "badly_shaped", made->relaxed.bad_after);
    (void)snprintf(run->record[PC_STAGE_QUADS].note, sizeof run->record->note, "%u faces, %.2f %% quads",
                   quads->face_count, quads->face_count ? 100.0 * four / quads->face_count : 0);
    return PC_OK;
}

static pc_status check(pc_run *run) {
    const pc_polymesh *quads = &run->product.quads;
    for (size_t c = 0; c < quads->start[quads->face_count]; c++)
        if (quads->corner[c] >= quads->vertex_count)
            return pc_fail(run->ctx, PC_E_BUG, "corner %zu of the quads has vertex %u of %u", c,
                           quads->corner[c], quads->vertex_count);
    return PC_OK;
}

static pc_status save(pc_run *run, pc_store *store) {
    return pc_polymesh_save(store, "quads", &run->product.quads);
}

static pc_status load(pc_run *run, pc_store *store) {
    pc_polymesh_free(&run->product.quads, run->ctx);
    return pc_polymesh_load(&run->product.quads, store, "quads");
}

static void drop(pc_run *run) {
    pc_polymesh_free(&run->product.quads, run->ctx);
}

const pc_stage pc_stage_quads = {
    .name = "quads",
    .version = 1,
    .needs = PC_NEEDS(PC_STAGE_MESH) | PC_NEEDS(PC_STAGE_LAYOUT),
    .options = put_options,
    .make = make,
    .check = check,
    .save = save,
    .load = load,
    .drop = drop,
};
