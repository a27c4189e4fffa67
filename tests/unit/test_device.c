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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(host_needs_no_opencl, make_context, free_context),
        cmocka_unit_test_setup_teardown(every_listed_device_opens, make_context, free_context),
        cmocka_unit_test_setup_teardown(unknown_names_are_refused_with_a_list, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
