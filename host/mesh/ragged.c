#include "ragged.h"
#include "geometry.h"
#include "memory.h"
#include "topology.h"
#include <string.h>

enum { WINDOW = 8 }; /* border edges on each side that tell whether a place is ragged */

/* One place of a border: a vertex, and who comes before and after it while faces are added. Borders have the
 * surface on their left. */
typedef struct place {
    pc_index vertex, before, after; /* the last two: places */
    double inside;                  /* angle of the surface at the vertex */
    pc_vec3 normal;                 /* unit, of the face along the edge to `after` */
    bool ragged;
} place;

/* An edge that has been added: a chain of them per vertex. */
typedef struct added_edge {
    pc_index head, next;
} added_edge;

typedef struct filling {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    place *place;
    pc_index place_count;
    pc_index *triangle; /* 3 per added face */
    pc_index face_count;
    pc_index *first_added; /* per vertex: chain of added edges; PC_NONE */
    added_edge *added;
    pc_index added_count;
    double most; /* length of an edge that is added */
    pc_index closed;
} filling;

static pc_vec3 point(const filling *f, pc_index p) {
    return pc_vec3_at(f->mesh->position, f->place[p].vertex);
}

static double angle_at(pc_vec3 at, pc_vec3 a, pc_vec3 b) {
    return pc_angle(pc_sub(a, at), pc_sub(b, at));
}

static double fan_angle(const filling *f, pc_index v) {
    double sum = 0;
    for (pc_index h = f->adjacency->vertex_half[v]; h != PC_NONE; h = pc_turn_ccw(f->adjacency, h))
        sum += pc_corner_angle(f->mesh, h);
    return sum;
}

static pc_vec3 face_normal(const pc_mesh *mesh, pc_index face) {
    const pc_index *t = mesh->triangle + 3 * (size_t)face;
    return pc_triangle_normal(pc_vec3_at(mesh->position, t[0]), pc_vec3_at(mesh->position, t[1]),
                              pc_vec3_at(mesh->position, t[2]));
}

static void add_border(filling *f, const pc_index *half, pc_index count) {
    const pc_index first = f->place_count;
    for (pc_index k = 0; k < count; k++) {
        const pc_index v = pc_tail(f->mesh, half[k]);
        f->place[first + k] = (place){.vertex = v,
                                      .before = first + (k + count - 1) % count,
                                      .after = first + (k + 1) % count,
                                      .inside = fan_angle(f, v),
                                      .normal = face_normal(f->mesh, half[k] / 3)};
    }
    f->place_count += count;
}

/* How much more the border turns to and fro around p than it turns in all, per vertex: nothing along circles,
 * and little where there are corners. */
static double raggedness(const filling *f, pc_index p) {
    double sum = 0, all = 0;
    pc_index count = 0, q = p;
    for (int k = 0; k < WINDOW; k++)
        q = f->place[q].before;
    const pc_index first = q;
    do {
        const double turn = PC_PI - f->place[q].inside;
        sum += turn, all += fabs(turn), count++;
        q = f->place[q].after;
    } while (q != first && count < 2 * WINDOW + 1);
    return (all - fabs(sum)) / count;
}

static pc_status find_places(filling *f, pc_context *ctx) {
    const double least = PC_PI / 9;
    pc_status status = PC_OK;
    pc_topology topology = {0};
    double length = 0;
    PC_TRY(pc_topology_make(&topology, ctx, f->mesh, f->adjacency));
    PC_TRY(pc_new(&f->place, ctx, f->adjacency->boundary_edge_count));
    for (pc_index l = 0; l < topology.loop_count; l++)
        add_border(f, topology.loop_half + topology.loop_start[l],
                   topology.loop_start[l + 1] - topology.loop_start[l]);
    for (pc_index p = 0; p < f->place_count; p++) {
        f->place[p].ragged = raggedness(f, p) > least;
        length += pc_distance(point(f, p), point(f, f->place[p].after));
    }
    f->most = 4 * length / f->place_count;
done:
    pc_topology_free(&topology, ctx);
    return status;
}

static bool is_edge(const filling *f, pc_index v, pc_index w) {
    const pc_adjacency *a = f->adjacency;
    for (pc_index h = a->vertex_half[v]; h != PC_NONE; h = pc_turn_ccw(a, h))
        if (pc_head(f->mesh, h) == w || pc_tail(f->mesh, pc_prev(h)) == w) return true;
    for (pc_index e = f->first_added[v]; e != PC_NONE; e = f->added[e].next)
        if (f->added[e].head == w) return true;
    return false;
}

static void add_edge(filling *f, pc_index v, pc_index w) {
    f->added[f->added_count] = (added_edge){w, f->first_added[v]};
    f->first_added[v] = f->added_count++;
}

/* x is above the triangle, seen along its normal. */
static bool is_over(pc_vec3 x, pc_vec3 a, pc_vec3 b, pc_vec3 c, pc_vec3 normal) {
    return pc_dot(pc_cross(pc_sub(b, a), pc_sub(x, a)), normal) > 0 &&
           pc_dot(pc_cross(pc_sub(c, b), pc_sub(x, b)), normal) > 0 &&
           pc_dot(pc_cross(pc_sub(a, c), pc_sub(x, c)), normal) > 0;
}

