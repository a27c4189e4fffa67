#include "halfsort.h"
#include "memory.h"
#include <stdlib.h>

typedef struct keyed_half {
    pc_index high, half;
} keyed_half;

static int compare_keyed(const void *a, const void *b) {
    const keyed_half *x = a, *y = b;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    return x->half < y->half ? -1 : x->half > y->half;
}

enum { SMALL_BUCKET = 64 };

static void sort_small(pc_index *half, pc_index count, const pc_mesh *mesh) {
    keyed_half key[SMALL_BUCKET];
    for (pc_index i = 0; i < count; i++) {
        keyed_half item = {pc_high_end(mesh, half[i]), half[i]};
        pc_index j = i;
        for (; j > 0 && compare_keyed(&item, &key[j - 1]) < 0; j--)
            key[j] = key[j - 1];
        key[j] = item;
    }
    for (pc_index i = 0; i < count; i++)
        half[i] = key[i].half;
}

static pc_status sort_large(pc_index *half, pc_context *ctx, pc_index count, const pc_mesh *mesh) {
    keyed_half *key;
    pc_status status = pc_new(&key, ctx, count);
    if (status != PC_OK) return status;
    for (pc_index i = 0; i < count; i++)
        key[i] = (keyed_half){pc_high_end(mesh, half[i]), half[i]};
    qsort(key, count, sizeof *key, compare_keyed);
    for (pc_index i = 0; i < count; i++)
        half[i] = key[i].half;
    pc_free(ctx, key);
    return PC_OK;
}

/* The order in which threads fill a bucket does not matter, as it is sorted afterwards. */
static void fill_buckets(pc_halfsort *sorted, const pc_mesh *mesh) {
    pc_index half_count = 3 * mesh->face_count, *start = sorted->start;
#pragma omp parallel for schedule(static)
    for (pc_index h = 0; h < half_count; h++) {
#pragma omp atomic
        start[pc_low_end(mesh, h)]++;
    }
    for (pc_index v = 0, sum = 0; v <= mesh->vertex_count; v++)
        sum += start[v], start[v] = sum;
        /* Filled from the end down, so that each start ends up where its bucket begins. */
#pragma omp parallel for schedule(static)
    for (pc_index h = 0; h < half_count; h++) {
        pc_index place;
#pragma omp atomic capture
        place = --start[pc_low_end(mesh, h)];
        sorted->half[place] = h;
    }
}

pc_status pc_halfsort_make(pc_halfsort *sorted, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    *sorted = (pc_halfsort){0};
    PC_TRY(pc_new(&sorted->start, ctx, (size_t)mesh->vertex_count + 1));
    PC_TRY(pc_new(&sorted->half, ctx, 3 * (size_t)mesh->face_count));
    fill_buckets(sorted, mesh);
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_index count = sorted->start[v + 1] - sorted->start[v];
        if (count <= SMALL_BUCKET) sort_small(sorted->half + sorted->start[v], count, mesh);
    }
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_index count = sorted->start[v + 1] - sorted->start[v];
        if (count > SMALL_BUCKET) PC_TRY(sort_large(sorted->half + sorted->start[v], ctx, count, mesh));
    }
done:
    if (status != PC_OK) pc_halfsort_free(sorted, ctx);
    return status;
}

void pc_halfsort_free(pc_halfsort *sorted, pc_context *ctx) {
    if (!sorted) return;
    pc_free(ctx, sorted->start);
    pc_free(ctx, sorted->half);
    *sorted = (pc_halfsort){0};
}
