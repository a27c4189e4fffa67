/* Blocks of all sizes: zeros where they are promised, also in blocks that were in use before, contents kept
 * through growth, and nothing left in the end. */
#include "memory.h"
#include "random.h"
#include "testing.h"
#include <string.h>

enum { SLOTS = 24, STEPS = 300 };

static size_t random_size(pc_random *random) {
    static const size_t around[] = {100, 1 << 16, 1 << 20, 2 << 20, 5 << 20};
    const size_t base = around[(size_t)(pc_random_uniform(random) * 5)];
    return base + (size_t)(pc_random_uniform(random) * (double)base / 3);
}

static bool all_are(const uint8_t *block, size_t size, uint8_t value) {
    return size == 0 || (block[0] == value && memcmp(block, block + 1, size - 1) == 0);
}

/* Takes, grows and gives back blocks in any order; false where one does not hold what it should. */
static bool blocks_hold(pc_context *ctx, uint64_t seed) {
    pc_random random = {seed};
    uint8_t *block[SLOTS] = {NULL};
    size_t size[SLOTS] = {0};
    bool good = true;
    for (int i = 0; i < STEPS && good; i++) {
        const size_t k = (size_t)(pc_random_uniform(&random) * SLOTS);
        const size_t now = random_size(&random);
        if (!block[k]) {
            good = pc_new(&block[k], ctx, now) == PC_OK && all_are(block[k], now, 0);
        } else if (pc_random_uniform(&random) < 0.3) {
            good = pc_resize(&block[k], ctx, now) == PC_OK &&
                   all_are(block[k], now < size[k] ? now : size[k], (uint8_t)(k + 1));
        } else {
            good = all_are(block[k], size[k], (uint8_t)(k + 1));
            pc_free(ctx, block[k]);
            block[k] = NULL;
            continue;
        }
        size[k] = now;
        if (good) memset(block[k], (int)k + 1, now);
    }
    for (size_t k = 0; k < SLOTS; k++)
        pc_free(ctx, block[k]);
    return good;
}

static void blocks_hold_what_they_should(void **state) {
    pc_context *ctx = *state;
    enum { RUNS = 8 };
    bool good[RUNS];
#pragma omp parallel for schedule(dynamic, 1) num_threads(4)
    for (int run = 0; run < RUNS; run++)
        good[run] = blocks_hold(ctx, (uint64_t)run + 1);
    for (int run = 0; run < RUNS; run++)
        if (!good[run]) fail_msg("seed %d", run + 1);
    assert_int_equal(pc_memory_used(ctx), 0);
    pc_memory_release(ctx);
    assert_true(blocks_hold(ctx, 99));
}

static void peaks_are_of_what_is_used(void **state) {
    pc_context *ctx = *state;
    char *one = NULL, *two = NULL;
    assert_ok(ctx, pc_new(&one, ctx, 4 << 20));
    assert_ok(ctx, pc_new(&two, ctx, 4 << 20));
    assert_int_equal(pc_memory_peak(ctx), 8 << 20);
    pc_free(ctx, one);
    pc_memory_reset_peak(ctx);
    assert_int_equal(pc_memory_used(ctx), 4 << 20);
    assert_ok(ctx, pc_new(&one, ctx, 4 << 20)); /* the block that was freed, or another */
    assert_int_equal(pc_memory_peak(ctx), 8 << 20);
    pc_free(ctx, one);
    pc_free(ctx, two);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(blocks_hold_what_they_should, make_context, free_context),
        cmocka_unit_test_setup_teardown(peaks_are_of_what_is_used, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
