#include "tmesh.h"
#include "memory.h"
#include "polygraph.h"
#include <string.h>

pc_status pc_tmesh_reserve(pc_tmesh *mesh, pc_context *ctx, size_t vertices, size_t halves, size_t faces) {
    pc_status status = PC_OK;
    vertices += mesh->vertex_count, halves += mesh->half_count, faces += mesh->face_count;
    if (halves >= PC_NONE)
        return pc_fail(ctx, PC_E_NOMEM, "a control mesh of more than 2^32-2 half-edges is not supported");
    if (vertices > mesh->vertex_room) {
        PC_TRY(pc_resize(&mesh->vertex, ctx, vertices + vertices / 2));
        mesh->vertex_room = vertices + vertices / 2;
    }
    if (halves > mesh->half_room) {
        PC_TRY(pc_resize(&mesh->half, ctx, halves + halves / 2));
        mesh->half_room = halves + halves / 2;
    }
    if (faces > mesh->face_room) {
        PC_TRY(pc_resize(&mesh->face, ctx, faces + faces / 2));
        mesh->face_room = faces + faces / 2;
    }
done:
    return status;
}

void pc_tmesh_free(pc_tmesh *mesh, pc_context *ctx) {
    pc_free(ctx, mesh->vertex);
    pc_free(ctx, mesh->half);
    pc_free(ctx, mesh->face);
    *mesh = (pc_tmesh){0};
}

pc_status pc_tmesh_copy(pc_tmesh *copy, pc_context *ctx, const pc_tmesh *mesh) {
    pc_status status = PC_OK;
    *copy = (pc_tmesh){0};
    PC_TRY(pc_tmesh_reserve(copy, ctx, mesh->vertex_count, mesh->half_count, mesh->face_count));
    copy->vertex_count = mesh->vertex_count;
    copy->half_count = mesh->half_count;
    copy->face_count = mesh->face_count;
    memcpy(copy->vertex, mesh->vertex, mesh->vertex_count * sizeof *mesh->vertex);
    memcpy(copy->half, mesh->half, mesh->half_count * sizeof *mesh->half);
    memcpy(copy->face, mesh->face, mesh->face_count * sizeof *mesh->face);
done:
    if (status != PC_OK) pc_tmesh_free(copy, ctx);
    return status;
}

void pc_tmesh_measure(pc_tmesh *mesh, pc_index f) {
    pc_tface *face = mesh->face + f;
    pc_index h = face->first;
    uint8_t side = 0;
    double along = 0;
    do {
        pc_thalf *e = mesh->half + h;
        if (h != face->first && pc_thalf_turns(mesh, h)) {
            if (side < 2) face->size[side] = along;
            side++, along = 0;
        }
        e->face = f;
        e->side = side;
        e->along = along;
        along += e->interval;
        h = e->next;
    } while (h != face->first);
}

void pc_tface_corners(pc_index corner[4], const pc_tmesh *mesh, pc_index f) {
    pc_index h = mesh->face[f].first;
    do {
        if (pc_thalf_turns(mesh, h)) corner[mesh->half[h].side] = mesh->half[h].tail;
        h = mesh->half[h].next;
    } while (h != mesh->face[f].first);
}

bool pc_tface_is_irregular(const pc_tmesh *mesh, pc_index f) {
    pc_index first = mesh->face[f].first, h = first;
    do {
        if (mesh->vertex[mesh->half[h].tail].extraordinary) return true;
        h = mesh->half[h].next;
    } while (h != first);
    return false;
}

/* What the construction needs besides the mesh. */
typedef struct draft {
    pc_tmesh *mesh;
    pc_index *source;
    const pc_polymesh *quads;
    const double *interval; /* per corner; NULL: all 1 */
    pc_polygraph graph;
    /* Per half-edge on a border: */
    pc_index *outer[2]; /* the vertices beyond its tail and its head */
    pc_index *ghost;    /* the first half-edge of the ghost face beyond it */
    pc_index *corner;   /* the same of the ghost face beyond its tail, PC_NONE where there is none */
} draft;

static bool is_flat(const draft *d, pc_index corner) {
    return d->quads->corner_flat && d->quads->corner_flat[corner];
}

static pc_status refuse_others(const draft *d, pc_context *ctx) {
    const pc_polymesh *q = d->quads;
    for (pc_index f = 0; f < q->face_count; f++) {
        pc_index corners = 0;
        for (pc_index c = q->start[f]; c < q->start[f + 1]; c++) {
            corners += !is_flat(d, c);
            if (d->graph.twin[c] == PC_NONE && !d->graph.boundary[c])
                return pc_fail(ctx, PC_E_MESH,
                               "the edge at corner %u of face %u is shared by more than two faces",
                               c - q->start[f], f);
        }
        if (corners != 4)
            return pc_fail(ctx, PC_E_MESH, "face %u has %u corners; a spline needs quads only", f, corners);
    }
    return PC_OK;
}

