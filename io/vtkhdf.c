#include "vtkhdf.h"
#include "memory.h"
#include <stdio.h>

enum { VTK_TRIANGLE_CELL = 5, VTK_POLYGON_CELL = 7, VTK_QUAD_CELL = 9 };

/* A grid as VTK wants it, before the arrays on it. */
typedef struct grid {
    size_t point_count, cell_count, corner_count;
    const double *position;
    const pc_index *corner;
    const pc_index *start; /* NULL: three corners each */
} grid;

static pc_status put_count(pc_store *store, const char *name, size_t count, const char *description) {
    const int64_t value = (int64_t)count;
    return pc_store_put(store, name, PC_STORE_I64, 1, &(size_t){1}, &value, "1", description);
}

static pc_status put_topology(pc_store *store, pc_context *ctx, const grid *g) {
    pc_status status = PC_OK;
    int64_t *corner = NULL, *offset = NULL;
    uint8_t *type = NULL;
    PC_TRY(pc_new(&corner, ctx, g->corner_count));
    PC_TRY(pc_new(&offset, ctx, g->cell_count + 1));
    PC_TRY(pc_new(&type, ctx, g->cell_count));
    for (size_t i = 0; i < g->corner_count; i++)
        corner[i] = g->corner[i];
    for (size_t i = 0; i <= g->cell_count; i++)
        offset[i] = g->start ? g->start[i] : 3 * (int64_t)i;
    for (size_t i = 0; i < g->cell_count; i++) {
        int64_t sides = offset[i + 1] - offset[i];
        type[i] = sides == 3 ? VTK_TRIANGLE_CELL : sides == 4 ? VTK_QUAD_CELL : VTK_POLYGON_CELL;
    }
    PC_TRY(pc_store_put(store, "VTKHDF/Connectivity", PC_STORE_I64, 1, &g->corner_count, corner, "1",
                        "points of each cell"));
    PC_TRY(pc_store_put(store, "VTKHDF/Offsets", PC_STORE_I64, 1, &(size_t){g->cell_count + 1}, offset, "1",
                        "where each cell begins in Connectivity"));
    PC_TRY(pc_store_put(store, "VTKHDF/Types", PC_STORE_U8, 1, &g->cell_count, type, "1", "VTK cell types"));
done:
    pc_free(ctx, corner);
    pc_free(ctx, offset);
    pc_free(ctx, type);
    return status;
}

static pc_status put_grid(pc_store *store, pc_context *ctx, const grid *g) {
    pc_status status = PC_OK;
    const int64_t version[] = {1, 0};
    PC_TRY(pc_store_set_ints(store, "VTKHDF", "Version", 2, version));
    PC_TRY(pc_store_set_label(store, "VTKHDF", "Type", "UnstructuredGrid"));
    PC_TRY(put_count(store, "VTKHDF/NumberOfConnectivityIds", g->corner_count, "length of Connectivity"));
    PC_TRY(put_count(store, "VTKHDF/NumberOfPoints", g->point_count, "number of points"));
    PC_TRY(put_count(store, "VTKHDF/NumberOfCells", g->cell_count, "number of cells"));
    PC_TRY(pc_store_put(store, "VTKHDF/Points", PC_STORE_F64, 2, (size_t[]){g->point_count, 3}, g->position,
                        "model", "position of each point"));
    PC_TRY(put_topology(store, ctx, g));
done:
    return status;
}

static pc_status put_array(pc_store *store, const grid *g, const pc_vtk_array *array) {
    char name[128];
    size_t dims[] = {array->on_cells ? g->cell_count : g->point_count, (size_t)array->components};
    (void)snprintf(name, sizeof name, "VTKHDF/%s/%s", array->on_cells ? "CellData" : "PointData",
                   array->name);
    return pc_store_put(store, name, array->type, array->components == 1 ? 1 : 2, dims, array->data,
                        array->units, array->description);
}

