#include "gauge.h"
#include "memory.h"
#include <string.h>

static pc_status start(pc_gauge *gauge, pc_context *ctx, const pc_tspline *spline) {
    pc_status status = PC_OK;
    pc_gauge_free(gauge, ctx);
    gauge->face_count = spline->mesh.face_count, gauge->vertex_count = spline->mesh.vertex_count;
    PC_TRY(pc_new(&gauge->face, ctx, gauge->face_count));
    PC_TRY(pc_new(&gauge->position, ctx, 3 * (size_t)gauge->vertex_count));
    memcpy(gauge->position, spline->position, 3 * (size_t)gauge->vertex_count * sizeof *gauge->position);
done:
    if (status != PC_OK) pc_gauge_free(gauge, ctx);
    return status;
}

pc_status pc_gauge_update(pc_gauge *gauge, pc_context *ctx, const pc_tspline *spline) {
    const pc_basis *basis = &spline->basis;
    const double *now = spline->position;
    double *then = gauge->position;
    if (gauge->face_count != spline->mesh.face_count || gauge->vertex_count != spline->mesh.vertex_count)
        return start(gauge, ctx, spline);
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < gauge->face_count; f++)
        for (size_t k = basis->start[basis->face_start[f]];
             gauge->face[f].known && k < basis->start[basis->face_start[f + 1]]; k++) {
            const size_t v = 3 * (size_t)basis->point[k];
            gauge->face[f].known =
                now[v] == then[v] && now[v + 1] == then[v + 1] && now[v + 2] == then[v + 2];
        }
    memcpy(then, now, 3 * (size_t)gauge->vertex_count * sizeof *then);
    return PC_OK;
}

pc_status pc_gauge_carry(pc_gauge *gauge, pc_context *ctx, const pc_tspline *refined) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &refined->mesh;
    pc_gauge next = {0};
    uint8_t *parts = NULL;
    PC_TRY(start(&next, ctx, refined));
    PC_TRY(pc_new(&parts, ctx, gauge->face_count));
    for (pc_index f = 0; f < mesh->face_count; f++)
        if (parts[mesh->face[f].root] < 2) parts[mesh->face[f].root]++;
    for (pc_index f = 0; f < mesh->face_count; f++)
        if (parts[mesh->face[f].root] == 1) next.face[f] = gauge->face[mesh->face[f].root];
    pc_gauge_free(gauge, ctx);
    *gauge = next, next = (pc_gauge){0};
done:
    pc_free(ctx, parts);
    pc_gauge_free(&next, ctx);
    return status;
}

void pc_gauge_free(pc_gauge *gauge, pc_context *ctx) {
    pc_free(ctx, gauge->face);
    pc_free(ctx, gauge->position);
    *gauge = (pc_gauge){0};
}
