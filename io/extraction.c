#include "extraction.h"
#include "memory.h"
#include <string.h>

void pc_extraction_free(pc_extraction *extraction, pc_context *ctx) {
    pc_free(ctx, extraction->vertex);
    pc_free(ctx, extraction->node);
    pc_free(ctx, extraction->order);
    *extraction = (pc_extraction){0};
}

/* By insertion: there are some sixteen. */
static void sort_points(size_t *order, const pc_basis *basis, size_t first, size_t count) {
    for (size_t i = 0; i < count; i++) {
        size_t at = i;
        for (; at > 0 && basis->point[order[at - 1]] > basis->point[first + i]; at--)
            order[at] = order[at - 1];
        order[at] = first + i;
    }
}

pc_status pc_extraction_make(pc_extraction *extraction, pc_context *ctx, const pc_basis *basis) {
    pc_status status = PC_OK;
    size_t points = basis->start[basis->element_count];
    *extraction = (pc_extraction){0};
    PC_TRY(pc_new(&extraction->vertex, ctx, basis->vertex_count));
    PC_TRY(pc_new(&extraction->node, ctx, basis->vertex_count));
    PC_TRY(pc_new(&extraction->order, ctx, points));
    memset(extraction->node, 0xff, basis->vertex_count * sizeof *extraction->node);
    for (size_t k = 0; k < points; k++)
        extraction->node[basis->point[k]] = 0;
    for (pc_index v = 0; v < basis->vertex_count; v++) {
        if (extraction->node[v] == PC_NONE) continue;
        extraction->vertex[extraction->node_count] = v;
        extraction->node[v] = extraction->node_count++;
    }
    for (pc_index e = 0; e < basis->element_count; e++)
        sort_points(extraction->order + basis->start[e], basis, basis->start[e],
                    basis->start[e + 1] - basis->start[e]);
done:
    if (status != PC_OK) pc_extraction_free(extraction, ctx);
    return status;
}
