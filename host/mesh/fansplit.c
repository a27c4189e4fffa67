#include "fansplit.h"
#include "halfsort.h"
#include "memory.h"
#include <string.h>

/* The clockwise end of the fan around the tail of `h`, or `h` where it is closed. */
static pc_index fan_begin(const pc_index *twin, pc_index h) {
    pc_index first = h;
    while (twin[h] != PC_NONE) {
        h = pc_next(twin[h]);
        if (h == first) break;
    }
    return h;
}

/* The smallest free wish in the fan that begins with `begin`, PC_NONE where there is none. */
static pc_index free_wish(const pc_index *twin, const pc_index *wish, const uint8_t *taken, pc_index begin) {
    pc_index best = PC_NONE, h = begin;
    do {
        if (!taken[wish[h]] && wish[h] < best) best = wish[h];
        h = twin[pc_prev(h)];
    } while (h != PC_NONE && h != begin);
    return best;
}

static void name_fan(pc_index *fan, const pc_index *twin, pc_index begin, pc_index name) {
    pc_index h = begin;
    do {
        fan[h] = name;
        h = twin[pc_prev(h)];
    } while (h != PC_NONE && h != begin);
}

pc_status pc_fansplit_vertices(pc_index **added_source, pc_index *added_count, pc_context *ctx, pc_mesh *mesh,
                               const pc_index *twin, const pc_index *wish) {
    pc_status status = PC_OK;
    pc_index half_count = 3 * mesh->face_count, *fan = NULL;
    size_t room = 0, count = 0;
    uint8_t *taken = NULL;
    *added_source = NULL, *added_count = 0;
    PC_TRY(pc_new(&fan, ctx, half_count));
    PC_TRY(pc_new(&taken, ctx, mesh->vertex_count));
    for (pc_index h = 0; h < half_count; h++)
        fan[h] = PC_NONE;
    for (pc_index h = 0; h < half_count; h++) {
        if (fan[h] != PC_NONE) continue;
        pc_index begin = fan_begin(twin, h), name = free_wish(twin, wish, taken, begin);
        if (name != PC_NONE) {
            taken[name] = 1;
        } else {
            if (count == room) PC_TRY(pc_resize(added_source, ctx, room = room ? 2 * room : 64));
            (*added_source)[count] = wish[h];
            name = mesh->vertex_count + (pc_index)count++;
        }
        name_fan(fan, twin, begin, name);
    }
    memcpy(mesh->triangle, fan, half_count * sizeof *fan);
    *added_count = (pc_index)count;
done:
    pc_free(ctx, fan);
    pc_free(ctx, taken);
    if (status != PC_OK) pc_free(ctx, *added_source), *added_source = NULL;
    return status;
}

/* Is this run of half-edges between two vertices one edge? */
static bool is_one_edge(const pc_index *half, pc_index count, const pc_mesh *mesh, const pc_index *twin) {
    if (count == 1) return true;
    if (count != 2) return false;
    if (twin[half[0]] == half[1]) return true;
    return twin[half[0]] == PC_NONE && twin[half[1]] == PC_NONE &&
           pc_tail(mesh, half[0]) == pc_head(mesh, half[1]);
}

static pc_status cut_run(pc_index *midpoint, pc_index **parent, size_t *count, size_t *room, pc_context *ctx,
                         const pc_index *half, pc_index run, const pc_mesh *mesh, const pc_index *twin) {
    for (pc_index i = 1; i < run; i++) {
        pc_index h = half[i], g = twin[h];
        if (g == half[0] || midpoint[h] != PC_NONE) continue;
        if (*count == *room) {
            *room = *room ? 2 * *room : 64;
            pc_status status = pc_resize(parent, ctx, 2 * *room);
            if (status != PC_OK) return status;
        }
        (*parent)[2 * *count] = pc_tail(mesh, h);
        (*parent)[2 * *count + 1] = pc_head(mesh, h);
        midpoint[h] = (pc_index)*count;
        if (g != PC_NONE) midpoint[g] = (pc_index)*count;
        ++*count;
    }
    return PC_OK;
}

pc_status pc_fansplit_edges(pc_index *midpoint, pc_index **parent, size_t *added_count, pc_context *ctx,
                            const pc_mesh *mesh, const pc_index *twin) {
    pc_status status = PC_OK;
    pc_halfsort sorted = {0};
    size_t room = 0;
    *parent = NULL, *added_count = 0;
    for (pc_index h = 0; h < 3 * mesh->face_count; h++)
        midpoint[h] = PC_NONE;
    PC_TRY(pc_halfsort_make(&sorted, ctx, mesh));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        for (pc_index i = sorted.start[v], end = sorted.start[v + 1], next; i < end; i = next) {
            const pc_index *half = sorted.half + i;
            next = pc_run_end(&sorted, mesh, i, end);
            if (!is_one_edge(half, next - i, mesh, twin))
                PC_TRY(cut_run(midpoint, parent, added_count, &room, ctx, half, next - i, mesh, twin));
        }
done:
    pc_halfsort_free(&sorted, ctx);
    if (status != PC_OK) pc_free(ctx, *parent), *parent = NULL;
    return status;
}