static pc_index new_vertex(draft *d, pc_index source) {
    pc_index v = d->mesh->vertex_count++;
    d->mesh->vertex[v] = (pc_tvertex){.out = PC_NONE};
    d->source[v] = source;
    return v;
}

/* A ghost, `width` along its side 0. */
static pc_index new_ghost(draft *d, const pc_index corner[4], double width) {
    pc_tmesh *mesh = d->mesh;
    pc_index f = mesh->face_count++, h = mesh->half_count;
    mesh->half_count += 4;
    mesh->face[f] = (pc_tface){.first = h, .size = {width, 1}, .root = f, .ghost = true};
    for (pc_index k = 0; k < 4; k++)
        mesh->half[h + k] = (pc_thalf){.tail = corner[k],
                                       .next = h + (k + 1) % 4,
                                       .prev = h + (k + 3) % 4,
                                       .twin = PC_NONE,
                                       .face = f,
                                       .interval = k & 1 ? 1 : width,
                                       .side = (uint8_t)k};
    return f;
}

static inline void pair(pc_tmesh *mesh, pc_index g, pc_index h) {
    mesh->half[g].twin = h;
    mesh->half[h].twin = g;
}

static void lay_face(draft *d, pc_index f) {
    pc_tmesh *mesh = d->mesh;
    pc_index from = d->quads->start[f], to = d->quads->start[f + 1], first = from;
    while (is_flat(d, first))
        first++;
    mesh->face[f] = (pc_tface){.first = first, .root = f};
    for (pc_index c = from; c < to; c++)
        mesh->half[c] = (pc_thalf){.tail = PC_NONE,
                                   .next = c + 1 < to ? c + 1 : from,
                                   .prev = c > from ? c - 1 : to - 1,
                                   .twin = d->graph.twin[c],
                                   .interval = d->interval ? d->interval[c] : 1,
                                   .along = is_flat(d, c)}; /* more than 0: measured next */
    pc_tmesh_measure(mesh, f);
}

/* The faces of the surface: half-edge c is that of corner c of the quads. A vertex per fan. */
static void lay_faces(draft *d) {
    pc_tmesh *mesh = d->mesh;
    mesh->face_count = d->quads->face_count;
    mesh->half_count = d->graph.corner_count;
    for (pc_index f = 0; f < mesh->face_count; f++)
        lay_face(d, f);
    for (pc_index c = 0; c < d->graph.corner_count; c++) {
        if (mesh->half[c].tail != PC_NONE) continue;
        pc_index v = new_vertex(d, d->quads->corner[c]), h = c;
        while (mesh->half[h].twin != PC_NONE) { /* clockwise to the border or all around */
            h = pc_thalf_cw(mesh, h);
            if (h == c) break;
        }
        mesh->vertex[v].out = h;
        pc_index first = h;
        do {
            mesh->half[h].tail = v;
            h = pc_thalf_ccw(mesh, h);
        } while (h != PC_NONE && h != first);
    }
}

/* The half-edge that follows h along its border. */
static pc_index border_next(const pc_tmesh *mesh, pc_index h) {
    pc_index n = mesh->half[h].next;
    while (mesh->half[n].twin != PC_NONE)
        n = pc_thalf_cw(mesh, n);
    return n;
}

/* Beyond the border vertex between h and n, which follows it: one outer vertex, or at a corner of a single
 * face three, with a ghost face of their own. */
static void lay_corner(draft *d, pc_index h, pc_index n) {
    pc_index v = d->mesh->half[n].tail, a = new_vertex(d, PC_NONE), b = a;
    d->corner[n] = PC_NONE;
    if (d->mesh->half[h].next == n) {
        b = new_vertex(d, PC_NONE);
        d->corner[n] = d->mesh->half_count;
        new_ghost(d, (const pc_index[4]){v, a, new_vertex(d, PC_NONE), b}, 1);
    }
    d->outer[1][h] = a;
    d->outer[0][n] = b;
}

