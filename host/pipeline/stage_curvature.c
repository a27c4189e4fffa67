/* Curvature: the normal-cycle tensor at each vertex. */
#include "columns.h"
#include "stage.h"
#include "user_order.h"
#include <stdio.h>

enum { VERTICES };
#define COLUMN_COUNT (sizeof columns / sizeof *columns)

static const pc_column columns[] = {
    {"normal", PC_STORE_F64, 3, VERTICES, offsetof(pc_curvature, normal), false, "1",
     "unit normal of each vertex, averaged over the neighbourhood"},
    {"tensor", PC_STORE_F64, 6, VERTICES, offsetof(pc_curvature, tensor), false, "1/model",
     "normal-cycle tensor xx xy xz yy yz zz; eigenvectors are swapped against curvatures"},
    {"value", PC_STORE_F64, 2, VERTICES, offsetof(pc_curvature, value), false, "1/model",
     "principal curvatures k1 >= k2, positive where convex"},
    {"direction", PC_STORE_F64, 3, VERTICES, offsetof(pc_curvature, direction), false, "1",
     "unit tangent along which the curvature is k1"},
    {"weight", PC_STORE_F64, 0, VERTICES, offsetof(pc_curvature, weight), false, "1",
     "how far the directions can be trusted, 0..1"},
};

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

static pc_status check(pc_run *run) { return pc_curvature_check(&run->product.curvature, run->ctx); }

static pc_status save(pc_run *run, pc_store *store) {
    const pc_renumbering to_user = pc_to_user_order(&run->product.mesh);
    const size_t counts[] = {run->product.curvature.vertex_count};
    pc_curvature user;
    pc_status status = pc_renumber_curvature(&user, run->ctx, &run->product.curvature, &to_user);
    if (status != PC_OK) return status;
    PC_TRY(pc_columns_save(store, "curvature", columns, COLUMN_COUNT, &user, counts));
    PC_TRY(pc_store_set_real(store, "curvature", "radius", user.radius));
    PC_TRY(pc_store_set_real(store, "curvature", "mean_edge", user.mean_edge));
done:
    pc_curvature_free(&user, run->ctx);
    return status;
}

static pc_status load(pc_run *run, pc_store *store) {
    const pc_renumbering from_user = pc_from_user_order(&run->product.mesh);
    size_t counts[] = {from_user.vertex_count};
    pc_curvature user = {.vertex_count = from_user.vertex_count};
    pc_status status = PC_OK;
    PC_TRY(pc_columns_load(&user, counts, store, "curvature", columns, COLUMN_COUNT));
    PC_TRY(pc_store_get_real(&user.radius, store, "curvature", "radius"));
    PC_TRY(pc_store_get_real(&user.mean_edge, store, "curvature", "mean_edge"));
    PC_TRY(pc_renumber_curvature(&run->product.curvature, run->ctx, &user, &from_user));
done:
    pc_curvature_free(&user, run->ctx);
    return status;
}

static void drop(pc_run *run) { pc_curvature_free(&run->product.curvature, run->ctx); }

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
