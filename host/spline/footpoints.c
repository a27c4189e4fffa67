#include "footpoints.h"
#include "memory.h"
#include <string.h>

void pc_footpoints_at(double at[2], const pc_footpoints *feet, pc_index face, int i) {
    const double *size = feet->size + 2 * (size_t)face;
    const int column = i % feet->per_side, line = i / feet->per_side;
    at[0] = (column + 0.5) / feet->per_side * size[0];
    at[1] = (line + 0.5) / feet->per_side * size[1];
}

const pc_foot *pc_footpoints_near(const pc_footpoints *feet, pc_index face, const double at[2]) {
    int cell[2];
    for (size_t k = 0; k < 2; k++) {
        cell[k] = (int)(at[k] / feet->size[2 * (size_t)face + k] * feet->per_side);
        cell[k] = cell[k] < 0 ? 0 : cell[k] >= feet->per_side ? feet->per_side - 1 : cell[k];
    }
    const size_t each = (size_t)(feet->per_side * feet->per_side);
    return feet->foot + face * each + cell[0] + cell[1] * feet->per_side;
}

double pc_footpoints_step(const pc_footpoints *feet, pc_index face) {
    const int n = feet->per_side, last = n * n - 1, steps = n > 1 ? n - 1 : 1;
    const pc_foot *grid = feet->foot + (size_t)face * (size_t)(n * n);
    const double one = pc_distance(grid[0].point, grid[last].point);
    const double other = pc_distance(grid[n - 1].point, grid[last - n + 1].point);
    return fmax(one, other) / steps;
}

static double try_triangle(pc_foot *best, double least, const pc_mesh *mesh, pc_index t, pc_vec3 p) {
    const pc_index *v = mesh->triangle + 3 * (size_t)t;
    double weight[3];
    double square =
        pc_closest_on_triangle(weight, p, pc_vec3_at(mesh->position, v[0]), pc_vec3_at(mesh->position, v[1]),
                               pc_vec3_at(mesh->position, v[2]));
    if (!(square < least)) return least;
    best->triangle = t;
    best->point = (pc_vec3){0, 0, 0};
    for (int k = 0; k < 3; k++)
        best->point = pc_madd(best->point, weight[k], pc_vec3_at(mesh->position, v[k]));
    return square;
}

/* From a triangle downhill to the nearest point of the scan, over all that touch the present one. */
static pc_foot walk(const pc_target *target, pc_index from, pc_vec3 p) {
    enum { MOST_STEPS = 200 };
    const pc_mesh *mesh = target->mesh;
    pc_foot best = {.triangle = from};
    double least = try_triangle(&best, INFINITY, mesh, from, p);
    for (int i = 0; i < MOST_STEPS; i++) {
        const pc_index here = best.triangle;
        for (pc_index k = 0; k < 3; k++) {
            pc_index first = target->adjacency->vertex_half[mesh->triangle[3 * here + k]], h = first;
            do {
                if (h / 3 != here) least = try_triangle(&best, least, mesh, h / 3, p);
                h = pc_turn_ccw(target->adjacency, h);
            } while (h != first && h != PC_NONE);
        }
        if (best.triangle == here) break;
    }
    return best;
}

static bool faces(const pc_target *target, pc_index t, pc_vec3 normal) {
    const pc_index *v = target->mesh->triangle + 3 * (size_t)t;
    pc_vec3 a = pc_vec3_at(target->mesh->position, v[0]);
    pc_vec3 n = pc_cross(pc_sub(pc_vec3_at(target->mesh->position, v[1]), a),
                         pc_sub(pc_vec3_at(target->mesh->position, v[2]), a));
    return pc_dot(n, normal) > 0;
}

/* Those that are lost go on from one beside them. */
static void rescue(pc_footpoints *feet, const pc_target *target, pc_foot *grid, const pc_vec3 *point,
                   const pc_vec3 *normal) {
    const int n = feet->per_side;
    bool more = true;
    while (more) {
        more = false;
        for (int i = 0; i < n * n; i++) {
            const int beside[4] = {i % n ? i - 1 : i, (i + 1) % n ? i + 1 : i, i >= n ? i - n : i,
                                   i + n < n * n ? i + n : i};
            for (int k = 0; k < 4 && grid[i].lost; k++) {
                if (grid[beside[k]].lost) continue;
                pc_foot foot = walk(target, grid[beside[k]].triangle, point[i]);
                if (!faces(target, foot.triangle, normal[i])) continue;
                grid[i] = foot;
                more = true;
            }
        }
    }
}

enum { MOST_PER_SIDE = 16 };

static void follow_face(pc_footpoints *feet, const pc_tspline *spline, const pc_target *target, pc_index f) {
    const int count = feet->per_side * feet->per_side;
    pc_foot *grid = feet->foot + (size_t)f * (size_t)count;
    pc_vec3 point[MOST_PER_SIDE * MOST_PER_SIDE], normal[MOST_PER_SIDE * MOST_PER_SIDE];
    for (int i = 0; i < count; i++) {
        double at[2];
        pc_footpoints_at(at, feet, f, i);
        pc_surface_point x = pc_tspline_evaluate(spline, pc_tspline_place(spline, f, at[0], at[1]));
        point[i] = x.p, normal[i] = pc_cross(x.s, x.t);
        grid[i] = walk(target, grid[i].triangle, point[i]);
        grid[i].lost = !faces(target, grid[i].triangle, normal[i]);
    }
    rescue(feet, target, grid, point, normal);
}

