#include "spline_store.h"
#include "closure.h"
#include "columns.h"
#include "memory.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* The mesh as plain arrays. */
typedef struct arrays {
    double *position, *interval, *along, *size, *origin;
    pc_index *out, *tail, *next, *prev, *twin, *face, *first, *root;
    uint8_t *extraordinary, *depth, *side, *ghost;
} arrays;

enum { VERTICES, HALVES, FACES, KINDS };

static const pc_column columns[] = {
    {"position", PC_STORE_F64, 3, VERTICES, offsetof(arrays, position), false, "model",
     "control point at each vertex, in the frame of the input"},
    {"out", PC_STORE_U32, 0, VERTICES, offsetof(arrays, out), false, "1",
     "a half-edge that leaves each vertex; on the outer rim the one whose twin has no face"},
    {"extraordinary", PC_STORE_U8, 0, VERTICES, offsetof(arrays, extraordinary), false, "1",
     "per vertex: 1 where the angles of the faces around do not sum to a full turn"},
    {"depth", PC_STORE_U8, 0, VERTICES, offsetof(arrays, depth), false, "1",
     "subdivisions around each extraordinary vertex before the closing patches"},
    {"tail", PC_STORE_U32, 0, HALVES, offsetof(arrays, tail), false, "1",
     "vertex that each half-edge leaves"},
    {"next", PC_STORE_U32, 0, HALVES, offsetof(arrays, next), false, "1",
     "half-edge that follows each around its face"},
    {"prev", PC_STORE_U32, 0, HALVES, offsetof(arrays, prev), false, "1",
     "half-edge that precedes each around its face"},
    {"twin", PC_STORE_U32, 0, HALVES, offsetof(arrays, twin), false, "1", "the same edge from its other end"},
    {"face", PC_STORE_U32, 0, HALVES, offsetof(arrays, face), false, "1",
     "face on the left of each half-edge, 4294967295 outside of the rim"},
    {"interval", PC_STORE_F64, 0, HALVES, offsetof(arrays, interval), false, "knot",
     "knot interval of each half-edge"},
    {"along", PC_STORE_F64, 0, HALVES, offsetof(arrays, along), false, "knot",
     "knots from the corner where a side of the face starts to the tail of each half-edge"},
    {"side", PC_STORE_U8, 0, HALVES, offsetof(arrays, side), false, "1",
     "side of the face that each half-edge is on: 0 +s, 1 +t, 2 -s, 3 -t"},
    {"first", PC_STORE_U32, 0, FACES, offsetof(arrays, first), false, "1",
     "half-edge of each face that leaves its corner (0,0) along s"},
    {"size", PC_STORE_F64, 2, FACES, offsetof(arrays, size), false, "knot",
     "extent of each face's parameters (s,t)"},
    {"root", PC_STORE_U32, 0, FACES, offsetof(arrays, root), false, "1",
     "face of the mesh before the last refinement that each is a part of"},
    {"origin", PC_STORE_F64, 2, FACES, offsetof(arrays, origin), false, "knot",
     "corner (0,0) of each face in the parameters of its root"},
    {"ghost", PC_STORE_U8, 0, FACES, offsetof(arrays, ghost), false, "1",
     "per face: 1 where it only carries control points beyond a border of the surface"},
};

static void free_arrays(arrays *a, pc_context *ctx) {
    for (size_t i = 0; i < COUNT(columns); i++) {
        void *array;
        memcpy((void *)&array, (char *)a + columns[i].pointer, sizeof array);
        pc_free(ctx, array);
    }
}

static pc_status make_arrays(arrays *a, pc_context *ctx, const size_t *counts) {
    pc_status status = PC_OK;
    static const size_t bytes[] = {[PC_STORE_U8] = 1, [PC_STORE_U32] = 4, [PC_STORE_F64] = 8};
    *a = (arrays){0};
    for (size_t i = 0; i < COUNT(columns); i++) {
        const pc_column *c = columns + i;
        uint8_t *array;
        size_t width = c->width ? (size_t)c->width : 1;
        PC_TRY(pc_new(&array, ctx, counts[c->rows] * width * bytes[c->type]));
        memcpy((char *)a + c->pointer, (void *)&array, sizeof array);
    }
done:
    return status;
}

static void pack(arrays *a, const pc_tspline *spline) {
    const pc_tmesh *mesh = &spline->mesh;
    memcpy(a->position, spline->position, 3 * sizeof(double) * mesh->vertex_count);
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        const pc_tvertex *from = mesh->vertex + v;
        a->out[v] = from->out, a->extraordinary[v] = from->extraordinary, a->depth[v] = from->depth;
    }
    for (size_t h = 0; h < mesh->half_count; h++) {
        const pc_thalf *from = mesh->half + h;
        a->tail[h] = from->tail, a->next[h] = from->next, a->prev[h] = from->prev, a->twin[h] = from->twin;
        a->face[h] = from->face, a->side[h] = from->side;
        a->interval[h] = from->interval, a->along[h] = from->along;
    }
    for (size_t f = 0; f < mesh->face_count; f++) {
        const pc_tface *from = mesh->face + f;
        a->first[f] = from->first, a->root[f] = from->root, a->ghost[f] = from->ghost;
        memcpy(a->size + 2 * f, from->size, sizeof from->size);
        memcpy(a->origin + 2 * f, from->origin, sizeof from->origin);
    }
}