static void lay_ghosts(draft *d) {
    pc_tmesh *mesh = d->mesh;
    pc_index corners = d->graph.corner_count;
    for (pc_index h = 0; h < corners; h++)
        if (d->graph.boundary[h]) lay_corner(d, h, border_next(mesh, h));
    for (pc_index h = 0; h < corners; h++) {
        if (!d->graph.boundary[h]) continue;
        d->ghost[h] = mesh->half_count;
        new_ghost(d,
                  (const pc_index[4]){mesh->half[mesh->half[h].next].tail, mesh->half[h].tail, d->outer[0][h],
                                      d->outer[1][h]},
                  mesh->half[h].interval);
    }
    for (pc_index h = 0; h < corners; h++) { /* each with the next along the border */
        if (!d->graph.boundary[h]) continue;
        pc_index n = border_next(mesh, h), corner = d->corner[n];
        if (corner == PC_NONE) {
            pair(mesh, d->ghost[h] + 3, d->ghost[n] + 1);
        } else {
            pair(mesh, d->ghost[h] + 3, corner);
            pair(mesh, d->ghost[n] + 1, corner + 3);
        }
    }
    for (pc_index h = 0; h < corners; h++)
        if (d->graph.boundary[h]) pair(mesh, h, d->ghost[h]);
}

/* Half-edges of no face around the outer rim. */
static void lay_rim(draft *d) {
    pc_tmesh *mesh = d->mesh;
    pc_index inner = mesh->half_count;
    for (pc_index h = 0; h < inner; h++) {
        if (mesh->half[h].twin != PC_NONE) continue;
        pc_index r = mesh->half_count++;
        mesh->half[r] = (pc_thalf){
            .tail = mesh->half[mesh->half[h].next].tail, .face = PC_NONE, .interval = mesh->half[h].interval};
        pair(mesh, h, r);
        mesh->vertex[mesh->half[h].tail].out = h;
    }
    for (pc_index r = inner; r < mesh->half_count; r++) { /* the rim half-edge that leaves the head of r */
        pc_index h = mesh->half[mesh->half[r].twin].prev;
        while (mesh->half[mesh->half[h].twin].face != PC_NONE)
            h = mesh->half[mesh->half[h].twin].prev;
        mesh->half[r].next = mesh->half[h].twin;
        mesh->half[mesh->half[h].twin].prev = r;
    }
    for (pc_index h = 0; h < inner; h++) {
        pc_tvertex *v = mesh->vertex + mesh->half[h].tail;
        if (v->out == PC_NONE) v->out = h;
    }
}

static pc_status mark_extraordinary(pc_tmesh *mesh, pc_context *ctx, const draft *d, uint8_t depth) {
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_index valence = 0, quarters = 0, first = mesh->vertex[v].out, h = first;
        bool rim = mesh->half[mesh->half[first].twin].face == PC_NONE;
        do {
            valence++;
            quarters += pc_thalf_turns(mesh, h) ? 1 : 2;
            h = pc_thalf_ccw(mesh, h);
        } while (h != first);
        if (!rim && valence < 3)
            return pc_fail(ctx, PC_E_MESH, "vertex %u is between two quads only; dissolve it first",
                           d->source[v]);
        if (valence > PC_TMESH_VALENCE)
            return pc_fail(ctx, PC_E_MESH, "vertex %u is in %u quads; at most %d are supported", d->source[v],
                           valence, PC_TMESH_VALENCE);
        mesh->vertex[v].extraordinary = !rim && quarters != 4;
        mesh->vertex[v].depth = mesh->vertex[v].extraordinary ? depth : 0;
    }
    return PC_OK;
}

pc_status pc_tmesh_make(pc_tmesh *mesh, pc_index **source, pc_context *ctx, const pc_polymesh *quads,
                        const double *interval, const pc_tmesh_options *options) {
    pc_status status = PC_OK;
    draft d = {.mesh = mesh, .quads = quads, .interval = interval};
    size_t corners = quads->start[quads->face_count], border = 0;
    *mesh = (pc_tmesh){0};
    PC_TRY(pc_polygraph_of_polymesh(&d.graph, ctx, quads));
    PC_TRY(refuse_others(&d, ctx));
    for (size_t c = 0; c < corners; c++)
        border += d.graph.boundary[c];
    PC_TRY(pc_tmesh_reserve(mesh, ctx, corners + 3 * border, corners + 12 * border,
                            quads->face_count + 2 * border));
    PC_TRY(pc_new(&d.source, ctx, corners + 3 * border));
    PC_TRY(pc_new(&d.outer[0], ctx, corners));
    PC_TRY(pc_new(&d.outer[1], ctx, corners));
    PC_TRY(pc_new(&d.ghost, ctx, corners));
    PC_TRY(pc_new(&d.corner, ctx, corners));
    lay_faces(&d);
    lay_ghosts(&d);
    lay_rim(&d);
    PC_TRY(mark_extraordinary(mesh, ctx, &d, options->depth));
    if (source) *source = d.source, d.source = NULL;
done:
    if (status != PC_OK) pc_tmesh_free(mesh, ctx);
    pc_polygraph_free(&d.graph, ctx);
    pc_free(ctx, d.source);
    pc_free(ctx, d.outer[0]);
    pc_free(ctx, d.outer[1]);
    pc_free(ctx, d.ghost);
    pc_free(ctx, d.corner);
    return status;
}

