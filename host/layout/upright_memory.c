#include "upright_memory.h"
#include "memory.h"
#include "random.h"
#include <string.h>

static size_t slot_of(const double *position, size_t mask) {
    uint64_t bits[3];
    memcpy(bits, position, sizeof bits);
    return (size_t)pc_hash64(bits[0] ^ pc_hash64(bits[1] ^ pc_hash64(bits[2]))) & mask;
}

static bool is_at(const pc_polymesh *quads, pc_index v, const double *position) {
    const double *p = quads->position + 3 * (size_t)v;
    return p[0] == position[0] && p[1] == position[1] && p[2] == position[2];
}

/* An open table of the unmoved vertices by their place, the first one where several stand there. */
static pc_status make_table(pc_index **table, size_t *mask, pc_context *ctx,
                            const pc_upright_memory *memory) {
    const pc_polymesh *quads = &memory->quads;
    size_t size = 16;
    while (size < 2 * (size_t)quads->vertex_count)
        size *= 2;
    pc_status status = pc_new(table, ctx, size);
    if (status != PC_OK) return status;
    *mask = size - 1;
    memset(*table, 0xff, size * sizeof **table);
    for (pc_index v = 0; v < quads->vertex_count; v++) {
        const double *p = quads->position + 3 * (size_t)v;
        if (memory->moved[v]) continue;
        size_t at = slot_of(p, *mask);
        while ((*table)[at] != PC_NONE && !is_at(quads, (*table)[at], p))
            at = (at + 1) & *mask;
        if ((*table)[at] == PC_NONE) (*table)[at] = v;
    }
    return PC_OK;
}

/* The face of the memory with the same corners, the first one first. */
static pc_index find_face(const pc_upright_memory *memory, const pc_polymesh *quads, pc_index f,
                          const pc_index *vertex) {
    const pc_polymesh *old = &memory->quads;
    const pc_index from = quads->start[f], n = quads->start[f + 1] - from;
    const pc_index first = vertex[quads->corner[from]];
    if (first == PC_NONE) return PC_NONE;
    for (pc_index i = memory->start[first]; i < memory->start[first + 1]; i++) {
        pc_index g = memory->face[i], begin = old->start[g], k = 0;
        if (old->start[g + 1] - begin != n) continue;
        while (k < n && old->corner[begin + k] == vertex[quads->corner[from + k]])
            k++;
        if (k == n) return g;
    }
    return PC_NONE;
}

pc_status pc_upright_memory_match(pc_index *vertex, pc_index *face, pc_context *ctx,
                                  const pc_upright_memory *memory, const pc_polymesh *quads) {
    pc_index *table = NULL;
    size_t mask;
    pc_status status = make_table(&table, &mask, ctx, memory);
    if (status != PC_OK) return status;
    for (pc_index v = 0; v < quads->vertex_count; v++) {
        const double *p = quads->position + 3 * (size_t)v;
        size_t at = slot_of(p, mask);
        while (table[at] != PC_NONE && !is_at(&memory->quads, table[at], p))
            at = (at + 1) & mask;
        vertex[v] = table[at];
    }
    for (pc_index f = 0; f < quads->face_count; f++)
        face[f] = find_face(memory, quads, f, vertex);
    pc_free(ctx, table);
    return PC_OK;
}

void pc_upright_memory_free(pc_upright_memory *memory, pc_context *ctx) {
    if (!memory) return;
    pc_polymesh_free(&memory->quads, ctx);
    pc_free(ctx, memory->start);
    pc_free(ctx, memory->face);
    pc_free(ctx, memory->moved);
    pc_free(ctx, memory->normal);
    pc_free(ctx, memory->hint);
    pc_free(ctx, memory->stuck);
    pc_free(ctx, memory->penalty);
    pc_free(ctx, memory->folded);
    pc_free(ctx, memory->bent);
    pc_free(ctx, memory);
}
