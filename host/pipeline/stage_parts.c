/* Parts: pieces of the mesh with few edges between them, for machines with more than one memory. No other
 * stage reads them, and no other file holds them, so that their number changes no result. */
#include "graph.h"
#include "memory.h"
#include "stage.h"
#include "user_order.h"
#include <stdio.h>

static bool wanted(const pc_convert_options *options) {
    return options->parts > 1;
}

static void put_options(pc_json *json, const pc_convert_options *options) {
    pc_json_integer(json, "parts", options->parts);
}

static pc_status make(pc_run *run, pc_json *facts) {
    const pc_held_mesh *held = &run->product.mesh;
    pc_parts *parts = &run->product.parts;
    pc_graph graph;
    pc_status status = pc_graph_make(&graph, run->ctx, &held->mesh, &held->adjacency);
    if (status != PC_OK) return status;
    PC_TRY(pc_parts_make(parts, run->ctx, &graph, run->options->parts));
    PC_TRY(pc_parts_check(parts, run->ctx, &graph));
    pc_json_integer(facts, "parts", parts->part_count);
    pc_json_integer(facts, "cut_edges", (int64_t)parts->cut_edges);
    (void)snprintf(run->record[PC_STAGE_PARTS].note, sizeof run->record->note,
                   "%u parts, %llu edges between them", parts->part_count,
                   (unsigned long long)parts->cut_edges);
done:
    pc_graph_free(&graph, run->ctx);
    return status;
}

static pc_status check(pc_run *run) {
    (void)run; /* make has the graph that the check needs */
    return PC_OK;
}

static pc_status save(pc_run *run, pc_store *store) {
    const pc_renumbering to_user = pc_to_user_order(&run->product.mesh);
    const pc_parts *parts = &run->product.parts;
    pc_index *part;
    pc_status status = pc_renumber_indices(&part, run->ctx, parts->vertex_part, &to_user);
    if (status != PC_OK) return status;
    PC_TRY(pc_indices_save(store, "parts/vertex_part", part, parts->vertex_count, "part of each vertex"));
    PC_TRY(pc_store_set_int(store, "parts", "part_count", parts->part_count));
    PC_TRY(pc_store_set_int(store, "parts", "cut_edges", (int64_t)parts->cut_edges));
done:
    pc_free(run->ctx, part);
    return status;
}

static pc_status load(pc_run *run, pc_store *store) {
    const pc_renumbering from_user = pc_from_user_order(&run->product.mesh);
    pc_parts *parts = &run->product.parts;
    size_t vertices = from_user.vertex_count;
    int64_t part_count, cut_edges;
    pc_index *part = NULL;
    pc_status status = PC_OK;
    PC_TRY(pc_indices_load(&part, &vertices, store, "parts/vertex_part"));
    PC_TRY(pc_store_get_int(&part_count, store, "parts", "part_count"));
    PC_TRY(pc_store_get_int(&cut_edges, store, "parts", "cut_edges"));
    PC_TRY(pc_renumber_indices(&parts->vertex_part, run->ctx, part, &from_user));
    parts->part_count = (pc_index)part_count;
    parts->vertex_count = (pc_index)vertices;
    parts->cut_edges = (uint64_t)cut_edges;
done:
    pc_free(run->ctx, part);
    return status;
}

static void drop(pc_run *run) {
    pc_parts_free(&run->product.parts, run->ctx);
}

const pc_stage pc_stage_parts = {
    .name = "parts",
    .version = 1,
    .needs = PC_NEEDS(PC_STAGE_MESH),
    .wanted = wanted,
    .options = put_options,
    .make = make,
    .check = check,
    .save = save,
    .load = load,
    .drop = drop,
};
