/* Devices are found, chosen by name, and refused in words. */
#include "device.h"
#include "memory.h"
#include "testing.h"

static void host_needs_no_opencl(void **state) {
    pc_device *device = NULL;
    const pc_kernel_stats *table;
    size_t count = 7;
    assert_ok(*state, pc_device_open(&device, *state, "host"));
    assert_true(pc_device_is_host(device));
    assert_string_equal(pc_device_name(device), "host");
    assert_ok(*state, pc_device_require_doubles(device, *state, "a test"));
    assert_ok(*state, pc_device_kernel_stats(&table, &count, *state, device));
    assert_int_equal(count, 0);
    pc_device_close(device, *state);
    pc_device_close(NULL, *state);
}

static void every_listed_device_opens(void **state) {
    pc_device_info *infos = NULL;
    size_t count = 0;
    assert_ok(*state, pc_device_list(&infos, &count, *state));
    for (size_t i = 0; i < count; i++) {
        char place[32];
        pc_device *device = NULL;
        (void)snprintf(place, sizeof place, "%d:%d", infos[i].platform, infos[i].device);
        assert_ok(*state, pc_device_open(&device, *state, place));
        assert_false(pc_device_is_host(device));
        assert_string_equal(pc_device_name(device), infos[i].name);
        assert_true(pc_device_allocation_cap(device) > 0);
        pc_device_close(device, *state);
        assert_ok(*state, pc_device_open(&device, *state, infos[i].name + strlen(infos[i].name) / 2));
        pc_device_close(device, *state);
    }
    if (count > 0) {
        pc_device *device = NULL;
        assert_ok(*state, pc_device_open(&device, *state, NULL));
        pc_device_close(device, *state);
    }
    pc_free(*state, infos);
}

static void unknown_names_are_refused_with_a_list(void **state) {
    static const char *const names[] = {"no such device", "97:3", "0:99", "1:x"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        pc_device *device = NULL;
        assert_int_equal(pc_device_open(&device, *state, names[i]), PC_E_DEVICE);
        assert_null(device);
        assert_non_null(strstr(pc_context_message(*state), names[i]));
        assert_non_null(strstr(pc_context_message(*state), "host"));
        pc_context_clear_message(*state);
    }
}

/* Of the first device there is: N entries of a list, or N sub-devices. */
static void members_open_with_their_device(void **state) {
    pc_context *ctx = *state;
    pc_device_info *infos = NULL;
    pc_device *device = NULL;
    size_t count = 0;
    char wanted[64];
    assert_ok(ctx, pc_device_list(&infos, &count, ctx));
    if (count == 0) {
        pc_free(ctx, infos);
        skip();
    }
    const pc_device_info first = infos[0];
    pc_free(ctx, infos);
    (void)snprintf(wanted, sizeof wanted, "%d:%d,%d:%d,%d:%d", first.platform, first.device, first.platform,
                   first.device, first.platform, first.device);
    assert_ok(ctx, pc_device_open(&device, ctx, wanted));
    assert_int_equal(pc_device_member_count(device), 3);
    assert_ptr_equal(pc_device_member(device, 0), device);
    assert_ptr_not_equal(pc_device_member(device, 1), pc_device_member(device, 2));
    pc_device_set_allocation_cap(device, 1000);
    assert_int_equal(pc_device_allocation_cap(pc_device_member(device, 2)), 1000);
    pc_device_close(device, ctx);
    (void)snprintf(wanted, sizeof wanted, "%d:%d/1", first.platform, first.device);
    assert_ok(ctx, pc_device_open(&device, ctx, wanted));
    assert_int_equal(pc_device_member_count(device), 1);
    pc_device_close(device, ctx);
    if (first.cpu && first.units >= 2 && first.units <= 32) {
        const int members = first.units > PC_MOST_MEMBERS ? PC_MOST_MEMBERS : (int)first.units;
        unsigned units = 0;
        (void)snprintf(wanted, sizeof wanted, "%d:%d/%d", first.platform, first.device, members);
        assert_ok(ctx, pc_device_open(&device, ctx, wanted));
        assert_int_equal(pc_device_member_count(device), members);
        for (int k = 0; k < members; k++) {
            assert_ptr_not_equal(pc_device_member(device, k), device);
            units += pc_device_describe(pc_device_member(device, k))->units;
        }
        assert_int_equal(units, pc_device_describe(device)->units);
        pc_device_close(device, ctx);
    }
}

/* Each names what is wrong. */
static void impossible_members_are_refused(void **state) {
    static const struct {
        const char *wanted, *said;
    } cases[] = {
        {"host/2", "has no sub-devices"},
        {"host,host", "no OpenCL device"},
        {"no such/2", "no such"},
        {"97:3,97:4", "97:3"},
        {"default/17", "at most 16"},
        {"default/0", "default/0"},
        {"default/2x", "default/2x"},
        {"default/-2", "default/-2"},
        {",", "','"},
        {"/2", "/2"},
        {"default/99999999999", "at most 16"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        pc_device *device = NULL;
        assert_int_equal(pc_device_open(&device, *state, cases[i].wanted), PC_E_DEVICE);
        assert_null(device);
        if (!strstr(pc_context_message(*state), cases[i].said))
            fail_msg("'%s': %s", cases[i].wanted, pc_context_message(*state));
        pc_context_clear_message(*state);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(host_needs_no_opencl, make_context, free_context),
        cmocka_unit_test_setup_teardown(every_listed_device_opens, make_context, free_context),
        cmocka_unit_test_setup_teardown(unknown_names_are_refused_with_a_list, make_context, free_context),
        cmocka_unit_test_setup_teardown(members_open_with_their_device, make_context, free_context),
        cmocka_unit_test_setup_teardown(impossible_members_are_refused, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
