/* The examples of FIPS 180-4, and that the size of the pieces does not matter. */
#include "sha256.h"
#include "testing.h"
#include <stdlib.h>

static void check(const char *bytes, size_t count, size_t repeat, const char *expected) {
    pc_sha256 hash;
    char text[PC_SHA256_TEXT];
    pc_sha256_start(&hash);
    for (size_t i = 0; i < repeat; i++)
        pc_sha256_add(&hash, bytes, count);
    pc_sha256_finish(text, &hash);
    assert_string_equal(text, expected);
}

static void known_digests(void **state) {
    (void)state;
    static const char long_text[] = "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq";
    check("", 0, 1, "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    check("abc", 3, 1, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    check(long_text, 56, 1, "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    check("a", 1, 1000000, "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
    check("aaaaaaaaaa", 10, 100000, "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

static void pieces_do_not_matter_but_texts_do(void **state) {
    (void)state;
    unsigned char bytes[300];
    char whole[PC_SHA256_TEXT], parts[PC_SHA256_TEXT];
    for (size_t i = 0; i < sizeof bytes; i++)
        bytes[i] = (unsigned char)(i * 37);
    for (size_t length = 0; length < sizeof bytes; length++) {
        pc_sha256 one, two;
        size_t cut = length * 2 / 3;
        pc_sha256_start(&one), pc_sha256_start(&two);
        pc_sha256_add(&one, bytes, length);
        pc_sha256_add(&two, bytes, cut), pc_sha256_add(&two, bytes + cut, length - cut);
        pc_sha256_finish(whole, &one), pc_sha256_finish(parts, &two);
        assert_string_equal(whole, parts);
    }
    pc_sha256 one, two;
    pc_sha256_start(&one), pc_sha256_start(&two);
    pc_sha256_add_text(&one, "ab"), pc_sha256_add_text(&one, "c");
    pc_sha256_add_text(&two, "a"), pc_sha256_add_text(&two, "bc");
    pc_sha256_finish(whole, &one), pc_sha256_finish(parts, &two);
    assert_string_not_equal(whole, parts);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_digests),
        cmocka_unit_test(pieces_do_not_matter_but_texts_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
