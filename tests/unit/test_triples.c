/* Lists of three numbers per line: what is read, and what is refused with its line. */
#include "testing.h"
#include "triples.h"
#include <unistd.h>

static char path[64];

static int enter(void **state) {
    (void)state;
    (void)snprintf(path, sizeof path, "/tmp/percale-triples-%ld.txt", (long)getpid());
    return 0;
}

static int leave(void **state) {
    (void)state;
    return unlink(path);
}

static pc_status read_text(pc_triples *triples, pc_context *ctx, const char *text) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
    pc_context_clear_message(ctx);
    return pc_triples_read(triples, ctx, path, "x y z");
}

static void rows_are_read(void **state) {
    static const char *const same[] = {
        "1 2 3\n4.5 -6e-1 7",         "1,2,3\r\n\r\n4.5 , -6e-1,7\r\n",
        "x,y,z\n1\t2  3\n4.5 -.6 7#", "# 9 9 9\n\n 1 2 3 # end\n\n4.5\t-0.6,7\n\n",
        "a b c\r1 2 3\r4.5 -0.6 7\r",
    };
    static const size_t line[][2] = {{1, 2}, {1, 3}, {2, 3}, {3, 5}, {2, 3}};
    pc_context *ctx = *state;
    for (size_t i = 0; i < sizeof same / sizeof *same; i++) {
        pc_triples t;
        assert_ok(ctx, read_text(&t, ctx, same[i]));
        const double expected[6] = {1, 2, 3, 4.5, -0.6, 7};
        assert_int_equal(t.count, 2);
        assert_memory_equal(t.value, expected, sizeof expected);
        assert_memory_equal(t.line, line[i], sizeof line[i]);
        pc_triples_free(&t, ctx);
    }
}

static void nothing_is_no_rows(void **state) {
    static const char *const empty[] = {"", "\n\n", "# 1 2 3", "x y z", "x y z\n", " \t"};
    pc_context *ctx = *state;
    for (size_t i = 0; i < sizeof empty / sizeof *empty; i++) {
        pc_triples t;
        assert_ok(ctx, read_text(&t, ctx, empty[i]));
        assert_int_equal(t.count, 0);
        pc_triples_free(&t, ctx);
    }
}

static void many_rows_are_read(void **state) {
    pc_context *ctx = *state;
    enum { ROWS = 5000 };
    static char text[20 * ROWS];
    size_t used = 0;
    pc_triples t;
    for (int i = 0; i < ROWS; i++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%d %d 0.5\n", i, 2 * i);
    assert_ok(ctx, read_text(&t, ctx, text));
    assert_int_equal(t.count, ROWS);
    for (int i = 0; i < ROWS; i++) {
        const double *v = t.value + 3 * (size_t)i;
        assert_true(v[0] == i && v[1] == 2 * i && v[2] == 0.5 && t.line[i] == (size_t)i + 1);
    }
    pc_triples_free(&t, ctx);
}

static void wrong_lines_are_named(void **state) {
    static const char *const wrong[][2] = {
        {"1 2\n3 4 5\n", ":1: the line ends before"},
        {"1 2 3\n\n4 5 6 7\n", ":3: expected 'x y z', found '7'"},
        {"1 2 3\nx y z\n", ":2: expected 'x y z', found 'x'"},
        {"1 2 3x\n", ":1: expected 'x y z', found '3x'"},
        {"1 nan 3\n", "found 'nan'"},
        {"1 2 1e999\n", "found '1e999'"},
        {"1,,2,3\n", "found ',2,3'"},
        {"1 2,", "the line ends before"},
        {"1;2;3\n", "found '1;2;3'"},
        {"1 2 3,4", "found ',4'"},
        {"x y z\n1 2", ":2: the line ends before"},
        {"1 2 # 3", "the line ends before"},
        {"\x80\xff 1 2", "found '?"},
    };
    pc_context *ctx = *state;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        pc_triples t;
        pc_status status = read_text(&t, ctx, wrong[i][0]);
        const char *message = pc_context_message(ctx);
        if (status != PC_E_FORMAT || !strstr(message, wrong[i][1]) ||
            strncmp(message, path, strlen(path)) != 0)
            fail_msg("'%s': %s (%s)", wrong[i][0], pc_status_name(status), message);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(rows_are_read, make_context, free_context),
        cmocka_unit_test_setup_teardown(nothing_is_no_rows, make_context, free_context),
        cmocka_unit_test_setup_teardown(many_rows_are_read, make_context, free_context),
        cmocka_unit_test_setup_teardown(wrong_lines_are_named, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, enter, leave);
}
