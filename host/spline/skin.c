#include "skin.h"
#include "growing.h"
#include "memory.h"
#include <stdlib.h>
#include <string.h>

void pc_skin_free(pc_skin *skin, pc_context *ctx) {
    pc_mesh_free(&skin->mesh, ctx);
    pc_free(ctx, skin->normal);
    pc_free(ctx, skin->place);
    pc_free(ctx, skin->element);
    pc_free(ctx, skin->corner);
    *skin = (pc_skin){0};
}

/* A point of one face of the T-mesh. All parameters are binary fractions: equal ones compare equal. */
typedef struct spot {
    double at[2];
    pc_index vertex; /* of the skin; PC_NONE: not made yet */
} spot;

typedef struct making {
    pc_skin *skin;
    const pc_tspline *spline;
    const uint8_t *wanted; /* per face; NULL: all */
    int steps;
    pc_index *of_vertex; /* per vertex of the T-mesh */
    size_t *edge_start;  /* per half-edge +1, at the smaller of two: into edge_place */
    double *edge_place;  /* distances from the tail, ascending, each once */
    pc_index *edge_vertex;
    spot *spot; /* those of the face at hand, by t, then s */
    size_t spot_count, spot_room;
    spot *rim; /* of the cell at hand */
    size_t rim_count, rim_room;
} making;

enum { MOST_STEPS = 64 };

/* Cells of element e in direction d. */
static int cells_of(const making *m, pc_index e, int d) {
    const pc_element *element = m->spline->basis.element + e;
    double part = (element->high[d] - element->low[d]) / m->spline->mesh.face[element->face].size[d];
    int n = 1;
    while (n < m->steps * part)
        n *= 2;
    return n;
}

static double line_of(const pc_element *element, int d, int i, int n) {
    return i == n ? element->high[d] : element->low[d] + (element->high[d] - element->low[d]) * i / n;
}

static pc_index lower_half(const pc_tmesh *mesh, pc_index h) {
    return h < mesh->half[h].twin ? h : mesh->half[h].twin;
}

static bool is_wanted(const making *m, pc_index f) {
    return f != PC_NONE && !m->spline->mesh.face[f].ghost && (!m->wanted || m->wanted[f]);
}

/* ---- Vertices ---- */

static pc_status add_vertex(making *m, pc_context *ctx, pc_surface_place place, pc_index *vertex) {
    pc_status status = PC_OK;
    pc_skin *f = m->skin;
    size_t count = f->mesh.vertex_count;
    if (count == f->place_room) {
        PC_TRY(pc_resize(&f->mesh.position, ctx, 3 * (2 * count + 1024)));
        PC_TRY(pc_resize(&f->place, ctx, 2 * count + 1024));
        f->place_room = 2 * count + 1024;
    }
    f->place[count] = place;
    pc_vec3_put(f->mesh.position, count, pc_tspline_point(m->spline, place));
    *vertex = f->mesh.vertex_count++;
done:
    return status;
}

/* Where a point `x` behind the tail of half-edge h lies on its face. */
static void place_on_half(double at[2], const pc_tmesh *mesh, pc_index h, double x) {
    const pc_thalf *e = mesh->half + h;
    const double *size = mesh->face[e->face].size, along = e->along + x;
    at[0] = e->side == 0 ? along : e->side == 1 ? size[0] : e->side == 2 ? size[0] - along : 0;
    at[1] = e->side == 0 ? 0 : e->side == 1 ? along : e->side == 2 ? size[1] : size[1] - along;
}

/* ---- Along the edges of the T-mesh ---- */

/* The places on the side of its face that side k of element e has, each inside of a half-edge: counted in
 * edge_start, one place ahead, or put where edge_start points. */
static void visit_side(making *m, pc_index e, int k, bool fill) {
    const pc_tmesh *mesh = &m->spline->mesh;
    const pc_element *element = m->spline->basis.element + e;
    const double *size = mesh->face[element->face].size;
    int d = k & 1, n = cells_of(m, e, d);
    double edge = k == 0   ? element->low[1]
                  : k == 1 ? size[0] - element->high[0]
                  : k == 2 ? size[1] - element->high[1]
                           : element->low[0];
    if (edge > 0) return;
    pc_index h = mesh->face[element->face].first;
    while (mesh->half[h].side != k)
        h = mesh->half[h].next;
    for (int i = 0; i <= n; i++) {
        double line = line_of(element, d, k < 2 ? i : n - i, n), along = k < 2 ? line : size[d] - line;
        while (mesh->half[h].along + mesh->half[h].interval < along)
            h = mesh->half[h].next;
        double x = along - mesh->half[h].along;
        if (x <= 0 || x >= mesh->half[h].interval) continue;
        pc_index low = lower_half(mesh, h);
        if (fill)
            m->edge_place[m->edge_start[low]++] = low == h ? x : mesh->half[h].interval - x;
        else
            m->edge_start[low + 1]++;
    }
}

