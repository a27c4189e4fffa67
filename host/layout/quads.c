#include "quads.h"
#include "bvh.h"
#include "memory.h"

static pc_vec3 arc_middle(const pc_layout *l, pc_index arc) {
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

static pc_status split_cells(pc_polymesh *quads, pc_context *ctx, const pc_layout *l) {
    pc_index sides = l->cell_start[l->cell_count], first_middle = l->node_count;
    pc_index first_centre = first_middle + l->arc_count;
    pc_status status = PC_OK;
    PC_TRY(pc_polymesh_make(quads, ctx, (size_t)first_centre + l->cell_count, sides, 4 * (size_t)sides));
    for (pc_index n = 0; n < l->node_count; n++)
        pc_vec3_put(quads->position, n, pc_vec3_at(l->mesh.position, l->node_vertex[n]));
    for (pc_index a = 0; a < l->arc_count; a++)
        pc_vec3_put(quads->position, first_middle + a, arc_middle(l, a));
    PC_TRY(place_centres(quads->position + 3 * (size_t)first_centre, ctx, l,
                         quads->position + 3 * (size_t)first_middle));
    for (pc_index c = 0; c < l->cell_count; c++)
        for (pc_index i = l->cell_start[c], from = i, to = l->cell_start[c + 1]; i < to; i++) {
            pc_index side = l->cell_side[i], before = l->cell_side[i == from ? to - 1 : i - 1];
            pc_index *corner = quads->corner + 4 * (size_t)i;
            corner[0] = l->arc_node[side];
            corner[1] = first_middle + side / 2;
            corner[2] = first_centre + c;
            corner[3] = first_middle + before / 2;
            quads->start[i] = 4 * i;
        }
    quads->start[sides] = 4 * sides;
done:
    return status;
}

/* Arcs that need a vertex in their middle: those that share both nodes with another arc, those of 1- and 2-gons. */
static pc_status find_doubled_arcs(uint8_t *doubled, pc_context *ctx, const pc_layout *l) {
    pc_status status = PC_OK;
    pc_index *start = NULL, *list = NULL;
    PC_TRY(pc_new(&start, ctx, (size_t)l->node_count + 2));
    PC_TRY(pc_new(&list, ctx, l->arc_count));
    for (pc_index a = 0; a < l->arc_count; a++) {
        pc_index p = l->arc_node[2 * a], q = l->arc_node[2 * a + 1];
        start[(p < q ? p : q) + 2]++;
    }
    for (pc_index n = 0; n < l->node_count; n++)
        start[n + 2] += start[n + 1];
    for (pc_index a = 0; a < l->arc_count; a++) {
        pc_index p = l->arc_node[2 * a], q = l->arc_node[2 * a + 1];
        list[start[(p < q ? p : q) + 1]++] = a;
    }
    for (pc_index n = 0; n < l->node_count; n++)
        for (pc_index i = start[n]; i < start[n + 1]; i++)
            for (pc_index j = i + 1; j < start[n + 1]; j++) {
                const pc_index *p = l->arc_node + 2 * (size_t)list[i], *q = l->arc_node + 2 * (size_t)list[j];
                if (p[0] + p[1] == q[0] + q[1]) doubled[list[i]] = doubled[list[j]] = 1;
            }
    for (pc_index c = 0; c < l->cell_count; c++)
        for (pc_index i = l->cell_start[c]; l->cell_start[c + 1] - l->cell_start[c] < 3 && i < l->cell_start[c + 1]; i++)
            doubled[l->cell_side[i] / 2] = 1;
done:
    pc_free(ctx, start);
    pc_free(ctx, list);
    return status;
}

static pc_status keep_cells(pc_polymesh *quads, pc_context *ctx, const pc_layout *l) {
    pc_status status = PC_OK;
    uint8_t *doubled = NULL;
    pc_index *middle = NULL, vertices = l->node_count;
    size_t corners = l->cell_start[l->cell_count];
    PC_TRY(pc_new(&doubled, ctx, l->arc_count));
    PC_TRY(pc_new(&middle, ctx, l->arc_count));
    PC_TRY(find_doubled_arcs(doubled, ctx, l));
    for (pc_index a = 0; a < l->arc_count; a++) {
        middle[a] = doubled[a] ? vertices++ : PC_NONE;
        if (doubled[a]) corners += (l->arc_cell[2 * a] != PC_NONE) + (l->arc_cell[2 * a + 1] != PC_NONE);
    }
    PC_TRY(pc_polymesh_make(quads, ctx, vertices, l->cell_count, corners));
    for (pc_index n = 0; n < l->node_count; n++)
        pc_vec3_put(quads->position, n, pc_vec3_at(l->mesh.position, l->node_vertex[n]));
    for (pc_index a = 0; a < l->arc_count; a++)
        if (middle[a] != PC_NONE) pc_vec3_put(quads->position, middle[a], arc_middle(l, a));
    pc_index at = 0;
    for (pc_index c = 0; c < l->cell_count; c++) {
        for (pc_index i = l->cell_start[c]; i < l->cell_start[c + 1]; i++) {
            pc_index side = l->cell_side[i];
            quads->corner[at] = l->arc_node[side];
            quads->corner_flat[at++] = l->cell_side_flat[i];
            if (middle[side / 2] == PC_NONE) continue;
            quads->corner[at] = middle[side / 2];
            quads->corner_flat[at++] = 1;
        }
        quads->start[c + 1] = at;
    }
done:
    pc_free(ctx, doubled);
    pc_free(ctx, middle);
    return status;
}

pc_status pc_quads_make(pc_polymesh *quads, pc_context *ctx, const pc_layout *layout, pc_ngons ngons) {
    *quads = (pc_polymesh){0};
    pc_status status =
        ngons == PC_NGONS_SPLIT ? split_cells(quads, ctx, layout) : keep_cells(quads, ctx, layout);
    if (status != PC_OK) pc_polymesh_free(quads, ctx);
    return status;
}

size_t pc_quads_count(const pc_layout *layout, pc_ngons ngons) {
    return ngons == PC_NGONS_SPLIT ? layout->cell_start[layout->cell_count] : layout->cell_count;
}
