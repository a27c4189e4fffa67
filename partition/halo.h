/* What each part holds: its own vertices, copies of the others' next to them, and who sends what to whom. */
#ifndef PC_HALO_H
#define PC_HALO_H

#include "parts.h"

/* Part p numbers its vertices locally: first the owned ones, from owned[owned_start[p]] on, then the halo,
 * from halo[halo_start[p]] on. */
typedef struct pc_halo {
    pc_index part_count;
    pc_index *owned_start; /* part_count+1 */
    pc_index *owned;       /* vertices by part, ascending within one */
    pc_index *local;       /* per vertex: its local number in the part that owns it */
    pc_index *halo_start;  /* part_count+1 */
    pc_index *halo;        /* other parts' vertices with an edge to an owned one; by owner, then ascending */
    pc_index *halo_owner;  /* per halo entry: the part that owns it */
    pc_index *send_start;  /* part_count+1: what part p gives away */
    pc_index *send_to;     /* per send entry: the part that gets it; ascending */
    pc_index *send_local;  /* per send entry: local number in p. The entries of p for q come in the order in
                              which q  lists p's vertices in its halo */
} pc_halo;

/* Linear in graph and halo. PC_E_NOMEM. */
pc_status pc_halo_make(pc_halo *halo, pc_context *ctx, const pc_graph *graph, const pc_parts *parts);
void pc_halo_free(pc_halo *halo, pc_context *ctx);
/* Everything above holds. PC_E_BUG else. */
pc_status pc_halo_check(const pc_halo *halo, pc_context *ctx, const pc_graph *graph, const pc_parts *parts);

static inline pc_index pc_halo_owned_count(const pc_halo *h, pc_index part) {
    return h->owned_start[part + 1] - h->owned_start[part];
}
static inline pc_index pc_halo_count(const pc_halo *h, pc_index part) {
    return h->halo_start[part + 1] - h->halo_start[part];
}

#endif
