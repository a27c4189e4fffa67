#include "halo.h"
#include "memory.h"
#include <stdlib.h>
#include <string.h>

static pc_status list_owned(pc_halo *halo, pc_context *ctx, const pc_parts *parts) {
    pc_status status = PC_OK;
    pc_index *next = NULL;
    PC_TRY(pc_new(&halo->owned_start, ctx, (size_t)parts->part_count + 1));
    PC_TRY(pc_new(&halo->owned, ctx, parts->vertex_count));
    PC_TRY(pc_new(&halo->local, ctx, parts->vertex_count));
    PC_TRY(pc_new(&next, ctx, parts->part_count));
    for (pc_index v = 0; v < parts->vertex_count; v++)
        halo->owned_start[parts->vertex_part[v] + 1]++;
    for (pc_index p = 0; p < parts->part_count; p++)
        halo->owned_start[p + 1] += halo->owned_start[p];
    for (pc_index v = 0; v < parts->vertex_count; v++) {
        pc_index p = parts->vertex_part[v];
        halo->local[v] = next[p];
        halo->owned[halo->owned_start[p] + next[p]++] = v;
    }
done:
    pc_free(ctx, next);
    return status;
}

typedef struct halo_entry {
    pc_index owner, vertex;
} halo_entry;

static int compare_entries(const void *a, const void *b) {
    const halo_entry *x = a, *y = b;
    if (x->owner != y->owner) return x->owner < y->owner ? -1 : 1;
    return x->vertex < y->vertex ? -1 : x->vertex > y->vertex;
}

/* The halo of part p into `list` (may be NULL); `stamp` per vertex is p+1 where it was met for p. */
static pc_index gather_part(halo_entry *list, pc_index *stamp, const pc_halo *halo, const pc_graph *graph,
                            const pc_parts *parts, pc_index p) {
    pc_index count = 0;
    for (pc_index i = halo->owned_start[p]; i < halo->owned_start[p + 1]; i++) {
        pc_index v = halo->owned[i];
        for (pc_index j = graph->start[v]; j < graph->start[v + 1]; j++) {
            pc_index w = graph->neighbour[j];
            if (parts->vertex_part[w] == p || stamp[w] == p + 1) continue;
            stamp[w] = p + 1;
            if (list) list[count] = (halo_entry){parts->vertex_part[w], w};
            count++;
        }
    }
    return count;
}

static pc_status list_halos(pc_halo *halo, pc_context *ctx, const pc_graph *graph, const pc_parts *parts) {
    pc_status status = PC_OK;
    pc_index *stamp = NULL, longest = 0;
    halo_entry *list = NULL;
    PC_TRY(pc_new(&stamp, ctx, graph->vertex_count));
    PC_TRY(pc_new(&halo->halo_start, ctx, (size_t)parts->part_count + 1));
    for (pc_index p = 0; p < parts->part_count; p++) {
        pc_index count = gather_part(NULL, stamp, halo, graph, parts, p);
        halo->halo_start[p + 1] = halo->halo_start[p] + count;
        if (count > longest) longest = count;
    }
    memset(stamp, 0, graph->vertex_count * sizeof *stamp);
    PC_TRY(pc_new(&list, ctx, longest));
    PC_TRY(pc_new(&halo->halo, ctx, halo->halo_start[parts->part_count]));
    PC_TRY(pc_new(&halo->halo_owner, ctx, halo->halo_start[parts->part_count]));
    for (pc_index p = 0; p < parts->part_count; p++) {
        pc_index count = gather_part(list, stamp, halo, graph, parts, p);
        qsort(list, count, sizeof *list, compare_entries);
        for (pc_index i = 0; i < count; i++) {
            halo->halo[halo->halo_start[p] + i] = list[i].vertex;
            halo->halo_owner[halo->halo_start[p] + i] = list[i].owner;
        }
    }
done:
    pc_free(ctx, stamp);
    pc_free(ctx, list);
    return status;
}

/* Receivers in ascending order and each one's list in its own order: exactly the order wanted per sender. */
static pc_status list_sends(pc_halo *halo, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index total = halo->halo_start[halo->part_count], *next = NULL;
    PC_TRY(pc_new(&halo->send_start, ctx, (size_t)halo->part_count + 1));
    PC_TRY(pc_new(&halo->send_to, ctx, total));
    PC_TRY(pc_new(&halo->send_local, ctx, total));
    PC_TRY(pc_new(&next, ctx, halo->part_count));
    for (pc_index i = 0; i < total; i++)
        halo->send_start[halo->halo_owner[i] + 1]++;
    for (pc_index p = 0; p < halo->part_count; p++)
        halo->send_start[p + 1] += halo->send_start[p];
    for (pc_index q = 0; q < halo->part_count; q++)
        for (pc_index i = halo->halo_start[q]; i < halo->halo_start[q + 1]; i++) {
            pc_index p = halo->halo_owner[i], place = halo->send_start[p] + next[p]++;
            halo->send_to[place] = q;
            halo->send_local[place] = halo->local[halo->halo[i]];
        }
done:
    pc_free(ctx, next);
    return status;
}