static void visit_sides(making *m, bool fill) {
    for (pc_index e = 0; e < m->spline->basis.element_count; e++)
        for (int k = 0; k < 4 && is_wanted(m, m->spline->basis.element[e].face); k++)
            visit_side(m, e, k, fill);
}

static int ascending(const void *x, const void *y) {
    double a = *(const double *)x, b = *(const double *)y;
    return (a > b) - (a < b);
}

/* Sorts what both sides of each edge have, keeps each place once, and makes its vertex. */
static pc_status settle_edges(making *m, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &m->spline->mesh;
    size_t begin = 0, kept = 0;
    for (pc_index h = 0; h < mesh->half_count; h++) {
        size_t end = m->edge_start[h], first = kept; /* filling has moved each start to its end */
        qsort(m->edge_place + begin, end - begin, sizeof *m->edge_place, ascending);
        for (size_t i = begin; i < end; i++) {
            double x = m->edge_place[i], at[2];
            if (kept > first && m->edge_place[kept - 1] == x) continue;
            pc_index real = is_wanted(m, mesh->half[h].face) ? h : mesh->half[h].twin;
            place_on_half(at, mesh, real, real == h ? x : mesh->half[h].interval - x);
            pc_surface_place place = pc_tspline_place(m->spline, mesh->half[real].face, at[0], at[1]);
            PC_TRY(add_vertex(m, ctx, place, m->edge_vertex + kept));
            m->edge_place[kept++] = x;
        }
        m->edge_start[h] = first;
        begin = end;
    }
    m->edge_start[mesh->half_count] = kept;
done:
    return status;
}

static pc_status make_edges(making *m, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index count = m->spline->mesh.half_count;
    PC_TRY(pc_new(&m->edge_start, ctx, (size_t)count + 1));
    visit_sides(m, false);
    for (pc_index h = 0; h < count; h++)
        m->edge_start[h + 1] += m->edge_start[h];
    PC_TRY(pc_new(&m->edge_place, ctx, m->edge_start[count]));
    PC_TRY(pc_new(&m->edge_vertex, ctx, m->edge_start[count]));
    visit_sides(m, true);
    PC_TRY(settle_edges(m, ctx));
done:
    return status;
}

static pc_status make_corners(making *m, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &m->spline->mesh;
    PC_TRY(pc_new(&m->of_vertex, ctx, mesh->vertex_count));
    memset(m->of_vertex, 0xff, mesh->vertex_count * sizeof *m->of_vertex);
    for (pc_index h = 0; h < mesh->half_count; h++) {
        double at[2];
        if (!is_wanted(m, mesh->half[h].face) || m->of_vertex[mesh->half[h].tail] != PC_NONE) continue;
        pc_thalf_place(at, mesh, h);
        PC_TRY(add_vertex(m, ctx, pc_tspline_place(m->spline, mesh->half[h].face, at[0], at[1]),
                          m->of_vertex + mesh->half[h].tail));
    }
done:
    return status;
}

/* ---- One face ---- */

static pc_status add_spot(making *m, pc_context *ctx, double s, double t, pc_index vertex) {
    pc_status status = PC_OK;
    PC_GROW(m->spot, m->spot_count, m->spot_room, 1);
    m->spot[m->spot_count++] = (spot){{s, t}, vertex};
done:
    return status;
}

static pc_status take_border(making *m, pc_context *ctx, pc_index f) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &m->spline->mesh;
    pc_index h = mesh->face[f].first;
    do {
        double at[2];
        pc_index low = lower_half(mesh, h);
        pc_thalf_place(at, mesh, h);
        PC_TRY(add_spot(m, ctx, at[0], at[1], m->of_vertex[mesh->half[h].tail]));
        for (size_t i = m->edge_start[low]; i < m->edge_start[low + 1]; i++) {
            double x = low == h ? m->edge_place[i] : mesh->half[h].interval - m->edge_place[i];
            place_on_half(at, mesh, h, x);
            PC_TRY(add_spot(m, ctx, at[0], at[1], m->edge_vertex[i]));
        }
        h = mesh->half[h].next;
    } while (h != mesh->face[f].first);
