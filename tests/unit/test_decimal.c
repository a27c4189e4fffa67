/* Decimals are read to the nearest double and written so that they come back, whatever the locale. */
#include "decimal.h"
#include "random.h"
#include "testing.h"
#include <locale.h>
#include <math.h>
#include <stdlib.h>

static double read_all(const char *text) {
    double value = NAN;
    const char *at = text;
    const char *end = text + strlen(text);
    assert_int_equal(pc_decimal_read(&value, &at, end), PC_DECIMAL_OK);
    assert_ptr_equal(at, end);
    return value;
}

static uint64_t bits_of(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static void same_as_strtod(const char *text) {
    if (bits_of(read_all(text)) != bits_of(strtod(text, NULL)))
        fail_msg("%s was read as %.17g, not %.17g", text, read_all(text), strtod(text, NULL));
}

static void known_hard_numbers(void **state) {
    (void)state;
    static const char *const texts[] = {"0",
                                        "-0",
                                        "+1",
                                        ".5",
                                        "5.",
                                        "-.25e1",
                                        "1e22",
                                        "1e23",
                                        "9007199254740993",
                                        "9007199254740992.5",
                                        "9007199254740993.00000000000000000000000000000000000000000001",
                                        "2.2250738585072011e-308",
                                        "2.2250738585072014e-308",
                                        "4.9e-324",
                                        "2.4703282292062327e-324",
                                        "2.4703282292062328e-324",
                                        "1.7976931348623157e308",
                                        "123456789012345678901234567890",
                                        "0.000000000000000000000000000001234567890123456789",
                                        "1E5",
                                        "1e+05",
                                        "00001.5",
                                        "179769313486231570000e288",
                                        "8.98846567431158e307",
                                        "0.1e-400",
                                        "1e-5000",
                                        "7.2057594037927933e16",
                                        "18446744073709551615",
                                        "1844674407370955161.5",
                                        "9999999999999999999e-19",
                                        "0.9999999999999999444888487687421729788184165954589843750",
                                        "0.99999999999999994448884876874217297881841659546",
                                        "0.500000000000000166533453693773481063544750213623046875"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        same_as_strtod(texts[i]);
}

/* Random digits, with lengths and exponents around every border between the quick ways and the slow one. */
static void random_decimals_are_read_as_strtod_does(void **state) {
    (void)state;
    pc_random random = {42};
    for (int round = 0; round < 100000; round++) {
        char text[64];
        size_t n = 0;
        uint64_t dice = pc_random_next(&random);
        int digits = 1 + (int)(dice % 22);
        int point = (int)((dice >> 8) % 24);
        for (int i = 0; i < digits; i++) {
            if (i == point) text[n++] = '.';
            text[n++] = (char)('0' + pc_random_next(&random) % 10);
        }
        text[n] = '\0';
        int exponent = (int)((dice >> 16) % 61) - 30;
        if (dice >> 32 & 1) (void)snprintf(text + n, sizeof text - n, "e%d", exponent);
        same_as_strtod(text);
    }
}

/* Decimals half-way between two doubles, and a touch beside it. */
static void halfway_cases_round_to_even(void **state) {
    (void)state;
    pc_random random = {43};
    for (int round = 0; round < 20000; round++) {
        char text[96];
        uint64_t odd = ((uint64_t)1 << 53) + 1 + 2 * (pc_random_next(&random) >> 12);
        int down = (int)(pc_random_next(&random) % 12);
        long double half = ldexpl((long double)odd, -down);
        (void)snprintf(text, sizeof text, "%.*Lf", down, half);
        same_as_strtod(text);
        size_t n = strlen(text);
        (void)snprintf(text + n, sizeof text - n, down ? "1" : ".00001");
        same_as_strtod(text);
    }
}

static void long_digit_strings(void **state) {
    (void)state;
    char text[3000] = "0.";
    memset(text + 2, '0', 300);
    memset(text + 302, '7', 1500);
    same_as_strtod(text);
    memset(text, '9', 2000);
    memcpy(text + 2000, "e-1999", 7);
    same_as_strtod(text);
    /* half-way but for the last of a thousand digits */
    memcpy(text, "9007199254740993.", 18);
    memset(text + 17, '0', 1000);
    memcpy(text + 1017, "1", 2);
    assert_true(read_all(text) == 9007199254740994.0);
    same_as_strtod(text);
}

static void what_is_no_number(void **state) {
    (void)state;
    static const char *const none[] = {"", "-", ".", "e5", "x", "+-1", "--1", "#", "/", "n", "i", "-in"};
    static const char *const endless[] = {"nan",   "NaN",          "-nan",    "inf",     "-INF",
                                          "1e400", "-1e999999999", "1.#QNAN", "nan(ind)"};
    double value;
    for (size_t i = 0; i < sizeof none / sizeof *none; i++) {
        const char *at = none[i];
        assert_int_equal(pc_decimal_read(&value, &at, none[i] + strlen(none[i])), PC_DECIMAL_NONE);
        assert_ptr_equal(at, none[i]);
    }
    for (size_t i = 0; i < sizeof endless / sizeof *endless; i++) {
        const char *at = endless[i];
        assert_int_equal(pc_decimal_read(&value, &at, endless[i] + strlen(endless[i])),
                         PC_DECIMAL_NOT_FINITE);
    }
    const char *text = "1e";
    const char *at = text;
    assert_int_equal(pc_decimal_read(&value, &at, text + 2), PC_DECIMAL_OK);
    assert_ptr_equal(at, text + 1);
}

static void integers(void **state) {
    (void)state;
    int64_t value;
    const char *text = "-12/";
    const char *at = text;
    assert_true(pc_decimal_read_integer(&value, &at, text + 4));
    assert_int_equal(value, -12);
    assert_ptr_equal(at, text + 3);
    text = at = "99999999999999999999999999";
    assert_true(pc_decimal_read_integer(&value, &at, text + 26));
    assert_true(value == (int64_t)1 << 62);
    text = at = "+";
    assert_false(pc_decimal_read_integer(&value, &at, text + 1));
    assert_ptr_equal(at, text);
}

static int digit_count(const char *text) {
    int count = 0;
    int zeros = 0;
    for (; *text && *text != 'e'; text++) {
        if (*text < '0' || *text > '9' || (*text == '0' && count == 0)) continue;
        zeros = *text == '0' ? zeros + 1 : 0;
        count++;
    }
    return count - zeros;
}

static void check_written(double value) {
    char text[PC_DECIMAL_SPACE];
    size_t n = pc_decimal_write(text, value);
    assert_int_equal(n, strlen(text));
    assert_true(n < PC_DECIMAL_SPACE);
    if (bits_of(strtod(text, NULL)) != bits_of(value)) fail_msg("%.17g was written as %s", value, text);
    for (int precision = 1; precision < 17; precision++) {
        char shorter[40];
        (void)snprintf(shorter, sizeof shorter, "%.*e", precision - 1, value);
        if (strtod(shorter, NULL) != value) continue;
        if (digit_count(text) > precision) fail_msg("%s could be %s", text, shorter);
        break;
    }
}

static void written_numbers_come_back_and_are_short(void **state) {
    (void)state;
    static const double values[] = {0.0,
                                    -0.0,
                                    1,
                                    -1,
                                    0.1,
                                    1.0 / 3,
                                    5e-324,
                                    2.2250738585072014e-308,
                                    1.7976931348623157e308,
                                    1e15,
                                    1e16,
                                    1e17,
                                    123456789012345680,
                                    9007199254740993.0,
                                    99999999999999.99,
                                    999999999999999.9,
                                    9.9999999999999999e13,
                                    1e-5,
                                    9.999999999999999e-6,
                                    1e14,
                                    0.5,
                                    1024,
                                    4503599627370496.5,
                                    100,
                                    123.456,
                                    0.00012,
                                    3.0000000000000004,
                                    1.0000000000000002};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++)
        check_written(values[i]);
    pc_random random = {44};
    for (int round = 0; round < 5000; round++) {
        uint64_t bits = pc_random_next(&random);
        double value;
        memcpy(&value, &bits, sizeof value);
        if (isfinite(value)) check_written(value);
        double usual = (pc_random_uniform(&random) - 0.5) * pow(10, (double)(bits % 22) - 6);
        check_written(usual);
        check_written((double)(float)usual);
        check_written(ldexp(1, (int)(bits % 60) - 20));
    }
    char text[PC_DECIMAL_SPACE];
    (void)pc_decimal_write(text, 1e21);
    assert_string_equal(text, "1e21");
    (void)pc_decimal_write(text, -12.5);
    assert_string_equal(text, "-12.5");
    (void)pc_decimal_write(text, 0.001);
    assert_string_equal(text, "0.001");
    (void)pc_decimal_write(text, 1500);
    assert_string_equal(text, "1500");
}

/* Where such a locale is there, its comma must not matter. */
static void locale_does_not_matter(void **state) {
    (void)state;
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "ru_RU.UTF-8"};
    char text[PC_DECIMAL_SPACE];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (setlocale(LC_ALL, names[i])) break;
    assert_true(read_all("1.5e-300") == 3 * 0.5e-300);
    (void)pc_decimal_write(text, 1.5e-300);
    assert_string_equal(text, "1.5e-300");
    (void)setlocale(LC_ALL, "C");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_hard_numbers),
        cmocka_unit_test(random_decimals_are_read_as_strtod_does),
        cmocka_unit_test(halfway_cases_round_to_even),
        cmocka_unit_test(long_digit_strings),
        cmocka_unit_test(what_is_no_number),
        cmocka_unit_test(integers),
        cmocka_unit_test(written_numbers_come_back_and_are_short),
        cmocka_unit_test(locale_does_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
