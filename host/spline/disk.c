#include "disk.h"
#include "convexmap.h"
#include "memory.h"
#include <stdlib.h>
#include <string.h>

/* ---- Which triangles ---- */

typedef struct closing {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    uint8_t *inside;
    pc_index *mark; /* per triangle: the flood that met it last */
    pc_index *list; /* of the flood at hand */
    pc_index floods;
} closing;

/* Triangles that hang together with t and are inside, or outside, as it is; their number, `most` at most. */
static pc_index flood(closing *c, pc_index t, pc_index most) {
    pc_index count = 0;
    c->floods++;
    c->mark[t] = c->floods, c->list[count++] = t;
    for (pc_index i = 0; i < count && count < most; i++)
        for (pc_index k = 0; k < 3 && count < most; k++) {
            const pc_index h = c->adjacency->twin[3 * (size_t)c->list[i] + k];
            if (h == PC_NONE || c->inside[h / 3] != c->inside[t] || c->mark[h / 3] == c->floods) continue;
            c->mark[h / 3] = c->floods, c->list[count++] = h / 3;
        }
    return count;
}

/* The number of triangles of the largest part, which alone stays inside. */
static pc_index keep_largest(closing *c) {
    pc_index largest = 0, seed = PC_NONE;
    for (pc_index t = 0; t < c->mesh->face_count; t++) {
        if (!c->inside[t] || c->mark[t]) continue;
        const pc_index count = flood(c, t, PC_NONE);
        if (count > largest) largest = count, seed = t;
    }
    if (seed == PC_NONE) return 0;
    const pc_index kept = c->mark[seed];
    for (pc_index t = 0; t < c->mesh->face_count; t++)
        c->inside[t] = c->inside[t] && c->mark[t] == kept;
    return largest;
}

/* What is around no more triangles than there are inside is a hole. */
static void fill_holes(closing *c, pc_index size) {
    const pc_index before = c->floods;
    for (pc_index t = 0; t < c->mesh->face_count; t++) {
        for (size_t k = 0; c->inside[t] == 1 && k < 3; k++) {
            const pc_index h = c->adjacency->twin[3 * (size_t)t + k];
            if (h == PC_NONE || c->inside[h / 3] || c->mark[h / 3] > before) continue;
            const pc_index count = flood(c, h / 3, size);
            for (pc_index i = 0; count < size && i < count; i++)
                c->inside[c->list[i]] = 2; /* not to be looked around */
        }
    }
    for (pc_index t = 0; t < c->mesh->face_count; t++)
        c->inside[t] = c->inside[t] != 0;
}

/* How often the rim passes through the tail of h. */
static int passes(const closing *c, pc_index h) {
    const pc_index first = c->adjacency->vertex_half[pc_tail(c->mesh, h)];
    int changes = 0;
    bool before = false, start = c->inside[first / 3];
    for (pc_index g = first; g != PC_NONE;) {
        const bool now = c->inside[g / 3];
        changes += now && !before;
        before = now;
        g = pc_turn_ccw(c->adjacency, g);
        if (g == first) return changes - (start && before && changes > 1);
    }
    return changes;
}

/* Takes in all triangles around vertices that the rim meets twice. */
static bool widen(closing *c) {
    bool widened = false;
    for (pc_index h = 0; h < 3 * c->mesh->face_count; h++) {
        if (!c->inside[h / 3] || passes(c, h) < 2) continue;
        const pc_index first = c->adjacency->vertex_half[pc_tail(c->mesh, h)];
        pc_index g = first;
        do {
            c->inside[g / 3] = 1;
            g = pc_turn_ccw(c->adjacency, g);
        } while (g != first && g != PC_NONE);
        widened = true;
    }
    return widened;
}

static pc_status close_part(pc_index *size, pc_context *ctx, const pc_mesh *mesh,
                            const pc_adjacency *adjacency, uint8_t *inside) {
    enum { MOST_ROUNDS = 10 };
    pc_status status = PC_OK;
    closing c = {.mesh = mesh, .adjacency = adjacency};
    c.inside = inside;
    *size = 0;
    PC_TRY(pc_new(&c.mark, ctx, mesh->face_count));
    PC_TRY(pc_new(&c.list, ctx, mesh->face_count));
    const pc_index largest = keep_largest(&c);
    if (!largest) goto done;
    for (int i = 0; i < MOST_ROUNDS; i++) {
        fill_holes(&c, largest);
        if (!widen(&c)) break;
    }
    for (pc_index t = 0; t < mesh->face_count; t++)
        *size += inside[t];
done:
    pc_free(ctx, c.mark);
    pc_free(ctx, c.list);
    return status;
}