done:
    return status;
}

static int by_place(const void *x, const void *y) {
    const spot *a = x, *b = y;
    for (int d = 1; d >= 0; d--)
        if (a->at[d] != b->at[d]) return a->at[d] < b->at[d] ? -1 : 1;
    return 0;
}

/* The points inside of the face, each once; then all are in order. */
static pc_status take_inside(making *m, pc_context *ctx, pc_index f) {
    pc_status status = PC_OK;
    const pc_basis *basis = &m->spline->basis;
    const double *size = m->spline->mesh.face[f].size;
    for (pc_index e = basis->face_start[f]; e < basis->face_start[f + 1]; e++) {
        const pc_element *element = basis->element + e;
        int n[2] = {cells_of(m, e, 0), cells_of(m, e, 1)};
        for (int j = 0; j <= n[1]; j++)
            for (int i = 0; i <= n[0]; i++) {
                double s = line_of(element, 0, i, n[0]), t = line_of(element, 1, j, n[1]);
                if (s > 0 && t > 0 && s < size[0] && t < size[1]) PC_TRY(add_spot(m, ctx, s, t, PC_NONE));
            }
    }
    qsort(m->spot, m->spot_count, sizeof *m->spot, by_place);
    size_t kept = 0;
    for (size_t i = 0; i < m->spot_count; i++) {
        if (kept && by_place(m->spot + kept - 1, m->spot + i) == 0) continue;
        spot *s = m->spot + kept++;
        *s = m->spot[i];
        if (s->vertex == PC_NONE)
            PC_TRY(add_vertex(m, ctx, pc_tspline_place(m->spline, f, s->at[0], s->at[1]), &s->vertex));
    }
    m->spot_count = kept;
done:
    return status;
}

/* ---- Triangles ---- */

static pc_status add_triangle(making *m, pc_context *ctx, pc_index e, const spot *a, const spot *b,
                              const spot *c) {
    const spot *const corner[3] = {a, b, c};
    pc_status status = PC_OK;
    pc_skin *f = m->skin;
    size_t count = f->mesh.face_count;
    if (count == f->triangle_room) {
        PC_TRY(pc_resize(&f->mesh.triangle, ctx, 3 * (2 * count + 1024)));
        PC_TRY(pc_resize(&f->element, ctx, 2 * count + 1024));
        PC_TRY(pc_resize(&f->corner, ctx, 6 * (2 * count + 1024)));
        f->triangle_room = 2 * count + 1024;
    }
    for (size_t k = 0; k < 3; k++) {
        f->mesh.triangle[3 * count + k] = corner[k]->vertex;
        memcpy(f->corner + 6 * count + 2 * k, corner[k]->at, sizeof corner[k]->at);
    }
    f->element[count] = e;
    f->mesh.face_count++;
done:
    return status;
}

/* All spots on the segment from `from` to `to`, which runs along s or t, without the last; inside of an
 * element there is none but the first. */
static pc_status add_to_rim(making *m, pc_context *ctx, const double from[2], const double to[2],
                            bool inside) {
    pc_status status = PC_OK;
    int d = from[0] == to[0];
    size_t first = m->rim_count;
    bool back = to[d] < from[d];
    const spot key = {{from[0], from[1]}, PC_NONE};
    const spot *found = bsearch(&key, m->spot, m->spot_count, sizeof key, by_place);
    for (const spot *i = inside ? found : m->spot; i < (inside ? found + 1 : m->spot + m->spot_count); i++) {
        if (i->at[1 - d] != from[1 - d] || i->at[d] == to[d]) continue;
        if (back ? i->at[d] > from[d] || i->at[d] < to[d] : i->at[d] < from[d] || i->at[d] > to[d]) continue;
        PC_GROW(m->rim, m->rim_count, m->rim_room, 1);
        if (back) memmove(m->rim + first + 1, m->rim + first, (m->rim_count - first) * sizeof *m->rim);
        m->rim[back ? first : m->rim_count] = *i;
        m->rim_count++;
    }
done:
    return status;
}

