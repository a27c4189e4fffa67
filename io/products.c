#include "products.h"
#include "columns.h"
#include "memory.h"
#include <stdio.h>

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* In the tables `rows` is an index into the counts that each _save and _load sets up. */
enum { VERTICES, FACES };

static const pc_column mesh_columns[] = {
    {"position", PC_STORE_F64, 3, VERTICES, offsetof(pc_mesh, position), false, "model",
     "position of each vertex, in the frame of the input"},
    {"triangle", PC_STORE_U32, 3, FACES, offsetof(pc_mesh, triangle), false, "1",
     "vertices of each triangle, counter-clockwise seen from outside"},
};

pc_status pc_mesh_save(pc_store *store, const char *group, const pc_mesh *mesh) {
    const size_t counts[] = {mesh->vertex_count, mesh->face_count};
    return pc_columns_save(store, group, mesh_columns, COUNT(mesh_columns), mesh, counts);
}

pc_status pc_mesh_load(pc_mesh *mesh, pc_store *store, const char *group) {
    pc_status status = PC_OK;
    size_t counts[] = {PC_STORE_ANY, PC_STORE_ANY};
    *mesh = (pc_mesh){0};
    PC_TRY(pc_columns_load(mesh, counts, store, group, mesh_columns, COUNT(mesh_columns)));
    mesh->vertex_count = (pc_index)counts[VERTICES];
    mesh->face_count = (pc_index)counts[FACES];
    PC_TRY(pc_columns_below(store, group, "triangle", mesh->triangle, 3 * counts[FACES], counts[VERTICES],
                            false));
done:
    if (status != PC_OK) pc_mesh_free(mesh, pc_store_context(store));
    return status;
}

static const pc_column curvature_columns[] = {
    {"normal", PC_STORE_F64, 3, VERTICES, offsetof(pc_curvature, normal), false, "1",
     "unit normal of each vertex, averaged over the neighbourhood"},
    {"tensor", PC_STORE_F64, 6, VERTICES, offsetof(pc_curvature, tensor), false, "1/model",
     "normal-cycle curvature tensor of each vertex: xx xy xz yy yz zz"},
    {"value", PC_STORE_F64, 2, VERTICES, offsetof(pc_curvature, value), false, "1/model",
     "principal curvatures k1 >= k2 of each vertex, positive where convex"},
    {"direction", PC_STORE_F64, 3, VERTICES, offsetof(pc_curvature, direction), false, "1",
     "unit tangent of each vertex along which the curvature is k1"},
    {"weight", PC_STORE_F64, 0, VERTICES, offsetof(pc_curvature, weight), false, "1",
     "trust in the direction of each vertex, 0 to 1"},
};

pc_status pc_curvature_save(pc_store *store, const char *group, const pc_curvature *curvature) {
    pc_status status = PC_OK;
    const size_t counts[] = {curvature->vertex_count};
    PC_TRY(pc_columns_save(store, group, curvature_columns, COUNT(curvature_columns), curvature, counts));
    PC_TRY(pc_store_set_real(store, group, "radius", curvature->radius));
    PC_TRY(pc_store_set_real(store, group, "mean_edge", curvature->mean_edge));
done:
    return status;
}

pc_status pc_curvature_load(pc_curvature *curvature, pc_store *store, const char *group) {
    pc_status status = PC_OK;
    size_t counts[] = {PC_STORE_ANY};
    *curvature = (pc_curvature){0};
    PC_TRY(pc_columns_load(curvature, counts, store, group, curvature_columns, COUNT(curvature_columns)));
    curvature->vertex_count = (pc_index)counts[VERTICES];
    PC_TRY(pc_store_get_real(&curvature->radius, store, group, "radius"));
    PC_TRY(pc_store_get_real(&curvature->mean_edge, store, group, "mean_edge"));
done:
    if (status != PC_OK) pc_curvature_free(curvature, pc_store_context(store));
    return status;
}

enum { FIELD_LOOPS = 2, FIELD_HALF_EDGES };

