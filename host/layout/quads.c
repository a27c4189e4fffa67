#include "quads.h"
#include "bvh.h"
#include "memory.h"
#include "mosaic.h"

pc_vec3 pc_layout_arc_middle(const pc_layout *l, pc_index arc) {
    const pc_index *v = l->arc_vertex + l->arc_start[arc];
    pc_index count = l->arc_start[arc + 1] - l->arc_start[arc];
    double length = 0;
    for (pc_index i = 1; i < count; i++)
        length += pc_distance(pc_vec3_at(l->mesh.position, v[i - 1]), pc_vec3_at(l->mesh.position, v[i]));
    double left = length / 2;
    for (pc_index i = 1; i < count; i++) {
        pc_vec3 p = pc_vec3_at(l->mesh.position, v[i - 1]), q = pc_vec3_at(l->mesh.position, v[i]);
        double piece = pc_distance(p, q);
        if (piece >= left && piece > 0) return pc_madd(p, left / piece, pc_sub(q, p));
        left -= piece;
    }
    return pc_vec3_at(l->mesh.position, v[count / 2]);
}

/* Per cell the point of its own surface nearest to the mean of its side middles. */
static pc_status place_centres(double *centre, pc_context *ctx, const pc_layout *l, const double *middle) {
    pc_status status = PC_OK;
    double *best = NULL, *target = NULL;
    PC_TRY(pc_new(&best, ctx, l->cell_count));
    PC_TRY(pc_new(&target, ctx, 3 * (size_t)l->cell_count));
    for (pc_index c = 0; c < l->cell_count; c++) {
        pc_vec3 sum = {0, 0, 0};
        for (pc_index i = l->cell_start[c]; i < l->cell_start[c + 1]; i++)
            sum = pc_add(sum, pc_vec3_at(middle, l->cell_side[i] / 2));
        pc_vec3_put(target, c, pc_scale(1.0 / (l->cell_start[c + 1] - l->cell_start[c]), sum));
        best[c] = INFINITY;
    }
    for (pc_index f = 0; f < l->mesh.face_count; f++) {
        const pc_index *t = l->mesh.triangle + 3 * (size_t)f;
        pc_index c = l->cell[f];
        pc_vec3 goal = pc_vec3_at(target, c);
        pc_vec3 p[3] = {pc_vec3_at(l->mesh.position, t[0]), pc_vec3_at(l->mesh.position, t[1]),
                        pc_vec3_at(l->mesh.position, t[2])};
        double weight[3], distance = pc_closest_on_triangle(weight, goal, p[0], p[1], p[2]);
        if (distance >= best[c]) continue;
        best[c] = distance;
        pc_vec3_put(centre, c, pc_madd(pc_madd(pc_scale(weight[0], p[0]), weight[1], p[1]), weight[2], p[2]));
    }
done:
    pc_free(ctx, best);
    pc_free(ctx, target);
    return status;
}

/* Quads around the centre of each cell; nodes come first, then middles of arcs, then centres. */
static void split_cells(pc_polymesh *quads, const pc_layout *l) {
    pc_index at = 0, face = 0, middle = l->node_count, centre = l->node_count + l->arc_count;
    for (pc_index cell = 0; cell < l->cell_count; cell++)
        for (pc_index from = l->cell_start[cell], to = l->cell_start[cell + 1], i = from; i < to; i++) {
            pc_index side = l->cell_side[i], before = l->cell_side[i == from ? to - 1 : i - 1];
            pc_index *corner = quads->corner + at;
            corner[0] = l->arc_node[side];
            corner[1] = middle + side / 2;
            corner[2] = centre + cell;
            corner[3] = middle + before / 2;
            at += 4;
            quads->start[++face] = at;
        }
}

static pc_status split(pc_polymesh *quads, pc_context *ctx, const pc_layout *l) {
    pc_status status = PC_OK;
    size_t faces = l->cell_start[l->cell_count];
    *quads = (pc_polymesh){0};
    PC_TRY(
        pc_polymesh_make(quads, ctx, (size_t)l->node_count + l->arc_count + l->cell_count, faces, 4 * faces));
    for (pc_index n = 0; n < l->node_count; n++)
        pc_vec3_put(quads->position, n, pc_vec3_at(l->mesh.position, l->node_vertex[n]));
    double *middle = quads->position + 3 * (size_t)l->node_count;
    for (pc_index a = 0; a < l->arc_count; a++)
        pc_vec3_put(middle, a, pc_layout_arc_middle(l, a));
    PC_TRY(place_centres(middle + 3 * (size_t)l->arc_count, ctx, l, middle));
    split_cells(quads, l);
done:
    if (status != PC_OK) pc_polymesh_free(quads, ctx);
    return status;
}

static pc_status keep(pc_polymesh *quads, pc_context *ctx, const pc_layout *l) {
    pc_mosaic mosaic;
    pc_index gone;
    pc_status status = pc_mosaic_make(&mosaic, ctx, l);
    if (status != PC_OK) return status;
    pc_mosaic_mend(&mosaic);
    PC_TRY(pc_mosaic_drop_lines(&mosaic, &gone, ctx, PC_MOSAIC_LONGEST, PC_MOSAIC_SLIMMEST));
    PC_TRY(pc_mosaic_polygons(quads, NULL, ctx, &mosaic));
done:
    pc_mosaic_free(&mosaic, ctx);
    return status;
}

pc_status pc_quads_make(pc_polymesh *quads, pc_context *ctx, const pc_layout *layout, pc_ngons ngons) {
    return ngons == PC_NGONS_SPLIT ? split(quads, ctx, layout) : keep(quads, ctx, layout);
}

size_t pc_quads_count(const pc_layout *layout, pc_ngons ngons) {
    return ngons == PC_NGONS_SPLIT ? layout->cell_start[layout->cell_count] : layout->cell_count;
}
