/* Mesh: the scan with long edges split, in an order that keeps neighbours close in memory. */
#include "geometry.h"
#include "memory.h"
#include "plan.h"
#include "refine.h"
#include "stage.h"
#include "topology.h"
#include "user_order.h"
#include <stdio.h>
#include <stdlib.h>

/* Edges longer than this part of a cell's side are split: PGP needs less than a half, and the density may
 * rise. */
static const double longest_part = 0.32;

static void put_options(pc_json *json, const pc_convert_options *options) {
    pc_json_integer(json, "quads", (int64_t)options->quads);
    pc_json_exact(json, "edge_length", options->edge_length);
    pc_json_exact(json, "edge_factor", options->edge_factor);
    pc_json_boolean(json, "keep_ngons", options->keep_ngons);
    pc_json_boolean(json, "for_spline", options->tolerance > 0);
}

static pc_status measure(pc_run *run, const pc_mesh *scan) {
    pc_held_mesh *held = &run->product.mesh;
    pc_adjacency adjacency;
    pc_status status = pc_adjacency_make(&adjacency, run->ctx, scan);
    if (status != PC_OK) return status;
    held->area = pc_geometry_area(scan);
    held->mean_edge = pc_geometry_mean_edge(scan, &adjacency);
    pc_adjacency_free(&adjacency, run->ctx);
    if (!(held->area > 0))
        return pc_fail(run->ctx, PC_E_MESH, "%s: the area of the surface is zero", run->scan_path);
    /* Cells that are split become quads of half their side. */
    double edge = pc_plan_edge(run->options, held->area, held->mean_edge);
    held->period = run->options->keep_ngons ? edge : 2 * edge;
    return PC_OK;
}

/* The scan with its long edges split; takes over what is worth keeping. */
static pc_status refine(pc_mesh *refined_mesh, pc_run *run, const pc_mesh *scan) {
    pc_held_mesh *held = &run->product.mesh;
    pc_refine_options options = PC_REFINE_DEFAULTS;
    pc_refined refined;
    options.max_edge = longest_part * held->period;
    pc_status status = pc_refine(&refined, run->ctx, scan, &options);
    if (status != PC_OK) return status;
    held->scan_vertex_count = refined.original_vertex_count;
    held->scan_face = refined.face_source, refined.face_source = NULL;
    held->parent = refined.parent, refined.parent = NULL;
    *refined_mesh = refined.mesh, refined.mesh = (pc_mesh){0};
    pc_refined_free(&refined, run->ctx);
    return PC_OK;
}

static pc_status order(pc_run *run, const pc_mesh *user_mesh) {
    pc_adjacency adjacency = {0};
    pc_graph graph = {0};
    pc_status status = PC_OK;
    PC_TRY(pc_adjacency_make(&adjacency, run->ctx, user_mesh));
    PC_TRY(pc_graph_make(&graph, run->ctx, user_mesh, &adjacency));
    PC_TRY(pc_order_make(&run->product.mesh.order, run->ctx, user_mesh, &graph));
done:
    pc_graph_free(&graph, run->ctx);
    pc_adjacency_free(&adjacency, run->ctx);
    return status;
}

typedef struct loop_rank {
    uint64_t least; /* half-edge in the user's order */
    pc_index loop;
} loop_rank;

static int compare_ranks(const void *a, const void *b) {
    const loop_rank *x = a, *y = b;
    return x->least < y->least ? -1 : x->least > y->least;
}

/* Loops come in the order of their smallest half-edge, which the two orders see differently. */
static pc_status order_loops(pc_held_mesh *held, pc_context *ctx, const pc_topology *topology) {
    loop_rank *rank = NULL;
    pc_status status = PC_OK;
    held->loop_count = topology->loop_count;
    PC_TRY(pc_new(&rank, ctx, held->loop_count));
    PC_TRY(pc_new(&held->loop_new, ctx, held->loop_count));
    PC_TRY(pc_new(&held->loop_old, ctx, held->loop_count));
    for (pc_index l = 0; l < held->loop_count; l++) {
        rank[l] = (loop_rank){UINT64_MAX, l};
        for (pc_index i = topology->loop_start[l]; i < topology->loop_start[l + 1]; i++) {
            pc_index h = topology->loop_half[i];
            uint64_t user = 3 * (uint64_t)held->order.face_old[h / 3] + h % 3;
            if (user < rank[l].least) rank[l].least = user;
        }
    }
    qsort(rank, held->loop_count, sizeof *rank, compare_ranks);
    for (pc_index l = 0; l < held->loop_count; l++) {
        held->loop_new[l] = rank[l].loop;
        held->loop_old[rank[l].loop] = l;
    }
done:
    pc_free(ctx, rank);
    return status;
}

