#include "bvh.h"
#include "memory.h"
#include "mosaic.h"
#include "quads.h"
#include <string.h>

/* What becomes of a mosaic: which nodes are left, which arcs get a vertex in their middle, which cells are
 * split around a centre. */
typedef struct plan {
    pc_index *vertex; /* per node, PC_NONE */
    pc_index *middle; /* per arc, PC_NONE */
    pc_index *centre; /* per cell, PC_NONE */
    size_t vertices, faces, corners;
    bool splits; /* some cell is split */
} plan;

static bool is_there(const pc_mosaic *m, pc_index arc) {
    return m->tail[2 * arc] != PC_NONE;
}

/* Arcs that share both nodes with another arc. */
static pc_status mark_doubled(uint8_t *doubled, pc_context *ctx, const pc_mosaic *m) {
    pc_status status = PC_OK;
    pc_index *start = NULL, *list = NULL;
    PC_TRY(pc_new(&start, ctx, (size_t)m->node_count + 2));
    PC_TRY(pc_new(&list, ctx, m->arc_count));
    for (pc_index a = 0; a < m->arc_count; a++)
        if (is_there(m, a))
            start[(m->tail[2 * a] < m->tail[2 * a + 1] ? m->tail[2 * a] : m->tail[2 * a + 1]) + 2]++;
    for (pc_index n = 0; n < m->node_count; n++)
        start[n + 2] += start[n + 1];
    for (pc_index a = 0; a < m->arc_count; a++)
        if (is_there(m, a))
            list[start[(m->tail[2 * a] < m->tail[2 * a + 1] ? m->tail[2 * a] : m->tail[2 * a + 1]) + 1]++] =
                a;
    for (pc_index n = 0; n < m->node_count; n++)
        for (pc_index i = start[n]; i < start[n + 1]; i++)
            for (pc_index j = i + 1; j < start[n + 1]; j++) {
                const pc_index *p = m->tail + 2 * (size_t)list[i], *q = m->tail + 2 * (size_t)list[j];
                if (p[0] + p[1] == q[0] + q[1]) doubled[list[i]] = doubled[list[j]] = 1;
            }
done:
    pc_free(ctx, start);
    pc_free(ctx, list);
    return status;
}

static pc_status make_plan(plan *p, pc_context *ctx, const pc_mosaic *m) {
    pc_status status = PC_OK;
    uint8_t *doubled = NULL;
    pc_index vertices = 0;
    PC_TRY(pc_new(&p->vertex, ctx, m->node_count));
    PC_TRY(pc_new(&p->middle, ctx, m->arc_count));
    PC_TRY(pc_new(&p->centre, ctx, m->cell_count));
    PC_TRY(pc_new(&doubled, ctx, m->arc_count));
    PC_TRY(mark_doubled(doubled, ctx, m));
    for (pc_index n = 0; n < m->node_count; n++)
        p->vertex[n] = m->degree[n] ? vertices++ : PC_NONE;
    for (pc_index c = 0; c < m->cell_count; c++) {
        p->centre[c] = PC_NONE;
        if (m->first[c] == PC_NONE) continue;
        pc_index sides = pc_mosaic_side_count(m, c), s = m->first[c];
        bool split = pc_mosaic_is_pinched(m, c);
        if (split) p->centre[c] = 0, p->splits = true;
        p->faces += split ? sides : 1;
        p->corners += split ? 4 * (size_t)sides : sides;
        for (pc_index k = 0; k < sides && (split || sides < 3); k++, s = m->next[s])
            doubled[s / 2] = 1;
    }
    for (pc_index a = 0; a < m->arc_count; a++) {
        p->middle[a] = doubled[a] ? vertices++ : PC_NONE;
        for (pc_index s = 2 * a; doubled[a] && s < 2 * a + 2; s++)
            p->corners += m->cell[s] != PC_NONE && p->centre[m->cell[s]] == PC_NONE;
    }
    for (pc_index c = 0; c < m->cell_count; c++)
        if (p->centre[c] != PC_NONE) p->centre[c] = vertices++;
    p->vertices = vertices;
done:
    pc_free(ctx, doubled);
    return status;
}

static pc_vec3 middle_of(const pc_mosaic *m, pc_index arc) {
    if (m->via[arc] == PC_NONE) return pc_layout_arc_middle(m->layout, arc);
    return pc_vec3_at(m->layout->mesh.position, m->layout->node_vertex[m->via[arc]]);
}

static pc_index owner(const pc_mosaic *m, pc_index cell) {
    while (m->joined[cell] != cell)
        cell = m->joined[cell];
    return cell;
}

