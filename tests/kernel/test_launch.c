/* Buffers, launches, their statistics, the program cache and its faults. */
#include "launch.h"
#include "memory.h"
#include "testing.h"
#include <dirent.h>
#include <stdlib.h>
#include <unistd.h>

static const char doubling[] = "kernel void twice(global float *x, const uint n) {\n"
                               "    const uint i = get_global_id(0);\n"
                               "    if (i < n) x[i] *= 2;\n"
                               "}\n";
static const char broken[] = "kernel void twice(global float *x) { x[0] = no_such_thing; }\n";

static char folder[] = "/tmp/percale_cache_XXXXXX";

static pc_device *open_device(pc_context *ctx) {
    pc_device *device = NULL;
    if (pc_device_open(&device, ctx, NULL) != PC_OK) {
        pc_context_clear_message(ctx);
        skip();
    }
    return device;
}

/* Doubles 1000 numbers on a fresh device. */
static void run_doubling(pc_context *ctx) {
    enum { N = 1000 };
    float x[N];
    pc_buffer *buffer = NULL;
    pc_kernel *kernel = NULL;
    const pc_kernel_stats *table;
    size_t count;
    pc_device *device = open_device(ctx);
    for (int i = 0; i < N; i++)
        x[i] = (float)i;
    assert_ok(ctx, pc_kernel_get(&kernel, ctx, device, doubling, "twice"));
    assert_ok(ctx, pc_buffer_from(&buffer, ctx, device, x, sizeof x));
    for (int k = 0; k < 3; k++)
        assert_ok(ctx, pc_kernel_run(ctx, kernel, N, 0, 2.0 * sizeof x, PC_ARGS(PC_BUF(buffer), PC_U32(N))));
    assert_ok(ctx, pc_buffer_read(x, ctx, buffer, 0, sizeof x));
    for (int i = 0; i < N; i++)
        assert_true(x[i] == 8 * (float)i);
    assert_ok(ctx, pc_device_kernel_stats(&table, &count, ctx, device));
    assert_int_equal(count, 1);
    assert_string_equal(table[0].name, "twice");
    assert_int_equal(table[0].count, 3);
    assert_true(table[0].bytes == 3 * 2.0 * sizeof x);
    assert_true(table[0].seconds > 0 && table[0].seconds < 10);
    pc_device_reset_stats(device);
    assert_ok(ctx, pc_device_kernel_stats(&table, &count, ctx, device));
    assert_int_equal(count, 0);
    pc_buffer_free(buffer, ctx);
    pc_device_close(device, ctx);
}

/* The only file in the cache folder; "" where there is none. */
static void cache_file(char *path, size_t size) {
    char below[200];
    (void)snprintf(below, sizeof below, "%s/percale", folder);
    path[0] = '\0';
    DIR *dir = opendir(below);
    if (!dir) return;
    for (struct dirent *entry = readdir(dir); entry; entry = readdir(dir)) {
        if (entry->d_name[0] == '.') continue;
        assert_string_equal(path, "");
        (void)snprintf(path, size, "%s/%s", below, entry->d_name);
    }
    (void)closedir(dir);
}

static void binaries_are_cached_and_mistrusted(void **state) {
    char path[512];
    assert_int_equal(setenv("XDG_CACHE_HOME", folder, 1), 0);
    run_doubling(*state);
    cache_file(path, sizeof path);
    assert_string_not_equal(path, "");
    run_doubling(*state);
    /* Cut short, emptied, a bit turned over, or another file altogether: the source is built again. */
    for (int fault = 0; fault < 4; fault++) {
        FILE *file = fopen(path, fault == 3 ? "wb" : "r+b");
        assert_non_null(file);
        if (fault == 0) assert_int_equal(ftruncate(fileno(file), 60), 0);
        if (fault == 1) assert_int_equal(ftruncate(fileno(file), 0), 0);
        if (fault == 2) {
            assert_int_equal(fseek(file, 200, SEEK_SET), 0);
            int byte = fgetc(file);
            assert_int_equal(fseek(file, 200, SEEK_SET), 0);
            assert_int_equal(fputc(byte ^ 4, file), byte ^ 4);
        }
        if (fault == 3) assert_true(fputs("not a program at all", file) >= 0);
        assert_int_equal(fclose(file), 0);
        run_doubling(*state);
    }
    assert_int_equal(unlink(path), 0);
}

static void no_home_is_fine(void **state) {
    assert_int_equal(setenv("XDG_CACHE_HOME", "/proc/no/such/place", 1), 0);
    run_doubling(*state);
    assert_int_equal(unsetenv("XDG_CACHE_HOME"), 0);
    char *home = getenv("HOME");
    char kept[512] = "";
    if (home) (void)snprintf(kept, sizeof kept, "%s", home);
    assert_int_equal(unsetenv("HOME"), 0);
    run_doubling(*state);
    if (kept[0]) assert_int_equal(setenv("HOME", kept, 1), 0);
}

static void errors_come_in_words(void **state) {
    pc_context *ctx = *state;
    pc_device *device = open_device(ctx);
    pc_kernel *kernel = NULL;
    pc_buffer *buffer = NULL;
    assert_int_equal(pc_kernel_get(&kernel, ctx, device, broken, "twice"), PC_E_DEVICE);
    assert_non_null(strstr(pc_context_message(ctx), "no_such_thing"));
    pc_context_clear_message(ctx);
    assert_int_equal(pc_kernel_get(&kernel, ctx, device, doubling, "thrice"), PC_E_DEVICE);
    assert_non_null(strstr(pc_context_message(ctx), "thrice"));
    pc_context_clear_message(ctx);
    pc_device_set_allocation_cap(device, 1000);
    assert_int_equal(pc_buffer_make(&buffer, ctx, device, 1001), PC_E_DEVICE);
    assert_non_null(strstr(pc_context_message(ctx), "1001"));
    pc_context_clear_message(ctx);
    assert_ok(ctx, pc_buffer_make(&buffer, ctx, device, 0));
    pc_buffer_free(buffer, ctx);
    pc_buffer_free(NULL, ctx);
    pc_device_close(device, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(binaries_are_cached_and_mistrusted, make_context, free_context),
        cmocka_unit_test_setup_teardown(no_home_is_fine, make_context, free_context),
        cmocka_unit_test_setup_teardown(errors_come_in_words, make_context, free_context),
    };
    if (!mkdtemp(folder)) return 1;
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    char below[200];
    (void)snprintf(below, sizeof below, "%s/percale", folder);
    (void)rmdir(below);
    (void)rmdir(folder);
    return failed;
}