static pc_status fill_rim(making *m, pc_context *ctx, pc_index e, const double low[2], const double high[2]) {
    pc_status status = PC_OK;
    const spot *r = m->rim;
    const double *p = m->skin->mesh.position;
    if (m->rim_count == 4) {
        double one = pc_distance(pc_vec3_at(p, r[0].vertex), pc_vec3_at(p, r[2].vertex));
        double two = pc_distance(pc_vec3_at(p, r[1].vertex), pc_vec3_at(p, r[3].vertex));
        int k = two < one;
        PC_TRY(add_triangle(m, ctx, e, r + k, r + k + 1, r + k + 2));
        return add_triangle(m, ctx, e, r + k, r + k + 2, r + ((k + 3) & 3));
    }
    spot centre = {{(low[0] + high[0]) / 2, (low[1] + high[1]) / 2}, PC_NONE};
    PC_TRY(add_vertex(m, ctx, (pc_surface_place){e, centre.at[0], centre.at[1]}, &centre.vertex));
    for (size_t i = 0; i < m->rim_count; i++)
        PC_TRY(add_triangle(m, ctx, e, &centre, r + i, r + (i + 1 == m->rim_count ? 0 : i + 1)));
done:
    return status;
}

static pc_status fill_element(making *m, pc_context *ctx, pc_index e) {
    pc_status status = PC_OK;
    const pc_element *element = m->spline->basis.element + e;
    int n[2] = {cells_of(m, e, 0), cells_of(m, e, 1)};
    for (int j = 0; j < n[1]; j++)
        for (int i = 0; i < n[0]; i++) {
            double low[2] = {line_of(element, 0, i, n[0]), line_of(element, 1, j, n[1])};
            double high[2] = {line_of(element, 0, i + 1, n[0]), line_of(element, 1, j + 1, n[1])};
            double corner[5][2] = {
                {low[0], low[1]}, {high[0], low[1]}, {high[0], high[1]}, {low[0], high[1]}, {low[0], low[1]}};
            m->rim_count = 0;
            for (int k = 0; k < 4; k++)
                PC_TRY(add_to_rim(m, ctx, corner[k], corner[k + 1],
                                  k % 2 ? (k == 1 ? i + 1 < n[0] : i > 0) : (k == 0 ? j > 0 : j + 1 < n[1])));
            PC_TRY(fill_rim(m, ctx, e, low, high));
        }
done:
    return status;
}

static void make_normals(pc_skin *skin, const pc_tspline *spline) {
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < skin->mesh.vertex_count; v++) {
        pc_surface_point p = pc_tspline_evaluate(spline, skin->place[v]);
        pc_vec3 n = pc_cross(p.s, p.t);
        double length = pc_norm(n);
        pc_vec3_put(skin->normal, v, length > 0 ? pc_scale(1 / length, n) : n);
    }
}

pc_status pc_skin_make(pc_skin *skin, pc_context *ctx, const pc_tspline *spline, int steps,
                       const uint8_t *wanted) {
    pc_status status = PC_OK;
    making m = {.skin = skin, .spline = spline, .wanted = wanted};
    m.steps = steps < MOST_STEPS ? steps : MOST_STEPS;
    const pc_basis *basis = &spline->basis;
    *skin = (pc_skin){0};
    PC_TRY(make_corners(&m, ctx));
    PC_TRY(make_edges(&m, ctx));
    for (pc_index f = 0; f < spline->mesh.face_count; f++) {
        if (!is_wanted(&m, f)) continue;
        m.spot_count = 0;
        PC_TRY(take_border(&m, ctx, f));
        PC_TRY(take_inside(&m, ctx, f));
        for (pc_index e = basis->face_start[f]; e < basis->face_start[f + 1]; e++)
            PC_TRY(fill_element(&m, ctx, e));
        PC_TRY(pc_check_interrupt(ctx));
    }
    PC_TRY(pc_new(&skin->normal, ctx, 3 * (size_t)skin->mesh.vertex_count));
    make_normals(skin, spline);
done:
    pc_free(ctx, m.of_vertex);
    pc_free(ctx, m.edge_start);
    pc_free(ctx, m.edge_place);
    pc_free(ctx, m.edge_vertex);
    pc_free(ctx, m.spot);
    pc_free(ctx, m.rim);
    if (status != PC_OK) pc_skin_free(skin, ctx);
    return status;
}
