/* Half-edges side by side that run along the same edge, whatever the mesh is like. */
#ifndef PC_HALFSORT_H
#define PC_HALFSORT_H

#include "trimesh.h"

/* All half-edges, in `start[v] .. start[v+1]` those whose smaller end is v, sorted by larger end, then by
 * index: the half-edges of one edge follow each other. Faces must not repeat a vertex. Free with
 * pc_halfsort_free. */
typedef struct pc_halfsort {
    pc_index *start; /* vertex_count+1 */
    pc_index *half;  /* 3*face_count */
} pc_halfsort;

pc_status pc_halfsort_make(pc_halfsort *sorted, pc_context *ctx, const pc_mesh *mesh);
void pc_halfsort_free(pc_halfsort *sorted, pc_context *ctx);

static inline pc_index pc_low_end(const pc_mesh *mesh, pc_index h) {
    pc_index a = pc_tail(mesh, h), b = pc_head(mesh, h);
    return a < b ? a : b;
}
static inline pc_index pc_high_end(const pc_mesh *mesh, pc_index h) {
    pc_index a = pc_tail(mesh, h), b = pc_head(mesh, h);
    return a < b ? b : a;
}
/* The end of the run of half-edges that begins at `i`, within the bucket that ends at `end`. */
static inline pc_index pc_run_end(const pc_halfsort *sorted, const pc_mesh *mesh, pc_index i, pc_index end) {
    pc_index high = pc_high_end(mesh, sorted->half[i++]);
    while (i < end && pc_high_end(mesh, sorted->half[i]) == high)
        i++;
    return i;
}

#endif
