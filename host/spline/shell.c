#include "shell.h"
#include "cubic.h"
#include "growing.h"
#include "memory.h"
#include <stdlib.h>
#include <string.h>

void pc_shell_free(pc_shell *shell, pc_context *ctx) {
    pc_free(ctx, shell->vertex);
    pc_free(ctx, shell->edge);
    pc_free(ctx, shell->face);
    pc_free(ctx, shell->loop);
    pc_free(ctx, shell->point);
    pc_free(ctx, shell->knot);
    *shell = (pc_shell){0};
}

/* The edges along one half-edge of the T-mesh, from its tail to its head. */
typedef struct chain {
    pc_index first; /* edges are numbered on from here; PC_NONE: not made yet */
    pc_index count;
} chain;

typedef struct making {
    pc_shell *shell;
    const pc_tspline *spline;
    pc_blocks blocks;
    pc_index *corner; /* per vertex of the T-mesh: its vertex here */
    chain *chain;     /* per half-edge, at the smaller one of two */
} making;

static pc_status add_vertex(making *m, pc_context *ctx, pc_vec3 p, pc_index *vertex) {
    pc_status status = PC_OK;
    pc_shell *s = m->shell;
    PC_GROW(s->vertex, 3 * (size_t)s->vertex_count, s->vertex_room, 3);
    pc_vec3_put(s->vertex, s->vertex_count, p);
    *vertex = s->vertex_count++;
done:
    return status;
}

/* ---- Curves ---- */

/* One side of an element as a cubic, running counter-clockwise: side 0 from the corner low, low along s, and
 * so on. `range` gets how far its ends are behind the start of the face's side. */
static void side_of_element(double b[12], double range[2], const pc_tspline *spline, pc_index e, int side) {
    static const int first[4] = {0, 3, 15, 12}, step[4] = {1, 4, -1, -4};
    const pc_element *element = spline->basis.element + e;
    const double *size = spline->mesh.face[element->face].size;
    int k = side & 1;
    for (int i = 0; i < 4; i++)
        memcpy(b + (ptrdiff_t)3 * i,
               spline->bezier + 48 * (size_t)e + (ptrdiff_t)3 * (first[side] + i * step[side]),
               3 * sizeof(double));
    range[0] = side < 2 ? element->low[k] : size[k] - element->high[k];
    range[1] = side < 2 ? element->high[k] : size[k] - element->low[k];
}

static pc_vec3 blossom_of(const double b[12], const double range[2], const double x[3]) {
    double w[4];
    pc_vec3 p = {0, 0, 0};
    pc_bezier_blossom_weights(w, range[0], range[1], x);
    for (size_t i = 0; i < 4; i++)
        p = pc_madd(p, w[i], pc_vec3_at(b, i));
    return p;
}

static bool touches_side(const pc_tspline *spline, pc_index e, int side) {
    const pc_element *element = spline->basis.element + e;
    const double *size = spline->mesh.face[element->face].size;
    return side == 0   ? element->low[1] == 0
           : side == 1 ? element->high[0] == size[0]
           : side == 2 ? element->high[1] == size[1]
                       : element->low[0] == 0;
}

static pc_status add_edge(making *m, pc_context *ctx, pc_index from, pc_index to, const double *knots,
                          pc_index knot_count) {
    pc_status status = PC_OK;
    pc_shell *s = m->shell;
    pc_index points = knot_count + 2;
    PC_GROW(s->edge, (size_t)s->edge_count, s->edge_room, 1);
    PC_GROW(s->point, s->point_count, s->point_room, 3 * (size_t)points);
    PC_GROW(s->knot, s->knot_count, s->knot_room, (size_t)knot_count);
    s->edge[s->edge_count++] = (pc_shell_edge){
        .vertex = {from, to}, .point_count = points, .point = s->point_count / 3, .knot = s->knot_count};
    memcpy(s->knot + s->knot_count, knots, knot_count * sizeof *knots);
    s->knot_count += knot_count;
    s->point_count += 3 * (size_t)points;
done:
    return status;
}

