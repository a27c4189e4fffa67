/* Analysis-suitability: no two extensions of T-junctions meet at an angle (Li et al. 2012, Scott et al.
 * 2012). An extension goes two faces on from the T-junction and one edge back; touching counts as meeting. */
#ifndef PC_SUITABLE_H
#define PC_SUITABLE_H

#include "tmesh.h"

/* One place where two meet: the vertices of the T-junctions. */
typedef struct pc_crossing {
    pc_index junction[2];
} pc_crossing;

/* `*crossings` (the caller frees it) gets one for every face, edge and vertex where extensions meet; the same
 * pair may be there more than once. None: the mesh is analysis-suitable. `junctions` (may be NULL) gets the
 * number of T-junctions. PC_E_NOMEM. */
pc_status pc_suitable_crossings(pc_crossing **crossings, size_t *count, pc_index *junctions, pc_context *ctx,
                                const pc_tmesh *mesh);
/* The half-edge with which the face straight ahead of T-junction v begins, PC_NONE where v is none. */
pc_index pc_suitable_junction(const pc_tmesh *mesh, pc_index v);

#endif
