/* What the members of a device tell each other during a solve: copies of rows, rows of a level that one of
 * them holds, partial sums and scalars (kernels/halo.cl). Arrays of buffers have one for each member. */
#ifndef PC_EXCHANGE_H
#define PC_EXCHANGE_H

#include "share.h"

typedef struct pc_exchange pc_exchange;

/* `device` has the members of `share`, which is copied as far as it is needed; rows have at most `row_bytes`
 * bytes. */
pc_status pc_exchange_make(pc_exchange **exchange, pc_context *ctx, pc_device *device, const pc_share *share,
                           size_t row_bytes);
/* NULL is fine; waits for nothing. */
void pc_exchange_free(pc_exchange *exchange, pc_context *ctx);

/* Starts to fill the copies in the vectors of a level, of `row_bytes` bytes a row and with copies from place
 * `first[member]` on. */
pc_status pc_exchange_start(pc_exchange *exchange, pc_context *ctx, int level, pc_buffer *const *vector,
                            const size_t *first, size_t row_bytes);
/* What the member starts from now on waits for its copies. */
pc_status pc_exchange_finish(pc_exchange *exchange, pc_context *ctx, int member);

/* `to` on the first member, in its order, from the rows that each member made of the level after those spread
 * out. */
pc_status pc_exchange_gather(pc_exchange *exchange, pc_context *ctx, const pc_buffer *to,
                             pc_buffer *const *made, size_t row_bytes);
/* `to` on the first member: the partial sums of all in the order of the blocks. A block has `per_block`,
 * member m has count[m]. */
pc_status pc_exchange_sums(pc_exchange *exchange, pc_context *ctx, const pc_buffer *to,
                           pc_buffer *const *partial, const size_t *count, size_t per_block);
/* The first member's bytes at `offset` become everyone's. */
pc_status pc_exchange_tell(pc_exchange *exchange, pc_context *ctx, pc_buffer *const *scalars, size_t offset,
                           size_t bytes);

#endif
