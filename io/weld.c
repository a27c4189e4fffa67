#include "weld.h"
#include "memory.h"
#include "random.h"
#include <string.h>

void pc_weld_free(pc_weld *weld, pc_context *ctx) {
    pc_free(ctx, weld->position);
    pc_free(ctx, weld->slot);
    *weld = (pc_weld){0};
}

static uint64_t bits_of(double value) {
    uint64_t bits;
    value += 0.0; /* -0 becomes 0 */
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static uint64_t hash_of(const double *p) {
    return pc_hash64(pc_hash64(pc_hash64(bits_of(p[0])) ^ bits_of(p[1])) ^ bits_of(p[2]));
}

static bool same(const double *a, const double *b) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static pc_status grow(pc_weld *weld, pc_context *ctx, size_t wanted) {
    pc_status status = PC_OK;
    if (wanted >= PC_NONE - 1)
        return pc_fail(ctx, PC_E_FORMAT, "%zu vertices exceed the 32-bit indices of this version", wanted);
    if (wanted > weld->capacity) {
        size_t room = wanted + wanted / 2;
        PC_TRY(pc_resize_bytes((void **)&weld->position, ctx, room, 3 * sizeof(double)));
        weld->capacity = room;
    }
    if (2 * wanted < weld->slots) return PC_OK;
    size_t slots = weld->slots ? weld->slots : 1024;
    while (slots <= 4 * wanted)
        slots *= 2;
    pc_free(ctx, weld->slot);
    weld->slots = 0;
    PC_TRY(pc_new(&weld->slot, ctx, slots));
    weld->slots = slots;
    memset(weld->slot, 0xff, slots * sizeof *weld->slot);
    for (size_t i = 0; i < weld->count; i++) {
        size_t s = hash_of(weld->position + 3 * i) & (slots - 1);
        while (weld->slot[s] != PC_NONE)
            s = (s + 1) & (slots - 1);
        weld->slot[s] = (pc_index)i;
    }
done:
    return status;
}

enum { BATCH = 32 };

/* Hashes of a whole batch first, so that the table's lines are on their way when they are needed. */
static void add_batch(pc_weld *weld, pc_index *index, const double *point, size_t count) {
    size_t slot[BATCH];
    for (size_t i = 0; i < count; i++) {
        slot[i] = hash_of(point + 3 * i) & (weld->slots - 1);
        __builtin_prefetch(&weld->slot[slot[i]]);
    }
    for (size_t i = 0; i < count; i++) {
        const double *p = point + 3 * i;
        size_t s = slot[i];
        while (weld->slot[s] != PC_NONE && !same(weld->position + 3 * (size_t)weld->slot[s], p))
            s = (s + 1) & (weld->slots - 1);
        if (weld->slot[s] == PC_NONE) {
            for (size_t k = 0; k < 3; k++)
                weld->position[3 * weld->count + k] = p[k] + 0.0;
            weld->slot[s] = (pc_index)weld->count++;
        }
        index[i] = weld->slot[s];
    }
}

pc_status pc_weld_add(pc_weld *weld, pc_context *ctx, pc_index *index, const double *point, size_t count) {
    pc_status status = PC_OK;
    for (size_t i = 0; i < count; i += BATCH) {
        size_t n = count - i < BATCH ? count - i : BATCH;
        PC_TRY(grow(weld, ctx, weld->count + n));
        add_batch(weld, index + i, point + 3 * i, n);
    }
done:
    return status;
}