static pc_status check_half(const pc_tmesh *mesh, pc_context *ctx, pc_index h) {
    const pc_thalf *e = mesh->half + h;
    if (e->next >= mesh->half_count || e->prev >= mesh->half_count || e->twin >= mesh->half_count ||
        e->tail >= mesh->vertex_count || (e->face != PC_NONE && e->face >= mesh->face_count))
        return pc_fail(ctx, PC_E_BUG, "half-edge %u of the T-mesh points out of range", h);
    const pc_thalf *n = mesh->half + e->next, *t = mesh->half + e->twin;
    if (n->prev != h || t->twin != h || e->twin == h || t->tail != n->tail || n->face != e->face)
        return pc_fail(ctx, PC_E_BUG, "half-edge %u of the T-mesh is not linked well", h);
    if (e->interval != t->interval || !(e->interval > 0)) /* NaN fails too */
        return pc_fail(ctx, PC_E_BUG, "half-edge %u of the T-mesh has interval %g", h, e->interval);
    return PC_OK;
}

static pc_status check_face(const pc_tmesh *mesh, pc_context *ctx, pc_index f) {
    double sum[4] = {0};
    const pc_tface *face = mesh->face + f;
    pc_index h = face->first;
    int corners = 0;
    do {
        const pc_thalf *e = mesh->half + h;
        corners += pc_thalf_turns(mesh, h);
        if (e->face != f || corners < 1 || corners > 4 || e->side != corners - 1 ||
            e->along != sum[corners - 1])
            return pc_fail(ctx, PC_E_BUG, "half-edge %u is not where face %u of the T-mesh has it", h, f);
        if (e->along > 0 && mesh->vertex[e->tail].extraordinary)
            return pc_fail(ctx, PC_E_BUG, "an extraordinary vertex lies in a side of face %u", f);
        sum[corners - 1] += e->interval;
        h = e->next;
    } while (h != face->first);
    if (corners != 4 || sum[0] != sum[2] || sum[1] != sum[3] || sum[0] != face->size[0] ||
        sum[1] != face->size[1])
        return pc_fail(ctx, PC_E_BUG, "opposite sides of face %u of the T-mesh differ: %g %g %g %g", f,
                       sum[0], sum[1], sum[2], sum[3]);
    return PC_OK;
}

static pc_status check_vertex(const pc_tmesh *mesh, pc_context *ctx, pc_index v) {
    const pc_tvertex *vertex = mesh->vertex + v;
    pc_index h = vertex->out, valence = 0;
    int turn = 0;
    bool rim = mesh->half[mesh->half[h].twin].face == PC_NONE, equal = true;
    do {
        const pc_thalf *e = mesh->half + h;
        if (e->tail != v) return pc_fail(ctx, PC_E_BUG, "half-edge %u does not leave vertex %u", h, v);
        if (e->face != PC_NONE) turn += pc_thalf_turns(mesh, h) ? 1 : 2;
        equal = equal && e->interval == mesh->half[vertex->out].interval;
        valence++;
        h = pc_thalf_ccw(mesh, h);
    } while (h != vertex->out && valence <= mesh->half_count);
    if (vertex->extraordinary ? turn == 4 || rim || valence < 3 : rim ? turn > 2 : turn != 4)
        return pc_fail(ctx, PC_E_BUG, "vertex %u of the T-mesh has valence %u and %d quarters", v, valence,
                       turn);
    if (vertex->extraordinary && !equal)
        return pc_fail(ctx, PC_E_BUG, "the intervals around extraordinary vertex %u differ", v);
    return PC_OK;
}

pc_status pc_tmesh_check(const pc_tmesh *mesh, pc_context *ctx) {
    pc_status status = PC_OK;
    for (pc_index h = 0; h < mesh->half_count; h++)
        PC_TRY(check_half(mesh, ctx, h));
    for (pc_index f = 0; f < mesh->face_count; f++)
        PC_TRY(check_face(mesh, ctx, f));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        PC_TRY(check_vertex(mesh, ctx, v));
done:
    return status;
}