/* The edge along side `side` of face f between two places on it, on which it runs counter-clockwise. */
static pc_status add_side_edge(making *m, pc_context *ctx, pc_index f, int side, const double span[2],
                               const pc_index vertex[2]) {
    pc_status status = PC_OK;
    enum { MOST = 130 }; /* lines of a face, and more */
    const pc_basis *basis = &m->spline->basis;
    double knot[MOST], b[12], range[2];
    pc_index count = 0;
    knot[count++] = span[0], knot[count++] = span[1];
    for (pc_index e = basis->face_start[f]; e < basis->face_start[f + 1]; e++) {
        if (!touches_side(m->spline, e, side)) continue;
        side_of_element(b, range, m->spline, e, side);
        for (int k = 0; k < 2; k++) {
            pc_index at = 0;
            if (range[k] <= span[0] || range[k] >= span[1] || count == MOST) continue;
            while (at + 1 < count && knot[at] < range[k])
                at++;
            if (knot[at] == range[k]) continue;
            memmove(knot + at + 1, knot + at, (count - at) * sizeof *knot);
            knot[at] = range[k];
            count++;
        }
    }
    PC_TRY(add_edge(m, ctx, vertex[0], vertex[1], knot, count));
    double *point = m->shell->point + 3 * m->shell->edge[m->shell->edge_count - 1].point;
    for (pc_index i = 0; i < count + 2; i++) {
        pc_index piece = i < 2 ? 0 : i - 2 < count - 2 ? i - 2 : count - 2;
        double middle = (knot[piece] + knot[piece + 1]) / 2, x[3];
        for (pc_index k = 0; k < 3; k++) { /* knots i+1 .. i+3 of the clamped vector */
            pc_index j = i + 1 + k;
            x[k] = knot[j < 3 ? 0 : j - 3 < count ? j - 3 : count - 1];
        }
        for (pc_index e = basis->face_start[f]; e < basis->face_start[f + 1]; e++) {
            if (!touches_side(m->spline, e, side)) continue;
            side_of_element(b, range, m->spline, e, side);
            if (range[0] <= middle && middle <= range[1]) break;
        }
        pc_vec3_put(point, i, blossom_of(b, range, x));
    }
done:
    return status;
}

/* ---- Edges along the T-mesh ---- */

static bool is_real(const pc_tmesh *mesh, pc_index f) {
    return f != PC_NONE && !mesh->face[f].ghost;
}

/* Corners of elements inside of a half-edge of an irregular face, as distances from its tail; from the other
 * end with `reverse`. */
static int break_points(double *at, int count, const pc_tspline *spline, pc_index h, bool reverse) {
    const pc_thalf *e = spline->mesh.half + h;
    enum { MOST = 32 };
    if (!is_real(&spline->mesh, e->face) || !pc_tface_is_irregular(&spline->mesh, e->face)) return count;
    for (pc_index i = spline->basis.face_start[e->face]; i < spline->basis.face_start[e->face + 1]; i++) {
        double b[12], range[2];
        if (!touches_side(spline, i, e->side)) continue;
        side_of_element(b, range, spline, i, e->side);
        double x = reverse ? e->interval - range[1] : range[1];
        int place = 0;
        if (x <= 0 || x >= e->interval || count == MOST) continue;
        while (place < count && at[place] < x)
            place++;
        if (place < count && at[place] == x) continue;
        memmove(at + place + 1, at + place, (size_t)(count - place) * sizeof *at);
        at[place] = x;
        count++;
    }
    return count;
}

static pc_status corner_vertex(making *m, pc_context *ctx, pc_index h, pc_index *vertex) {
    pc_status status = PC_OK;
    const pc_thalf *e = m->spline->mesh.half + h;
    pc_index *slot = m->corner + e->tail;
    if (*slot == PC_NONE) {
        double at[2];
        pc_thalf_place(at, &m->spline->mesh, h);
        pc_surface_place place = pc_tspline_place(m->spline, e->face, at[0], at[1]);
        PC_TRY(add_vertex(m, ctx, pc_tspline_point(m->spline, place), slot));
    }
    *vertex = *slot;
done:
    return status;
}

