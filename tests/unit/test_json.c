/* The writer's bytes, read back by eye and by rule. */
#include "json.h"
#include "testing.h"
#include <math.h>

static void members_keep_their_order(void **state) {
    pc_json json;
    pc_json_start(&json, *state, false);
    pc_json_object(&json, NULL);
    pc_json_string(&json, "name", "a\"b\\c\n");
    pc_json_flat_array(&json, "list");
    pc_json_integer(&json, NULL, -3);
    pc_json_number(&json, NULL, 0.1);
    pc_json_number(&json, NULL, NAN);
    pc_json_close(&json);
    pc_json_object(&json, "empty");
    pc_json_close(&json);
    pc_json_flat_object(&json, "flat");
    pc_json_boolean(&json, "yes", true);
    pc_json_string(&json, "none", NULL);
    pc_json_close(&json);
    pc_json_close(&json);
    assert_ok(*state, pc_json_end(&json));
    assert_string_equal(json.text, "{\n  \"name\": \"a\\\"b\\\\c\\u000a\",\n  \"list\": [-3, 0.1, null],\n"
                                   "  \"empty\": {},\n  \"flat\": {\"yes\": true, \"none\": null}\n}\n");
    pc_json_free(&json);
}

static void compact_form_has_no_space(void **state) {
    pc_json json;
    pc_json_start(&json, *state, true);
    pc_json_object(&json, NULL);
    pc_json_exact(&json, "x", 0.1);
    pc_json_array(&json, "a");
    pc_json_integer(&json, NULL, 1);
    pc_json_integer(&json, NULL, 2);
    pc_json_close(&json);
    pc_json_close(&json);
    assert_ok(*state, pc_json_end(&json));
    assert_string_equal(json.text, "{\"x\":0.10000000000000001,\"a\":[1,2]}");
    pc_json_free(&json);
}

static void broken_utf8_becomes_a_replacement(void **state) {
    const char *broken[] = {"\xff", "\xc0\xaf", "\xed\xa0\x80", "\xf5\x80\x80\x80", "\xe2\x82"};
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        pc_json json;
        pc_json_start(&json, *state, true);
        pc_json_string(&json, NULL, broken[i]);
        assert_ok(*state, pc_json_end(&json));
        assert_non_null(strstr(json.text, "\xef\xbf\xbd"));
        pc_json_free(&json);
    }
    pc_json json;
    pc_json_start(&json, *state, true);
    pc_json_string(&json, NULL, "\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80");
    assert_ok(*state, pc_json_end(&json));
    assert_string_equal(json.text, "\"\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80\"");
    pc_json_free(&json);
}

static void errors_are_kept(void **state) {
    pc_json json;
    pc_json_start(&json, *state, false);
    pc_json_object(&json, NULL);
    assert_int_equal(pc_json_end(&json), PC_E_BUG);
    pc_json_free(&json);
    pc_context_clear_message(*state);
    pc_memory_fail_at(*state, 1);
    pc_json_start(&json, *state, false);
    pc_json_object(&json, NULL);
    pc_json_close(&json);
    assert_int_equal(pc_json_end(&json), PC_E_NOMEM);
    pc_json_free(&json);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(members_keep_their_order, make_context, free_context),
        cmocka_unit_test_setup_teardown(compact_form_has_no_space, make_context, free_context),
        cmocka_unit_test_setup_teardown(broken_utf8_becomes_a_replacement, make_context, free_context),
        cmocka_unit_test_setup_teardown(errors_are_kept, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
