/* The store: what goes in comes out, equal calls give equal bytes, and nothing damaged is read. */
#include "memory.h"
#include "random.h"
#include "store.h"
#include "testing.h"
#include <omp.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static char folder[64];

static int enter_folder(void **state) {
    (void)state;
    bool fast = access("/dev/shm", W_OK) == 0; /* flushing many small files to a disk takes long */
    (void)snprintf(folder, sizeof folder, "%s/percale-store-XXXXXX", fast ? "/dev/shm" : "/tmp");
    return mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static int leave_folder(void **state) {
    (void)state;
    char command[128];
    (void)snprintf(command, sizeof command, "rm -r %s", folder);
    return chdir("/") == 0 && system(command) == 0 ? 0 : -1; // NOLINT(cert-env33-c)
}

static const pc_store_options replace = {.force = true};

/* The caller frees the bytes. */
static unsigned char *read_file(size_t *size, const char *path) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    struct stat info;
    assert_int_equal(fstat(fileno(file), &info), 0);
    *size = (size_t)info.st_size;
    unsigned char *bytes = malloc(*size + 1);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, file), *size);
    (void)fclose(file);
    return bytes;
}

static void write_file(const char *path, const unsigned char *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* A file with several arrays and attributes; `rows` large enough makes chunks when compressing. */
static void write_example(pc_context *ctx, const char *path, size_t rows, bool compress) {
    const pc_store_options options = {.force = true, .compress = compress};
    pc_random random = {7};
    double *position;
    pc_index *list;
    pc_store *store;
    size_t dims[2] = {rows, 3};
    assert_ok(ctx, pc_new(&position, ctx, 3 * rows));
    assert_ok(ctx, pc_new(&list, ctx, rows));
    for (size_t i = 0; i < 3 * rows; i++)
        position[i] = pc_random_uniform(&random);
    for (size_t i = 0; i < rows; i++)
        list[i] = (pc_index)(i / 3);
    assert_ok(ctx, pc_store_create(&store, ctx, path, &options));
    assert_ok(ctx, pc_store_put(store, "mesh/position", PC_STORE_F64, 2, dims, position, "model", "where"));
    assert_ok(ctx, pc_store_put(store, "deep/er/list", PC_STORE_U32, 1, dims, list, "1", "what"));
    assert_ok(ctx, pc_store_put(store, "deep/empty", PC_STORE_I8, 1, &(size_t){0}, NULL, "1", "nothing"));
    assert_ok(ctx, pc_store_set_text(store, "/", "options", "{\"n\": \"größer\"}"));
    assert_ok(ctx, pc_store_set_int(store, "mesh", "count", -5));
    assert_ok(ctx, pc_store_set_real(store, "new/group", "length", 2.5));
    assert_ok(ctx, pc_store_set_real(store, "new/group", "length", 3.5));
    assert_ok(ctx, pc_store_commit(&store));
    assert_null(store);
    pc_free(ctx, position);
    pc_free(ctx, list);
}

static void check_example(pc_context *ctx, const char *path, size_t rows) {
    pc_random random = {7};
    pc_store *store;
    double *position, length;
    pc_index *list;
    int8_t *empty;
    char *text;
    int64_t count;
    size_t dims[2] = {PC_STORE_ANY, 3}, any = PC_STORE_ANY;
    assert_ok(ctx, pc_store_open(&store, ctx, path));
    assert_ok(ctx, pc_store_get(&position, store, "mesh/position", PC_STORE_F64, 2, dims));
    assert_int_equal(dims[0], rows);
    for (size_t i = 0; i < 3 * rows; i++)
        assert_true(position[i] == pc_random_uniform(&random));
    assert_ok(ctx, pc_store_get(&list, store, "deep/er/list", PC_STORE_U32, 1, dims));
    for (size_t i = 0; i < rows; i++)
        assert_int_equal(list[i], i / 3);
    assert_ok(ctx, pc_store_get(&empty, store, "deep/empty", PC_STORE_I8, 1, &any));
    assert_int_equal(any, 0);
    assert_ok(ctx, pc_store_get_text(&text, store, "/", "options"));
    assert_string_equal(text, "{\"n\": \"größer\"}");
    assert_ok(ctx, pc_store_get_int(&count, store, "mesh", "count"));
    assert_int_equal(count, -5);
    assert_ok(ctx, pc_store_get_real(&length, store, "new/group", "length"));
    assert_true(length == 3.5);
    pc_free(ctx, position), pc_free(ctx, list), pc_free(ctx, empty), pc_free(ctx, text);
    pc_store_close(store);
}

static void what_goes_in_comes_out(void **state) {
    pc_context *ctx = *state;
    for (int compress = 0; compress < 2; compress++)
        for (size_t rows = 1; rows < 1000000; rows = 9 * rows + 1) {
            write_example(ctx, "example.h5", rows, compress);
            check_example(ctx, "example.h5", rows);
        }
}

static void equal_calls_give_equal_bytes(void **state) {
    pc_context *ctx = *state;
    int threads = omp_get_max_threads();
    for (int compress = 0; compress < 2; compress++) {
        size_t size[2];
        unsigned char *bytes[2];
        for (int k = 0; k < 2; k++) {
            omp_set_num_threads(k == 0 ? 1 : 3);
            write_example(ctx, k ? "two.h5" : "one.h5", 300000, compress);
            bytes[k] = read_file(&size[k], k ? "two.h5" : "one.h5");
            if (k == 0) (void)sleep(1); /* a time in seconds would show */
        }
        assert_int_equal(size[0], size[1]);
        assert_memory_equal(bytes[0], bytes[1], size[0]);
        free(bytes[0]), free(bytes[1]);
    }
    omp_set_num_threads(threads);
}

static void nothing_appears_before_the_commit(void **state) {
    pc_context *ctx = *state;
    pc_store *store;
    const double one = 1;
    assert_ok(ctx, pc_store_create(&store, ctx, "later.h5", NULL));
    assert_ok(ctx, pc_store_put(store, "a", PC_STORE_F64, 1, &(size_t){1}, &one, "1", "one"));
    assert_int_equal(access("later.h5", F_OK), -1);
    pc_store_close(store);
    assert_int_equal(access("later.h5", F_OK), -1);
    assert_int_equal(access("later.h5.partial", F_OK), -1);
    write_example(ctx, "later.h5", 3, false);
    assert_int_equal(pc_store_create(&store, ctx, "later.h5", NULL), PC_E_IO);
    assert_non_null(strstr(pc_context_message(ctx), "there already"));
    check_example(ctx, "later.h5", 3);
}

static void damage_is_refused(void **state) {
    pc_context *ctx = *state;
    size_t size;
    pc_store *store;
    write_example(ctx, "good.h5", 50, false);
    unsigned char *bytes = read_file(&size, "good.h5");
    for (size_t i = 0; i < size; i += 1 + i % 7) { /* one flipped bit anywhere */
        bytes[i] ^= (unsigned char)(1 << i % 8);
        write_file("bad.h5", bytes, size);
        bytes[i] ^= (unsigned char)(1 << i % 8);
        pc_context_clear_message(ctx);
        assert_int_equal(pc_store_open(&store, ctx, "bad.h5"), PC_E_FORMAT);
        assert_non_null(strstr(pc_context_message(ctx), "bad.h5"));
    }
    for (size_t length = 0; length < size; length += 1 + length / 9) { /* cut off */
        write_file("bad.h5", bytes, length);
        assert_int_equal(pc_store_open(&store, ctx, "bad.h5"), PC_E_FORMAT);
    }
    free(bytes);
    assert_int_equal(pc_store_open(&store, ctx, "/dev/null"), PC_E_FORMAT);
    assert_int_equal(pc_store_open(&store, ctx, "."), PC_E_FORMAT);
    assert_int_equal(pc_store_open(&store, ctx, "no such file"), PC_E_IO);
}

static void wrong_demands_are_refused(void **state) {
    pc_context *ctx = *state;
    static const struct {
        const char *name;
        pc_store_type type;
        int rank;
        size_t dims[2];
        const char *message;
    } cases[] = {
        {"mesh/positions", PC_STORE_F64, 2, {50, 3}, "'mesh/positions': missing"},
        {"none/position", PC_STORE_F64, 2, {50, 3}, "missing"},
        {"mesh", PC_STORE_F64, 2, {50, 3}, "not a dataset"},
        {"mesh/position", PC_STORE_F32, 2, {50, 3}, "element type"},
        {"mesh/position", PC_STORE_F64, 1, {50, 3}, "rank"},
        {"mesh/position", PC_STORE_F64, 2, {49, 3}, "size 50 in direction 0, expected 49"},
        {"mesh/position", PC_STORE_F64, 2, {50, 4}, "size 3 in direction 1, expected 4"},
    };
    pc_store *store;
    double *data;
    int64_t number;
    char *text;
    write_example(ctx, "good.h5", 50, false);
    assert_ok(ctx, pc_store_open(&store, ctx, "good.h5"));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        size_t dims[2] = {cases[i].dims[0], cases[i].dims[1]};
        pc_context_clear_message(ctx);
        assert_int_equal(pc_store_get(&data, store, cases[i].name, cases[i].type, cases[i].rank, dims),
                         PC_E_FORMAT);
        assert_null(data);
        if (!strstr(pc_context_message(ctx), cases[i].message)) fail_msg("%s", pc_context_message(ctx));
        assert_non_null(strstr(pc_context_message(ctx), "good.h5"));
    }
    assert_int_equal(pc_store_get_int(&number, store, "/", "options"), PC_E_FORMAT);
    assert_int_equal(pc_store_get_text(&text, store, "mesh", "count"), PC_E_FORMAT);
    assert_int_equal(pc_store_get_text(&text, store, "mesh", "no"), PC_E_FORMAT);
    assert_int_equal(pc_store_get_text(&text, store, "no", "no"), PC_E_FORMAT);
    pc_store_close(store);
}

