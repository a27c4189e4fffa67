#include "doublet.h"
#include "memory.h"

enum { MOST_PASSES = 32 };

typedef struct touching {
    pc_index count;     /* faces at the vertex */
    pc_index corner[2]; /* where the first two of them have it */
} touching;

static pc_status gather(touching **vertex, pc_context *ctx, const pc_polymesh *quads) {
    pc_status status = pc_new(vertex, ctx, quads->vertex_count);
    if (status != PC_OK) return status;
    for (pc_index c = 0; c < quads->start[quads->face_count]; c++) {
        touching *t = &(*vertex)[quads->corner[c]];
        if (t->count < 2) t->corner[t->count] = c;
        t->count++;
    }
    return PC_OK;
}

static bool is_quad(const pc_polymesh *quads, pc_index f) {
    return quads->start[f + 1] - quads->start[f] == 4;
}

/* The corner `by` steps on in the quad that holds corner c; every face before it is a quad too. */
static pc_index turned(pc_index first, pc_index c, pc_index by) {
    return first + (c - first + by) % 4;
}

/* Faces a < b around v as a: v x p y and b: v y q x become a: x p y q. False where that is not what they are.
 */
static bool join(pc_polymesh *quads, const touching *vertex, pc_index v, const pc_index *face_of,
                 uint8_t *locked, uint8_t *removed_face, pc_index least) {
    pc_index ca = vertex[v].corner[0], cb = vertex[v].corner[1], a = face_of[ca], b = face_of[cb];
    if (a == b || locked[a] || locked[b] || !is_quad(quads, a) || !is_quad(quads, b)) return false;
    pc_index *corner = quads->corner, sa = quads->start[a], sb = quads->start[b];
    pc_index x = corner[turned(sa, ca, 1)], p = corner[turned(sa, ca, 2)], y = corner[turned(sa, ca, 3)];
    pc_index q = corner[turned(sb, cb, 2)];
    if (corner[turned(sb, cb, 1)] != y || corner[turned(sb, cb, 3)] != x || p == q) return false;
    if (vertex[x].count < least || vertex[y].count < least) return false;
    corner[sa] = x, corner[sa + 1] = p, corner[sa + 2] = y, corner[sa + 3] = q;
    locked[a] = 1, locked[b] = 1;
    removed_face[b] = 1;
    return true;
}

static pc_status pass(pc_polymesh *quads, pc_index *removed, pc_context *ctx, pc_index least) {
    pc_status status = PC_OK;
    touching *vertex = NULL;
    pc_index *face_of = NULL, before = *removed;
    uint8_t *locked = NULL, *removed_face = NULL;
    PC_TRY(gather(&vertex, ctx, quads));
    PC_TRY(pc_new(&face_of, ctx, quads->start[quads->face_count]));
    PC_TRY(pc_new(&locked, ctx, quads->face_count));
    PC_TRY(pc_new(&removed_face, ctx, quads->face_count));
    for (pc_index f = 0; f < quads->face_count; f++)
        for (pc_index c = quads->start[f]; c < quads->start[f + 1]; c++)
            face_of[c] = f;
    for (pc_index v = 0; v < quads->vertex_count; v++)
        if (vertex[v].count == 2 && join(quads, vertex, v, face_of, locked, removed_face, least)) ++*removed;
    if (*removed > before) PC_TRY(pc_polymesh_compact(quads, ctx, removed_face));
done:
    pc_free(ctx, vertex);
    pc_free(ctx, face_of);
    pc_free(ctx, locked);
    pc_free(ctx, removed_face);
    return status;
}

pc_status pc_doublets_remove(pc_polymesh *quads, pc_index *removed, pc_context *ctx, bool at_borders) {
    const pc_index least = at_borders ? 2 : 3; /* two faces around a vertex inside: p would be q */
    *removed = 0;
    for (int i = 0; i < MOST_PASSES; i++) {
        pc_index before = *removed;
        pc_status status = pass(quads, removed, ctx, least);
        if (status != PC_OK) return status;
        if (*removed == before) break;
    }
    return PC_OK;
}
