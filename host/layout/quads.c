#include "quads.h"
#include "bvh.h"
#include "memory.h"
#include <string.h>

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

/* Whether the rim of a cell comes by the same node twice: it would be no polygon, and is split around its
 * centre. */
static bool is_pinched(const pc_layout *l, pc_index cell) {
    pc_index from = l->cell_start[cell], to = l->cell_start[cell + 1];
    for (pc_index i = from; i < to; i++)
        for (pc_index k = i + 1; k < to; k++)
            if (l->arc_node[l->cell_side[i]] == l->arc_node[l->cell_side[k]]) return true;
    return false;
}

/* Arcs that need a vertex in their middle: those that share both nodes with another arc, those of 1- and
 * 2-gons and of cells that are split. */
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
        if (l->cell_start[c + 1] - l->cell_start[c] < 3 || is_pinched(l, c))
            for (pc_index i = l->cell_start[c]; i < l->cell_start[c + 1]; i++)
                doubled[l->cell_side[i] / 2] = 1;
done:
    pc_free(ctx, start);
    pc_free(ctx, list);
    return status;
}

/* Quads around a centre for one cell, from corner *at and face *face on. */
static void split_cell(pc_polymesh *quads, pc_index *at, pc_index *face, const pc_layout *l, pc_index cell,
                       const pc_index *middle, pc_index centre) {
    for (pc_index from = l->cell_start[cell], to = l->cell_start[cell + 1], i = from; i < to; i++) {
        pc_index side = l->cell_side[i], before = l->cell_side[i == from ? to - 1 : i - 1];
        pc_index *corner = quads->corner + *at;
        corner[0] = l->arc_node[side];
        corner[1] = middle[side / 2];
        corner[2] = centre;
        corner[3] = middle[before / 2];
        *at += 4;
        quads->start[++*face] = *at;
    }
}

/* The cell itself, the middles of its sides listed as flat corners. */
static void keep_cell(pc_polymesh *quads, pc_index *at, pc_index *face, const pc_layout *l, pc_index cell,
                      const pc_index *middle) {
    for (pc_index i = l->cell_start[cell]; i < l->cell_start[cell + 1]; i++) {
        pc_index side = l->cell_side[i];
        quads->corner[*at] = l->arc_node[side];
        quads->corner_flat[(*at)++] = l->cell_side_flat[i];
        if (middle[side / 2] == PC_NONE) continue;
        quads->corner[*at] = middle[side / 2];
        quads->corner_flat[(*at)++] = 1;
    }
    quads->start[++*face] = *at;
}

/* What becomes of a layout: which arcs get a vertex in their middle, which cells are split around a centre.
 */
typedef struct plan {
    pc_index *middle; /* per arc, PC_NONE */
    pc_index *centre; /* per cell, PC_NONE */
    size_t vertices, faces, corners;
} plan;

static void count_cells(plan *p, const pc_layout *l) {
    p->faces = p->corners = 0;
    for (pc_index c = 0; c < l->cell_count; c++) {
        pc_index sides = l->cell_start[c + 1] - l->cell_start[c];
        p->faces += p->centre[c] == PC_NONE ? 1 : sides;
        p->corners += p->centre[c] == PC_NONE ? sides : 4 * (size_t)sides;
        for (pc_index i = l->cell_start[c]; p->centre[c] == PC_NONE && i < l->cell_start[c + 1]; i++)
            p->corners += p->middle[l->cell_side[i] / 2] != PC_NONE;
    }
}

static pc_status make_plan(plan *p, pc_context *ctx, const pc_layout *l, pc_ngons ngons) {
    pc_status status = PC_OK;
    uint8_t *doubled = NULL;
    pc_index vertices = l->node_count;
    PC_TRY(pc_new(&p->middle, ctx, l->arc_count));
    PC_TRY(pc_new(&p->centre, ctx, l->cell_count));
    PC_TRY(pc_new(&doubled, ctx, l->arc_count));
    if (ngons == PC_NGONS_SPLIT)
        memset(doubled, 1, l->arc_count);
    else
        PC_TRY(find_doubled_arcs(doubled, ctx, l));
    for (pc_index a = 0; a < l->arc_count; a++)
        p->middle[a] = doubled[a] ? vertices++ : PC_NONE;
    for (pc_index c = 0; c < l->cell_count; c++)
        p->centre[c] = ngons == PC_NGONS_SPLIT || is_pinched(l, c) ? vertices++ : PC_NONE;
    p->vertices = vertices;
    count_cells(p, l);
done:
    pc_free(ctx, doubled);
    return status;
}

static pc_status place_vertices(pc_polymesh *quads, pc_context *ctx, const pc_layout *l, const plan *p) {
    pc_status status = PC_OK;
    double *middle = NULL, *centre = NULL;
    PC_TRY(pc_new(&middle, ctx, 3 * (size_t)l->arc_count));
    PC_TRY(pc_new(&centre, ctx, 3 * (size_t)l->cell_count));
    for (pc_index n = 0; n < l->node_count; n++)
        pc_vec3_put(quads->position, n, pc_vec3_at(l->mesh.position, l->node_vertex[n]));
    for (pc_index a = 0; a < l->arc_count; a++) {
        pc_vec3_put(middle, a, arc_middle(l, a));
        if (p->middle[a] != PC_NONE) pc_vec3_put(quads->position, p->middle[a], pc_vec3_at(middle, a));
    }
    PC_TRY(place_centres(centre, ctx, l, middle));
    for (pc_index c = 0; c < l->cell_count; c++)
        if (p->centre[c] != PC_NONE) pc_vec3_put(quads->position, p->centre[c], pc_vec3_at(centre, c));
done:
    pc_free(ctx, middle);
    pc_free(ctx, centre);
    return status;
}

pc_status pc_quads_make(pc_polymesh *quads, pc_context *ctx, const pc_layout *layout, pc_ngons ngons) {
    pc_status status = PC_OK;
    plan p = {0};
    pc_index at = 0, face = 0;
    *quads = (pc_polymesh){0};
    PC_TRY(make_plan(&p, ctx, layout, ngons));
    PC_TRY(pc_polymesh_make(quads, ctx, p.vertices, p.faces, p.corners));
    PC_TRY(place_vertices(quads, ctx, layout, &p));
    for (pc_index c = 0; c < layout->cell_count; c++)
        if (p.centre[c] == PC_NONE)
            keep_cell(quads, &at, &face, layout, c, p.middle);
        else
            split_cell(quads, &at, &face, layout, c, p.middle, p.centre[c]);
done:
    pc_free(ctx, p.middle);
    pc_free(ctx, p.centre);
    if (status != PC_OK) pc_polymesh_free(quads, ctx);
    return status;
}

size_t pc_quads_count(const pc_layout *layout, pc_ngons ngons) {
    size_t count = 0;
    if (ngons == PC_NGONS_SPLIT) return layout->cell_start[layout->cell_count];
    for (pc_index c = 0; c < layout->cell_count; c++)
        count += is_pinched(layout, c) ? layout->cell_start[c + 1] - layout->cell_start[c] : 1;
    return count;
}
