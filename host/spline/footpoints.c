#include "footpoints.h"
#include "memory.h"
#include <string.h>

void pc_footpoints_at(double at[2], const pc_footpoints *feet, pc_index face, int i) {
    const double *size = feet->size + 2 * (size_t)face;
    const int column = i % feet->per_side, line = i / feet->per_side;
    at[0] = (column + 0.5) / feet->per_side * size[0];
    at[1] = (line + 0.5) / feet->per_side * size[1];
}

/* The foot of the grid's point next to a place on a face. */
static const pc_foot *foot_near(const pc_footpoints *feet, pc_index face, const double at[2]) {
    int cell[2];
    for (size_t k = 0; k < 2; k++) {
        cell[k] = (int)(at[k] / feet->size[2 * (size_t)face + k] * feet->per_side);
        cell[k] = cell[k] < 0 ? 0 : cell[k] >= feet->per_side ? feet->per_side - 1 : cell[k];
    }
    const size_t n = (size_t)feet->per_side, each = n * n;
    return feet->foot + face * each + cell[0] + cell[1] * feet->per_side;
}

pc_vec3 pc_footpoints_point(const pc_mesh *mesh, const pc_foot *foot) {
    const pc_index *v = mesh->triangle + 3 * (size_t)foot->triangle;
    pc_vec3 p = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        p = pc_madd(p, foot->weight[k], pc_vec3_at(mesh->position, v[k]));
    return p;
}

static double try_triangle(pc_foot *best, double least, const pc_mesh *mesh, pc_index t, pc_vec3 p) {
    const pc_index *v = mesh->triangle + 3 * (size_t)t;
    double weight[3];
    double square =
        pc_closest_on_triangle(weight, p, pc_vec3_at(mesh->position, v[0]), pc_vec3_at(mesh->position, v[1]),
                               pc_vec3_at(mesh->position, v[2]));
    if (!(square < least)) return least;
    best->triangle = t;
    memcpy(best->weight, weight, sizeof weight);
    return square;
}

/* All triangles around the tail of half-edge h but its own. */
static double try_fan(pc_foot *best, double least, const pc_mesh *mesh, const pc_adjacency *adjacency,
                      pc_index h, pc_vec3 p) {
    const pc_index first = adjacency->vertex_half[pc_tail(mesh, h)];
    pc_index g = first;
    do {
        if (g / 3 != h / 3) least = try_triangle(best, least, mesh, g / 3, p);
        g = pc_turn_ccw(adjacency, g);
    } while (g != first && g != PC_NONE);
    return least;
}

/* From a triangle downhill to a nearest point of the mesh: while that is on a corner or an edge of the
 * present triangle, over all that touch it there or at the ends of the edge. */
static pc_foot walk(const pc_mesh *mesh, const pc_adjacency *adjacency, pc_index from, pc_vec3 p) {
    enum { MOST_STEPS = 200 };
    pc_foot best = {.triangle = from};
    double least = try_triangle(&best, INFINITY, mesh, from, p);
    for (int i = 0; i < MOST_STEPS; i++) {
        const pc_foot here = best;
        if (here.weight[0] > 0 && here.weight[1] > 0 && here.weight[2] > 0) break;
        for (pc_index k = 0; k < 3; k++)
            if (here.weight[k] > 0) least = try_fan(&best, least, mesh, adjacency, 3 * here.triangle + k, p);
        if (best.triangle == here.triangle) break;
    }
    best.point = pc_footpoints_point(mesh, &best);
    return best;
}

static bool faces(const pc_mesh *mesh, pc_index t, pc_vec3 normal) {
    const pc_index *v = mesh->triangle + 3 * (size_t)t;
    pc_vec3 a = pc_vec3_at(mesh->position, v[0]);
    pc_vec3 n =
        pc_cross(pc_sub(pc_vec3_at(mesh->position, v[1]), a), pc_sub(pc_vec3_at(mesh->position, v[2]), a));
    return pc_dot(n, normal) > 0;
}

enum { MOST_PER_SIDE = 16, MOST_POINTS = MOST_PER_SIDE * MOST_PER_SIDE };

/* The points of one face's grid, and its normals there. */
typedef struct grid {
    pc_vec3 point[MOST_POINTS], normal[MOST_POINTS];
} grid;