static pc_status write_grid(pc_context *ctx, const char *path, const grid *g, const pc_vtk_array *arrays,
                            size_t array_count, const pc_store_options *options) {
    pc_status status = PC_OK;
    pc_store *store = NULL;
    PC_TRY(pc_store_create(&store, ctx, path, options));
    PC_TRY(put_grid(store, ctx, g));
    for (size_t i = 0; i < array_count; i++)
        PC_TRY(put_array(store, g, &arrays[i]));
    PC_TRY(pc_store_commit(&store));
done:
    pc_store_close(store);
    return status;
}

pc_status pc_vtkhdf_write_triangles(pc_context *ctx, const char *path, const pc_mesh *mesh,
                                    const pc_vtk_array *arrays, size_t array_count,
                                    const pc_store_options *options) {
    const grid g = {.point_count = mesh->vertex_count,
                    .cell_count = mesh->face_count,
                    .corner_count = 3 * (size_t)mesh->face_count,
                    .position = mesh->position,
                    .corner = mesh->triangle};
    return write_grid(ctx, path, &g, arrays, array_count, options);
}

pc_status pc_vtkhdf_write_polygons(pc_context *ctx, const char *path, const pc_polymesh *mesh,
                                   const pc_vtk_array *arrays, size_t array_count,
                                   const pc_store_options *options) {
    pc_status status = PC_OK;
    const grid g = {.point_count = mesh->vertex_count,
                    .cell_count = mesh->face_count,
                    .corner_count = mesh->start[mesh->face_count],
                    .position = mesh->position,
                    .corner = mesh->corner,
                    .start = mesh->start};
    pc_vtk_array *all = NULL;
    uint32_t *sides = NULL;
    PC_TRY(pc_new(&sides, ctx, mesh->face_count));
    PC_TRY(pc_new(&all, ctx, array_count + 1));
    for (pc_index f = 0; f < mesh->face_count; f++)
        for (pc_index c = mesh->start[f]; c < mesh->start[f + 1]; c++)
            sides[f] += !(mesh->corner_flat && mesh->corner_flat[c]);
    for (size_t i = 0; i < array_count; i++)
        all[i] = arrays[i];
    all[array_count] =
        (pc_vtk_array){"sides", PC_STORE_U32, 1, true, sides, "1", "corners that are not T-junctions"};
    PC_TRY(write_grid(ctx, path, &g, all, array_count + 1, options));
done:
    pc_free(ctx, all);
    pc_free(ctx, sides);
    return status;
}

enum { SCAN_ARRAYS = 12 };

typedef struct scan_arrays {
    pc_vtk_array array[SCAN_ARRAYS];
    double *scratch[SCAN_ARRAYS]; /* those that had to be made */
    size_t count, scratch_count;
} scan_arrays;

static void add_points(scan_arrays *a, const char *name, int components, const double *data,
                       const char *units, const char *description) {
    a->array[a->count++] = (pc_vtk_array){name, PC_STORE_F64, components, false, data, units, description};
}

static pc_status add_scratch(scan_arrays *a, pc_context *ctx, double **data, const char *name, size_t count,
                             const char *units, const char *description) {
    pc_status status = pc_new(data, ctx, count);
    if (status != PC_OK) return status;
    a->scratch[a->scratch_count++] = *data;
    add_points(a, name, 1, *data, units, description);
    return PC_OK;
}

static pc_status add_curvature(scan_arrays *a, pc_context *ctx, const pc_curvature *c) {
    pc_status status = PC_OK;
    double *k1, *k2;
    PC_TRY(add_scratch(a, ctx, &k1, "k1", c->vertex_count, "1/model", "larger principal curvature"));
    PC_TRY(add_scratch(a, ctx, &k2, "k2", c->vertex_count, "1/model", "smaller principal curvature"));
    for (size_t v = 0; v < c->vertex_count; v++)
        k1[v] = c->value[2 * v], k2[v] = c->value[2 * v + 1];
    add_points(a, "curvature_direction", 3, c->direction, "1", "direction along which the curvature is k1");
    add_points(a, "curvature_weight", 1, c->weight, "1", "trust in that direction, 0 to 1");
done:
    return status;
}