static const pc_column field_columns[] = {
    {"normal", PC_STORE_F64, 3, VERTICES, offsetof(pc_field, normal), false, "1",
     "unit normal of each vertex"},
    {"direction", PC_STORE_F64, 3, VERTICES, offsetof(pc_field, direction), false, "1",
     "unit tangent K of each vertex; the others follow by turns of 360/symmetry degrees about the normal"},
    {"angle", PC_STORE_F64, 0, VERTICES, offsetof(pc_field, angle), true, "rad",
     "angle of K in the tangent frame of each vertex"},
    {"turn", PC_STORE_U8, 0, FIELD_HALF_EDGES, offsetof(pc_field, turn), true, "360/symmetry degrees",
     "per half-edge 3*triangle+corner from i to j: turns that bring the direction at j nearest to that at i"},
    {"index", PC_STORE_I8, 0, FACES, offsetof(pc_field, index), false, "1",
     "singularity index inside each triangle, times symmetry"},
    {"loop_index", PC_STORE_I32, 0, FIELD_LOOPS, offsetof(pc_field, loop_index), false, "1",
     "index of each boundary loop, times symmetry; loops in the order of their smallest half-edge"},
};

pc_status pc_field_save(pc_store *store, const char *group, const pc_field *field) {
    pc_status status = PC_OK;
    const size_t counts[] = {field->vertex_count, field->face_count, field->loop_count,
                             3 * (size_t)field->face_count};
    PC_TRY(pc_columns_save(store, group, field_columns, COUNT(field_columns), field, counts));
    PC_TRY(pc_store_set_int(store, group, "symmetry", field->symmetry));
done:
    return status;
}

static pc_status check_turns(const pc_field *field, const size_t *counts, unsigned symmetry, pc_store *store,
                             const char *group) {
    if (!field->turn) return PC_OK;
    if (counts[FIELD_HALF_EDGES] != 3 * counts[FACES])
        return pc_fail(pc_store_context(store), PC_E_FORMAT, "%s: '%s/turn': %zu half-edges of %zu triangles",
                       pc_store_path(store), group, counts[FIELD_HALF_EDGES], counts[FACES]);
    return pc_columns_bytes_below(store, group, "turn", field->turn, 3 * counts[FACES], symmetry);
}

pc_status pc_field_load(pc_field *field, pc_store *store, const char *group) {
    pc_status status = PC_OK;
    int64_t symmetry;
    size_t counts[] = {PC_STORE_ANY, PC_STORE_ANY, PC_STORE_ANY, PC_STORE_ANY};
    *field = (pc_field){0};
    PC_TRY(pc_columns_load(field, counts, store, group, field_columns, COUNT(field_columns)));
    PC_TRY(pc_store_get_int(&symmetry, store, group, "symmetry"));
    if (symmetry != 1 && symmetry != 2 && symmetry != 4)
        PC_TRY(pc_fail(pc_store_context(store), PC_E_FORMAT, "%s: '%s': symmetry is %lld, not 1, 2 or 4",
                       pc_store_path(store), group, (long long)symmetry));
    PC_TRY(check_turns(field, counts, (unsigned)symmetry, store, group));
    field->symmetry = (int)symmetry;
    field->vertex_count = (pc_index)counts[VERTICES];
    field->face_count = (pc_index)counts[FACES];
    field->loop_count = (pc_index)counts[FIELD_LOOPS];
done:
    if (status != PC_OK) pc_field_free(field, pc_store_context(store));
    return status;
}

enum { PARAM_HALF_EDGES = 2 };

static const pc_column param_columns[] = {
    {"phase", PC_STORE_F32, 4, VERTICES, offsetof(pc_param, phase), false, "1",
     "U and V as solved: cos s, sin s, cos t, sin t of each vertex, norms kept"},
    {"coordinate", PC_STORE_I32, 2, VERTICES, offsetof(pc_param, coordinate), false, "period/2^24",
     "(s,t) of each vertex, fixed point; odd, so that no line meets a vertex"},
    {"turn", PC_STORE_U8, 0, PARAM_HALF_EDGES, offsetof(pc_param, turn), false, "quarter turn",
     "per half-edge 3*triangle+corner from i to j: turns r that bring the frame of j to that of i"},
    {"shift", PC_STORE_I32, 2, PARAM_HALF_EDGES, offsetof(pc_param, shift), false, "period",
     "per half-edge from i to j: seen from i, j lies at S^r (s,t)_j + (a,b) periods, S(s,t) = (t,-s)"},
    {"singular", PC_STORE_U8, 0, FACES, offsetof(pc_param, singular), false, "1",
     "per triangle: 0 regular, 1 shifted once around, 2 turned once around, 3 not of positive area"},
};

