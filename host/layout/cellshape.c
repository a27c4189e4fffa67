#include "cellshape.h"
#include "memory.h"

static const double degrees = 180 / PC_PI;

pc_index pc_cell_corners(pc_index *corner, pc_index room, const pc_polymesh *mesh, pc_index f) {
    pc_index count = 0;
    for (pc_index c = mesh->start[f]; c < mesh->start[f + 1]; c++) {
        if (mesh->corner_flat && mesh->corner_flat[c]) continue;
        if (count < room) corner[count] = mesh->corner[c];
        count++;
    }
    return count;
}

pc_vec3 pc_face_normal(const pc_polymesh *mesh, pc_index f) {
    pc_vec3 sum = {0, 0, 0};
    pc_index first = mesh->start[f], end = mesh->start[f + 1];
    if (end - first < 3) return sum;
    pc_vec3 origin = pc_vec3_at(mesh->position, mesh->corner[first]);
    for (pc_index c = first + 1; c + 1 < end; c++)
        sum = pc_add(sum, pc_cross(pc_sub(pc_vec3_at(mesh->position, mesh->corner[c]), origin),
                                   pc_sub(pc_vec3_at(mesh->position, mesh->corner[c + 1]), origin)));
    return pc_scale(0.5, sum);
}

/* Values of the four-cornered cells, one after the other. */
typedef struct values {
    double *angle, *aspect, *jacobian, *warp;
    size_t count;
} values;

static void add_cell(values *out, const pc_vec3 p[4]) {
    pc_vec3 normal[4], sum = {0, 0, 0};
    double side[4], least = INFINITY;
    size_t n = out->count++;
    for (int k = 0; k < 4; k++) {
        pc_vec3 ahead = pc_sub(p[(k + 1) % 4], p[k]), back = pc_sub(p[(k + 3) % 4], p[k]);
        side[k] = pc_norm(ahead);
        normal[k] = pc_cross(ahead, back);
        sum = pc_add(sum, normal[k]);
        out->angle[4 * n + (size_t)k] = fabs(pc_angle(ahead, back) * degrees - 90);
    }
    sum = pc_unit(sum);
    for (int k = 0; k < 4; k++) {
        double product = side[k] * side[(k + 3) % 4];
        least = fmin(least, product > 0 ? pc_dot(normal[k], sum) / product : 0);
    }
    double x = side[0] + side[2], y = side[1] + side[3], small = fmin(x, y), large = fmax(x, y);
    out->jacobian[n] = least;
    out->aspect[n] = small > 1e-9 * large ? large / small : 1e9;
    out->warp[n] = fmax(pc_angle(normal[0], normal[2]), pc_angle(normal[1], normal[3])) * degrees;
}

static void collect_cells(values *out, const pc_polymesh *mesh) {
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_index corner[4];
        pc_vec3 p[4];
        if (pc_cell_corners(corner, 4, mesh, f) != 4) continue;
        for (int k = 0; k < 4; k++)
            p[k] = pc_vec3_at(mesh->position, corner[k]);
        add_cell(out, p);
    }
}

static pc_status measure_cells(pc_cellshape *shape, pc_context *ctx, const pc_polymesh *mesh) {
    pc_status status = PC_OK;
    values v = {0};
    PC_TRY(pc_new(&v.angle, ctx, 4 * (size_t)mesh->face_count));
    PC_TRY(pc_new(&v.aspect, ctx, mesh->face_count));
    PC_TRY(pc_new(&v.jacobian, ctx, mesh->face_count));
    PC_TRY(pc_new(&v.warp, ctx, mesh->face_count));
    collect_cells(&v, mesh);
    for (size_t i = 0; i < v.count; i++)
        shape->folded_cells += v.jacobian[i] <= 0;
    shape->angle = pc_spread_of(v.angle, 4 * v.count);
    shape->aspect = pc_spread_of(v.aspect, v.count);
    shape->scaled_jacobian = pc_spread_of(v.jacobian, v.count);
    shape->warp = pc_spread_of(v.warp, v.count);
done:
    pc_free(ctx, v.angle);
    pc_free(ctx, v.aspect);
    pc_free(ctx, v.jacobian);
    pc_free(ctx, v.warp);
    return status;
}

static pc_status measure_edges(pc_cellshape *shape, pc_context *ctx, const pc_polymesh *mesh,
                               const pc_polygraph *graph) {
    pc_status status = PC_OK;
    double *length = NULL, square = 0;
    size_t count = 0;
    PC_TRY(pc_new(&length, ctx, graph->corner_count));
    for (pc_index f = 0; f < mesh->face_count; f++)
        for (pc_index c = mesh->start[f]; c < mesh->start[f + 1]; c++) {
            pc_index next = pc_polymesh_next(mesh, f, c);
            if (graph->twin[c] != PC_NONE && graph->twin[c] < c) continue;
            length[count++] = pc_distance(pc_vec3_at(mesh->position, mesh->corner[c]),
                                          pc_vec3_at(mesh->position, mesh->corner[next]));
        }
    shape->edge_length = pc_spread_of(length, count);
    double mean = shape->edge_length.mean;
    for (size_t i = 0; i < count; i++)
        square += (length[i] - mean) * (length[i] - mean);
    shape->edge_deviation = mean > 0 ? sqrt(square / (double)count) / mean : 0;
done:
    pc_free(ctx, length);
    return status;
}

pc_status pc_cellshape_measure(pc_cellshape *shape, pc_context *ctx, const pc_polymesh *mesh,
                               const pc_polygraph *graph) {
    pc_status status = PC_OK;
    *shape = (pc_cellshape){0};
    PC_TRY(measure_cells(shape, ctx, mesh));
    PC_TRY(measure_edges(shape, ctx, mesh, graph));
done:
    return status;
}