/* The edges along half-edge h, made at the first call for either side of it. */
static pc_status make_chain(making *m, pc_context *ctx, pc_index h) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &m->spline->mesh;
    pc_index twin = mesh->half[h].twin, low = h < twin ? h : twin;
    chain *c = m->chain + low;
    double at[34];
    if (c->first != PC_NONE) return PC_OK;
    pc_index real = is_real(mesh, mesh->half[low].face) ? low : mesh->half[low].twin;
    const pc_thalf *e = mesh->half + real;
    int count = break_points(at + 1, 0, m->spline, real, false);
    count = break_points(at + 1, count, m->spline, e->twin, true);
    at[0] = 0, at[count + 1] = e->interval;
    pc_index vertex[2], head;
    PC_TRY(corner_vertex(m, ctx, real, &vertex[0]));
    PC_TRY(corner_vertex(m, ctx, e->next, &head));
    c->first = m->shell->edge_count;
    c->count = (pc_index)count + 1;
    for (int i = 0; i <= count; i++) {
        const double span[2] = {e->along + at[i], e->along + at[i + 1]};
        vertex[1] = head;
        if (i < count) {
            double local[2], *size = mesh->face[e->face].size;
            local[0] = e->side == 0 ? span[1] : e->side == 1 ? size[0] : e->side == 2 ? size[0] - span[1] : 0;
            local[1] = e->side == 0 ? 0 : e->side == 1 ? span[1] : e->side == 2 ? size[1] : size[1] - span[1];
            pc_surface_place place = pc_tspline_place(m->spline, e->face, local[0], local[1]);
            PC_TRY(add_vertex(m, ctx, pc_tspline_point(m->spline, place), &vertex[1]));
        }
        PC_TRY(add_side_edge(m, ctx, e->face, e->side, span, vertex));
        vertex[0] = vertex[1];
    }
done:
    return status;
}

static pc_status add_to_loop(making *m, pc_context *ctx, pc_index directed) {
    pc_status status = PC_OK;
    PC_GROW(m->shell->loop, m->shell->loop_count, m->shell->loop_room, 1);
    m->shell->loop[m->shell->loop_count++] = directed;
done:
    return status;
}

/* Chains run as the real one of the two half-edges, or as the smaller one where both are. */
static bool runs_along(const pc_tmesh *mesh, pc_index h) {
    pc_index twin = mesh->half[h].twin, low = h < twin ? h : twin;
    return (is_real(mesh, mesh->half[low].face) ? low : mesh->half[low].twin) == h;
}

static const chain *chain_of(const making *m, pc_index h) {
    pc_index twin = m->spline->mesh.half[h].twin;
    return m->chain + (h < twin ? h : twin);
}

static pc_status add_half_to_loop(making *m, pc_context *ctx, pc_index h) {
    pc_status status = PC_OK;
    PC_TRY(make_chain(m, ctx, h));
    const chain *c = chain_of(m, h);
    bool along = runs_along(&m->spline->mesh, h);
    for (pc_index i = 0; i < c->count; i++)
        PC_TRY(add_to_loop(m, ctx, along ? 2 * (c->first + i) : 2 * (c->first + c->count - 1 - i) + 1));
done:
    return status;
}

/* ---- Faces ---- */

static pc_status add_face(making *m, pc_context *ctx, const pc_block_surface *surface) {
    pc_status status = PC_OK;
    pc_shell *s = m->shell;
    pc_index n = surface->line_count[0] + 2, k = surface->line_count[1] + 2;
    size_t points = 3 * (size_t)n * k;
    PC_GROW(s->face, (size_t)s->face_count, s->face_room, 1);
    PC_GROW(s->point, s->point_count, s->point_room, points);
    pc_shell_face *face = s->face + s->face_count;
    *face = (pc_shell_face){.point_count = {n, k}, .point = s->point_count / 3, .loop = s->loop_count};
    memcpy(s->point + s->point_count, surface->point, points * sizeof *s->point);
    s->point_count += points;
    for (int d = 0; d < 2; d++) {
        PC_GROW(s->knot, s->knot_count, s->knot_room, (size_t)surface->line_count[d]);
        face->knot[d] = s->knot_count;
        memcpy(s->knot + s->knot_count, surface->line[d], surface->line_count[d] * sizeof *s->knot);
        s->knot_count += surface->line_count[d];
    }
    s->face_count++;
done:
    return status;
}

static pc_status add_block(making *m, pc_context *ctx, pc_index number) {
    pc_status status = PC_OK;
    const pc_block *block = m->blocks.block + number;
    pc_block_surface surface = {0};
    PC_TRY(pc_block_surface_make(&surface, ctx, m->spline, &m->blocks, number));
    PC_TRY(add_face(m, ctx, &surface));
    for (pc_index i = 0; i < block->side_count; i++)
        PC_TRY(add_half_to_loop(m, ctx, m->blocks.side[block->side + i]));
    pc_shell_face *face = m->shell->face + m->shell->face_count - 1;
    face->loop_count = (pc_index)(m->shell->loop_count - face->loop);
done:
    pc_block_surface_free(&surface, ctx);
    return status;
}