pc_status pc_param_save(pc_store *store, const char *group, const pc_param *param) {
    pc_status status = PC_OK;
    const size_t counts[] = {param->vertex_count, param->face_count, 3 * (size_t)param->face_count};
    PC_TRY(pc_columns_save(store, group, param_columns, COUNT(param_columns), param, counts));
    PC_TRY(pc_store_set_real(store, group, "period_length", param->period_length));
    PC_TRY(pc_store_set_int(store, group, "period", PC_PERIOD));
done:
    return status;
}

static pc_status check_param(const pc_param *param, pc_store *store, const char *group) {
    pc_status status = PC_OK;
    int64_t period;
    PC_TRY(pc_store_get_int(&period, store, group, "period"));
    if (period != PC_PERIOD)
        PC_TRY(pc_fail(pc_store_context(store), PC_E_FORMAT, "%s: '%s': a period has %lld units, expected %d",
                       pc_store_path(store), group, (long long)period, PC_PERIOD));
    for (size_t i = 0; i < 2 * (size_t)param->vertex_count; i++)
        if (param->coordinate[i] % 2 == 0)
            PC_TRY(pc_fail(pc_store_context(store), PC_E_FORMAT,
                           "%s: '%s/coordinate': vertex %zu is at %d, which is even", pc_store_path(store),
                           group, i / 2, param->coordinate[i]));
    PC_TRY(pc_columns_bytes_below(store, group, "turn", param->turn, 3 * (size_t)param->face_count, 4));
    PC_TRY(
        pc_columns_bytes_below(store, group, "singular", param->singular, param->face_count, PC_FLIPPED + 1));
done:
    return status;
}

pc_status pc_param_load(pc_param *param, pc_store *store, const char *group) {
    pc_status status = PC_OK;
    size_t counts[] = {PC_STORE_ANY, PC_STORE_ANY, PC_STORE_ANY};
    *param = (pc_param){0};
    PC_TRY(pc_columns_load(param, counts, store, group, param_columns, COUNT(param_columns)));
    if (counts[PARAM_HALF_EDGES] != 3 * counts[FACES])
        PC_TRY(pc_fail(pc_store_context(store), PC_E_FORMAT, "%s: '%s': %zu half-edges of %zu triangles",
                       pc_store_path(store), group, counts[PARAM_HALF_EDGES], counts[FACES]));
    param->vertex_count = (pc_index)counts[VERTICES];
    param->face_count = (pc_index)counts[FACES];
    PC_TRY(pc_store_get_real(&param->period_length, store, group, "period_length"));
    PC_TRY(check_param(param, store, group));
done:
    if (status != PC_OK) pc_param_free(param, pc_store_context(store));
    return status;
}

enum {
    LAYOUT_NODES = 2,
    LAYOUT_ARCS,
    LAYOUT_ARC_OFFSETS,
    LAYOUT_ARC_VERTICES,
    LAYOUT_CELL_OFFSETS,
    LAYOUT_SIDES
};