/* `mesh` has room. */
static void unpack(pc_tmesh *mesh, const arrays *a) {
    for (size_t v = 0; v < mesh->vertex_count; v++)
        mesh->vertex[v] = (pc_tvertex){a->out[v], a->extraordinary[v], a->depth[v]};
    for (size_t h = 0; h < mesh->half_count; h++)
        mesh->half[h] = (pc_thalf){.tail = a->tail[h],
                                   .next = a->next[h],
                                   .prev = a->prev[h],
                                   .twin = a->twin[h],
                                   .face = a->face[h],
                                   .interval = a->interval[h],
                                   .along = a->along[h],
                                   .side = a->side[h]};
    for (size_t f = 0; f < mesh->face_count; f++)
        mesh->face[f] = (pc_tface){.first = a->first[f],
                                   .size = {a->size[2 * f], a->size[2 * f + 1]},
                                   .root = a->root[f],
                                   .origin = {a->origin[2 * f], a->origin[2 * f + 1]},
                                   .ghost = a->ghost[f]};
}

pc_status pc_tspline_save(pc_store *store, const char *group, const pc_tspline *spline) {
    pc_status status = PC_OK;
    pc_context *ctx = pc_store_context(store);
    const size_t counts[KINDS] = {spline->mesh.vertex_count, spline->mesh.half_count,
                                  spline->mesh.face_count};
    arrays a = {0};
    PC_TRY(make_arrays(&a, ctx, counts));
    pack(&a, spline);
    PC_TRY(pc_columns_save(store, group, columns, COUNT(columns), &a, counts));
done:
    free_arrays(&a, ctx);
    return status;
}

/* What went wrong in the words of the mesh's own checks, with the file before it. */
static pc_status unfit(pc_store *store, const char *group) {
    pc_context *ctx = pc_store_context(store);
    char why[512];
    (void)snprintf(why, sizeof why, "%s", pc_context_message(ctx));
    pc_context_clear_message(ctx);
    return pc_fail(ctx, PC_E_FORMAT, "%s: '%s': %s", pc_store_path(store), group, why);
}

static pc_status wrong(pc_store *store, const char *group, const char *what, size_t at, const char *why) {
    return pc_fail(pc_store_context(store), PC_E_FORMAT, "%s: '%s': %s %zu %s", pc_store_path(store), group,
                   what, at, why);
}

/* Every array by itself. */
static pc_status check_ranges(const arrays *a, const size_t *counts, pc_store *store, const char *group) {
    pc_status status = PC_OK;
    const size_t vertices = counts[VERTICES], halves = counts[HALVES], faces = counts[FACES];
    PC_TRY(pc_columns_below(store, group, "out", a->out, vertices, halves, false));
    PC_TRY(pc_columns_bytes_below(store, group, "extraordinary", a->extraordinary, vertices, 2));
    PC_TRY(pc_columns_below(store, group, "tail", a->tail, halves, vertices, false));
    PC_TRY(pc_columns_below(store, group, "next", a->next, halves, halves, false));
    PC_TRY(pc_columns_below(store, group, "prev", a->prev, halves, halves, false));
    PC_TRY(pc_columns_below(store, group, "twin", a->twin, halves, halves, false));
    PC_TRY(pc_columns_below(store, group, "face", a->face, halves, faces, true));
    PC_TRY(pc_columns_bytes_below(store, group, "side", a->side, halves, 4));
    PC_TRY(pc_columns_below(store, group, "first", a->first, faces, halves, false));
    PC_TRY(pc_columns_below(store, group, "root", a->root, faces, faces, false));
    PC_TRY(pc_columns_bytes_below(store, group, "ghost", a->ghost, faces, 2));
    if (faces == 0 || !memchr(a->ghost, 0, faces))
        PC_TRY(pc_fail(pc_store_context(store), PC_E_FORMAT, "%s: '%s': no face of a surface",
                       pc_store_path(store), group));
    for (size_t i = 0; i < 3 * vertices; i++)
        if (!isfinite(a->position[i])) PC_TRY(wrong(store, group, "vertex", i / 3, "is nowhere"));
done:
    return status;
}

/* Intervals come of halving, so that sums of them are exact and comparisons of knots are too: no walk along
 * the mesh can miss its end. */
static bool is_knot(double x, double least) {
    const double finest = 0x1p-44, most = 64;
    return x >= least && x <= most && x / finest == floor(x / finest);
}

