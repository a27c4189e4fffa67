/* A polygon mesh as arrays: the quads that Percale writes. */
#ifndef PC_POLYMESH_H
#define PC_POLYMESH_H

#include "context.h"

typedef struct pc_polymesh {
    pc_index vertex_count;
    pc_index face_count;
    double *position;     /* 3 per vertex */
    pc_index *start;      /* face_count+1 offsets into corner */
    pc_index *corner;     /* vertex per corner, counter-clockwise */
    uint8_t *corner_flat; /* per corner: 1 where the vertex is a T-junction on a straight side of this face;
                             may be NULL */
} pc_polymesh;

pc_status pc_polymesh_make(pc_polymesh *mesh, pc_context *ctx, size_t vertex_count, size_t face_count,
                           size_t corner_count);
/* PC_E_NOMEM. */
pc_status pc_polymesh_copy(pc_polymesh *copy, pc_context *ctx, const pc_polymesh *mesh);
/* Takes out the faces with removed[f] != 0 and the vertices that no face uses then; the rest keeps its order.
 */
pc_status pc_polymesh_compact(pc_polymesh *mesh, pc_context *ctx, const uint8_t *removed);
void pc_polymesh_free(pc_polymesh *mesh, pc_context *ctx);

/* The corners after and before c around face f. */
static inline pc_index pc_polymesh_next(const pc_polymesh *mesh, pc_index f, pc_index c) {
    return c + 1 < mesh->start[f + 1] ? c + 1 : mesh->start[f];
}
static inline pc_index pc_polymesh_previous(const pc_polymesh *mesh, pc_index f, pc_index c) {
    return (c > mesh->start[f] ? c : mesh->start[f + 1]) - 1;
}

#endif