static const pc_column layout_columns[] = {
    {"position", PC_STORE_F64, 3, VERTICES, offsetof(pc_layout, mesh.position), false, "model",
     "position of each vertex of the refined scan; the vertices of the scan come first"},
    {"triangle", PC_STORE_U32, 3, FACES, offsetof(pc_layout, mesh.triangle), false, "1",
     "vertices of each triangle of the refined scan"},
    {"source_face", PC_STORE_U32, 0, FACES, offsetof(pc_layout, source_face), false, "1",
     "triangle of the scan in which each triangle lies"},
    {"cell", PC_STORE_U32, 0, FACES, offsetof(pc_layout, cell), false, "1",
     "cell in which each triangle lies"},
    {"node_vertex", PC_STORE_U32, 0, LAYOUT_NODES, offsetof(pc_layout, node_vertex), false, "1",
     "vertex of the refined scan at each node"},
    {"arc_start", PC_STORE_U32, 0, LAYOUT_ARC_OFFSETS, offsetof(pc_layout, arc_start), false, "1",
     "where the chain of each arc begins in arc_vertex, and the end of the last"},
    {"arc_vertex", PC_STORE_U32, 0, LAYOUT_ARC_VERTICES, offsetof(pc_layout, arc_vertex), false, "1",
     "vertices of the refined scan along each arc, both ends included"},
    {"arc_node", PC_STORE_U32, 2, LAYOUT_ARCS, offsetof(pc_layout, arc_node), false, "1",
     "first and last node of each arc"},
    {"arc_cell", PC_STORE_U32, 2, LAYOUT_ARCS, offsetof(pc_layout, arc_cell), false, "1",
     "cell on the left and on the right of each arc, 4294967295 past a boundary"},
    {"cell_start", PC_STORE_U32, 0, LAYOUT_CELL_OFFSETS, offsetof(pc_layout, cell_start), false, "1",
     "where the sides of each cell begin in cell_side, and the end of the last"},
    {"cell_side", PC_STORE_U32, 0, LAYOUT_SIDES, offsetof(pc_layout, cell_side), false, "1",
     "counter-clockwise sides of each cell: 2*arc, +1 where the arc is run backwards"},
    {"cell_side_flat", PC_STORE_U8, 0, LAYOUT_SIDES, offsetof(pc_layout, cell_side_flat), false, "1",
     "per side: 1 where its first node is a T-junction on a straight side of this cell"},
};

pc_status pc_layout_save(pc_store *store, const char *group, const pc_layout *layout) {
    const size_t counts[] = {layout->mesh.vertex_count,
                             layout->mesh.face_count,
                             layout->node_count,
                             layout->arc_count,
                             (size_t)layout->arc_count + 1,
                             layout->arc_start[layout->arc_count],
                             (size_t)layout->cell_count + 1,
                             layout->cell_start[layout->cell_count]};
    return pc_columns_save(store, group, layout_columns, COUNT(layout_columns), layout, counts);
}

static pc_status check_layout(const pc_layout *l, const size_t *counts, pc_store *store, const char *group) {
    pc_status status = PC_OK;
    size_t vertices = counts[VERTICES], arcs = counts[LAYOUT_ARCS], nodes = counts[LAYOUT_NODES];
    size_t cells = counts[LAYOUT_CELL_OFFSETS] - 1;
    if (counts[LAYOUT_ARC_OFFSETS] != arcs + 1)
        PC_TRY(pc_fail(pc_store_context(store), PC_E_FORMAT, "%s: '%s/arc_start': %zu rows for %zu arcs",
                       pc_store_path(store), group, counts[LAYOUT_ARC_OFFSETS], arcs));
    PC_TRY(
        pc_columns_offsets(store, group, "arc_start", l->arc_start, arcs + 1, counts[LAYOUT_ARC_VERTICES]));
    PC_TRY(pc_columns_offsets(store, group, "cell_start", l->cell_start, counts[LAYOUT_CELL_OFFSETS],
                              counts[LAYOUT_SIDES]));
    PC_TRY(pc_columns_below(store, group, "triangle", l->mesh.triangle, 3 * counts[FACES], vertices, false));
    PC_TRY(pc_columns_below(store, group, "cell", l->cell, counts[FACES], cells, false));
    PC_TRY(pc_columns_below(store, group, "node_vertex", l->node_vertex, nodes, vertices, false));
    PC_TRY(pc_columns_below(store, group, "arc_vertex", l->arc_vertex, counts[LAYOUT_ARC_VERTICES], vertices,
                            false));
    PC_TRY(pc_columns_below(store, group, "arc_node", l->arc_node, 2 * arcs, nodes, false));
    PC_TRY(pc_columns_below(store, group, "arc_cell", l->arc_cell, 2 * arcs, cells, true));
    PC_TRY(pc_columns_below(store, group, "cell_side", l->cell_side, counts[LAYOUT_SIDES], 2 * arcs, false));
done:
    return status;
}