static pc_status check_knots(const arrays *a, const size_t *counts, pc_store *store, const char *group) {
    for (size_t h = 0; h < counts[HALVES]; h++)
        if (!is_knot(a->interval[h], 0x1p-44) || !is_knot(a->along[h], 0))
            return wrong(store, group, "half-edge", h, "has an interval that does not come of halving");
    for (size_t i = 0; i < 2 * counts[FACES]; i++)
        if (!is_knot(a->size[i], 0x1p-44) || !is_knot(a->origin[i], 0))
            return wrong(store, group, "face", i / 2, "has a size or origin that does not come of halving");
    return PC_OK;
}

/* What pc_tmesh_check takes for granted: each half-edge is in the circle of its face and in that of its
 * tail, the rim has the surface on its other side and a circle passes it once. */
static pc_status check_circles(const pc_tmesh *mesh, pc_store *store, const char *group) {
    size_t seen = 0;
    for (pc_index h = 0; h < mesh->half_count; h++) {
        const pc_thalf *e = mesh->half + h;
        if (e->face != PC_NONE) continue;
        seen++;
        if (mesh->half[e->twin].face == PC_NONE || mesh->vertex[pc_thalf_head(mesh, h)].out != e->twin)
            return wrong(store, group, "half-edge", h, "is not beside the rim of the surface");
    }
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_index h = mesh->face[f].first;
        do {
            seen++, h = mesh->half[h].next;
        } while (h != mesh->face[f].first);
    }
    if (seen != mesh->half_count)
        return wrong(store, group, "number of half-edges", mesh->half_count, "is not what the faces have");
    seen = 0;
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_index first = mesh->vertex[v].out, h = first, valence = 0;
        do {
            valence++, h = pc_thalf_ccw(mesh, h);
        } while (h != first);
        seen += valence;
        if (valence > PC_TMESH_VALENCE)
            return wrong(store, group, "vertex", v, "is in more faces than are supported");
    }
    if (seen != mesh->half_count)
        return wrong(store, group, "number of half-edges", mesh->half_count, "is not what the vertices have");
    return PC_OK;
}

/* Around every point of the surface lies a full ring of faces; depths belong to extraordinary vertices. */
static pc_status check_rings(const pc_tmesh *mesh, pc_store *store, const char *group) {
    enum { DEEPEST = 32 };
    for (pc_index h = 0; h < mesh->half_count; h++) {
        const pc_thalf *e = mesh->half + h;
        pc_index behind = mesh->half[mesh->half[mesh->vertex[e->tail].out].twin].face;
        if (e->face != PC_NONE && !mesh->face[e->face].ghost && behind == PC_NONE)
            return wrong(store, group, "face", e->face, "of the surface is on the rim of the ghosts");
    }
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        if (mesh->vertex[v].depth > (mesh->vertex[v].extraordinary ? DEEPEST : 0))
            return wrong(store, group, "vertex", v, "has a depth that makes no sense");
    return PC_OK;
}

static pc_status check_mesh(const pc_tmesh *mesh, pc_store *store, const char *group) {
    pc_status status = PC_OK;
    if (pc_tmesh_check(mesh, pc_store_context(store)) != PC_OK) PC_TRY(unfit(store, group));
    PC_TRY(check_circles(mesh, store, group));
    PC_TRY(check_rings(mesh, store, group));
    status = pc_closure_check(mesh, pc_store_context(store));
    if (status == PC_E_BUG) PC_TRY(unfit(store, group));
done:
    return status;
}

pc_status pc_tspline_load(pc_tspline *spline, pc_store *store, const char *group) {
    pc_status status = PC_OK;
    pc_context *ctx = pc_store_context(store);
    size_t counts[KINDS] = {PC_STORE_ANY, PC_STORE_ANY, PC_STORE_ANY};
    arrays a = {0};
    *spline = (pc_tspline){0};
    PC_TRY(pc_columns_load(&a, counts, store, group, columns, COUNT(columns)));
    PC_TRY(check_ranges(&a, counts, store, group));
    PC_TRY(check_knots(&a, counts, store, group));
    PC_TRY(pc_tmesh_reserve(&spline->mesh, ctx, counts[VERTICES], counts[HALVES], counts[FACES]));
    spline->mesh.vertex_count = (pc_index)counts[VERTICES];
    spline->mesh.half_count = (pc_index)counts[HALVES];
    spline->mesh.face_count = (pc_index)counts[FACES];
    unpack(&spline->mesh, &a);
    PC_TRY(check_mesh(&spline->mesh, store, group));
    spline->position = a.position, a.position = NULL;
    status = pc_tspline_complete(spline, ctx);
    if (status == PC_E_BUG) PC_TRY(unfit(store, group));
done:
    free_arrays(&a, ctx);
    if (status != PC_OK) pc_tspline_free(spline, ctx);
    return status;
}
