#include "oddpair.h"
#include "memory.h"
#include "polygraph.h"
#include <stdlib.h>
#include <string.h>

typedef struct couple {
    int distance;
    pc_index one, two;
} couple;

typedef struct pairing {
    const pc_polymesh *mesh;
    pc_polygraph graph;
    uint8_t *taken;  /* per polygon: kept, or part of a pair */
    int *distance;   /* per polygon seen: edges from the start; -1 for all others */
    pc_index *entry; /* per polygon seen: its corner whose edge leads back */
    pc_index *queue;
    pc_index seen;
    couple *couple;
    size_t count, room;
    uint8_t *open;    /* per corner: its edge goes */
    pc_index *joined; /* per polygon: PC_NONE, or the end of the pair that it went into */
    uint8_t *mark;    /* per vertex */
} pairing;

static bool is_odd(const pairing *p, pc_index f) {
    return !p->taken[f] && (p->mesh->start[f + 1] - p->mesh->start[f]) % 2 == 1;
}

static void forget(pairing *p) {
    for (pc_index i = 0; i < p->seen; i++)
        p->distance[p->queue[i]] = -1;
    p->seen = 0;
}

/* All polygons up to `farthest` edges from `start`, or up to `goal`. */
static void explore(pairing *p, pc_index start, pc_index goal, int farthest) {
    forget(p);
    p->queue[p->seen++] = start;
    p->distance[start] = 0;
    for (pc_index at = 0; at < p->seen; at++) {
        pc_index f = p->queue[at];
        if (f == goal || p->distance[f] == farthest) break;
        for (pc_index c = p->mesh->start[f]; c < p->mesh->start[f + 1]; c++) {
            pc_index twin = p->graph.twin[c];
            if (twin == PC_NONE) continue;
            pc_index g = p->graph.face[twin];
            if (p->taken[g] || p->distance[g] >= 0) continue;
            p->distance[g] = p->distance[f] + 1;
            p->entry[g] = twin;
            p->queue[p->seen++] = g;
        }
    }
}

static int by_distance(const void *x, const void *y) {
    const couple *a = x, *b = y;
    if (a->distance != b->distance) return a->distance - b->distance;
    if (a->one != b->one) return (a->one > b->one) - (a->one < b->one);
    return (a->two > b->two) - (a->two < b->two);
}

static pc_status list_couples(pairing *p, pc_context *ctx, int farthest) {
    pc_status status = PC_OK;
    for (pc_index f = 0; f < p->mesh->face_count; f++) {
        if (!is_odd(p, f)) continue;
        explore(p, f, PC_NONE, farthest);
        for (pc_index i = 1; i < p->seen; i++) {
            pc_index g = p->queue[i];
            if (g < f || !is_odd(p, g)) continue;
            if (p->count == p->room) {
                p->room = 2 * p->room + 64;
                PC_TRY(pc_resize(&p->couple, ctx, p->room));
            }
            p->couple[p->count++] = (couple){p->distance[g], f, g};
        }
    }
    if (p->count) qsort(p->couple, p->count, sizeof *p->couple, by_distance);
done:
    return status;
}

static pc_index after(const pairing *p, pc_index c) {
    return pc_polymesh_next(p->mesh, p->graph.face[c], c);
}

/* The corner that follows c around what has been joined. */
static pc_index next_around(const pairing *p, pc_index c) {
    c = after(p, c);
    while (p->open[c])
        c = after(p, p->graph.twin[c]);
    return c;
}

/* Whether the polygon around what has been joined is a simple one with all the corners it should have. */
static bool is_simple(pairing *p, pc_index first, pc_index expected) {
    pc_index count = 0, c = first;
    bool simple = true;
    do {
        simple = simple && !p->mark[p->mesh->corner[c]];
        p->mark[p->mesh->corner[c]] = 1;
        count++;
        c = next_around(p, c);
    } while (c != first);
    do {
        p->mark[p->mesh->corner[c]] = 0;
        c = next_around(p, c);
    } while (c != first);
    return simple && count == expected;
}

static pc_index first_closed(const pairing *p, pc_index f) {
    pc_index c = p->mesh->start[f];
    while (p->open[c])
        c++;
    return c;
}