/* ---- The part as a mesh ---- */

static pc_status extract(pc_disk *disk, pc_context *ctx, const pc_mesh *mesh, const uint8_t *inside,
                         pc_index size) {
    pc_status status = PC_OK;
    pc_index *local = NULL, count = 0, triangles = 0;
    PC_TRY(pc_new(&local, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&disk->triangle, ctx, size));
    PC_TRY(pc_new(&disk->vertex, ctx, 3 * (size_t)size));
    for (pc_index t = 0; t < mesh->face_count; t++) {
        if (!inside[t]) continue;
        disk->triangle[triangles++] = t;
        for (size_t k = 0; k < 3; k++) {
            const pc_index v = mesh->triangle[3 * (size_t)t + k];
            if (local[v]) continue;
            disk->vertex[count++] = v;
            local[v] = count;
        }
    }
    PC_TRY(pc_mesh_make(&disk->mesh, ctx, count, size));
    for (pc_index v = 0; v < count; v++)
        pc_vec3_put(disk->mesh.position, v, pc_vec3_at(mesh->position, disk->vertex[v]));
    for (size_t i = 0; i < 3 * (size_t)size; i++)
        disk->mesh.triangle[i] = local[mesh->triangle[3 * (size_t)disk->triangle[i / 3] + i % 3]] - 1;
done:
    pc_free(ctx, local);
    return status;
}

/* The rim from one vertex around; no loop where there is more than one or the part has handles. */
static pc_status find_loop(pc_disk *disk, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_adjacency *a = &disk->adjacency;
    const int64_t euler =
        (int64_t)disk->mesh.vertex_count - (int64_t)a->edge_count + (int64_t)disk->mesh.face_count;
    pc_index count = 0, first = PC_NONE;
    if (euler != 1 || !a->boundary_edge_count) return PC_OK;
    PC_TRY(pc_new(&disk->loop, ctx, a->boundary_edge_count));
    for (pc_index h = 0; first == PC_NONE; h++)
        if (a->twin[h] == PC_NONE) first = pc_tail(&disk->mesh, h);
    for (pc_index v = first; count < a->boundary_edge_count;) {
        disk->loop[count++] = v;
        v = pc_head(&disk->mesh, a->vertex_half[v]);
        if (v == first) break;
    }
    if (count == a->boundary_edge_count) disk->loop_count = count;
done:
    return status;
}

pc_status pc_disk_make(pc_disk *disk, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency,
                       uint8_t *inside) {
    pc_status status = PC_OK;
    pc_index size;
    *disk = (pc_disk){0};
    PC_TRY(close_part(&size, ctx, mesh, adjacency, inside));
    if (!size) goto done;
    PC_TRY(extract(disk, ctx, mesh, inside, size));
    status = pc_adjacency_make(&disk->adjacency, ctx, &disk->mesh);
    if (status == PC_E_MESH) { /* still pinched somewhere: no disk */
        pc_context_clear_message(ctx);
        status = PC_OK;
        goto done;
    }
    PC_TRY(status);
    PC_TRY(find_loop(disk, ctx));
done:
    if (status != PC_OK) pc_disk_free(disk, ctx);
    return status;
}

void pc_disk_free(pc_disk *disk, pc_context *ctx) {
    pc_bvh_free(&disk->tree, ctx);
    pc_adjacency_free(&disk->adjacency, ctx);
    pc_mesh_free(&disk->mesh, ctx);
    pc_free(ctx, disk->vertex);
    pc_free(ctx, disk->triangle);
    pc_free(ctx, disk->loop);
    *disk = (pc_disk){0};
}

pc_index pc_disk_find(const pc_disk *disk, pc_index t) {
    pc_index low = 0, high = disk->mesh.face_count;
    while (low < high) {
        const pc_index middle = low + (high - low) / 2;
        if (disk->triangle[middle] < t)
            low = middle + 1;
        else
            high = middle;
    }
    return low < disk->mesh.face_count && disk->triangle[low] == t ? low : PC_NONE;
}

