/* What pc_upright_make knows at its end, for the next call on nearly the same mesh. */
#ifndef PC_UPRIGHT_MEMORY_H
#define PC_UPRIGHT_MEMORY_H

#include "upright.h"
#include "vec3.h"

struct pc_upright_memory {
    pc_polymesh quads;
    pc_index *start, *face; /* per vertex: its faces */
    uint8_t *moved;         /* per vertex: its normal is that of another place */
    pc_vec3 *normal;
    pc_index *hint;
    uint8_t *stuck;
    double *penalty; /* per face; of those whose corners have not moved */
    uint8_t *folded, *bent;
};

/* Per vertex of `quads` the vertex of the memory that stands unmoved at the same place, per face the one
 * between such vertices; PC_NONE where there is none. PC_E_NOMEM. */
pc_status pc_upright_memory_match(pc_index *vertex, pc_index *face, pc_context *ctx,
                                  const pc_upright_memory *memory, const pc_polymesh *quads);

#endif
