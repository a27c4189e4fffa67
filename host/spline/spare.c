#include "spare.h"
#include "memory.h"
#include "polygraph.h"
#include <string.h>

/* What is known of the vertices and faces in one pass. */
typedef struct tidying {
    pc_polymesh *mesh;
    pc_index *source; /* per face: the one given */
    uint8_t *border;  /* per vertex */
    pc_polygraph graph;
    pc_index *faces, *flats; /* per vertex: faces around, and those that it is flat in */
    pc_index *left;          /* per face: corners; 0 where it goes */
    uint8_t *drop;           /* per vertex */
    uint8_t *changed;        /* per face: in this pass */
    uint8_t *open;           /* per corner: its edge goes */
} tidying;

static pc_index next_corner(const tidying *t, pc_index k) {
    return pc_polymesh_next(t->mesh, t->graph.face[k], k);
}

static pc_index previous_corner(const tidying *t, pc_index k) {
    return pc_polymesh_previous(t->mesh, t->graph.face[k], k);
}

/* The vertices beside corner k that stay. */
static pc_index vertex_after(const tidying *t, pc_index k) {
    do
        k = next_corner(t, k);
    while (t->drop[t->mesh->corner[k]]);
    return t->mesh->corner[k];
}

static pc_index vertex_before(const tidying *t, pc_index k) {
    do
        k = previous_corner(t, k);
    while (t->drop[t->mesh->corner[k]]);
    return t->mesh->corner[k];
}

/* Whether an edge joins the vertex of corner k to v. */
static bool has_edge_to(const tidying *t, pc_index k, pc_index v) {
    pc_index at = k;
    do {
        pc_index before = previous_corner(t, at);
        if (vertex_after(t, at) == v || vertex_before(t, at) == v) return true;
        at = t->graph.twin[before];
    } while (at != PC_NONE && at != k);
    for (; at == PC_NONE || at != k;) { /* a border: the other way round */
        at = t->graph.twin[at == PC_NONE ? k : at];
        if (at == PC_NONE) return false;
        at = next_corner(t, at);
        if (vertex_after(t, at) == v) return true;
    }
    return false;
}

/* The faces have three vertices in common and no more. */
static bool share_three(const tidying *t, pc_index f, pc_index g) {
    int shared = 0;
    for (pc_index i = t->mesh->start[f]; i < t->mesh->start[f + 1]; i++)
        for (pc_index j = t->mesh->start[g]; j < t->mesh->start[g + 1]; j++)
            shared += t->mesh->corner[i] == t->mesh->corner[j];
    return shared == 3;
}

/* The vertex of corner k, inner and of the two faces f and g only, goes: out of both faces, a triangle's
 * place being taken by the other one, or, where its neighbours have an edge already, with the edges between
 * them. */
static bool drop_vertex(tidying *t, pc_index k, pc_index f, pc_index g) {
    const pc_index before = previous_corner(t, k), v = t->mesh->corner[k];
    const bool triangle = t->left[f] == 3 || t->left[g] == 3;
    if (t->left[f] + t->left[g] < 7) return false;
    if (triangle || !has_edge_to(t, before, t->mesh->corner[next_corner(t, k)])) {
        t->drop[v] = 1;
        t->left[f] = t->left[f] > 3 ? t->left[f] - 1 : 0;
        t->left[g] = t->left[g] > 3 ? t->left[g] - 1 : 0;
    } else {
        if (!share_three(t, f, g)) return false;
        t->open[k] = t->open[t->graph.twin[k]] = 1;
        t->open[before] = t->open[t->graph.twin[before]] = 1;
        t->left[f] += t->left[g] - 4;
        t->left[g] = 0;
    }
    t->changed[f] = t->changed[g] = 1;
    return true;
}

static bool drop_useless(tidying *t) {
    bool dropped = false;
    for (pc_index f = 0; f < t->mesh->face_count; f++)
        t->left[f] = t->mesh->start[f + 1] - t->mesh->start[f];
    for (pc_index k = 0; k < t->graph.corner_count; k++) {
        pc_index v = t->mesh->corner[k], f = t->graph.face[k];
        if (t->border[v] || t->faces[v] != 2 || t->graph.twin[k] == PC_NONE || t->changed[f]) continue;
        pc_index g = t->graph.face[t->graph.twin[k]];
        if (f != g && !t->changed[g]) dropped |= drop_vertex(t, k, f, g);
    }
    return dropped;
}

