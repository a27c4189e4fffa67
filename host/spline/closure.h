/* Refines a T-mesh so that it stays one with a good basis: analysis-suitable, with whole surroundings of
 * extraordinary vertices, and with all edges that Rule 2 asks for (digest C34). */
#ifndef PC_CLOSURE_H
#define PC_CLOSURE_H

#include "tmesh.h"

/* What one wishes of a face. */
enum { PC_HALVE_S = 1, PC_HALVE_T = 2 };

typedef struct pc_closure_stats {
    pc_index asked;     /* cuts that were wished for */
    pc_index rounds;    /* until nothing was left to cut */
    pc_index cuts;      /* in all */
    pc_index junctions; /* T-junctions afterwards */
} pc_closure_stats;

/* Cuts the faces with wish[f] (face_count values) in half, and then as many more as it takes:
 * - a face with an extraordinary corner is cut in four together with all faces around that vertex, whose
 *   depth falls by one;
 * - around faces with extraordinary corners no face has a T-junction in a side, and the faces after those
 *   have none in the sides that lead away, so that all knots there agree along lines;
 * - T-junctions that face each other are joined, and no extensions cross;
 * - lines that reach a border go on through the ghost beyond it.
 * Faces keep their root and their place in it. PC_E_NOMEM. */
pc_status pc_closure_refine(pc_tmesh *mesh, pc_closure_stats *stats, pc_context *ctx, const uint8_t *wish);
/* Makes a new mesh one of these: where the intervals around an extraordinary vertex differ the faces there
 * are cut down to squares of the shortest, and then as above. PC_E_NOMEM. */
pc_status pc_closure_settle(pc_tmesh *mesh, pc_closure_stats *stats, pc_context *ctx);
/* That all of this holds, whoever made the mesh. PC_E_BUG else. */
pc_status pc_closure_check(const pc_tmesh *mesh, pc_context *ctx);

#endif