/* Joins what is between `one` and `two`, whose way back is known. */
static bool join_way(pairing *p, pc_index one, pc_index two) {
    pc_index corners = p->mesh->start[one + 1] - p->mesh->start[one];
    for (pc_index f = two; f != one; f = p->graph.face[p->graph.twin[p->entry[f]]]) {
        corners += p->mesh->start[f + 1] - p->mesh->start[f] - 2;
        p->open[p->entry[f]] = p->open[p->graph.twin[p->entry[f]]] = 1;
    }
    bool good = is_simple(p, first_closed(p, one), corners);
    for (pc_index f = two;; f = p->graph.face[p->graph.twin[p->entry[f]]]) {
        if (good) p->taken[f] = 1, p->joined[f] = one;
        if (f == one) break;
        if (!good) p->open[p->entry[f]] = p->open[p->graph.twin[p->entry[f]]] = 0;
    }
    return good;
}

static pc_index join_couples(pairing *p, int farthest) {
    pc_index pairs = 0;
    for (size_t i = 0; i < p->count; i++) {
        pc_index one = p->couple[i].one, two = p->couple[i].two;
        if (p->taken[one] || p->taken[two]) continue;
        explore(p, one, two, farthest); /* around those that are taken by now */
        if (p->distance[two] > 0) pairs += join_way(p, one, two);
    }
    return pairs;
}

/* The polygons that are left, in their order. */
static pc_status write(pc_polymesh *out, pc_index **source, pc_context *ctx, const pairing *p) {
    pc_status status = PC_OK;
    const pc_polymesh *mesh = p->mesh;
    pc_index at = 0, face = 0;
    *out = (pc_polymesh){0};
    PC_TRY(pc_polymesh_make(out, ctx, mesh->vertex_count, mesh->face_count, p->graph.corner_count));
    PC_TRY(pc_new(source, ctx, mesh->face_count));
    memcpy(out->position, mesh->position, 3 * sizeof(double) * mesh->vertex_count);
    for (pc_index f = 0; f < mesh->face_count; f++) {
        if (p->joined[f] != PC_NONE && p->joined[f] != f) continue;
        pc_index first = first_closed(p, f), c = first;
        do {
            out->corner_flat[at] = p->joined[f] == PC_NONE && mesh->corner_flat[c];
            out->corner[at++] = mesh->corner[c];
            c = next_around(p, c);
        } while (c != first);
        (*source)[face] = f;
        out->start[++face] = at;
    }
    out->face_count = face;
done:
    return status;
}

pc_status pc_oddpair_join(pc_polymesh *mesh, pc_index **source, pc_index *pairs, pc_context *ctx,
                          const uint8_t *kept, int farthest) {
    pc_status status = PC_OK;
    pairing p = {.mesh = mesh};
    pc_polymesh out = {0};
    *source = NULL, *pairs = 0;
    PC_TRY(pc_polygraph_of_polymesh(&p.graph, ctx, mesh));
    PC_TRY(pc_new(&p.taken, ctx, mesh->face_count));
    PC_TRY(pc_new(&p.distance, ctx, mesh->face_count));
    PC_TRY(pc_new(&p.entry, ctx, mesh->face_count));
    PC_TRY(pc_new(&p.queue, ctx, mesh->face_count));
    PC_TRY(pc_new(&p.joined, ctx, mesh->face_count));
    PC_TRY(pc_new(&p.open, ctx, p.graph.corner_count));
    PC_TRY(pc_new(&p.mark, ctx, mesh->vertex_count));
    memcpy(p.taken, kept, mesh->face_count);
    memset(p.joined, 0xff, mesh->face_count * sizeof *p.joined);
    for (pc_index f = 0; f < mesh->face_count; f++)
        p.distance[f] = -1;
    PC_TRY(list_couples(&p, ctx, farthest));
    *pairs = join_couples(&p, farthest);
    PC_TRY(write(&out, source, ctx, &p));
    pc_polymesh_free(mesh, ctx);
    *mesh = out, out = (pc_polymesh){0};
done:
    pc_polymesh_free(&out, ctx);
    pc_polygraph_free(&p.graph, ctx);
    pc_free(ctx, p.taken);
    pc_free(ctx, p.distance);
    pc_free(ctx, p.entry);
    pc_free(ctx, p.queue);
    pc_free(ctx, p.joined);
    pc_free(ctx, p.open);
    pc_free(ctx, p.mark);
    pc_free(ctx, p.couple);
    return status;
}