pc_status pc_layout_load(pc_layout *layout, pc_store *store, const char *group) {
    pc_status status = PC_OK;
    size_t counts[PC_COLUMN_COUNTS];
    for (int i = 0; i < PC_COLUMN_COUNTS; i++)
        counts[i] = PC_STORE_ANY;
    *layout = (pc_layout){0};
    PC_TRY(pc_columns_load(layout, counts, store, group, layout_columns, COUNT(layout_columns)));
    if (counts[LAYOUT_CELL_OFFSETS] == 0)
        PC_TRY(pc_columns_offsets(store, group, "cell_start", layout->cell_start, 0, 0));
    PC_TRY(check_layout(layout, counts, store, group));
    layout->mesh.vertex_count = (pc_index)counts[VERTICES];
    layout->mesh.face_count = (pc_index)counts[FACES];
    layout->node_count = (pc_index)counts[LAYOUT_NODES];
    layout->arc_count = (pc_index)counts[LAYOUT_ARCS];
    layout->cell_count = (pc_index)counts[LAYOUT_CELL_OFFSETS] - 1;
done:
    if (status != PC_OK) pc_layout_free(layout, pc_store_context(store));
    return status;
}

enum { POLY_OFFSETS = 1, POLY_CORNERS };

static const pc_column polymesh_columns[] = {
    {"position", PC_STORE_F64, 3, VERTICES, offsetof(pc_polymesh, position), false, "model",
     "position of each vertex, in the frame of the input"},
    {"start", PC_STORE_U32, 0, POLY_OFFSETS, offsetof(pc_polymesh, start), false, "1",
     "where the corners of each polygon begin in corner, and the end of the last"},
    {"corner", PC_STORE_U32, 0, POLY_CORNERS, offsetof(pc_polymesh, corner), false, "1",
     "vertices of each polygon, counter-clockwise seen from outside"},
    {"corner_flat", PC_STORE_U8, 0, POLY_CORNERS, offsetof(pc_polymesh, corner_flat), true, "1",
     "per corner: 1 where the vertex is a T-junction on a straight side of this polygon"},
};

pc_status pc_polymesh_save(pc_store *store, const char *group, const pc_polymesh *mesh) {
    const size_t counts[] = {mesh->vertex_count, (size_t)mesh->face_count + 1, mesh->start[mesh->face_count]};
    return pc_columns_save(store, group, polymesh_columns, COUNT(polymesh_columns), mesh, counts);
}

pc_status pc_polymesh_load(pc_polymesh *mesh, pc_store *store, const char *group) {
    pc_status status = PC_OK;
    size_t counts[] = {PC_STORE_ANY, PC_STORE_ANY, PC_STORE_ANY};
    *mesh = (pc_polymesh){0};
    PC_TRY(pc_columns_load(mesh, counts, store, group, polymesh_columns, COUNT(polymesh_columns)));
    PC_TRY(
        pc_columns_offsets(store, group, "start", mesh->start, counts[POLY_OFFSETS], counts[POLY_CORNERS]));
    PC_TRY(pc_columns_below(store, group, "corner", mesh->corner, counts[POLY_CORNERS], counts[VERTICES],
                            false));
    mesh->vertex_count = (pc_index)counts[VERTICES];
    mesh->face_count = (pc_index)counts[POLY_OFFSETS] - 1;
done:
    if (status != PC_OK) pc_polymesh_free(mesh, pc_store_context(store));
    return status;
}

pc_status pc_indices_save(pc_store *store, const char *name, const pc_index *list, size_t count,
                          const char *description) {
    return pc_store_put(store, name, PC_STORE_U32, 1, &count, list, "1", description);
}

pc_status pc_indices_load(pc_index **list, size_t *count, pc_store *store, const char *name) {
    return pc_store_get(list, store, name, PC_STORE_U32, 1, count);
}

pc_status pc_reals_save(pc_store *store, const char *name, const double *list, size_t count,
                        const char *units, const char *description) {
    return pc_store_put(store, name, PC_STORE_F64, 1, &count, list, units, description);
}

pc_status pc_reals_load(double **list, size_t *count, pc_store *store, const char *name) {
    return pc_store_get(list, store, name, PC_STORE_F64, 1, count);
}