pc_status pc_halo_make(pc_halo *halo, pc_context *ctx, const pc_graph *graph, const pc_parts *parts) {
    pc_status status = PC_OK;
    *halo = (pc_halo){.part_count = parts->part_count};
    PC_TRY(list_owned(halo, ctx, parts));
    PC_TRY(list_halos(halo, ctx, graph, parts));
    PC_TRY(list_sends(halo, ctx));
done:
    if (status != PC_OK) pc_halo_free(halo, ctx);
    return status;
}

void pc_halo_free(pc_halo *halo, pc_context *ctx) {
    if (!halo) return;
    pc_free(ctx, halo->owned_start);
    pc_free(ctx, halo->owned);
    pc_free(ctx, halo->local);
    pc_free(ctx, halo->halo_start);
    pc_free(ctx, halo->halo);
    pc_free(ctx, halo->halo_owner);
    pc_free(ctx, halo->send_start);
    pc_free(ctx, halo->send_to);
    pc_free(ctx, halo->send_local);
    *halo = (pc_halo){0};
}

static pc_status check_owned(const pc_halo *halo, pc_context *ctx, const pc_parts *parts) {
    if (halo->owned_start[halo->part_count] != parts->vertex_count)
        return pc_fail(ctx, PC_E_BUG, "the parts own %u of %u vertices", halo->owned_start[halo->part_count],
                       parts->vertex_count);
    for (pc_index p = 0; p < halo->part_count; p++)
        for (pc_index i = halo->owned_start[p]; i < halo->owned_start[p + 1]; i++) {
            pc_index v = halo->owned[i];
            if (parts->vertex_part[v] != p || halo->local[v] != i - halo->owned_start[p] ||
                (i > halo->owned_start[p] && halo->owned[i - 1] >= v))
                return pc_fail(ctx, PC_E_BUG, "part %u does not own vertex %u in order", p, v);
        }
    return PC_OK;
}

/* Each halo entry is next to an owned vertex and in order; with as many as there are (vertex, foreign part)
 * pairs, none is missing. */
static pc_status check_halos(const pc_halo *halo, pc_context *ctx, const pc_graph *graph,
                             const pc_parts *parts) {
    for (pc_index p = 0; p < halo->part_count; p++)
        for (pc_index i = halo->halo_start[p]; i < halo->halo_start[p + 1]; i++) {
            pc_index w = halo->halo[i], owner = halo->halo_owner[i];
            bool near = false, first = i == halo->halo_start[p];
            for (pc_index j = graph->start[w]; j < graph->start[w + 1]; j++)
                near = near || parts->vertex_part[graph->neighbour[j]] == p;
            bool ordered = first || halo->halo_owner[i - 1] < owner ||
                           (halo->halo_owner[i - 1] == owner && halo->halo[i - 1] < w);
            if (!near || !ordered || owner == p || owner != parts->vertex_part[w])
                return pc_fail(ctx, PC_E_BUG, "the halo of part %u is wrong at vertex %u", p, w);
        }
    return PC_OK;
}

static pc_status check_complete(const pc_halo *halo, pc_context *ctx, const pc_graph *graph,
                                const pc_parts *parts) {
    pc_status status = PC_OK;
    pc_index *stamp = NULL, total = 0;
    PC_TRY(pc_new(&stamp, ctx, graph->vertex_count));
    for (pc_index p = 0; p < halo->part_count; p++)
        total += gather_part(NULL, stamp, halo, graph, parts, p);
    if (total != halo->halo_start[halo->part_count])
        status = pc_fail(ctx, PC_E_BUG, "the halos hold %u of %u vertices",
                         halo->halo_start[halo->part_count], total);
done:
    pc_free(ctx, stamp);
    return status;
}

/* Walks all receivers and matches each of their entries with the sender's next one. */
static pc_status check_sends(const pc_halo *halo, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index *next = NULL;
    PC_TRY(pc_new(&next, ctx, halo->part_count));
    for (pc_index q = 0; q < halo->part_count; q++)
        for (pc_index i = halo->halo_start[q]; i < halo->halo_start[q + 1]; i++) {
            pc_index p = halo->halo_owner[i], place = halo->send_start[p] + next[p]++;
            if (place >= halo->send_start[p + 1] || halo->send_to[place] != q ||
                halo->owned[halo->owned_start[p] + halo->send_local[place]] != halo->halo[i]) {
                status = pc_fail(ctx, PC_E_BUG, "part %u does not send vertex %u to part %u in turn", p,
                                 halo->halo[i], q);
                goto done;
            }
        }
done:
    pc_free(ctx, next);
    return status;
}

pc_status pc_halo_check(const pc_halo *halo, pc_context *ctx, const pc_graph *graph, const pc_parts *parts) {
    pc_status status = PC_OK;
    PC_TRY(check_owned(halo, ctx, parts));
    PC_TRY(check_halos(halo, ctx, graph, parts));
    PC_TRY(check_complete(halo, ctx, graph, parts));
    PC_TRY(check_sends(halo, ctx));
done:
    return status;
}
