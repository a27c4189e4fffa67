#include "decimal.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double exact_power[23] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                       1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static const uint64_t integer_power[20] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,
                                           1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19};

typedef unsigned __int128 wide;

static bool is_digit(char c) {
    return (unsigned)(c - '0') < 10;
}

/* More digits than any double needs to be told from its neighbours (767); what follows counts as one more
 * digit. */
enum { KEPT_DIGITS = 800, EXPONENT_LIMIT = 1000000 };

/* The digits as an integer with an exponent: strtod then meets no decimal point, which is a matter of locale.
 */
static double read_slowly(const char *at, const char *end, int exponent) {
    char text[KEPT_DIGITS + 32];
    size_t n = 0;
    bool fraction = false;
    bool more = false;
    for (; at < end && (is_digit(*at) || *at == '.'); at++) {
        if (*at == '.') {
            fraction = true;
            continue;
        }
        if (n == KEPT_DIGITS) {
            more |= *at != '0';
            exponent += !fraction && exponent < 2 * EXPONENT_LIMIT;
            continue;
        }
        exponent -= fraction && exponent > -2 * EXPONENT_LIMIT;
        if (n > 0 || *at != '0') text[n++] = *at;
    }
    if (n == 0) return 0;
    if (more) {
        text[n++] = '1';
        exponent--;
    }
    (void)snprintf(text + n, sizeof text - n, "e%d", exponent);
    return strtod(text, NULL);
}

