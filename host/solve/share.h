/* Which member of a device (device.h) holds which rows of a hierarchy, and copies of whose rows it needs.
 *
 * The finest level is dealt out in blocks of PC_SHARE_BLOCK places of its row order, so that each partial sum
 * over a block is one member's and a sum of all in their order has the bits of one device's. METIS cuts the
 * graph of the blocks. A coarser row goes where the first row of its group is. Levels with too few rows are
 * the first member's; the first of these is still restricted by all. */
#ifndef PC_SHARE_H
#define PC_SHARE_H

#include "devmat.h"
#include "multigrid.h"

enum { PC_SHARE_BLOCK = 4096 };

/* A member's part of a level. */
typedef struct pc_share_rows {
    pc_row_order order; /* its own rows; `place` is that of its copies too, and PC_NONE of what it lacks */
    pc_index *made; /* the rows that it restricts, ascending in the level's order; NULL where these are its
                       own */
    pc_index made_count;
    pc_index *sent; /* places that others have copies of, by the member that has them */
    pc_index sent_start[PC_MOST_MEMBERS + 1];
    pc_index copied_start[PC_MOST_MEMBERS + 1]; /* by member, where its rows begin among the copies */
} pc_share_rows;

/* Blocks of the finest level that lie side by side, with one member as in the whole. */
typedef struct pc_share_run {
    int member;
    pc_index first; /* of the member's blocks */
    pc_index whole; /* of all */
    pc_index count;
} pc_share_run;

typedef struct pc_share {
    int member_count;
    int spread;      /* levels that are dealt out */
    int level_count; /* these, and the next one where there is one */
    pc_share_rows *rows;
    pc_share_run *run;
    pc_index run_count;
} pc_share;

/* `order` has the row order of every level of `multigrid`, whose matrices must be there. Spreads the finest
 * level, and those after it with `least` rows per member. Copies follow rows in slices of `slice_rows`. */
pc_status pc_share_make(pc_share *share, pc_context *ctx, const pc_multigrid *multigrid,
                        const pc_row_order *const *order, int member_count, pc_index slice_rows,
                        pc_index least);
void pc_share_free(pc_share *share, pc_context *ctx);

static inline pc_share_rows *pc_share_of(const pc_share *share, int level, int member) {
    return &share->rows[level * share->member_count + member];
}

#endif