/* Feet where the scan faces the other way go on from one beside them, where that helps. */
static void rescue(pc_foot *foot, int n, const pc_mesh *mesh, const pc_adjacency *adjacency, const grid *g) {
    for (bool more = true; more;) {
        more = false;
        for (int i = 0; i < n * n; i++) {
            const int beside[4] = {i % n ? i - 1 : i, (i + 1) % n ? i + 1 : i, i >= n ? i - n : i,
                                   i + n < n * n ? i + n : i};
            for (int k = 0; k < 4 && foot[i].opposed; k++) {
                if (foot[beside[k]].opposed) continue;
                pc_foot next = walk(mesh, adjacency, foot[beside[k]].triangle, g->point[i]);
                if (!faces(mesh, next.triangle, g->normal[i])) continue;
                foot[i] = next;
                more = true;
            }
        }
    }
}

pc_foot pc_foot_follow(const pc_foot *foot, const pc_target *target, const pc_surface_point *above,
                       double let_go) {
    pc_foot next = walk(target->mesh, target->adjacency, foot->triangle, above->p);
    next.opposed = !faces(target->mesh, next.triangle, pc_cross(above->s, above->t));
    next.stress = foot->stress;
    return !foot->held || (!next.opposed && pc_distance(above->p, next.point) < let_go) ? next : *foot;
}

static void follow_face(pc_footpoints *feet, const pc_tspline *spline, const pc_target *target, pc_index f,
                        double let_go) {
    const int n = feet->per_side;
    pc_foot *foot = feet->foot + (size_t)f * (size_t)(n * n);
    grid g;
    for (int i = 0; i < n * n; i++) {
        double at[2];
        pc_footpoints_at(at, feet, f, i);
        const pc_surface_point x = pc_tspline_evaluate(spline, pc_tspline_place(spline, f, at[0], at[1]));
        g.point[i] = x.p, g.normal[i] = pc_cross(x.s, x.t);
        foot[i] = pc_foot_follow(foot + i, target, &x, let_go);
    }
    rescue(foot, n, target->mesh, target->adjacency, &g);
}

void pc_footpoints_follow(pc_footpoints *feet, const pc_tspline *spline, const pc_target *target,
                          double let_go, const uint8_t *active) {
#pragma omp parallel for schedule(dynamic, 16)
    for (pc_index f = 0; f < feet->face_count; f++)
        if (!spline->mesh.face[f].ghost && (!active || active[f]))
            follow_face(feet, spline, target, f, let_go);
}

/* Corners of the bilinear face. */
static void flat_corners(pc_vec3 c[4], const pc_tspline *spline, pc_index f) {
    pc_index corner[4];
    pc_tface_corners(corner, &spline->mesh, f);
    for (int k = 0; k < 4; k++)
        c[k] = pc_vec3_at(spline->position, corner[k]);
}

/* Point i of its grid, and the normal there. */
static pc_vec3 flat_point(pc_vec3 *normal, const pc_vec3 c[4], int n, int i) {
    const int column = i % n, line = i / n;
    const double u = (column + 0.5) / n, v = (line + 0.5) / n;
    const pc_vec3 along = pc_madd(pc_scale(1 - v, pc_sub(c[1], c[0])), v, pc_sub(c[2], c[3]));
    const pc_vec3 across = pc_madd(pc_scale(1 - u, pc_sub(c[3], c[0])), u, pc_sub(c[2], c[1]));
    *normal = pc_cross(along, across);
    return pc_madd(pc_madd(c[0], u, pc_sub(c[1], c[0])), v, across);
}

/* From the nearest corner along the flat face: what lies between leads to the right sheet. */
static void land_face(pc_footpoints *feet, const pc_tspline *spline, const pc_mesh *scan,
                      const pc_adjacency *adjacency, const pc_index *at, pc_index f) {
    enum { STEPS = 4 };
    const int n = feet->per_side;
    pc_foot *foot = feet->foot + (size_t)f * (size_t)(n * n);
    grid g;
    pc_index corner[4];
    pc_vec3 c[4];
    pc_tface_corners(corner, &spline->mesh, f);
    flat_corners(c, spline, f);
    for (int i = 0; i < n * n; i++) {
        g.point[i] = flat_point(g.normal + i, c, n, i);
        const bool right = 2 * (i % n) + 1 > n, upper = 2 * (i / n) + 1 > n;
        const int k = upper ? (right ? 2 : 3) : (right ? 1 : 0);
        foot[i].triangle = at[corner[k]];
        for (int step = 1; step <= STEPS; step++)
            foot[i] = walk(scan, adjacency, foot[i].triangle,
                           pc_madd(c[k], (double)step / STEPS, pc_sub(g.point[i], c[k])));
        foot[i].opposed = !faces(scan, foot[i].triangle, g.normal[i]);
    }
    rescue(foot, n, scan, adjacency, &g);
}

