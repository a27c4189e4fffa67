/* Gives equal positions one index: for files that repeat a vertex in every face. */
#ifndef PC_WELD_H
#define PC_WELD_H

#include "context.h"

/* A growing set of positions; starts zeroed. */
typedef struct pc_weld {
    double *position; /* 3 per vertex, in the order they were first met */
    size_t count;
    size_t capacity;
    pc_index *slot; /* open addressing, PC_NONE where free */
    size_t slots;   /* a power of two, more than twice count */
} pc_weld;

void pc_weld_free(pc_weld *weld, pc_context *ctx);
/* The index of each of `count` points (3 doubles each), finite. Equal means equal bit for bit, but for -0,
 * which becomes 0. PC_E_FORMAT beyond the range of an index. */
pc_status pc_weld_add(pc_weld *weld, pc_context *ctx, pc_index *index, const double *point, size_t count);

#endif
