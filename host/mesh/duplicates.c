#include "duplicates.h"
#include "memory.h"
#include "random.h"
#include <string.h>

/* An open hash table of item numbers, at most half full. */
typedef struct item_table {
    pc_index *slot;
    size_t mask;
} item_table;

static pc_status table_make(item_table *table, pc_context *ctx, size_t item_count) {
    size_t size = 16;
    while (size < 2 * item_count)
        size *= 2;
    table->mask = size - 1;
    pc_status status = pc_new(&table->slot, ctx, size);
    if (status == PC_OK) memset(table->slot, 0xff, size * sizeof *table->slot); /* PC_NONE */
    return status;
}

static uint64_t place_key(const double *position, pc_index v) {
    uint64_t hash = 0;
    for (int k = 0; k < 3; k++) {
        double x = position[3 * (size_t)v + (size_t)k] + 0.0; /* -0 becomes 0 */
        uint64_t bits;
        memcpy(&bits, &x, sizeof bits);
        hash = pc_hash64(hash ^ bits);
    }
    return hash;
}

static bool same_place(const double *position, pc_index v, pc_index w) {
    const double *p = position + 3 * (size_t)v, *q = position + 3 * (size_t)w;
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

pc_status pc_duplicates_of_vertices(pc_index **same, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    item_table table = {0};
    uint64_t *key = NULL;
    *same = NULL;
    PC_TRY(pc_new(same, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&key, ctx, mesh->vertex_count));
    PC_TRY(table_make(&table, ctx, mesh->vertex_count));
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        key[v] = place_key(mesh->position, v);
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        size_t i = key[v] & table.mask;
        while (table.slot[i] != PC_NONE && !same_place(mesh->position, v, table.slot[i]))
            i = (i + 1) & table.mask;
        if (table.slot[i] == PC_NONE) table.slot[i] = v;
        (*same)[v] = table.slot[i];
    }
done:
    pc_free(ctx, table.slot);
    pc_free(ctx, key);
    if (status != PC_OK) pc_free(ctx, *same), *same = NULL;
    return status;
}

static void sorted_corners(pc_index corner[3], const pc_mesh *mesh, pc_index f) {
    const pc_index *t = mesh->triangle + 3 * (size_t)f;
    pc_index low = t[0] < t[1] ? t[0] : t[1], high = t[0] < t[1] ? t[1] : t[0];
    corner[0] = t[2] < low ? t[2] : low;
    corner[2] = t[2] > high ? t[2] : high;
    corner[1] = t[2] < low ? low : t[2] > high ? high : t[2];
}

static bool same_corners(const pc_mesh *mesh, pc_index f, pc_index g) {
    pc_index a[3], b[3];
    sorted_corners(a, mesh, f);
    sorted_corners(b, mesh, g);
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

pc_status pc_duplicates_of_faces(pc_index **same, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    item_table table = {0};
    *same = NULL;
    PC_TRY(pc_new(same, ctx, mesh->face_count));
    PC_TRY(table_make(&table, ctx, mesh->face_count));
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_index corner[3];
        sorted_corners(corner, mesh, f);
        size_t i = pc_hash64(pc_hash64(corner[0]) ^ ((uint64_t)corner[1] << 32 | corner[2])) & table.mask;
        while (table.slot[i] != PC_NONE && !same_corners(mesh, f, table.slot[i]))
            i = (i + 1) & table.mask;
        if (table.slot[i] == PC_NONE) table.slot[i] = f;
        (*same)[f] = table.slot[i];
    }
done:
    pc_free(ctx, table.slot);
    if (status != PC_OK) pc_free(ctx, *same), *same = NULL;
    return status;
}
