/* The basis of a spline as files of Bezier extraction list it: nodes without those of no function, and the
 * functions of each element in the order of their nodes. */
#ifndef PC_EXTRACTION_H
#define PC_EXTRACTION_H

#include "tspline.h"

typedef struct pc_extraction {
    pc_index node_count;
    pc_index *vertex; /* per node: its vertex of the T-mesh, ascending */
    pc_index *node;   /* per vertex: its node; PC_NONE where its function is zero on the whole surface */
    size_t *order;    /* per element from basis.start on: indices into basis.point, by ascending node */
} pc_extraction;

/* PC_E_NOMEM. */
pc_status pc_extraction_make(pc_extraction *extraction, pc_context *ctx, const pc_basis *basis);
void pc_extraction_free(pc_extraction *extraction, pc_context *ctx);

#endif
