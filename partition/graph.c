#include "graph.h"
#include "memory.h"
#include <stdlib.h>

static int compare_index(const void *a, const void *b) {
    pc_index x = *(const pc_index *)a, y = *(const pc_index *)b;
    return x < y ? -1 : x > y;
}

enum { SMALL_ROW = 64 };

static void sort_row(pc_index *row, pc_index count) {
    if (count > SMALL_ROW) {
        qsort(row, count, sizeof *row, compare_index);
        return;
    }
    for (pc_index i = 1; i < count; i++) {
        pc_index item = row[i], j = i;
        for (; j > 0 && row[j - 1] > item; j--)
            row[j] = row[j - 1];
        row[j] = item;
    }
}

/* Around vertex v: its neighbours into `row` (may be NULL), returns how many. */
static pc_index walk_row(pc_index *row, const pc_mesh *mesh, const pc_adjacency *adjacency, pc_index v) {
    pc_index first = adjacency->vertex_half[v], h = first, count = 0, last = PC_NONE;
    while (h != PC_NONE) {
        if (row) row[count] = pc_head(mesh, h);
        count++;
        last = h;
        h = pc_turn_ccw(adjacency, h);
        if (h == first) return count;
    }
    if (last == PC_NONE) return 0;
    if (row) row[count] = pc_tail(mesh, pc_prev(last)); /* the far side of the last face of an open fan */
    return count + 1;
}

pc_status pc_graph_make(pc_graph *graph, pc_context *ctx, const pc_mesh *mesh,
                        const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    *graph = (pc_graph){.vertex_count = mesh->vertex_count};
    if (adjacency->edge_count >= PC_NONE / 2)
        return pc_fail(ctx, PC_E_MESH, "%u edges exceed the 32-bit indices of this version",
                       adjacency->edge_count);
    PC_TRY(pc_new(&graph->start, ctx, (size_t)mesh->vertex_count + 1));
    PC_TRY(pc_new(&graph->neighbour, ctx, 2 * (size_t)adjacency->edge_count));
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        graph->start[v + 1] = walk_row(NULL, mesh, adjacency, v);
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        graph->start[v + 1] += graph->start[v];
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        sort_row(graph->neighbour + graph->start[v],
                 walk_row(graph->neighbour + graph->start[v], mesh, adjacency, v));
done:
    if (status != PC_OK) pc_graph_free(graph, ctx);
    return status;
}

void pc_graph_free(pc_graph *graph, pc_context *ctx) {
    if (!graph) return;
    pc_free(ctx, graph->start);
    pc_free(ctx, graph->neighbour);
    *graph = (pc_graph){0};
}

bool pc_graph_has(const pc_graph *graph, pc_index v, pc_index w) {
    pc_index low = graph->start[v], high = graph->start[v + 1];
    while (low < high) {
        pc_index middle = low + (high - low) / 2;
        if (graph->neighbour[middle] == w) return true;
        if (graph->neighbour[middle] < w)
            low = middle + 1;
        else
            high = middle;
    }
    return false;
}

pc_status pc_graph_check(const pc_graph *graph, pc_context *ctx) {
    for (pc_index v = 0; v < graph->vertex_count; v++)
        for (pc_index i = graph->start[v]; i < graph->start[v + 1]; i++) {
            pc_index w = graph->neighbour[i];
            if (w >= graph->vertex_count || w == v)
                return pc_fail(ctx, PC_E_BUG, "vertex %u has neighbour %u", v, w);
            if (i > graph->start[v] && graph->neighbour[i - 1] >= w)
                return pc_fail(ctx, PC_E_BUG, "the neighbours of vertex %u do not ascend", v);
            if (!pc_graph_has(graph, w, v))
                return pc_fail(ctx, PC_E_BUG, "%u has neighbour %u but not back", v, w);
        }
    return PC_OK;
}