/* ---- Flat ---- */

/* The tangent of half the angle between sides a and b of a triangle, across from c. */
static double half_tangent(double a, double b, double c) {
    const double cosine = (a * a + b * b - c * c) / fmax(2 * a * b, 1e-300);
    return sqrt(fmax(1 - cosine, 0) / fmax(1 + cosine, 1e-9));
}

/* Per half-edge: how much its head pulls at its tail. */
static void weigh(double *pull, const pc_disk *disk, const double *length) {
    const pc_adjacency *a = &disk->adjacency;
    const pc_index halves = 3 * disk->mesh.face_count;
    for (pc_index h = 0; h < halves; h++) {
        const pc_index g = a->twin[h];
        double sum = half_tangent(length[h], length[pc_prev(h)], length[pc_next(h)]);
        if (g != PC_NONE) sum += half_tangent(length[g], length[pc_next(g)], length[pc_prev(g)]);
        pull[h] = fmin(sum, 1e6) / fmax(length[h], 1e-300);
    }
}

static int compare(const void *x, const void *y) {
    const pc_index a = *(const pc_index *)x, b = *(const pc_index *)y;
    return (a > b) - (a < b);
}

/* Vertices inside are means of those around, the rim is fixed. */
static pc_status make_map(pc_convexmap *map, pc_context *ctx, const pc_disk *disk, const double *pull) {
    pc_status status = PC_OK;
    const pc_adjacency *a = &disk->adjacency;
    size_t count = 0;
    double *share = NULL; /* per vertex, of the row at hand */
    PC_TRY(pc_new(&share, ctx, disk->mesh.vertex_count));
    PC_TRY(pc_convexmap_make(map, ctx, disk->mesh.vertex_count, 3 * (size_t)disk->mesh.face_count));
    for (pc_index v = 0; v < map->count; v++) {
        const size_t from = count;
        const pc_index first = a->vertex_half[v];
        double total = 0;
        for (pc_index h = first; !a->vertex_boundary[v];) {
            const pc_index w = pc_head(&disk->mesh, h);
            map->column[count++] = w;
            share[w] = pull[h];
            total += pull[h];
            h = pc_turn_ccw(a, h);
            if (h == first) break;
        }
        qsort(map->column + from, count - from, sizeof *map->column, compare);
        for (size_t e = from; e < count; e++)
            map->weight[e] = share[map->column[e]] / total;
        map->start[v + 1] = count;
    }
done:
    pc_free(ctx, share);
    return status;
}

static pc_status settle(pc_disk *disk, pc_context *ctx, const double *pull) {
    const double tolerance = 1e-10; /* of the circle's radius */
    pc_status status = PC_OK;
    pc_convexmap map = {0};
    double *flat = NULL;
    PC_TRY(make_map(&map, ctx, disk, pull));
    PC_TRY(pc_new(&flat, ctx, 2 * (size_t)map.count));
    for (size_t i = 0; i < 2 * (size_t)map.count; i++)
        flat[i] = disk->mesh.position[i / 2 * 3 + i % 2];
    PC_TRY(pc_convexmap_solve(flat, ctx, &map, tolerance));
    for (size_t i = 0; i < 2 * (size_t)map.count; i++)
        disk->mesh.position[i / 2 * 3 + i % 2] = flat[i];
done:
    pc_convexmap_free(&map, ctx);
    pc_free(ctx, flat);
    return status;
}

pc_status pc_disk_lay(pc_disk *disk, pc_context *ctx, const double *angle, const double *length) {
    pc_status status = PC_OK;
    double *pull = NULL;
    PC_TRY(pc_new(&pull, ctx, 3 * (size_t)disk->mesh.face_count));
    weigh(pull, disk, length);
    memset(disk->mesh.position, 0, 3 * (size_t)disk->mesh.vertex_count * sizeof *disk->mesh.position);
    for (pc_index i = 0; i < disk->loop_count; i++)
        pc_vec3_put(disk->mesh.position, disk->loop[i], (pc_vec3){cos(angle[i]), sin(angle[i]), 0});
    PC_TRY(settle(disk, ctx, pull));
    PC_TRY(pc_bvh_make(&disk->tree, ctx, &disk->mesh));
done:
    pc_free(ctx, pull);
    return status;
}
