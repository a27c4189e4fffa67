#include "curvature_store.h"
#include "columns.h"

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

pc_status pc_curvature_save(pc_store *store, const char *group, const pc_curvature *curvature) {
    const size_t counts[] = {curvature->vertex_count};
    pc_status status = PC_OK;
    PC_TRY(pc_columns_save(store, group, columns, COLUMN_COUNT, curvature, counts));
    PC_TRY(pc_store_set_real(store, group, "radius", curvature->radius));
    PC_TRY(pc_store_set_real(store, group, "mean_edge", curvature->mean_edge));
done:
    return status;
}

pc_status pc_curvature_load(pc_curvature *curvature, pc_store *store, const char *group) {
    size_t counts[] = {PC_STORE_ANY};
    pc_status status = PC_OK;
    *curvature = (pc_curvature){0};
    PC_TRY(pc_columns_load(curvature, counts, store, group, columns, COLUMN_COUNT));
    PC_TRY(pc_store_get_real(&curvature->radius, store, group, "radius"));
    PC_TRY(pc_store_get_real(&curvature->mean_edge, store, group, "mean_edge"));
    curvature->vertex_count = (pc_index)counts[VERTICES];
done:
    if (status != PC_OK) pc_curvature_free(curvature, pc_store_context(store));
    return status;
}
