#include "parts.h"
#include "memory.h"
#include <metis.h>
#include <signal.h>

/* Below this METIS has nothing to gain, and on tiny graphs it fails. */
enum { LEAST_PER_PART = 16, SEED = 1 };

#define IDX_LIMIT (sizeof(idx_t) == 4 ? (uint64_t)INT32_MAX : (uint64_t)INT64_MAX)

static void cut_runs(pc_parts *parts) {
    for (pc_index v = 0; v < parts->vertex_count; v++)
        parts->vertex_part[v] = (pc_index)((uint64_t)v * parts->part_count / parts->vertex_count);
}

/* METIS traps these two while it runs and puts them back with signal(), which loses the flags and the mask.
 */
typedef struct handlers {
    struct sigaction abort_was, term_was;
} handlers;

static void save_handlers(handlers *saved) {
    (void)sigaction(SIGABRT, NULL, &saved->abort_was);
    (void)sigaction(SIGTERM, NULL, &saved->term_was);
}

static void restore_handlers(const handlers *saved) {
    (void)sigaction(SIGABRT, &saved->abort_was, NULL);
    (void)sigaction(SIGTERM, &saved->term_was, NULL);
}

static pc_status status_of(pc_context *ctx, int code) {
    if (code == METIS_OK) return PC_OK;
    if (code == METIS_ERROR_MEMORY) return pc_fail(ctx, PC_E_NOMEM, "METIS is out of memory");
    return pc_fail(ctx, PC_E_BUG, "METIS refuses the graph (code %d)", code);
}

static pc_status call_metis(idx_t *part, pc_context *ctx, idx_t *start, idx_t *neighbour, idx_t vertex_count,
                            idx_t part_count) {
    idx_t options[METIS_NOPTIONS], constraints = 1, cut = 0;
    handlers saved;
    (void)METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = SEED;
    options[METIS_OPTION_NUMBERING] = 0;
    save_handlers(&saved);
    int code = METIS_PartGraphKway(&vertex_count, &constraints, start, neighbour, NULL, NULL, NULL,
                                   &part_count, NULL, NULL, options, &cut, part);
    restore_handlers(&saved);
    return status_of(ctx, code);
}

static pc_status cut_with_metis(pc_parts *parts, pc_context *ctx, const pc_graph *graph) {
    pc_status status = PC_OK;
    size_t n = graph->vertex_count, entries = graph->start[n];
    idx_t *start = NULL, *neighbour = NULL, *part = NULL;
    if (entries >= IDX_LIMIT || parts->part_count >= IDX_LIMIT)
        return pc_fail(ctx, PC_E_MESH, "%zu graph entries in %u parts exceed the %zu-bit indices of METIS",
                       entries, parts->part_count, 8 * sizeof(idx_t));
    PC_TRY(pc_new(&start, ctx, n + 1));
    PC_TRY(pc_new(&neighbour, ctx, entries));
    PC_TRY(pc_new(&part, ctx, n));
    for (size_t v = 0; v <= n; v++)
        start[v] = (idx_t)graph->start[v];
    for (size_t i = 0; i < entries; i++)
        neighbour[i] = (idx_t)graph->neighbour[i];
    PC_TRY(call_metis(part, ctx, start, neighbour, (idx_t)n, (idx_t)parts->part_count));
    for (size_t v = 0; v < n; v++) {
        if (part[v] < 0 || (uint64_t)part[v] >= parts->part_count) {
            status = pc_fail(ctx, PC_E_BUG, "METIS put vertex %zu into part %lld", v, (long long)part[v]);
            goto done;
        }
        parts->vertex_part[v] = (pc_index)part[v];
    }
done:
    pc_free(ctx, start);
    pc_free(ctx, neighbour);
    pc_free(ctx, part);
    return status;
}

/* Parts in the order of their smallest vertex, whatever METIS called them. */
static pc_status number_parts(pc_parts *parts, pc_context *ctx) {
    pc_index *number = NULL, next = 0;
    pc_status status = pc_new(&number, ctx, parts->part_count);
    if (status != PC_OK) return status;
    for (pc_index p = 0; p < parts->part_count; p++)
        number[p] = PC_NONE;
    for (pc_index v = 0; v < parts->vertex_count; v++) {
        pc_index *p = &number[parts->vertex_part[v]];
        if (*p == PC_NONE) *p = next++;
        parts->vertex_part[v] = *p;
    }
    pc_free(ctx, number);
    return PC_OK;
}

static uint64_t count_cut(const pc_parts *parts, const pc_graph *graph) {
    uint64_t cut = 0;
#pragma omp parallel for schedule(static) reduction(+ : cut)
    for (pc_index v = 0; v < graph->vertex_count; v++)
        for (pc_index i = graph->start[v]; i < graph->start[v + 1]; i++)
            cut += parts->vertex_part[v] != parts->vertex_part[graph->neighbour[i]];
    return cut / 2;
}

pc_status pc_parts_make(pc_parts *parts, pc_context *ctx, const pc_graph *graph, pc_index part_count) {
    pc_status status = PC_OK;
    *parts = (pc_parts){.part_count = part_count, .vertex_count = graph->vertex_count};
    if (!part_count) return pc_fail(ctx, PC_E_USAGE, "there must be at least one part");
    PC_TRY(pc_new(&parts->vertex_part, ctx, graph->vertex_count));
    if (part_count > 1 && graph->vertex_count / part_count < LEAST_PER_PART)
        cut_runs(parts);
    else if (part_count > 1)
        PC_TRY(cut_with_metis(parts, ctx, graph));
    PC_TRY(number_parts(parts, ctx));
    parts->cut_edges = count_cut(parts, graph);
done:
    if (status != PC_OK) pc_parts_free(parts, ctx);
    return status;
}

void pc_parts_free(pc_parts *parts, pc_context *ctx) {
    if (!parts) return;
    pc_free(ctx, parts->vertex_part);
    *parts = (pc_parts){0};
}

pc_status pc_parts_check(const pc_parts *parts, pc_context *ctx, const pc_graph *graph) {
    pc_index next = 0;
    if (parts->vertex_count != graph->vertex_count) return pc_fail(ctx, PC_E_BUG, "parts of another graph");
    for (pc_index v = 0; v < parts->vertex_count; v++) {
        if (parts->vertex_part[v] > next || parts->vertex_part[v] >= parts->part_count)
            return pc_fail(ctx, PC_E_BUG, "vertex %u is in part %u of %u", v, parts->vertex_part[v],
                           parts->part_count);
        next += parts->vertex_part[v] == next;
    }
    if (count_cut(parts, graph) != parts->cut_edges)
        return pc_fail(ctx, PC_E_BUG, "the cut edges are counted wrong");
    return PC_OK;
}