static pc_status add_param(scan_arrays *a, pc_context *ctx, const pc_param *p) {
    pc_status status = PC_OK;
    double *s, *t;
    PC_TRY(add_scratch(a, ctx, &s, "s", p->vertex_count, "period", "first coordinate"));
    PC_TRY(add_scratch(a, ctx, &t, "t", p->vertex_count, "period", "second coordinate"));
    for (size_t v = 0; v < p->vertex_count; v++)
        s[v] = p->coordinate[2 * v] / (double)PC_PERIOD, t[v] = p->coordinate[2 * v + 1] / (double)PC_PERIOD;
    a->array[a->count++] = (pc_vtk_array){"singular",
                                          PC_STORE_U8,
                                          1,
                                          true,
                                          p->singular,
                                          "1",
                                          "0 regular, 1 shifted, 2 turned, 3 not of positive area"};
done:
    return status;
}

pc_status pc_vtkhdf_write_scan(pc_context *ctx, const char *path, const pc_mesh *mesh,
                               const pc_curvature *curvature, const pc_field *field, const pc_param *param,
                               const pc_store_options *options) {
    pc_status status = PC_OK;
    scan_arrays a = {.count = 0};
    if (curvature) PC_TRY(add_curvature(&a, ctx, curvature));
    if (field) {
        add_points(&a, "normal", 3, field->normal, "1", "unit normal");
        add_points(&a, "direction", 3, field->direction, "1", "unit direction of the field");
        a.array[a.count++] = (pc_vtk_array){"singularity",
                                            PC_STORE_I8,
                                            1,
                                            true,
                                            field->index,
                                            "1",
                                            "singularity index of the field, times its symmetry"};
    }
    if (param) PC_TRY(add_param(&a, ctx, param));
    PC_TRY(pc_vtkhdf_write_triangles(ctx, path, mesh, a.array, a.count, options));
done:
    for (size_t i = 0; i < a.scratch_count; i++)
        pc_free(ctx, a.scratch[i]);
    return status;
}

pc_status pc_vtkhdf_write_layout(pc_context *ctx, const char *path, const pc_layout *layout,
                                 const pc_store_options *options) {
    const pc_vtk_array arrays[] = {
        {"cell", PC_STORE_U32, 1, true, layout->cell, "1", "cell in which the triangle lies"},
        {"source_face", PC_STORE_U32, 1, true, layout->source_face, "1",
         "triangle of the scan in which it lies"},
    };
    return pc_vtkhdf_write_triangles(ctx, path, &layout->mesh, arrays, 2, options);
}

pc_status pc_vtkhdf_write_surface(pc_context *ctx, const char *path, const pc_tspline *spline,
                                  const pc_skin *skin, const double *distance,
                                  const pc_store_options *options) {
    pc_status status = PC_OK;
    pc_index *face = NULL;
    PC_TRY(pc_new(&face, ctx, skin->mesh.face_count));
    for (pc_index t = 0; t < skin->mesh.face_count; t++)
        face[t] = spline->basis.element[skin->element[t]].face;
    const pc_vtk_array arrays[] = {
        {"normal", PC_STORE_F64, 3, false, skin->normal, "1", "unit normal of the spline surface"},
        {"element", PC_STORE_U32, 1, true, skin->element, "1", "Bezier element on which the triangle lies"},
        {"face", PC_STORE_U32, 1, true, face, "1", "face of the T-mesh on which the triangle lies"},
        {"distance", PC_STORE_F64, 1, false, distance, "model", "distance to the scan"},
    };
    PC_TRY(pc_vtkhdf_write_triangles(ctx, path, &skin->mesh, arrays, distance ? 4 : 3, options));
done:
    pc_free(ctx, face);
    return status;
}