/* Inside of an irregular face: where corners of elements are, and the edges between them. */
typedef struct inside {
    double (*place)[2];
    pc_index *vertex;
    pc_index place_count;
    pc_index *edge; /* 3 each: both places, smaller one first, and the edge */
    pc_index edge_count;
} inside;

static pc_index place_of(const inside *in, double s, double t) {
    for (pc_index i = 0; i < in->place_count; i++)
        if (in->place[i][0] == s && in->place[i][1] == t) return i;
    return PC_NONE;
}

/* Vertices on the sides of the face come with the chains there. */
static pc_status take_sides(making *m, inside *in, pc_context *ctx, pc_index f) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &m->spline->mesh;
    pc_index h = mesh->face[f].first;
    do {
        const pc_thalf *e = mesh->half + h;
        PC_TRY(make_chain(m, ctx, h));
        const chain *c = chain_of(m, h);
        bool along = runs_along(mesh, h);
        double at[34];
        int count = break_points(at + 1, 0, m->spline, h, false);
        count = break_points(at + 1, count, m->spline, e->twin, true);
        at[0] = 0;
        for (int i = 0; i <= count; i++) {
            const double *size = mesh->face[f].size, x = at[i];
            pc_index edge = c->first + (along ? (pc_index)i : c->count - 1 - (pc_index)i);
            double s = e->side == 0 ? x : e->side == 1 ? size[0] : e->side == 2 ? size[0] - x : 0;
            double t = e->side == 0 ? 0 : e->side == 1 ? x : e->side == 2 ? size[1] : size[1] - x;
            in->place[in->place_count][0] = s, in->place[in->place_count][1] = t;
            in->vertex[in->place_count++] = m->shell->edge[edge].vertex[along ? 0 : 1];
        }
        h = e->next;
    } while (h != mesh->face[f].first);
done:
    return status;
}

static pc_status take_corners(making *m, inside *in, pc_context *ctx, pc_index f) {
    pc_status status = PC_OK;
    const pc_basis *basis = &m->spline->basis;
    for (pc_index e = basis->face_start[f]; e < basis->face_start[f + 1]; e++)
        for (int k = 0; k < 4; k++) {
            const pc_element *element = basis->element + e;
            double s = k % 2 ? element->high[0] : element->low[0];
            double t = k / 2 ? element->high[1] : element->low[1];
            if (place_of(in, s, t) != PC_NONE) continue;
            in->place[in->place_count][0] = s, in->place[in->place_count][1] = t;
            PC_TRY(add_vertex(m, ctx, pc_tspline_point(m->spline, (pc_surface_place){e, s, t}),
                              in->vertex + in->place_count));
            in->place_count++;
        }
done:
    return status;
}

/* Whether a place lies on side k of the element; `x` gets its distance from where that side begins. */
static bool lies_on(double *x, const pc_element *e, int k, const double at[2]) {
    int d = k & 1;
    double edge = k == 0 ? e->low[1] : k == 1 ? e->high[0] : k == 2 ? e->high[1] : e->low[0];
    *x = k < 2 ? at[d] - e->low[d] : e->high[d] - at[d];
    return at[1 - d] == edge && *x >= 0 && *x < e->high[d] - e->low[d];
}

/* The edge from place a to place b along side k of element e: one of a chain, or one of the face's own. */
static pc_status add_inner_to_loop(making *m, inside *in, pc_context *ctx, pc_index e, int k, pc_index a,
                                   pc_index b) {
    pc_status status = PC_OK;
    pc_index low = a < b ? a : b, high = a < b ? b : a;
    for (pc_index i = 0; i < in->edge_count; i++)
        if (in->edge[3 * i] == low && in->edge[3 * i + 1] == high) {
            pc_index edge = in->edge[3 * i + 2];
            return add_to_loop(m, ctx, 2 * edge + (m->shell->edge[edge].vertex[0] != in->vertex[a]));
        }
    const pc_element *element = m->spline->basis.element + e;
    const double *size = m->spline->mesh.face[element->face].size;
    double bezier[12], range[2];
    int d = k & 1;
    const double span[2] = {k < 2 ? in->place[a][d] : size[d] - in->place[a][d],
                            k < 2 ? in->place[b][d] : size[d] - in->place[b][d]};
    side_of_element(bezier, range, m->spline, e, k);
    PC_TRY(add_edge(m, ctx, in->vertex[a], in->vertex[b], span, 2));
    double *point = m->shell->point + 3 * m->shell->edge[m->shell->edge_count - 1].point;
    for (int i = 0; i < 4; i++) {
        const double x[3] = {span[i > 2], span[i > 1], span[i > 0]};
        pc_vec3_put(point, (size_t)i, blossom_of(bezier, range, x));
    }
    in->edge[3 * in->edge_count] = low;
    in->edge[3 * in->edge_count + 1] = high;
    in->edge[3 * in->edge_count++ + 2] = m->shell->edge_count - 1;
    PC_TRY(add_to_loop(m, ctx, 2 * (m->shell->edge_count - 1)));
done:
    return status;
}

