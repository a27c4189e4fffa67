#include "region.h"
#include "memory.h"

/* Marks the control points with a function on a face that is marked. */
static void mark_points(pc_region *region, const pc_basis *basis) {
    for (pc_index e = 0; e < basis->element_count; e++)
        for (size_t k = basis->start[e]; region->active[basis->element[e].face] && k < basis->start[e + 1];
             k++)
            region->free[basis->point[k]] = 1;
}

/* Marks the faces with a function of a control point that is marked. */
static void mark_faces(pc_region *region, const pc_basis *basis) {
    for (pc_index e = 0; e < basis->element_count; e++)
        for (size_t k = basis->start[e]; !region->active[basis->element[e].face] && k < basis->start[e + 1];
             k++)
            region->active[basis->element[e].face] = region->free[basis->point[k]];
}

pc_status pc_region_make(pc_region *region, pc_context *ctx, const pc_tspline *spline, const double *far,
                         double limit) {
    pc_status status = PC_OK;
    const pc_basis *basis = &spline->basis;
    *region = (pc_region){0};
    PC_TRY(pc_new(&region->free, ctx, basis->vertex_count));
    PC_TRY(pc_new(&region->active, ctx, basis->face_count));
    for (pc_index f = 0; f < basis->face_count; f++)
        region->active[f] = far[f] > limit;
    for (int ring = 0; ring < 2; ring++) {
        mark_points(region, basis);
        mark_faces(region, basis);
    }
    for (pc_index v = 0; v < basis->vertex_count; v++)
        region->points += region->free[v];
    for (pc_index f = 0; f < basis->face_count; f++)
        region->faces += region->active[f];
done:
    if (status != PC_OK) pc_region_free(region, ctx);
    return status;
}

void pc_region_free(pc_region *region, pc_context *ctx) {
    pc_free(ctx, region->free);
    pc_free(ctx, region->active);
    *region = (pc_region){0};
}