void pc_footpoints_land(pc_footpoints *feet, const pc_tspline *spline, const pc_mesh *scan,
                        const pc_adjacency *adjacency, const pc_index *at, const uint8_t *wanted) {
#pragma omp parallel for schedule(dynamic, 16)
    for (pc_index f = 0; f < feet->face_count; f++)
        if (!spline->mesh.face[f].ghost && (!wanted || wanted[f]))
            land_face(feet, spline, scan, adjacency, at, f);
}

void pc_footpoints_lift(pc_footpoints *feet, const pc_mesh *scan) {
    const size_t count = pc_footpoints_count(feet);
    for (size_t i = 0; i < count; i++)
        if (feet->foot[i].triangle != PC_NONE)
            feet->foot[i].point = pc_footpoints_point(scan, feet->foot + i);
}

bool pc_footpoints_near(const pc_footpoints *feet, const pc_tspline *spline, pc_index f, double far) {
    const int each = feet->per_side * feet->per_side;
    const pc_foot *foot = feet->foot + (size_t)f * (size_t)each;
    for (int i = 0; i < each; i++) {
        double at[2];
        pc_footpoints_at(at, feet, f, i);
        const pc_vec3 p = pc_tspline_point(spline, pc_tspline_place(spline, f, at[0], at[1]));
        if (!(pc_distance(p, foot[i].point) <= far)) return false;
    }
    return true;
}

bool pc_footpoints_torn(const pc_footpoints *feet, pc_index f, int i, int j, double step) {
    const double most_stretch = 3;
    const pc_foot *foot = feet->foot + (size_t)f * (size_t)(feet->per_side * feet->per_side);
    return pc_distance(foot[i].point, foot[j].point) > most_stretch * step;
}

bool pc_footpoints_gap(const pc_footpoints *feet, const pc_tspline *spline, pc_index f, int i, int j) {
    const pc_foot *foot = feet->foot + (size_t)f * (size_t)(feet->per_side * feet->per_side);
    pc_vec3 c[4], normal;
    if (foot[i].opposed || foot[j].opposed) return true;
    flat_corners(c, spline, f);
    return pc_footpoints_torn(
        feet, f, i, j,
        pc_distance(flat_point(&normal, c, feet->per_side, i), flat_point(&normal, c, feet->per_side, j)));
}

static pc_status make_room(pc_footpoints *feet, pc_context *ctx, const pc_tmesh *mesh) {
    pc_status status = PC_OK;
    feet->face_count = mesh->face_count;
    const size_t count = pc_footpoints_count(feet);
    PC_TRY(pc_new(&feet->foot, ctx, count));
    PC_TRY(pc_new(&feet->size, ctx, 2 * (size_t)mesh->face_count));
    for (pc_index f = 0; f < mesh->face_count; f++)
        memcpy(feet->size + 2 * (size_t)f, mesh->face[f].size, 2 * sizeof *feet->size);
    for (size_t i = 0; i < count; i++)
        feet->foot[i].triangle = PC_NONE;
done:
    return status;
}

pc_status pc_footpoints_make(pc_footpoints *feet, pc_context *ctx, const pc_tmesh *mesh, int per_side) {
    const int most = MOST_PER_SIDE;
    *feet = (pc_footpoints){.per_side = per_side < 2 ? 2 : per_side > most ? most : per_side};
    pc_status status = make_room(feet, ctx, mesh);
    if (status != PC_OK) pc_footpoints_free(feet, ctx);
    return status;
}

void pc_footpoints_free(pc_footpoints *feet, pc_context *ctx) {
    pc_free(ctx, feet->foot);
    pc_free(ctx, feet->size);
    *feet = (pc_footpoints){0};
}

pc_status pc_footpoints_carry(pc_footpoints *feet, pc_context *ctx, const pc_tmesh *refined) {
    pc_status status = PC_OK;
    const size_t n = (size_t)feet->per_side, each = n * n;
    pc_footpoints finer = {.per_side = feet->per_side};
    PC_TRY(make_room(&finer, ctx, refined));
    for (pc_index f = 0; f < refined->face_count; f++) {
        const pc_tface *face = refined->face + f;
        for (size_t i = 0; i < each && !face->ghost; i++) {
            double at[2];
            pc_footpoints_at(at, &finer, f, (int)i);
            at[0] += face->origin[0], at[1] += face->origin[1];
            finer.foot[f * each + i] = *foot_near(feet, face->root, at);
        }
    }
    pc_footpoints_free(feet, ctx);
    *feet = finer;
done:
    if (status != PC_OK) pc_footpoints_free(&finer, ctx);
    return status;
}