pc_status pc_footpoints_follow(pc_footpoints *feet, pc_context *ctx, const pc_tspline *spline,
                               const pc_target *target) {
    (void)ctx;
#pragma omp parallel for schedule(dynamic, 16)
    for (pc_index f = 0; f < feet->face_count; f++)
        if (!spline->mesh.face[f].ghost) follow_face(feet, spline, target, f);
    return PC_OK;
}

/* From the foot of the nearest corner along the flat face: what lies between leads to the right sheet. */
static void start_face(pc_footpoints *feet, const pc_tspline *spline, const pc_target *target, pc_index f,
                       const pc_bvh_hit *hit) {
    enum { STEPS = 4 };
    const int n = feet->per_side;
    const double *size = spline->mesh.face[f].size;
    pc_foot *grid = feet->foot + (size_t)f * (size_t)(n * n);
    pc_vec3 corner[4], point[MOST_PER_SIDE * MOST_PER_SIDE], normal[MOST_PER_SIDE * MOST_PER_SIDE];
    pc_index start[4];
    pc_tface_corners(start, &spline->mesh, f);
    for (int k = 0; k < 4; k++) {
        corner[k] = pc_vec3_at(spline->position, start[k]);
        start[k] = hit[start[k]].face;
    }
    for (int i = 0; i < n * n; i++) {
        double at[2];
        pc_footpoints_at(at, feet, f, i);
        const double u = at[0] / size[0], v = at[1] / size[1];
        const int k = u < 0.5 ? (v < 0.5 ? 0 : 3) : (v < 0.5 ? 1 : 2);
        const pc_vec3 along = pc_madd(pc_scale(1 - v, pc_sub(corner[1], corner[0])), v,
                                      pc_sub(corner[2], corner[3]));
        const pc_vec3 across = pc_madd(pc_scale(1 - u, pc_sub(corner[3], corner[0])), u,
                                       pc_sub(corner[2], corner[1]));
        point[i] = pc_madd(pc_madd(corner[0], u, pc_sub(corner[1], corner[0])), v, across);
        normal[i] = pc_cross(along, across);
        grid[i].triangle = start[k];
        for (int step = 1; step <= STEPS; step++)
            grid[i] = walk(target, grid[i].triangle,
                           pc_madd(corner[k], (double)step / STEPS, pc_sub(point[i], corner[k])));
        grid[i].lost = !faces(target, grid[i].triangle, normal[i]);
    }
    rescue(feet, target, grid, point, normal);
}

static pc_status make_room(pc_footpoints *feet, pc_context *ctx, const pc_tmesh *mesh) {
    pc_status status = PC_OK;
    feet->face_count = mesh->face_count;
    PC_TRY(pc_new(&feet->foot, ctx, (size_t)mesh->face_count * (size_t)(feet->per_side * feet->per_side)));
    PC_TRY(pc_new(&feet->size, ctx, 2 * (size_t)mesh->face_count));
    for (pc_index f = 0; f < mesh->face_count; f++)
        memcpy(feet->size + 2 * (size_t)f, mesh->face[f].size, 2 * sizeof *feet->size);
done:
    return status;
}

pc_status pc_footpoints_make(pc_footpoints *feet, pc_context *ctx, const pc_tspline *spline,
                             const pc_target *target, int per_side) {
    pc_status status = PC_OK;
    pc_bvh_hit *hit = NULL;
    *feet = (pc_footpoints){.per_side = per_side < 1               ? 1
                                        : per_side > MOST_PER_SIDE ? MOST_PER_SIDE
                                                                   : per_side};
    PC_TRY(make_room(feet, ctx, &spline->mesh));
    PC_TRY(pc_new(&hit, ctx, spline->mesh.vertex_count));
    pc_bvh_closest_all(hit, &target->tree, spline->position, spline->mesh.vertex_count);
#pragma omp parallel for schedule(dynamic, 16)
    for (pc_index f = 0; f < feet->face_count; f++)
        if (!spline->mesh.face[f].ghost) start_face(feet, spline, target, f, hit);
done:
    pc_free(ctx, hit);
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
    const size_t each = (size_t)(feet->per_side * feet->per_side);
    pc_footpoints finer = {.per_side = feet->per_side};
    PC_TRY(make_room(&finer, ctx, refined));
    for (pc_index f = 0; f < refined->face_count; f++) {
        const pc_tface *face = refined->face + f;
        for (size_t i = 0; i < each && !face->ghost; i++) {
            double at[2];
            pc_footpoints_at(at, &finer, f, (int)i);
            at[0] += face->origin[0], at[1] += face->origin[1];
            finer.foot[f * each + i] = *pc_footpoints_near(feet, face->root, at);
        }
    }
    pc_footpoints_free(feet, ctx);
    *feet = finer;
done:
    if (status != PC_OK) pc_footpoints_free(&finer, ctx);
    return status;
}
