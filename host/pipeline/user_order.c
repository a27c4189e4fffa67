#include "user_order.h"
#include "memory.h"
#include <string.h>

pc_renumbering pc_to_user_order(const pc_held_mesh *mesh) {
    const pc_order *order = &mesh->order;
    return (pc_renumbering){.vertex_count = order->vertex_count,
                            .face_count = order->face_count,
                            .loop_count = mesh->loop_count,
                            .vertex = order->vertex_new,
                            .face = order->face_new,
                            .loop = mesh->loop_new,
                            .vertex_place = order->vertex_old,
                            .face_place = order->face_old};
}

pc_renumbering pc_from_user_order(const pc_held_mesh *mesh) {
    const pc_order *order = &mesh->order;
    return (pc_renumbering){.vertex_count = order->vertex_count,
                            .face_count = order->face_count,
                            .loop_count = mesh->loop_count,
                            .vertex = order->vertex_old,
                            .face = order->face_old,
                            .loop = mesh->loop_old,
                            .vertex_place = order->vertex_new,
                            .face_place = order->face_new};
}

/* A new array whose row i is row map[i] of `in`; NULL stays NULL. */
static pc_status gather_rows(void **out, pc_context *ctx, const void *in, size_t row_bytes,
                             const pc_index *map, size_t count) {
    *out = NULL;
    if (!in) return PC_OK;
    pc_status status = pc_alloc_bytes(out, ctx, count, row_bytes);
    if (status != PC_OK) return status;
    const char *from = in;
    char *to = *out;
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < count; i++)
        memcpy(to + i * row_bytes, from + map[i] * row_bytes, row_bytes);
    return PC_OK;
}

static pc_status copy_bytes(void **out, pc_context *ctx, const void *in, size_t bytes) {
    pc_status status = pc_alloc_bytes(out, ctx, bytes, 1);
    if (status == PC_OK) memcpy(*out, in, bytes);
    return status;
}

/* Rows of `width` elements of the array `member` of in, gathered into out. */
#define GATHER(member, width, map, count)                                                                    \
    gather_rows((void **)&out->member, ctx, in->member, (width) * sizeof *in->member, map, count)
#define COPY(member, count) copy_bytes((void **)&out->member, ctx, in->member, (count) * sizeof *in->member)

pc_status pc_renumber_mesh(pc_mesh *out, pc_context *ctx, const pc_mesh *in, const pc_renumbering *r) {
    pc_status status = PC_OK;
    *out = (pc_mesh){.vertex_count = in->vertex_count, .face_count = in->face_count};
    PC_TRY(GATHER(position, 3, r->vertex, r->vertex_count));
    PC_TRY(GATHER(triangle, 3, r->face, r->face_count));
#pragma omp parallel for schedule(static)
    for (size_t c = 0; c < 3 * (size_t)out->face_count; c++)
        out->triangle[c] = r->vertex_place[out->triangle[c]];
done:
    if (status != PC_OK) pc_mesh_free(out, ctx);
    return status;
}

pc_status pc_renumber_curvature(pc_curvature *out, pc_context *ctx, const pc_curvature *in,
                                const pc_renumbering *r) {
    pc_status status = PC_OK;
    *out = *in;
    out->normal = out->tensor = out->value = out->direction = out->weight = NULL;
    PC_TRY(GATHER(normal, 3, r->vertex, r->vertex_count));
    PC_TRY(GATHER(tensor, 6, r->vertex, r->vertex_count));
    PC_TRY(GATHER(value, 2, r->vertex, r->vertex_count));
    PC_TRY(GATHER(direction, 3, r->vertex, r->vertex_count));
    PC_TRY(GATHER(weight, 1, r->vertex, r->vertex_count));
done:
    if (status != PC_OK) pc_curvature_free(out, ctx);
    return status;
}