/* From the mesh in the user's order and the permutation to all the rest. */
static pc_status finish(pc_run *run, const pc_mesh *user_mesh, pc_topology *topology) {
    pc_held_mesh *held = &run->product.mesh;
    pc_status status = PC_OK;
    PC_TRY(pc_order_apply(&held->mesh, run->ctx, &held->order, user_mesh));
    PC_TRY(pc_adjacency_make(&held->adjacency, run->ctx, &held->mesh));
    PC_TRY(pc_topology_make(topology, run->ctx, &held->mesh, &held->adjacency));
    PC_TRY(order_loops(held, run->ctx, topology));
done:
    return status;
}

static void put_facts(pc_run *run, pc_json *facts, const pc_topology *topology) {
    const pc_held_mesh *held = &run->product.mesh;
    pc_json_integer(facts, "vertices", held->mesh.vertex_count);
    pc_json_integer(facts, "faces", held->mesh.face_count);
    pc_json_integer(facts, "added_vertices", held->mesh.vertex_count - held->scan_vertex_count);
    pc_json_integer(facts, "components", topology->component_count);
    pc_json_integer(facts, "euler_number", topology->chi);
    pc_json_integer(facts, "genus", (int64_t)topology->genus);
    pc_json_integer(facts, "boundary_loops", topology->loop_count);
    pc_json_integer(facts, "boundary_edges", held->adjacency.boundary_edge_count);
    pc_json_number(facts, "area", held->area);
    pc_json_number(facts, "mean_edge", held->mean_edge);
    pc_json_number(facts, "period", held->period);
    (void)snprintf(run->record[PC_STAGE_MESH].note, sizeof run->record->note,
                   "%u triangles, chi %lld, %u loops", held->mesh.face_count, (long long)topology->chi,
                   topology->loop_count);
}

static pc_status make(pc_run *run, pc_json *facts) {
    pc_mesh user_mesh = {0};
    pc_topology topology = {0};
    pc_status status = PC_OK;
    PC_TRY(measure(run, &run->product.scan.mesh));
    PC_TRY(refine(&user_mesh, run, &run->product.scan.mesh));
    PC_TRY(order(run, &user_mesh));
    PC_TRY(finish(run, &user_mesh, &topology));
    put_facts(run, facts, &topology);
done:
    pc_topology_free(&topology, run->ctx);
    pc_mesh_free(&user_mesh, run->ctx);
    return status;
}

static pc_status check(pc_run *run) {
    pc_status status = pc_mesh_check(&run->product.mesh.mesh, run->ctx);
    return status == PC_OK ? pc_order_check(&run->product.mesh.order, run->ctx) : status;
}

static pc_status save(pc_run *run, pc_store *store) {
    const pc_held_mesh *held = &run->product.mesh;
    const pc_renumbering to_user = pc_to_user_order(held);
    const size_t added[] = {held->mesh.vertex_count - held->scan_vertex_count, 2};
    pc_mesh user_mesh;
    pc_status status = pc_renumber_mesh(&user_mesh, run->ctx, &held->mesh, &to_user);
    if (status != PC_OK) return status;
    PC_TRY(pc_mesh_save(store, "mesh", &user_mesh));
    PC_TRY(pc_indices_save(store, "mesh/vertex_order", held->order.vertex_new, held->mesh.vertex_count,
                           "place of each vertex in the order of computation"));
    PC_TRY(pc_indices_save(store, "mesh/face_order", held->order.face_new, held->mesh.face_count,
                           "place of each triangle in the order of computation"));
    PC_TRY(pc_indices_save(store, "mesh/scan_face", held->scan_face, held->mesh.face_count,
                           "triangle of the scan that each triangle is a part of"));
    PC_TRY(
        pc_store_put(store, "mesh/parent", PC_STORE_U32, 2, added, held->parent, "1",
                     "the two vertices that each added vertex stands between; those of the scan come first"));
    PC_TRY(pc_store_set_real(store, "mesh", "area", held->area));
    PC_TRY(pc_store_set_real(store, "mesh", "mean_edge", held->mean_edge));
    PC_TRY(pc_store_set_real(store, "mesh", "period", held->period));
done:
    pc_mesh_free(&user_mesh, run->ctx);
    return status;
}