/* T-junctions are between three faces inside of the mesh, and in the side of one. */
static pc_status write_tidied(tidying *t, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_polymesh *p = t->mesh;
    pc_polymesh out = {0};
    pc_index at = 0, face = 0;
    PC_TRY(pc_polymesh_make(&out, ctx, p->vertex_count, p->face_count, t->graph.corner_count));
    memcpy(out.position, p->position, 3 * sizeof(double) * p->vertex_count);
    for (pc_index f = 0; f < p->face_count; f++) {
        if (!t->left[f]) continue;
        pc_index first = p->start[f];
        while (t->open[first])
            first++;
        pc_index k = first;
        do {
            pc_index v = p->corner[k];
            bool flat = p->corner_flat[k] && t->left[f] > 4 && !t->border[v] && t->faces[v] == 3;
            out.corner_flat[at] = flat && t->flats[v] == 1;
            if (!t->drop[v]) out.corner[at++] = v;
            k = next_corner(t, k);
            while (t->open[k])
                k = next_corner(t, t->graph.twin[k]);
        } while (k != first);
        t->source[face] = t->source[f];
        out.start[++face] = at;
    }
    out.face_count = face;
    pc_polymesh_free(t->mesh, ctx);
    *t->mesh = out;
done:
    return status;
}

static pc_status look_at_vertices(tidying *t, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_polymesh *p = t->mesh;
    PC_TRY(pc_polygraph_of_polymesh(&t->graph, ctx, p));
    PC_TRY(pc_new(&t->open, ctx, t->graph.corner_count));
    PC_TRY(pc_new(&t->changed, ctx, p->face_count));
    PC_TRY(pc_new(&t->border, ctx, p->vertex_count));
    PC_TRY(pc_new(&t->faces, ctx, p->vertex_count));
    PC_TRY(pc_new(&t->flats, ctx, p->vertex_count));
    PC_TRY(pc_new(&t->drop, ctx, p->vertex_count));
    PC_TRY(pc_new(&t->left, ctx, p->face_count));
    for (pc_index k = 0; k < t->graph.corner_count; k++) {
        pc_index v = p->corner[k], f = t->graph.face[k];
        pc_index w = p->corner[pc_polymesh_next(p, f, k)];
        t->faces[v]++;
        t->flats[v] += p->corner_flat[k];
        if (t->graph.twin[k] != PC_NONE) continue;
        if (!t->graph.boundary[k])
            PC_TRY(pc_fail(ctx, PC_E_MESH,
                           "the edge at corner %u of face %u is shared by more than two faces",
                           k - p->start[f], t->source[f]));
        t->border[v] = t->border[w] = 1;
    }
done:
    return status;
}

/* All of one pass. */
static void forget(tidying *t, pc_context *ctx) {
    pc_polygraph_free(&t->graph, ctx);
    pc_free(ctx, t->faces);
    pc_free(ctx, t->flats);
    pc_free(ctx, t->left);
    pc_free(ctx, t->drop);
    pc_free(ctx, t->changed);
    pc_free(ctx, t->open);
    pc_free(ctx, t->border);
    *t = (tidying){.mesh = t->mesh, .source = t->source};
}

pc_status pc_spare_drop(pc_polymesh *mesh, pc_index **source, uint8_t **border, pc_context *ctx) {
    pc_status status = PC_OK;
    tidying t = {.mesh = mesh};
    bool dropped = true;
    *source = NULL, *border = NULL;
    PC_TRY(pc_new(source, ctx, mesh->face_count));
    for (pc_index f = 0; f < mesh->face_count; f++)
        (*source)[f] = f;
    t.source = *source;
    while (dropped) {
        forget(&t, ctx);
        PC_TRY(look_at_vertices(&t, ctx));
        dropped = drop_useless(&t);
        PC_TRY(write_tidied(&t, ctx));
    }
    *border = t.border, t.border = NULL;
done:
    forget(&t, ctx);
    return status;
}