static double power_of_two(int exponent) {
    uint64_t bits = (uint64_t)(1023 + exponent) << 52;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* mantissa / 10^places, exactly divided to 63 bits and rounded once: for numbers of 17 digits, which do not
 * fit into a double, but are what a double prints as. */
static double divide(uint64_t mantissa, ptrdiff_t places) {
    if (mantissa == 0) return 0;
    uint64_t divisor = integer_power[places];
    int up = __builtin_clzll(mantissa);
    int down = __builtin_clzll(divisor);
    wide numerator = (wide)(mantissa << up) << 63;
    uint64_t quotient = (uint64_t)(numerator / (divisor << down));
    bool rest = numerator != (wide)quotient * (divisor << down);
    int shift = 11 - __builtin_clzll(quotient);
    uint64_t kept = quotient >> shift;
    uint64_t lost = quotient - (kept << shift);
    uint64_t half = (uint64_t)1 << (shift - 1);
    if (lost > half || (lost == half && (rest || kept % 2 == 1))) kept++;
    return (double)kept * power_of_two(shift - 63 + down - up);
}

static bool word_is(const char *at, const char *end, const char *word) {
    size_t n = strlen(word);
    if ((size_t)(end - at) < n) return false;
    for (size_t i = 0; i < n; i++)
        if ((at[i] | 0x20) != word[i]) return false;
    return true;
}

static int read_exponent(const char **at, const char *end) {
    const char *p = *at;
    if (p == end || (*p | 0x20) != 'e') return 0;
    p++;
    bool negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+')) p++;
    if (p == end || !is_digit(*p)) return 0;
    int exponent = 0;
    for (; p < end && is_digit(*p); p++)
        if (exponent < EXPONENT_LIMIT) exponent = 10 * exponent + (*p - '0');
    *at = p;
    return negative ? -exponent : exponent;
}

pc_decimal_result pc_decimal_read(double *value, const char **at, const char *end) {
    const char *p = *at;
    bool negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+')) p++;
    const char *first = p;
    uint64_t mantissa = 0;
    for (; p < end && is_digit(*p); p++)
        mantissa = 10 * mantissa + (uint64_t)(*p - '0');
    ptrdiff_t digits = p - first;
    ptrdiff_t fraction = 0;
    if (p < end && *p == '.') {
        const char *point = p++;
        for (; p < end && is_digit(*p); p++)
            mantissa = 10 * mantissa + (uint64_t)(*p - '0');
        fraction = p - point - 1;
        digits += fraction;
    }
    if (digits == 0) {
        if (!word_is(first, end, "nan") && !word_is(first, end, "inf")) return PC_DECIMAL_NONE;
        return PC_DECIMAL_NOT_FINITE;
    }
    const char *digits_end = p;
    int exponent = read_exponent(&p, end);
    ptrdiff_t scale = exponent - fraction;
    double result;
    if (digits <= 19 && mantissa <= (uint64_t)1 << 53 && scale >= -22 && scale <= 22)
        result = scale < 0 ? (double)mantissa / exact_power[-scale] : (double)mantissa * exact_power[scale];
    else if (digits <= 19 && scale < 0 && scale >= -19)
        result = divide(mantissa, -scale);
    else
        result = read_slowly(first, digits_end, exponent);
    if (!isfinite(result)) return PC_DECIMAL_NOT_FINITE;
    /* 1.#QNAN and its kin are what old compilers print for nan. */
    if (digits_end[-1] == '.' && p < end && *p == '#') return PC_DECIMAL_NOT_FINITE;
    *value = negative ? -result : result;
    *at = p;
    return PC_DECIMAL_OK;
}

bool pc_decimal_read_integer(int64_t *value, const char **at, const char *end) {
    const int64_t limit = (int64_t)1 << 62;
    const char *p = *at;
    bool negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+')) p++;
    if (p == end || !is_digit(*p)) return false;
    int64_t result = 0;
    const char *sure = end - p > 18 ? p + 18 : end;
    for (; p < sure && is_digit(*p); p++)
        result = 10 * result + (*p - '0');
    for (; p < end && is_digit(*p); p++)
        result = result > (limit - 9) / 10 ? limit : 10 * result + (*p - '0');
    *value = negative ? -result : result;
    *at = p;
    return true;
}

/* The digits of |value| rounded to `precision` places, and the power of ten of the first; no locale in them.
 */
static int digits_of(char digits[20], double value, int precision) {
    char text[64];
    (void)snprintf(text, sizeof text, "%.*e", precision - 1, value);
    int n = 0;
    const char *p = text;
    for (; *p && *p != 'e'; p++)
        if (is_digit(*p)) digits[n++] = *p;
    while (n > 1 && digits[n - 1] == '0')
        n--;
    digits[n] = '\0';
    return *p == 'e' ? (int)strtol(p + 1, NULL, 10) : 0;
}

/* |value| in [1e-5, 1e14) as a fraction of integers: its decimals by integers alone, and whether they read
 * back. */
typedef struct fraction {
    uint64_t mantissa;
    int shift; /* |value| = mantissa / 2^shift */
} fraction;

static fraction fraction_of(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint64_t mantissa = (bits & (((uint64_t)1 << 52) - 1)) | (uint64_t)1 << 52;
    return (fraction){mantissa, 1075 - (int)(bits >> 52 & 0x7ff)};
}

static wide wide_power(int k) {
    return k < 20 ? integer_power[k] : (wide)integer_power[19] * integer_power[k - 19];
}

/* The nearest decimal of `places` decimals, times 10^places; true where no other double is as near to it. */
static bool round_to_places(uint64_t *decimal, fraction f, int places) {
    wide power = wide_power(places);
    wide scaled = (wide)f.mantissa * power;
    wide half = (wide)1 << (f.shift - 1);
    *decimal = (uint64_t)((scaled + half) >> f.shift);
    wide back = (wide)*decimal << f.shift;
    if (back == scaled + half && *decimal % 2 == 1) { /* half-way: to even, as printf does */
        (*decimal)--;
        back -= half + half;
    }
    wide error = back > scaled ? back - scaled : scaled - back;
    return (f.mantissa == (uint64_t)1 << 52 ? 4 : 2) * error < power;
}

static double power_of_ten(int k) {
    return k < 0 ? 1 / exact_power[-k] : exact_power[k];
}

static int quick_digits(char digits[20], double value) {
    fraction f = fraction_of(value);
    int exponent = (int)floor(log10(value));
    exponent += value >= power_of_ten(exponent + 1);
    exponent -= value < power_of_ten(exponent);
    uint64_t decimal = 0;
    int precision = 15;
    while (!round_to_places(&decimal, f, precision - 1 - exponent))
        precision++;
    exponent += decimal == integer_power[precision]; /* 99.9... became 100 */
    while (decimal % 10 == 0)
        decimal /= 10;
    int n = 0;
    for (uint64_t rest = decimal; rest > 0; rest /= 10)
        n++;
    digits[n] = '\0';
    for (; decimal > 0; decimal /= 10)
        digits[--n] = (char)('0' + decimal % 10);
    return exponent;
}

static size_t lay_out(char *text, bool negative, const char *digits, int exponent) {
    const char *sign = negative ? "-" : "";
    int n = (int)strlen(digits);
    int written;
    if (exponent < -5 || exponent > 16)
        written = snprintf(text, PC_DECIMAL_SPACE, "%s%c%s%se%d", sign, digits[0], n > 1 ? "." : "",
                           digits + 1, exponent);
    else if (exponent < 0)
        written = snprintf(text, PC_DECIMAL_SPACE, "%s0.%.*s%s", sign, -exponent - 1, "0000", digits);
    else if (n <= exponent + 1)
        written =
            snprintf(text, PC_DECIMAL_SPACE, "%s%s%.*s", sign, digits, exponent + 1 - n, "0000000000000000");
    else
        written =
            snprintf(text, PC_DECIMAL_SPACE, "%s%.*s.%s", sign, exponent + 1, digits, digits + exponent + 1);
    return (size_t)written;
}

size_t pc_decimal_write(char text[PC_DECIMAL_SPACE], double value) {
    char digits[20];
    size_t length = 0;
    if (value == 0) return lay_out(text, signbit(value), "0", 0);
    if (fabs(value) >= 1e-5 && fabs(value) < 1e14) {
        int exponent = quick_digits(digits, fabs(value));
        return lay_out(text, value < 0, digits, exponent);
    }
    for (int precision = 1; precision <= 17; precision++) {
        double back = 0;
        int exponent = digits_of(digits, fabs(value), precision);
        length = lay_out(text, value < 0, digits, exponent);
        const char *p = text;
        if (pc_decimal_read(&back, &p, text + length) == PC_DECIMAL_OK && back == value) break;
    }
    return length;
}