/* The face between p and its neighbours would fill a notch of less than `limit`, in the surface's direction,
 * and cover nothing of the border nearby. */
static bool fills(const filling *f, pc_index p, double limit) {
    enum { NEARBY = 4 };
    const double steepest = 0.3;
    const place *at = f->place + p, *before = f->place + at->before, *after = f->place + at->after;
    const pc_vec3 a = point(f, at->before), b = point(f, p), c = point(f, at->after);
    const double gap = angle_at(b, a, c);
    if (!at->ragged || at->inside < PC_PI || gap > limit) return false;
    if (fabs(2 * PC_PI - at->inside - gap) > PC_PI / 3) return false; /* the surface is not flat there */
    const bool closes = after->after == at->before;
    if (!closes && (pc_distance(a, c) > f->most || is_edge(f, before->vertex, after->vertex))) return false;
    const pc_vec3 normal = pc_triangle_normal(b, a, c);
    if (pc_dot(normal, before->normal) < steepest || pc_dot(normal, at->normal) < steepest) return false;
    for (int k = 0; k < NEARBY; k++) {
        before = f->place + before->before, after = f->place + after->after;
        if (is_over(pc_vec3_at(f->mesh->position, before->vertex), b, a, c, normal) ||
            is_over(pc_vec3_at(f->mesh->position, after->vertex), b, a, c, normal))
            return false;
    }
    return true;
}

/* p leaves the border. */
static void fill(filling *f, pc_index p) {
    place *at = f->place + p, *before = f->place + at->before, *after = f->place + at->after;
    const pc_vec3 a = point(f, at->before), b = point(f, p), c = point(f, at->after);
    pc_index *corner = f->triangle + 3 * (size_t)f->face_count++;
    corner[0] = at->vertex, corner[1] = before->vertex, corner[2] = after->vertex;
    at->ragged = false;
    if (after->after == at->before) { /* the hole is closed */
        before->ragged = after->ragged = false;
        f->closed++;
        return;
    }
    add_edge(f, before->vertex, after->vertex);
    add_edge(f, after->vertex, before->vertex);
    before->inside += angle_at(a, b, c), after->inside += angle_at(c, a, b);
    before->normal = pc_triangle_normal(b, a, c);
    before->after = at->after, after->before = at->before;
}

/* The narrowest notches first, each from its bottom up. */
static void fill_all(filling *f) {
    static const double limit[] = {PC_PI / 3, PC_PI / 2, 2 * PC_PI / 3, 5 * PC_PI / 6};
    for (size_t k = 0; k < sizeof limit / sizeof *limit; k++)
        for (bool more = true; more;) {
            more = false;
            for (pc_index p = 0; p < f->place_count; p++)
                if (fills(f, p, limit[k])) fill(f, p), more = true;
        }
}

static pc_status append(pc_mesh *mesh, pc_context *ctx, const filling *f) {
    pc_mesh grown;
    pc_status status =
        pc_mesh_make(&grown, ctx, mesh->vertex_count, (size_t)mesh->face_count + f->face_count);
    if (status != PC_OK) return status;
    const size_t had = 3 * (size_t)mesh->face_count;
    memcpy(grown.position, mesh->position, 3 * (size_t)mesh->vertex_count * sizeof *grown.position);
    memcpy(grown.triangle, mesh->triangle, had * sizeof *grown.triangle);
    memcpy(grown.triangle + had, f->triangle, 3 * (size_t)f->face_count * sizeof *grown.triangle);
    pc_mesh_free(mesh, ctx);
    *mesh = grown;
    return PC_OK;
}

pc_status pc_ragged_fill(pc_mesh *mesh, pc_ragged_stats *stats, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_adjacency adjacency = {0};
    filling f = {.mesh = mesh, .adjacency = &adjacency};
    *stats = (pc_ragged_stats){0};
    PC_TRY(pc_adjacency_make(&adjacency, ctx, mesh));
    const size_t border = adjacency.boundary_edge_count;
    if (!border) goto done;
    PC_TRY(find_places(&f, ctx));
    PC_TRY(pc_new(&f.triangle, ctx, 3 * border));
    PC_TRY(pc_new(&f.added, ctx, 2 * border));
    PC_TRY(pc_new(&f.first_added, ctx, mesh->vertex_count));
    memset(f.first_added, 0xff, mesh->vertex_count * sizeof *f.first_added);
    fill_all(&f);
    if (f.face_count) PC_TRY(append(mesh, ctx, &f));
    *stats = (pc_ragged_stats){f.face_count, f.closed};
done:
    pc_adjacency_free(&adjacency, ctx);
    pc_free(ctx, f.place);
    pc_free(ctx, f.triangle);
    pc_free(ctx, f.added);
    pc_free(ctx, f.first_added);
    return status;
}