/* A full disk: the file may not grow past a limit. */
static void a_failed_write_leaves_nothing(void **state) {
    pc_context *ctx = *state;
    struct rlimit old, small;
    static double data[200000];
    write_example(ctx, "kept.h5", 10, false);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    (void)signal(SIGXFSZ, SIG_IGN);
    for (rlim_t limit = 0; limit < 1600000; limit = 3 * limit + 100) {
        pc_store *store = NULL;
        small = old;
        small.rlim_cur = limit;
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        pc_context_clear_message(ctx);
        pc_status status = pc_store_create(&store, ctx, "kept.h5", &replace);
        if (status == PC_OK)
            status = pc_store_put(store, "a", PC_STORE_F64, 1, &(size_t){200000}, data, "1", "large");
        if (status == PC_OK)
            status = pc_store_commit(&store);
        else
            pc_store_close(store);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
        assert_int_equal(status, PC_E_IO);
        assert_non_null(strstr(pc_context_message(ctx), "kept.h5"));
        assert_int_equal(access("kept.h5.partial", F_OK), -1);
        check_example(ctx, "kept.h5", 10);
    }
    (void)signal(SIGXFSZ, SIG_DFL);
}

/* Whichever allocation fails, nothing is left behind and the old file stays. */
static void missing_memory_leaves_nothing(void **state) {
    pc_context *ctx = *state;
    static double data[20000];
    const pc_store_options options = {.force = true, .compress = true};
    write_example(ctx, "kept.h5", 10, false);
    pc_status status = PC_E_NOMEM;
    int refused = 0;
    for (size_t n = 1; status == PC_E_NOMEM; n++) {
        pc_store *store = NULL;
        pc_memory_fail_at(ctx, n);
        status = pc_store_create(&store, ctx, "kept.h5", &options);
        if (status == PC_OK)
            status = pc_store_put(store, "a", PC_STORE_F64, 1, &(size_t){20000}, data, "1", "large");
        if (status == PC_OK)
            status = pc_store_commit(&store);
        else
            pc_store_close(store);
        if (status == PC_OK) break;
        refused++;
        pc_memory_fail_at(ctx, 0);
        assert_int_equal(status, PC_E_NOMEM);
        assert_int_equal(pc_memory_used(ctx), 0);
        assert_int_equal(access("kept.h5.partial", F_OK), -1);
        check_example(ctx, "kept.h5", 10);
    }
    pc_memory_fail_at(ctx, 0);
    assert_true(refused >= 5);
}

