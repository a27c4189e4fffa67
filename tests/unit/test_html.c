/* Text for web pages, and what pictures become for them. */
#include "html_text.h"
#include "memory.h"
#include "picture.h"
#include "random.h"
#include "testing.h"
#include <math.h>

static void is_text(pc_html *html, const char *expected) {
    assert_int_equal(pc_html_end(html), PC_OK);
    assert_string_equal(html->text, expected);
    assert_int_equal(strlen(html->text), html->length);
    html->length = 0;
}

static void text_loses_its_markup(void **state) {
    pc_context *ctx = *state;
    pc_html html;
    pc_html_start(&html, ctx);
    pc_html_escape(&html, "a<b>&\"c\"'d'.ply");
    is_text(&html, "a&lt;b&gt;&amp;&quot;c&quot;&#39;d&#39;.ply");
    pc_html_escape(&html, "\xc3\xa4 \xff \xc3 \x01 \xef\xbf\xbf \xf0\x9f\x90\x84");
    is_text(&html, "\xc3\xa4 \xef\xbf\xbd \xef\xbf\xbd \xef\xbf\xbd \xef\xbf\xbd \xf0\x9f\x90\x84");
    pc_html_put(&html, "<p>");
    pc_html_escape(&html, NULL);
    pc_html_print(&html, "%d</p>", 7);
    is_text(&html, "<p>7</p>");
    pc_html_free(&html);
}

/* RFC 4648, chapter 10; and bytes of any value. */
static void base64_is_that_of_the_standard(void **state) {
    pc_context *ctx = *state;
    static const char *const encoded[] = {"", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"};
    pc_html html;
    pc_html_start(&html, ctx);
    for (size_t n = 1; n <= 6; n++) {
        pc_html_base64(&html, (const uint8_t *)"foobar", n);
        is_text(&html, encoded[n]);
    }
    pc_html_base64(&html, (const uint8_t *)"\xff\xef\xbe\x00\x10\x83", 6);
    is_text(&html, "/+++ABCD");
    pc_html_free(&html);
}

static void numbers_read_well(void **state) {
    pc_context *ctx = *state;
    pc_html html;
    pc_html_start(&html, ctx);
    const double count[] = {0, 999, 1000, -1234567, 12345678};
    static const char *const counted[] = {"0", "999", "1,000", "-1,234,567", "12,345,678"};
    for (size_t k = 0; k < 5; k++) {
        pc_html_count(&html, count[k]);
        is_text(&html, counted[k]);
    }
    const double number[] = {0, 0.5, 0.00233, 1234.5, 123456, 0.0000123, 1e-9, INFINITY, NAN, -2};
    static const char *const told[] = {"0",         "0.5",   "0.00233", "1234",    "123,456",
                                       "0.0000123", "1e-09", "&#8211;", "&#8211;", "-2"};
    for (size_t k = 0; k < 10; k++) {
        pc_html_number(&html, number[k]);
        is_text(&html, told[k]);
    }
    pc_html_bytes(&html, 12345678);
    is_text(&html, "12 MB");
    pc_html_bytes(&html, 2.5e9);
    is_text(&html, "2.50 GB");
    pc_html_free(&html);
}

static void refused_memory_is_told_at_the_end(void **state) {
    pc_context *ctx = *state;
    pc_html html;
    pc_html_start(&html, ctx);
    pc_memory_fail_at(ctx, 1);
    pc_html_put(&html, "<p>");
    pc_html_escape(&html, "more");
    pc_html_base64(&html, (const uint8_t *)"more", 4);
    assert_int_equal(pc_html_end(&html), PC_E_NOMEM);
    pc_memory_fail_at(ctx, 0);
    pc_context_clear_message(ctx);
    pc_html_free(&html);
}

/* Smaller pictures keep the mean of all pixels; whole ratios are plain means, no ratio changes nothing. */
static void shrinking_keeps_the_light(void **state) {
    pc_context *ctx = *state;
    enum { W = 48, H = 30 };
    uint8_t pixels[3 * W * H];
    pc_random random = {11};
    double sum = 0;
    for (int i = 0; i < 3 * W * H; i++)
        sum += pixels[i] = (uint8_t)(pc_random_next(&random) & 255);
    const int size[][2] = {{W, H}, {24, 15}, {47, 29}, {31, 7}, {1, 1}};
    for (size_t k = 0; k < 5; k++) {
        uint8_t *small = NULL;
        const int w = size[k][0], h = size[k][1];
        assert_ok(ctx, pc_picture_shrink(&small, ctx, pixels, W, H, w, h));
        double mean = 0;
        for (int i = 0; i < 3 * w * h; i++)
            mean += small[i];
        assert_true(fabs(mean / (3 * w * h) - sum / (3 * W * H)) < 0.5);
        if (k == 0) assert_memory_equal(small, pixels, sizeof pixels);
        if (k == 1) {
            int four = pixels[3 * 4] + pixels[3 * 5] + pixels[3 * (W + 4)] + pixels[3 * (W + 5)];
            assert_int_equal(small[3 * 2], (four + 2) / 4);
        }
        pc_free(ctx, small);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(text_loses_its_markup, make_context, free_context),
        cmocka_unit_test_setup_teardown(base64_is_that_of_the_standard, make_context, free_context),
        cmocka_unit_test_setup_teardown(numbers_read_well, make_context, free_context),
        cmocka_unit_test_setup_teardown(refused_memory_is_told_at_the_end, make_context, free_context),
        cmocka_unit_test_setup_teardown(shrinking_keeps_the_light, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
