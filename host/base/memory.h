/* Allocation through the context: counted, 64-byte aligned, on huge pages where large. */
#ifndef PC_MEMORY_H
#define PC_MEMORY_H

#include "context.h"

/* count*size bytes, zeroed; `*out` is NULL on failure. count 0 gives a valid pointer. PC_E_NOMEM on overflow.
 */
pc_status pc_alloc_bytes(void **out, pc_context *ctx, size_t count, size_t size);
/* Grows or shrinks a block got from pc_alloc_bytes (or NULL); new bytes are not zeroed. On failure `*block`
 * stays. */
pc_status pc_resize_bytes(void **block, pc_context *ctx, size_t count, size_t size);
/* NULL is fine. */
void pc_free(pc_context *ctx, void *block);

/* `*out` is a typed pointer: PC_TRY(pc_new(&array, ctx, n)). */
#define pc_new(out, ctx, count)    pc_alloc_bytes((void **)(out), (ctx), (count), sizeof(**(out)))
#define pc_resize(out, ctx, count) pc_resize_bytes((void **)(out), (ctx), (count), sizeof(**(out)))

/* Bytes alive now, and the most that were alive since the last reset. */
size_t pc_memory_used(const pc_context *ctx);
size_t pc_memory_peak(const pc_context *ctx);
void pc_memory_reset_peak(pc_context *ctx);
/* Gives back what was freed and kept for the next blocks, as the context does at its end. */
void pc_memory_release(pc_context *ctx);
/* Tests: let the n-th next allocation fail (0: none). */
void pc_memory_fail_at(pc_context *ctx, size_t n);

#endif