/* A process that is killed while it writes leaves the old file or the new one. */
static void a_killed_writer_leaves_a_whole_file(void **state) {
    pc_context *ctx = *state;
    write_example(ctx, "kept.h5", 1000, false);
    for (int round = 0; round < 12; round++) {
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            for (size_t i = 0; i < 1000000; i++)
                write_example(ctx, "kept.h5", 1000 + 911 * i % 1001, false);
            _exit(1);
        }
        struct timespec pause = {.tv_nsec = 1700000 * (round + 1)};
        (void)nanosleep(&pause, NULL);
        assert_int_equal(kill(child, SIGKILL), 0);
        assert_int_equal(waitpid(child, NULL, 0), child);
        pc_store *store;
        size_t dims[2] = {PC_STORE_ANY, 3};
        double *position;
        assert_ok(ctx, pc_store_open(&store, ctx, "kept.h5"));
        assert_ok(ctx, pc_store_get(&position, store, "mesh/position", PC_STORE_F64, 2, dims));
        pc_free(ctx, position);
        pc_store_close(store);
        check_example(ctx, "kept.h5", dims[0]);
    }
    write_example(ctx, "kept.h5", 5, false); /* over a partial file that was left */
    assert_int_equal(access("kept.h5.partial", F_OK), -1);
    check_example(ctx, "kept.h5", 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_goes_in_comes_out, make_context, free_context),
        cmocka_unit_test_setup_teardown(equal_calls_give_equal_bytes, make_context, free_context),
        cmocka_unit_test_setup_teardown(nothing_appears_before_the_commit, make_context, free_context),
        cmocka_unit_test_setup_teardown(damage_is_refused, make_context, free_context),
        cmocka_unit_test_setup_teardown(wrong_demands_are_refused, make_context, free_context),
        cmocka_unit_test_setup_teardown(a_failed_write_leaves_nothing, make_context, free_context),
        cmocka_unit_test_setup_teardown(missing_memory_leaves_nothing, make_context, free_context),
        cmocka_unit_test_setup_teardown(a_killed_writer_leaves_a_whole_file, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
