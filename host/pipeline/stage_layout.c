/* Layout: the cells between the iso-lines. */
#include "stage.h"
#include "user_order.h"
#include <stdio.h>

/* The parameterization draws layouts while it looks for the right density; the one that fits is taken over.
 */
static pc_status make(pc_run *run, pc_json *facts) {
    const pc_held_mesh *held = &run->product.mesh;
    pc_layout *layout = &run->product.layout;
    pc_layout_stats *stats = &run->product.layout_stats;
    if (!layout->cell_start) {
        pc_status status = pc_layout_make(layout, stats, run->ctx, &held->mesh, &run->product.param);
        if (status != PC_OK) return status;
    }
    pc_json_integer(facts, "nodes", layout->node_count);
    pc_json_integer(facts, "arcs", layout->arc_count);
    pc_json_integer(facts, "cells", layout->cell_count);
    pc_json_integer(facts, "dangling_edges", stats->dangling_edges);
    pc_json_integer(facts, "cut_cells", stats->cut_cells);
    pc_json_integer(facts, "split_cells", stats->split_cells);
    (void)snprintf(run->record[PC_STAGE_LAYOUT].note, sizeof run->record->note, "%u cells",
                   layout->cell_count);
    return PC_OK;
}

static pc_status check(pc_run *run) {
    return pc_layout_check(&run->product.layout, run->ctx);
}

static pc_status save(pc_run *run, pc_store *store) {
    const pc_renumbering to_user = pc_to_user_order(&run->product.mesh);
    pc_layout user;
    pc_status status = pc_renumber_layout(&user, run->ctx, &run->product.layout, &to_user);
    if (status == PC_OK) status = pc_layout_save(store, "layout", &user);
    pc_layout_free(&user, run->ctx);
    return status;
}

static pc_status load(pc_run *run, pc_store *store) {
    const pc_renumbering from_user = pc_from_user_order(&run->product.mesh);
    pc_layout user;
    pc_status status = pc_layout_load(&user, store, "layout");
    if (status != PC_OK) return status;
    pc_layout_free(&run->product.layout, run->ctx); /* the parameterization's, where that was made anew */
    status = pc_renumber_layout(&run->product.layout, run->ctx, &user, &from_user);
    pc_layout_free(&user, run->ctx);
    return status;
}

static void drop(pc_run *run) {
    pc_layout_free(&run->product.layout, run->ctx);
}

const pc_stage pc_stage_layout = {
    .name = "layout",
    .version = 1,
    .needs = PC_NEEDS(PC_STAGE_MESH) | PC_NEEDS(PC_STAGE_PARAM),
    .make = make,
    .check = check,
    .save = save,
    .load = load,
    .drop = drop,
};
