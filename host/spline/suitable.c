#include "suitable.h"
#include "memory.h"
#include "ray.h"
#include <string.h>

pc_index pc_suitable_junction(const pc_tmesh *mesh, pc_index v) {
    pc_index first = mesh->vertex[v].out, h = first;
    if (mesh->vertex[v].extraordinary) return PC_NONE;
    do {
        if (mesh->half[h].face != PC_NONE && !pc_thalf_turns(mesh, h)) return h;
        h = pc_thalf_ccw(mesh, h);
    } while (h != first);
    return PC_NONE;
}

/* Who came by, in either of two directions: along s and t in a face, from `out` and across it at a vertex,
 * along and across an edge. The first one stays. */
typedef struct trace {
    pc_index by[2];
} trace;

typedef struct tracing {
    const pc_tmesh *mesh;
    trace *face, *vertex, *half; /* edges by the smaller of their two half-edges */
    pc_crossing *crossing;
    size_t count, room;
} tracing;

static pc_status mark(tracing *t, pc_context *ctx, trace *at, int way, pc_index junction) {
    pc_status status = PC_OK;
    if (at->by[way] == PC_NONE) at->by[way] = junction;
    if (at->by[1 - way] == PC_NONE) return PC_OK;
    if (t->count == t->room) {
        PC_TRY(pc_resize(&t->crossing, ctx, 2 * t->room + 16));
        t->room = 2 * t->room + 16;
    }
    t->crossing[t->count++] = (pc_crossing){{junction, at->by[1 - way]}};
done:
    return status;
}

/* Whether a ray that leaves (or comes in along) half-edge h or across its face runs along direction 0 and 2
 * of the star of h's tail (0) or along 1 and 3 (1). */
static int way_at(const pc_tmesh *mesh, pc_index h, bool across) {
    pc_star star;
    pc_star_make(&star, mesh, mesh->half[h].tail);
    for (int d = 0; d < 4; d++)
        if (star.ray[d].half == h && (star.ray[d].way == PC_RAY_ACROSS) == across) return d & 1;
    return 0;
}

static trace *edge_trace(tracing *t, pc_index h) {
    pc_index twin = t->mesh->half[h].twin;
    return t->half + (h < twin ? h : twin);
}

/* Marks what the ray meets on its next step, and where it comes to. */
static pc_status follow(tracing *t, pc_context *ctx, pc_ray *ray, pc_index junction) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = t->mesh;
    pc_ray now = *ray;
    if (now.way == PC_RAY_ENDED) return PC_OK;
    (void)pc_ray_step(ray, mesh);
    if (now.way == PC_RAY_ALONG) {
        PC_TRY(mark(t, ctx, edge_trace(t, now.half), 0, junction));
        pc_index back = mesh->half[now.half].twin, head = mesh->half[back].tail;
        if (!mesh->vertex[head].extraordinary)
            PC_TRY(mark(t, ctx, t->vertex + head, way_at(mesh, back, false), junction));
    } else if (mesh->half[now.half].face != PC_NONE) {
        PC_TRY(
            mark(t, ctx, t->face + mesh->half[now.half].face, (mesh->half[now.half].side + 1) & 1, junction));
        if (ray->way == PC_RAY_ACROSS && ray->offset > 0)
            PC_TRY(mark(t, ctx, edge_trace(t, ray->half), 1, junction));
        else if (ray->way != PC_RAY_ENDED)
            PC_TRY(mark(t, ctx, t->vertex + mesh->half[ray->half].tail,
                        way_at(mesh, ray->half, ray->way == PC_RAY_ACROSS), junction));
    }
done:
    return status;
}

static pc_status trace_junction(tracing *t, pc_context *ctx, pc_index v) {
    pc_status status = PC_OK;
    pc_star star;
    pc_star_make(&star, t->mesh, v);
    for (int d = 0; d < 4; d++) {
        if (star.ray[d].way != PC_RAY_ACROSS) continue;
        pc_ray ahead = star.ray[d], back = star.ray[(d + 2) & 3];
        PC_TRY(mark(t, ctx, t->vertex + v, d & 1, v));
        PC_TRY(follow(t, ctx, &ahead, v));
        PC_TRY(follow(t, ctx, &ahead, v));
        PC_TRY(follow(t, ctx, &back, v));
    }
done:
    return status;
}

pc_status pc_suitable_crossings(pc_crossing **crossings, size_t *count, pc_index *junctions, pc_context *ctx,
                                const pc_tmesh *mesh) {
    pc_status status = PC_OK;
    tracing t = {.mesh = mesh};
    pc_index found = 0;
    *crossings = NULL, *count = 0;
    PC_TRY(pc_new(&t.face, ctx, mesh->face_count));
    PC_TRY(pc_new(&t.vertex, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&t.half, ctx, mesh->half_count));
    memset(t.face, 0xff, mesh->face_count * sizeof *t.face);
    memset(t.vertex, 0xff, mesh->vertex_count * sizeof *t.vertex);
    memset(t.half, 0xff, mesh->half_count * sizeof *t.half);
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        if (pc_suitable_junction(mesh, v) == PC_NONE) continue;
        found++;
        PC_TRY(trace_junction(&t, ctx, v));
    }
    *crossings = t.crossing, *count = t.count, t.crossing = NULL;
    if (junctions) *junctions = found;
done:
    pc_free(ctx, t.face);
    pc_free(ctx, t.vertex);
    pc_free(ctx, t.half);
    pc_free(ctx, t.crossing);
    return status;
}