pc_status pc_renumber_field(pc_field *out, pc_context *ctx, const pc_field *in, const pc_renumbering *r) {
    pc_status status = PC_OK;
    *out = *in;
    out->normal = out->direction = out->angle = NULL;
    out->index = NULL, out->loop_index = NULL, out->turn = NULL;
    PC_TRY(GATHER(normal, 3, r->vertex, r->vertex_count));
    PC_TRY(GATHER(direction, 3, r->vertex, r->vertex_count));
    PC_TRY(GATHER(angle, 1, r->vertex, r->vertex_count));
    PC_TRY(GATHER(index, 1, r->face, r->face_count));
    PC_TRY(GATHER(turn, 3, r->face, r->face_count));
    PC_TRY(GATHER(loop_index, 1, r->loop, in->loop_count));
done:
    if (status != PC_OK) pc_field_free(out, ctx);
    return status;
}

pc_status pc_renumber_param(pc_param *out, pc_context *ctx, const pc_param *in, const pc_renumbering *r) {
    pc_status status = PC_OK;
    *out = *in;
    out->phase = NULL, out->coordinate = NULL, out->turn = NULL, out->shift = NULL, out->singular = NULL;
    PC_TRY(GATHER(phase, 4, r->vertex, r->vertex_count));
    PC_TRY(GATHER(coordinate, 2, r->vertex, r->vertex_count));
    PC_TRY(GATHER(turn, 3, r->face, r->face_count));
    PC_TRY(GATHER(shift, 6, r->face, r->face_count));
    PC_TRY(GATHER(singular, 1, r->face, r->face_count));
done:
    if (status != PC_OK) pc_param_free(out, ctx);
    return status;
}

static void replace_vertices(pc_index *list, size_t count, const pc_renumbering *r) {
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < count; i++)
        if (list[i] < r->vertex_count) list[i] = r->vertex_place[list[i]];
}

static pc_status renumber_layout_mesh(pc_layout *out, pc_context *ctx, const pc_layout *in,
                                      const pc_renumbering *r) {
    pc_status status = PC_OK;
    const pc_mesh *mesh = &in->mesh;
    PC_TRY(pc_mesh_copy(&out->mesh, ctx, mesh));
    for (size_t v = 0; v < r->vertex_count; v++)
        memcpy(out->mesh.position + 3 * v, mesh->position + 3 * (size_t)r->vertex[v], 3 * sizeof(double));
    replace_vertices(out->mesh.triangle, 3 * (size_t)mesh->face_count, r);
    PC_TRY(COPY(source_face, mesh->face_count));
    for (size_t f = 0; f < mesh->face_count; f++)
        out->source_face[f] = r->face_place[out->source_face[f]];
    PC_TRY(COPY(cell, mesh->face_count));
done:
    return status;
}

pc_status pc_renumber_layout(pc_layout *out, pc_context *ctx, const pc_layout *in, const pc_renumbering *r) {
    pc_status status = PC_OK;
    *out =
        (pc_layout){.node_count = in->node_count, .arc_count = in->arc_count, .cell_count = in->cell_count};
    const size_t arc_vertices = in->arc_start[in->arc_count], sides = in->cell_start[in->cell_count];
    PC_TRY(renumber_layout_mesh(out, ctx, in, r));
    PC_TRY(COPY(node_vertex, in->node_count));
    replace_vertices(out->node_vertex, in->node_count, r);
    PC_TRY(COPY(arc_start, (size_t)in->arc_count + 1));
    PC_TRY(COPY(arc_vertex, arc_vertices));
    replace_vertices(out->arc_vertex, arc_vertices, r);
    PC_TRY(COPY(arc_node, 2 * (size_t)in->arc_count));
    PC_TRY(COPY(arc_cell, 2 * (size_t)in->arc_count));
    PC_TRY(COPY(cell_start, (size_t)in->cell_count + 1));
    PC_TRY(COPY(cell_side, sides));
    PC_TRY(COPY(cell_side_flat, sides));
done:
    if (status != PC_OK) pc_layout_free(out, ctx);
    return status;
}

pc_status pc_renumber_reals(double **out, pc_context *ctx, const double *in, const pc_renumbering *r) {
    return gather_rows((void **)out, ctx, in, sizeof *in, r->vertex, r->vertex_count);
}

pc_status pc_renumber_indices(pc_index **out, pc_context *ctx, const pc_index *in, const pc_renumbering *r) {
    return gather_rows((void **)out, ctx, in, sizeof *in, r->vertex, r->vertex_count);
}
