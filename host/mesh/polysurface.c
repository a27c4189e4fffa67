#include "polysurface.h"
#include "memory.h"
#include "vec3.h"
#include <string.h>

static pc_vec3 newell_normal(const double *position, const pc_index *corner, pc_index count) {
    pc_vec3 origin = pc_vec3_at(position, corner[0]), sum = {0, 0, 0};
    for (pc_index i = 1; i + 1 < count; i++)
        sum = pc_add(sum, pc_cross(pc_sub(pc_vec3_at(position, corner[i]), origin),
                                   pc_sub(pc_vec3_at(position, corner[i + 1]), origin)));
    return pc_unit(sum);
}

/* Twice the area, over the product of the two longer sides: the sine of the smallest angle; signed by the
 * normal. */
static double triangle_quality(const double *position, pc_index i, pc_index j, pc_index k, pc_vec3 normal) {
    pc_vec3 a = pc_vec3_at(position, i), b = pc_vec3_at(position, j), c = pc_vec3_at(position, k);
    pc_vec3 n = pc_cross(pc_sub(b, a), pc_sub(c, a));
    double x = pc_distance(a, b), y = pc_distance(b, c), z = pc_distance(c, a);
    double least = fmin(x, fmin(y, z)), product = least > 0 ? x * y * z / least : 0;
    double sine = product > 0 ? pc_norm(n) / product : 0;
    return pc_dot(n, normal) < 0 ? -1 - sine : sine;
}

static void put_triangle(pc_index **out, pc_index a, pc_index b, pc_index c) {
    (*out)[0] = a, (*out)[1] = b, (*out)[2] = c;
    *out += 3;
}

static void cut_quad(pc_index **out, const double *position, const pc_index *v, pc_vec3 normal) {
    double even = fmin(triangle_quality(position, v[0], v[1], v[2], normal),
                       triangle_quality(position, v[0], v[2], v[3], normal));
    double odd = fmin(triangle_quality(position, v[1], v[2], v[3], normal),
                      triangle_quality(position, v[1], v[3], v[0], normal));
    int k = odd > even;
    put_triangle(out, v[k], v[k + 1], v[k + 2]);
    put_triangle(out, v[k], v[k + 2], v[(k + 3) % 4]);
}

/* `ring` is the polygon's corners, used up as ears go. */
static void cut_ears(pc_index **out, const double *position, pc_index *ring, pc_index count, pc_vec3 normal) {
    while (count > 4) {
        pc_index best = 0;
        double best_quality = -INFINITY;
        for (pc_index i = 0; i < count; i++) {
            double quality = triangle_quality(position, ring[(i + count - 1) % count], ring[i],
                                              ring[(i + 1) % count], normal);
            if (quality > best_quality) best_quality = quality, best = i;
        }
        put_triangle(out, ring[(best + count - 1) % count], ring[best], ring[(best + 1) % count]);
        memmove(ring + best, ring + best + 1, (count - best - 1) * sizeof *ring);
        count--;
    }
    cut_quad(out, position, ring, normal);
}

pc_status pc_polysurface_make(pc_mesh *out, pc_index **source, pc_context *ctx, const pc_polymesh *mesh) {
    pc_status status = PC_OK;
    size_t count = 0;
    pc_index widest = 0, *ring = NULL;
    *out = (pc_mesh){0};
    if (source) *source = NULL;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_index sides = mesh->start[f + 1] - mesh->start[f];
        count += sides > 2 ? sides - 2 : 0;
        widest = sides > widest ? sides : widest;
    }
    PC_TRY(pc_mesh_make(out, ctx, mesh->vertex_count, count));
    PC_TRY(pc_new(&ring, ctx, widest));
    if (source) PC_TRY(pc_new(source, ctx, count));
    memcpy(out->position, mesh->position, 3 * sizeof(double) * (size_t)mesh->vertex_count);
    pc_index *end = out->triangle;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_index sides = mesh->start[f + 1] - mesh->start[f], *begin = end;
        const pc_index *corner = mesh->corner + mesh->start[f];
        if (sides < 3) continue;
        if (sides == 3) {
            put_triangle(&end, corner[0], corner[1], corner[2]);
        } else {
            memcpy(ring, corner, sides * sizeof *ring);
            cut_ears(&end, mesh->position, ring, sides, newell_normal(mesh->position, corner, sides));
        }
        for (size_t t = (size_t)(begin - out->triangle) / 3; source && t < (size_t)(end - out->triangle) / 3;
             t++)
            (*source)[t] = f;
    }
done:
    pc_free(ctx, ring);
    if (status != PC_OK) {
        pc_mesh_free(out, ctx);
        if (source) pc_free(ctx, *source), *source = NULL;
    }
    return status;
}