/* Per cell that is split the point of its own surface nearest to the mean of its side middles. */
static pc_status place_centres(double *position, pc_context *ctx, const pc_mosaic *m, const plan *p) {
    pc_status status = PC_OK;
    const pc_mesh *mesh = &m->layout->mesh;
    double *best = NULL, *target = NULL;
    PC_TRY(pc_new(&best, ctx, m->cell_count));
    PC_TRY(pc_new(&target, ctx, 3 * (size_t)m->cell_count));
    for (pc_index c = 0; c < m->cell_count; c++) {
        pc_vec3 sum = {0, 0, 0};
        if (p->centre[c] == PC_NONE) continue;
        pc_index sides = pc_mosaic_side_count(m, c), s = m->first[c];
        for (pc_index k = 0; k < sides; k++, s = m->next[s])
            sum = pc_add(sum, middle_of(m, s / 2));
        pc_vec3_put(target, c, pc_scale(1.0 / sides, sum));
        best[c] = INFINITY;
    }
    for (pc_index f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        pc_index c = owner(m, m->layout->cell[f]);
        if (p->centre[c] == PC_NONE) continue;
        pc_vec3 q[3] = {pc_vec3_at(mesh->position, t[0]), pc_vec3_at(mesh->position, t[1]),
                        pc_vec3_at(mesh->position, t[2])};
        double weight[3];
        double distance = pc_closest_on_triangle(weight, pc_vec3_at(target, c), q[0], q[1], q[2]);
        if (distance >= best[c]) continue;
        best[c] = distance;
        pc_vec3 point = pc_madd(pc_madd(pc_scale(weight[0], q[0]), weight[1], q[1]), weight[2], q[2]);
        pc_vec3_put(position, p->centre[c], point);
    }
done:
    pc_free(ctx, best);
    pc_free(ctx, target);
    return status;
}

static void add_corner(pc_polymesh *polygons, pc_index *at, pc_index vertex, bool flat) {
    polygons->corner[*at] = vertex;
    polygons->corner_flat[(*at)++] = flat;
}

/* The cell itself, the middles of its sides listed as flat corners; of what has fewer than three corners all
 * vertices are corners. */
static void keep_cell(pc_polymesh *polygons, pc_index *at, const pc_mosaic *m, const plan *p, pc_index cell) {
    pc_index sides = pc_mosaic_side_count(m, cell), s = m->first[cell], corners = 0;
    for (pc_index k = 0; k < sides; k++, s = m->next[s])
        corners += !pc_mosaic_is_flat(m, s);
    for (pc_index k = 0; k < sides; k++, s = m->next[s]) {
        add_corner(polygons, at, p->vertex[m->tail[s]], corners > 2 && pc_mosaic_is_flat(m, s));
        if (p->middle[s / 2] != PC_NONE) add_corner(polygons, at, p->middle[s / 2], corners > 2);
    }
}

static void write_cells(pc_polymesh *polygons, pc_index *face_cell, const pc_mosaic *m, const plan *p) {
    pc_index at = 0, face = 0;
    for (pc_index c = 0; c < m->cell_count; c++) {
        pc_index s = m->first[c];
        if (s == PC_NONE) continue;
        pc_index faces = p->centre[c] == PC_NONE ? 1 : pc_mosaic_side_count(m, c);
        for (pc_index k = 0; k < faces; k++, s = m->next[s]) {
            if (p->centre[c] == PC_NONE) {
                keep_cell(polygons, &at, m, p, c);
            } else {
                add_corner(polygons, &at, p->vertex[m->tail[s]], false);
                add_corner(polygons, &at, p->middle[s / 2], false);
                add_corner(polygons, &at, p->centre[c], false);
                add_corner(polygons, &at, p->middle[m->prev[s] / 2], false);
            }
            if (face_cell) face_cell[face] = c;
            polygons->start[++face] = at;
        }
    }
}

pc_status pc_mosaic_polygons(pc_polymesh *polygons, pc_index **face_cell, pc_context *ctx,
                             const pc_mosaic *m) {
    pc_status status = PC_OK;
    const pc_layout *l = m->layout;
    plan p = {0};
    *polygons = (pc_polymesh){0};
    if (face_cell) *face_cell = NULL;
    PC_TRY(make_plan(&p, ctx, m));
    PC_TRY(pc_polymesh_make(polygons, ctx, p.vertices, p.faces, p.corners));
    if (face_cell) PC_TRY(pc_new(face_cell, ctx, p.faces));
    for (pc_index n = 0; n < m->node_count; n++)
        if (p.vertex[n] != PC_NONE)
            pc_vec3_put(polygons->position, p.vertex[n], pc_vec3_at(l->mesh.position, l->node_vertex[n]));
    for (pc_index a = 0; a < m->arc_count; a++)
        if (p.middle[a] != PC_NONE) pc_vec3_put(polygons->position, p.middle[a], middle_of(m, a));
    if (p.splits) PC_TRY(place_centres(polygons->position, ctx, m, &p));
    write_cells(polygons, face_cell ? *face_cell : NULL, m, &p);
done:
    pc_free(ctx, p.vertex);
    pc_free(ctx, p.middle);
    pc_free(ctx, p.centre);
    if (status != PC_OK) pc_polymesh_free(polygons, ctx);
    if (status != PC_OK && face_cell) {
        pc_free(ctx, *face_cell);
        *face_cell = NULL;
    }
    return status;
}