static pc_status add_element_face(making *m, inside *in, pc_context *ctx, pc_index e) {
    pc_status status = PC_OK;
    const pc_element *element = m->spline->basis.element + e;
    double line[2][2] = {{element->low[0], element->high[0]}, {element->low[1], element->high[1]}};
    pc_block_surface surface = {.line_count = {2, 2}, .line = {line[0], line[1]}};
    surface.point = m->spline->bezier + 48 * (size_t)e;
    PC_TRY(add_face(m, ctx, &surface));
    for (int k = 0; k < 4; k++) {
        double reached = -1;
        pc_index from = PC_NONE;
        for (;;) { /* the places on this side in order, then the corner behind it */
            pc_index next = PC_NONE;
            double least = INFINITY, x;
            for (pc_index i = 0; i < in->place_count; i++)
                if (lies_on(&x, element, k, in->place[i]) && x > reached && x < least) least = x, next = i;
            if (next == PC_NONE) {
                double s = k == 0 || k == 1 ? element->high[0] : element->low[0];
                double t = k == 1 || k == 2 ? element->high[1] : element->low[1];
                next = place_of(in, s, t);
            }
            if (from != PC_NONE) PC_TRY(add_inner_to_loop(m, in, ctx, e, k, from, next));
            if (least == INFINITY) break;
            from = next, reached = least;
        }
    }
    pc_shell_face *face = m->shell->face + m->shell->face_count - 1;
    face->loop_count = (pc_index)(m->shell->loop_count - face->loop);
done:
    return status;
}

static pc_status add_irregular(making *m, pc_context *ctx, pc_index f) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &m->spline->mesh;
    inside in = {0};
    pc_index elements = m->spline->basis.face_start[f + 1] - m->spline->basis.face_start[f];
    size_t room = 4 * (size_t)elements + 4 * 34;
    PC_TRY(pc_new(&in.place, ctx, room));
    PC_TRY(pc_new(&in.vertex, ctx, room));
    PC_TRY(pc_new(&in.edge, ctx, 6 * room));
    PC_TRY(take_sides(m, &in, ctx, f));
    pc_index on_sides = in.place_count;
    for (pc_index i = 0, h = mesh->face[f].first; i < on_sides;) { /* the chains' edges are known */
        const chain *c = chain_of(m, h);
        bool along = runs_along(mesh, h);
        for (pc_index k = 0; k < c->count; k++, i++) {
            pc_index a = i, b = (i + 1) % on_sides;
            in.edge[3 * in.edge_count] = a < b ? a : b;
            in.edge[3 * in.edge_count + 1] = a < b ? b : a;
            in.edge[3 * in.edge_count++ + 2] = c->first + (along ? k : c->count - 1 - k);
        }
        h = mesh->half[h].next;
    }
    PC_TRY(take_corners(m, &in, ctx, f));
    for (pc_index e = 0; e < elements; e++)
        PC_TRY(add_element_face(m, &in, ctx, m->spline->basis.face_start[f] + e));
done:
    pc_free(ctx, in.place);
    pc_free(ctx, in.vertex);
    pc_free(ctx, in.edge);
    return status;
}

/* ---- The whole ---- */

