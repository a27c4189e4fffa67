/* Groups of strongly coupled rows, and the frames that the couplings carry from a group's root to its rows.
 */
#ifndef PC_AGGREGATE_H
#define PC_AGGREGATE_H

#include "blockmat.h"

typedef struct pc_aggregates {
    pc_index count;
    pc_index row_count;
    pc_index *of; /* per row: its group; PC_NONE for rows whose diagonal rules: smoothing alone solves them */
    pc_index *via;    /* per row: the row that its frame comes from; itself for a root */
    pc_index *start;  /* count+1 offsets into `member`; NULL where they are not listed */
    pc_index *member; /* rows by group, ascending */
} pc_aggregates;

/* Greedy groups of a row and its strong neighbours (Vanek, Mandel, Brezina 1996), in row order. */
pc_status pc_aggregates_make(pc_aggregates *aggregates, pc_context *ctx, const pc_blockmat *matrix,
                             double threshold);
/* Lists the rows of groups where they are not, and forgets them. */
pc_status pc_aggregates_list(pc_aggregates *aggregates, pc_context *ctx);
void pc_aggregates_unlist(pc_aggregates *aggregates, pc_context *ctx);
void pc_aggregates_free(pc_aggregates *aggregates, pc_context *ctx);

/* The tentative prolongator of listed groups: in row i one orthogonal block, the product of the rotations
 * -A_ij/|A_ij| on the way from the root, then relaxed within the group towards least energy. Made anew for
 * new values on the same groups. */
pc_status pc_aggregates_transport(pc_blockmat *tentative, pc_context *ctx, const pc_aggregates *aggregates,
                                  const pc_blockmat *matrix);

#endif
