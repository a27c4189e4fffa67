#define _DEFAULT_SOURCE /* mmap without a file, madvise */
#include "memory.h"
#include "context_private.h"
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* The size of a block stands in the 64 bytes before it, so that freeing can count. */
enum { HEADER = 64, HUGE_PAGE = 2 << 20, HUGE_FROM = 2 << 20 };

static void count_used(pc_context *ctx, size_t bytes) {
    size_t used = atomic_fetch_add(&ctx->used, bytes) + bytes;
    size_t peak = atomic_load(&ctx->peak);
    while (used > peak && !atomic_compare_exchange_weak(&ctx->peak, &peak, used)) {
    }
}

static bool refused_by_test(pc_context *ctx) {
    size_t n = atomic_load(&ctx->fail_at);
    while (n > 0 && !atomic_compare_exchange_weak(&ctx->fail_at, &n, n - 1)) {
    }
    return n == 1;
}

static pc_status block_bytes(size_t *bytes, pc_context *ctx, size_t count, size_t size) {
    if (__builtin_mul_overflow(count, size, bytes) || *bytes > SIZE_MAX / 2)
        return pc_fail(ctx, PC_E_NOMEM, "a block of %zu x %zu bytes is beyond any machine", count, size);
    return PC_OK;
}

/* Large blocks come from the system and go back to it: heaps keep what was freed between blocks that live on.
 * Where addresses are checked they stay in the checker's heap. */
#if defined(__SANITIZE_ADDRESS__)
static const size_t mapped_from = SIZE_MAX;
#else
static const size_t mapped_from = 1 << 20;
#endif

static bool is_mapped(size_t bytes) {
    return bytes >= mapped_from;
}

static size_t mapped_bytes(size_t bytes) {
    enum { PAGE = 4096 };
    return (bytes + HEADER + PAGE - 1) / PAGE * PAGE;
}

/* Fresh zeros; large blocks are aligned so that they can be huge pages. */
static void *map_block(size_t bytes) {
    const size_t wanted = mapped_bytes(bytes);
    if (bytes < HUGE_FROM) {
        void *block = mmap(NULL, wanted, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        return block == MAP_FAILED ? NULL : block;
    }
    char *at = mmap(NULL, wanted + HUGE_PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED) return NULL;
    const size_t before = (HUGE_PAGE - (uintptr_t)at % HUGE_PAGE) % HUGE_PAGE;
    if (before > 0) (void)munmap(at, before);
    (void)munmap(at + before + wanted, HUGE_PAGE - before);
    return at + before;
}

static void *raw_block(pc_context *ctx, size_t bytes, bool zeroed) {
    void *base = NULL;
    const bool mapped = is_mapped(bytes);
    if (refused_by_test(ctx)) return NULL;
    if (mapped)
        base = map_block(bytes);
    else if (posix_memalign(&base, bytes >= HUGE_FROM ? HUGE_PAGE : HEADER, bytes + HEADER) != 0)
        base = NULL;
    if (!base) return NULL;
    if (bytes >= HUGE_FROM) (void)madvise(base, bytes + HEADER, MADV_HUGEPAGE);
    if (zeroed && !mapped) memset((char *)base + HEADER, 0, bytes);
    *(size_t *)base = bytes;
    count_used(ctx, bytes);
    return (char *)base + HEADER;
}

pc_status pc_alloc_bytes(void **out, pc_context *ctx, size_t count, size_t size) {
    size_t bytes;
    *out = NULL;
    pc_status status = block_bytes(&bytes, ctx, count, size);
    if (status != PC_OK) return status;
    void *block = raw_block(ctx, bytes, true);
    if (!block)
        return pc_fail(ctx, PC_E_NOMEM, "out of memory: %zu more bytes on top of %zu", bytes,
                       pc_memory_used(ctx));
    *out = block;
    return PC_OK;
}

pc_status pc_resize_bytes(void **block, pc_context *ctx, size_t count, size_t size) {
    size_t bytes;
    pc_status status = block_bytes(&bytes, ctx, count, size);
    if (status != PC_OK) return status;
    void *grown = raw_block(ctx, bytes, false);
    if (!grown)
        return pc_fail(ctx, PC_E_NOMEM, "out of memory: %zu more bytes on top of %zu", bytes,
                       pc_memory_used(ctx));
    if (*block) {
        size_t old = *(size_t *)((char *)*block - HEADER);
        memcpy(grown, *block, old < bytes ? old : bytes);
        pc_free(ctx, *block);
    }
    *block = grown;
    return PC_OK;
}

void pc_free(pc_context *ctx, void *block) {
    if (!block) return;
    void *base = (char *)block - HEADER;
    const size_t bytes = *(size_t *)base;
    atomic_fetch_sub(&ctx->used, bytes);
    if (is_mapped(bytes))
        (void)munmap(base, mapped_bytes(bytes));
    else
        free(base);
}

size_t pc_memory_used(const pc_context *ctx) {
    return atomic_load(&ctx->used);
}

size_t pc_memory_peak(const pc_context *ctx) {
    return atomic_load(&ctx->peak);
}

void pc_memory_reset_peak(pc_context *ctx) {
    atomic_store(&ctx->peak, atomic_load(&ctx->used));
}

void pc_memory_fail_at(pc_context *ctx, size_t n) {
    atomic_store(&ctx->fail_at, n);
}