/* Numbers the components of faces across edges, and counts border edges. */
static pc_status connect(pc_shell *s, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index *parent = NULL, *owner = NULL, *number = NULL;
    PC_TRY(pc_new(&parent, ctx, s->face_count));
    PC_TRY(pc_new(&number, ctx, s->face_count));
    PC_TRY(pc_new(&owner, ctx, s->edge_count));
    memset(owner, 0xff, s->edge_count * sizeof *owner);
    s->border_count = s->edge_count;
    for (pc_index f = 0; f < s->face_count; f++) {
        parent[f] = f;
        number[f] = PC_NONE;
    }
    for (pc_index f = 0; f < s->face_count; f++)
        for (size_t i = s->face[f].loop; i < s->face[f].loop + s->face[f].loop_count; i++) {
            pc_index *first = owner + s->loop[i] / 2;
            if (*first == PC_NONE) {
                *first = f;
                continue;
            }
            pc_index a = *first, b = f;
            s->border_count--;
            while (parent[a] != a)
                a = parent[a] = parent[parent[a]];
            while (parent[b] != b)
                b = parent[b] = parent[parent[b]];
            parent[a > b ? a : b] = a > b ? b : a;
        }
    for (pc_index f = 0; f < s->face_count; f++) {
        pc_index a = f;
        while (parent[a] != a)
            a = parent[a];
        if (number[a] == PC_NONE) number[a] = s->component_count++;
        s->face[f].component = number[a];
    }
done:
    pc_free(ctx, parent);
    pc_free(ctx, number);
    pc_free(ctx, owner);
    return status;
}

pc_status pc_shell_make(pc_shell *shell, pc_context *ctx, const pc_tspline *spline) {
    pc_status status = PC_OK;
    making m = {.shell = shell, .spline = spline};
    const pc_tmesh *mesh = &spline->mesh;
    *shell = (pc_shell){0};
    PC_TRY(pc_blocks_make(&m.blocks, ctx, spline));
    PC_TRY(pc_new(&m.corner, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&m.chain, ctx, mesh->half_count));
    memset(m.corner, 0xff, mesh->vertex_count * sizeof *m.corner);
    memset(m.chain, 0xff, mesh->half_count * sizeof *m.chain);
    for (pc_index b = 0; b < m.blocks.block_count; b++)
        PC_TRY(add_block(&m, ctx, b));
    for (pc_index f = 0; f < mesh->face_count; f++)
        if (!mesh->face[f].ghost && m.blocks.of_face[f] == PC_NONE) PC_TRY(add_irregular(&m, ctx, f));
    PC_TRY(connect(shell, ctx));
done:
    pc_blocks_free(&m.blocks, ctx);
    pc_free(ctx, m.corner);
    pc_free(ctx, m.chain);
    if (status != PC_OK) pc_shell_free(shell, ctx);
    return status;
}

/* The four functions that are not zero at u (0..1 of the whole) for `count` distinct knots; returns the first
 * of their points. */
static pc_index clamped(double value[4], const double *knot, pc_index count, double u) {
    double x = knot[0] + u * (knot[count - 1] - knot[0]);
    pc_index span = 0;
    while (span + 2 < count && x >= knot[span + 1])
        span++;
    for (pc_index i = 0; i < 4; i++) { /* de Boor: the blossom at (x,x,x) by its control points */
        double n[4] = {i == 0, i == 1, i == 2, i == 3};
        for (pc_index p = 1; p <= 3; p++)
            for (pc_index j = 3; j >= p; j--) {
                pc_index left = span + j, right = span + j + 4 - p; /* in the clamped vector */
                double a = knot[left < 3 ? 0 : left - 3 < count ? left - 3 : count - 1];
                double b = knot[right < 3 ? 0 : right - 3 < count ? right - 3 : count - 1];
                n[j] = ((b - x) * n[j - 1] + (x - a) * n[j]) / (b - a);
            }
        value[i] = n[3];
    }
    return span;
}

pc_vec3 pc_shell_edge_point(const pc_shell *shell, pc_index e, double u) {
    const pc_shell_edge *edge = shell->edge + e;
    double w[4];
    pc_vec3 p = {0, 0, 0};
    pc_index first = clamped(w, shell->knot + edge->knot, edge->point_count - 2, u);
    for (pc_index i = 0; i < 4; i++)
        p = pc_madd(p, w[i], pc_vec3_at(shell->point, edge->point + first + i));
    return p;
}

pc_vec3 pc_shell_face_point(const pc_shell *shell, pc_index f, double s, double t) {
    const pc_shell_face *face = shell->face + f;
    double v[4], w[4];
    pc_vec3 p = {0, 0, 0};
    pc_index a = clamped(v, shell->knot + face->knot[0], face->point_count[0] - 2, s);
    pc_index b = clamped(w, shell->knot + face->knot[1], face->point_count[1] - 2, t);
    for (pc_index i = 0; i < 16; i++)
        p = pc_madd(
            p, v[i % 4] * w[i / 4],
            pc_vec3_at(shell->point, face->point + a + i % 4 + (size_t)(b + i / 4) * face->point_count[0]));
    return p;
}

