#define _DEFAULT_SOURCE /* mmap without a file, madvise */
#include "memory.h"
#include "context_private.h"
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* The size of a block stands in the 64 bytes before it, so that freeing can count. */
enum { HEADER = 64, HUGE_PAGE = 2 << 20, HUGE_FROM = 2 << 20, MOST_SPARE = 64 << 20 };

static void raise_to(atomic_size_t *peak, size_t used) {
    size_t before = atomic_load(peak);
    while (used > before && !atomic_compare_exchange_weak(peak, &before, used)) {
    }
}

static void count_used(pc_context *ctx, size_t bytes) {
    const size_t used = atomic_fetch_add(&ctx->used, bytes) + bytes;
    raise_to(&ctx->peak, used);
    raise_to(&ctx->most, used);
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
static void *map_block(size_t wanted) {
    if (wanted < HUGE_FROM) {
        void *block = mmap(NULL, wanted, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        return block == MAP_FAILED ? NULL : block;
    }
    char *at = mmap(NULL, wanted + HUGE_PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED) return NULL;
    const size_t before = (HUGE_PAGE - (uintptr_t)at % HUGE_PAGE) % HUGE_PAGE;
    if (before > 0) (void)munmap(at, before);
    (void)munmap(at + before + wanted, HUGE_PAGE - before);
    (void)madvise(at + before, wanted, MADV_HUGEPAGE);
    return at + before;
}

/* ---- Spare blocks: the system need not clear their pages again ---- */

static void drop_spare(pc_spare_blocks *s, size_t i) {
    (void)munmap(s->block[i].base, s->block[i].mapped);
    s->bytes -= s->block[i].mapped;
    s->block[i] = s->block[--s->count];
}

/* A spare block of `wanted` bytes or little more, NULL if there is none; then those that would make for a
 * larger peak together with a new one go. */
static void *take_spare(pc_context *ctx, size_t wanted, size_t *mapped) {
    pc_spare_blocks *s = &ctx->spare;
    void *base = NULL;
    pthread_mutex_lock(&s->lock);
    size_t best = s->count;
    for (size_t i = 0; i < s->count; i++)
        if (s->block[i].mapped >= wanted && s->block[i].mapped <= wanted + wanted / 4 &&
            (best == s->count || s->block[i].mapped < s->block[best].mapped))
            best = i;
    if (best < s->count) {
        base = s->block[best].base, *mapped = s->block[best].mapped;
        s->bytes -= *mapped;
        s->block[best] = s->block[--s->count];
    }
    while (!base && s->count > 0 && atomic_load(&ctx->used) + wanted + s->bytes > atomic_load(&ctx->most))
        drop_spare(s, 0);
    pthread_mutex_unlock(&s->lock);
    return base;
}

/* Kept while that does not make for a larger peak; else it goes back to the system. */
static void keep_spare(pc_context *ctx, void *base, size_t mapped) {
    pc_spare_blocks *s = &ctx->spare;
    pthread_mutex_lock(&s->lock);
    const bool kept = s->count < sizeof s->block / sizeof *s->block && s->bytes + mapped <= MOST_SPARE &&
                      atomic_load(&ctx->used) + s->bytes + mapped <= atomic_load(&ctx->most);
    if (kept) {
        s->block[s->count].base = base, s->block[s->count++].mapped = mapped;
        s->bytes += mapped;
    }
    pthread_mutex_unlock(&s->lock);
    if (!kept) (void)munmap(base, mapped);
}

void pc_memory_release(pc_context *ctx) {
    pthread_mutex_lock(&ctx->spare.lock);
    while (ctx->spare.count > 0)
        drop_spare(&ctx->spare, 0);
    pthread_mutex_unlock(&ctx->spare.lock);
}

/* What stands before a block. */
typedef struct header {
    size_t bytes, mapped;
} header;

static void *raw_block(pc_context *ctx, size_t bytes, bool zeroed) {
    void *base = NULL;
    size_t mapped = 0;
    bool clear = zeroed;
    if (refused_by_test(ctx)) return NULL;
    if (is_mapped(bytes)) {
        base = take_spare(ctx, mapped_bytes(bytes), &mapped);
        if (!base) {
            mapped = mapped_bytes(bytes), clear = false;
            base = map_block(mapped);
        }
    } else if (posix_memalign(&base, bytes >= HUGE_FROM ? HUGE_PAGE : HEADER, bytes + HEADER) != 0)
        base = NULL;
    if (!base) return NULL;
    if (clear) memset((char *)base + HEADER, 0, bytes);
    *(header *)base = (header){bytes, mapped};
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
        const size_t old = ((const header *)(const void *)((char *)*block - HEADER))->bytes;
        memcpy(grown, *block, old < bytes ? old : bytes);
        pc_free(ctx, *block);
    }
    *block = grown;
    return PC_OK;
}

void pc_free(pc_context *ctx, void *block) {
    if (!block) return;
    void *base = (char *)block - HEADER;
    const header about = *(header *)base;
    atomic_fetch_sub(&ctx->used, about.bytes);
    if (about.mapped)
        keep_spare(ctx, base, about.mapped);
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