static void drop(pc_run *run) {
    pc_held_mesh *held = &run->product.mesh;
    pc_mesh_free(&held->mesh, run->ctx);
    pc_adjacency_free(&held->adjacency, run->ctx);
    pc_order_free(&held->order, run->ctx);
    pc_free(run->ctx, held->loop_new);
    pc_free(run->ctx, held->loop_old);
    pc_free(run->ctx, held->scan_face);
    pc_free(run->ctx, held->parent);
    *held = (pc_held_mesh){0};
}

static pc_status load_order(pc_held_mesh *held, pc_store *store, const pc_mesh *user_mesh) {
    pc_context *ctx = pc_store_context(store);
    size_t vertices = user_mesh->vertex_count, faces = user_mesh->face_count;
    pc_order *o = &held->order;
    pc_status status = PC_OK;
    o->vertex_count = user_mesh->vertex_count, o->face_count = user_mesh->face_count;
    PC_TRY(pc_indices_load(&o->vertex_new, &vertices, store, "mesh/vertex_order"));
    PC_TRY(pc_indices_load(&o->face_new, &faces, store, "mesh/face_order"));
    PC_TRY(pc_new(&o->vertex_old, ctx, vertices));
    PC_TRY(pc_new(&o->face_old, ctx, faces));
    for (size_t v = 0; v < vertices; v++)
        if (o->vertex_new[v] < vertices) o->vertex_old[o->vertex_new[v]] = (pc_index)v;
    for (size_t f = 0; f < faces; f++)
        if (o->face_new[f] < faces) o->face_old[o->face_new[f]] = (pc_index)f;
    PC_TRY(pc_order_check(o, ctx));
done:
    return status;
}

static pc_status load(pc_run *run, pc_store *store) {
    pc_held_mesh *held = &run->product.mesh;
    pc_mesh user_mesh = {0};
    pc_topology topology = {0};
    size_t faces, parent[] = {PC_STORE_ANY, 2};
    pc_status status = PC_OK;
    *held = (pc_held_mesh){0};
    PC_TRY(pc_mesh_load(&user_mesh, store, "mesh"));
    faces = user_mesh.face_count;
    PC_TRY(load_order(held, store, &user_mesh));
    PC_TRY(pc_indices_load(&held->scan_face, &faces, store, "mesh/scan_face"));
    PC_TRY(pc_store_get(&held->parent, store, "mesh/parent", PC_STORE_U32, 2, parent));
    held->scan_vertex_count = user_mesh.vertex_count - (pc_index)parent[0];
    PC_TRY(pc_store_get_real(&held->area, store, "mesh", "area"));
    PC_TRY(pc_store_get_real(&held->mean_edge, store, "mesh", "mean_edge"));
    PC_TRY(pc_store_get_real(&held->period, store, "mesh", "period"));
    PC_TRY(finish(run, &user_mesh, &topology));
done:
    pc_topology_free(&topology, run->ctx);
    pc_mesh_free(&user_mesh, run->ctx);
    if (status != PC_OK) drop(run);
    return status;
}

const pc_stage pc_stage_mesh = {
    .name = "mesh",
    .version = 1,
    .needs = PC_NEEDS(PC_STAGE_SCAN),
    .options = put_options,
    .make = make,
    .check = check,
    .save = save,
    .load = load,
    .drop = drop,
};