/* What is wrong with a face: an edge that its loop or its surface misses. */
typedef struct face_fault {
    bool open;
    pc_index edge; /* PC_NONE: nothing */
    double gap;
} face_fault;

/* The total length of knots along the loop's edges tells where on the rectangle's rim each lies. */
static face_fault check_face(const pc_shell *shell, pc_index f, double size) {
    const pc_shell_face *face = shell->face + f;
    double length[2], along = 0;
    for (int k = 0; k < 2; k++) {
        const double *knot = shell->knot + face->knot[k];
        length[k] = knot[face->point_count[k] - 3] - knot[0];
    }
    for (pc_index i = 0; i < face->loop_count; i++) {
        pc_index directed = shell->loop[face->loop + i],
                 next = shell->loop[face->loop + (i + 1) % face->loop_count];
        const pc_shell_edge *edge = shell->edge + directed / 2;
        const double *knot = shell->knot + edge->knot;
        double span = knot[edge->point_count - 3] - knot[0];
        if (edge->vertex[1 - directed % 2] != shell->edge[next / 2].vertex[next % 2])
            return (face_fault){.open = true, .edge = directed / 2};
        for (int k = 0; k <= 4; k++) {
            double u = k / 4.0, x = along + span * u, s = 0, t = 0;
            pc_vec3 p = pc_shell_edge_point(shell, directed / 2, directed % 2 ? 1 - u : u);
            if (x <= length[0])
                s = x / length[0];
            else if (x <= length[0] + length[1])
                s = 1, t = (x - length[0]) / length[1];
            else if (x <= 2 * length[0] + length[1])
                s = (2 * length[0] + length[1] - x) / length[0], t = 1;
            else
                t = (2 * length[0] + 2 * length[1] - x) / length[1];
            double gap = pc_distance(p, pc_shell_face_point(shell, f, s, t));
            if (!(gap <= 1e-12 * size)) return (face_fault){.edge = directed / 2, .gap = gap};
        }
        along += span;
    }
    return (face_fault){.edge = PC_NONE};
}

static pc_status check_faces(const pc_shell *shell, pc_context *ctx, double size) {
    pc_index first = PC_NONE;
#pragma omp parallel for schedule(static) reduction(min : first)
    for (pc_index f = 0; f < shell->face_count; f++)
        if (first == PC_NONE && check_face(shell, f, size).edge != PC_NONE) first = f;
    if (first == PC_NONE) return PC_OK;
    const face_fault fault = check_face(shell, first, size);
    if (fault.open) return pc_fail(ctx, PC_E_BUG, "the loop of face %u of the shell does not close", first);
    return pc_fail(ctx, PC_E_BUG, "edge %u of the shell is %g off face %u", fault.edge, fault.gap, first);
}

pc_status pc_shell_check(const pc_shell *shell, pc_context *ctx, double size) {
    pc_status status = PC_OK;
    uint8_t *use = NULL;
    pc_index border = 0;
    PC_TRY(pc_new(&use, ctx, shell->edge_count));
    PC_TRY(check_faces(shell, ctx, size));
    for (size_t i = 0; i < shell->loop_count; i++) {
        uint8_t way = (uint8_t)(1 + shell->loop[i] % 2);
        if (use[shell->loop[i] / 2] & way)
            PC_TRY(
                pc_fail(ctx, PC_E_BUG, "edge %u of the shell is run twice the same way", shell->loop[i] / 2));
        use[shell->loop[i] / 2] |= way;
    }
    for (pc_index e = 0; e < shell->edge_count; e++) {
        const pc_shell_edge *edge = shell->edge + e;
        border += use[e] != 3;
        for (int k = 0; k < 2; k++)
            if (!(pc_distance(pc_shell_edge_point(shell, e, k), pc_vec3_at(shell->vertex, edge->vertex[k])) <=
                  1e-12 * size))
                PC_TRY(pc_fail(ctx, PC_E_BUG, "edge %u of the shell misses its vertex", e));
    }
    if (border != shell->border_count)
        PC_TRY(pc_fail(ctx, PC_E_BUG, "%u border edges, not %u", border, shell->border_count));
done:
    pc_free(ctx, use);
    return status;
}
