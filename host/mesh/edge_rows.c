#include "edge_rows.h"
#include "memory.h"

enum { GRAIN = 4096 };

static void sort_row(pc_index *column, pc_index count) {
    for (pc_index a = 1; a < count; a++) {
        pc_index value = column[a], b = a;
        for (; b > 0 && column[b - 1] > value; b--)
            column[b] = column[b - 1];
        column[b] = value;
    }
}

static pc_index find_column(const pc_edge_rows *rows, pc_index row, pc_index column) {
    pc_index at = rows->start[row];
    while (rows->column[at] != column)
        at++;
    return at;
}

pc_status pc_edge_rows_make(pc_edge_rows *rows, pc_context *ctx, const pc_mesh *mesh,
                            const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    pc_index n = mesh->vertex_count, edges = adjacency->edge_count;
    *rows = (pc_edge_rows){.row_count = n, .edge_count = edges};
    PC_TRY(pc_new(&rows->start, ctx, (size_t)n + 2));
    PC_TRY(pc_new(&rows->column, ctx, 2 * (size_t)edges));
    PC_TRY(pc_new(&rows->slot, ctx, 2 * (size_t)edges));
    for (pc_index e = 0; e < edges; e++) {
        pc_index h = adjacency->edge_half[e];
        rows->start[pc_tail(mesh, h) + 2]++, rows->start[pc_head(mesh, h) + 2]++;
    }
    for (pc_index i = 0; i < n; i++)
        rows->start[i + 2] += rows->start[i + 1];
    for (pc_index e = 0; e < edges; e++) {
        pc_index i = pc_tail(mesh, adjacency->edge_half[e]), j = pc_head(mesh, adjacency->edge_half[e]);
        rows->column[rows->start[i + 1]++] = j;
        rows->column[rows->start[j + 1]++] = i;
    }
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index i = 0; i < n; i++)
        sort_row(rows->column + rows->start[i], rows->start[i + 1] - rows->start[i]);
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index e = 0; e < edges; e++) {
        pc_index i = pc_tail(mesh, adjacency->edge_half[e]), j = pc_head(mesh, adjacency->edge_half[e]);
        rows->slot[2 * (size_t)e] = find_column(rows, i, j);
        rows->slot[2 * (size_t)e + 1] = find_column(rows, j, i);
    }
done:
    if (status != PC_OK) pc_edge_rows_free(rows, ctx);
    return status;
}

void pc_edge_rows_free(pc_edge_rows *rows, pc_context *ctx) {
    if (!rows) return;
    pc_free(ctx, rows->start);
    pc_free(ctx, rows->column);
    pc_free(ctx, rows->slot);
    *rows = (pc_edge_rows){0};
}
