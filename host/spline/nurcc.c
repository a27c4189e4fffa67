#include "nurcc.h"
#include "memory.h"
#include "ray.h"
#include "ringmesh.h"
#include <string.h>

/* Growing lists of the faces and vertices around one face. */
typedef struct gathering {
    const pc_tmesh *mesh;
    pc_index face_count, vertex_count, room;
    pc_index *face, *vertex;
} gathering;

static pc_index find(const pc_index *list, pc_index count, pc_index wanted) {
    for (pc_index i = 0; i < count; i++)
        if (list[i] == wanted) return i;
    return PC_NONE;
}

static pc_status gather(gathering *g, pc_context *ctx, pc_index f) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = g->mesh;
    for (pc_index c = 0, h = mesh->face[f].first; c < 4; c++, h = mesh->half[h].next) {
        pc_index first = h, e = h;
        do {
            pc_index face = mesh->half[e].face;
            if (find(g->face, g->face_count, face) == PC_NONE) {
                if (g->face_count == g->room) {
                    g->room += 32;
                    PC_TRY(pc_resize(&g->face, ctx, g->room));
                    PC_TRY(pc_resize(&g->vertex, ctx, 4 * (size_t)g->room));
                }
                g->face[g->face_count++] = face;
                for (pc_index k = 0, v = mesh->face[face].first; k < 4; k++, v = mesh->half[v].next)
                    if (find(g->vertex, g->vertex_count, mesh->half[v].tail) == PC_NONE)
                        g->vertex[g->vertex_count++] = mesh->half[v].tail;
            }
            e = pc_thalf_ccw(mesh, e);
        } while (e != first);
    }
done:
    return status;
}

static double interval_behind(const pc_tmesh *mesh, pc_index h) {
    pc_ray ray = pc_ray_behind(mesh, h);
    return pc_ray_step(&ray, mesh);
}

static pc_status fill_face(pc_ringface *to, pc_context *ctx, const gathering *g, pc_index f) {
    const pc_tmesh *mesh = g->mesh;
    pc_index h = mesh->face[f].first;
    for (int k = 0; k < 4; k++, h = mesh->half[h].next) {
        const pc_thalf *e = mesh->half + h;
        if (e->side != k)
            return pc_fail(ctx, PC_E_BUG, "face %u beside an extraordinary vertex has T-junctions", f);
        to->vertex[k] = find(g->vertex, g->vertex_count, e->tail);
        to->near[k] = find(g->face, g->face_count, mesh->half[e->twin].face);
        to->near_side[k] = mesh->half[e->twin].side;
        to->interval[k] = e->interval;
        to->ahead[k] = interval_behind(mesh, h);
        to->behind[k] = interval_behind(mesh, e->twin);
    }
    return PC_OK;
}

static pc_status make_ring(pc_ringmesh *ring, pc_index **point, pc_context *ctx, const pc_tmesh *mesh,
                           pc_index f) {
    pc_status status = PC_OK;
    gathering g = {.mesh = mesh};
    *ring = (pc_ringmesh){0};
    PC_TRY(gather(&g, ctx, f));
    pc_index *middle = g.face + find(g.face, g.face_count, f);
    *middle = g.face[0], g.face[0] = f;
    PC_TRY(pc_ringmesh_make(ring, ctx, g.face_count, g.vertex_count, g.vertex_count));
    ring->face_count = g.face_count;
    ring->vertex_count = g.vertex_count;
    for (pc_index i = 0; i < g.face_count; i++)
        PC_TRY(fill_face(ring->face + i, ctx, &g, g.face[i]));
    for (pc_index v = 0; v < g.vertex_count; v++) {
        const pc_tvertex *from = mesh->vertex + g.vertex[v];
        ring->vertex[v] = (pc_ringvertex){from->extraordinary, from->depth};
        ring->row[(size_t)v * g.vertex_count + v] = 1;
    }
    *point = g.vertex, g.vertex = NULL;
done:
    pc_free(ctx, g.face);
    pc_free(ctx, g.vertex);
    if (status != PC_OK) pc_ringmesh_free(ring, ctx);
    return status;
}

static bool is_ready(const pc_ringmesh *ring, int level) {
    for (int k = 0; k < 4; k++) {
        const pc_ringvertex *v = ring->vertex + ring->face[0].vertex[k];
        if (v->extraordinary && v->depth > level) return false;
    }
    return true;
}

static pc_status emit(pc_patches *patches, pc_context *ctx, const pc_ringmesh *ring, const double low[2],
                      const double high[2]) {
    pc_status status = PC_OK;
    size_t size = 16 * (size_t)patches->point_count;
    PC_TRY(pc_resize(&patches->patch, ctx, (size_t)patches->patch_count + 1));
    PC_TRY(pc_resize(&patches->weight, ctx, ((size_t)patches->patch_count + 1) * size));
    pc_ringmesh_bezier(patches->weight + patches->patch_count * size, ring);
    patches->patch[patches->patch_count++] = (pc_patch){.low = {low[0], low[1]}, .high = {high[0], high[1]}};
done:
    return status;
}

static pc_status divide(pc_patches *patches, pc_context *ctx, const pc_ringmesh *ring, int level,
                        const double low[2], const double high[2]) {
    pc_status status = PC_OK;
    pc_ringmesh finer = {0}, part = {0};
    pc_index middle[4];
    if (is_ready(ring, level)) return emit(patches, ctx, ring, low, high);
    PC_TRY(pc_ringmesh_subdivide(&finer, middle, ctx, ring));
    for (int k = 0; k < 4; k++) {
        bool right = k == 1 || k == 2, top = k >= 2;
        double half[2] = {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2};
        PC_TRY(pc_ringmesh_around(&part, ctx, &finer, middle[k]));
        PC_TRY(divide(patches, ctx, &part, level + 1,
                      (const double[2]){right ? half[0] : low[0], top ? half[1] : low[1]},
                      (const double[2]){right ? high[0] : half[0], top ? high[1] : half[1]}));
        pc_ringmesh_free(&part, ctx);
    }
done:
    pc_ringmesh_free(&finer, ctx);
    pc_ringmesh_free(&part, ctx);
    return status;
}

pc_status pc_nurcc_make(pc_patches *patches, pc_context *ctx, const pc_tmesh *mesh, pc_index f) {
    pc_status status = PC_OK;
    pc_ringmesh ring = {0};
    *patches = (pc_patches){0};
    PC_TRY(make_ring(&ring, &patches->point, ctx, mesh, f));
    patches->point_count = ring.width;
    PC_TRY(divide(patches, ctx, &ring, 0, (const double[2]){0, 0}, mesh->face[f].size));
    for (pc_index i = 0; i < patches->patch_count; i++)
        patches->patch[i].weight = patches->weight + (size_t)i * 16 * ring.width;
done:
    pc_ringmesh_free(&ring, ctx);
    if (status != PC_OK) pc_nurcc_free(patches, ctx);
    return status;
}

void pc_nurcc_free(pc_patches *patches, pc_context *ctx) {
    pc_free(ctx, patches->point);
    pc_free(ctx, patches->patch);
    pc_free(ctx, patches->weight);
    *patches = (pc_patches){0};
}
