/* PNG files: what was written is read back by libpng; a refused path leaves nothing. */
#include "png_file.h"
#include "testing.h"
#include <png.h>
#include <stdlib.h>
#include <unistd.h>

static void pixels_come_back(void **state) {
    pc_context *ctx = *state;
    char folder[] = "/tmp/percale_png_XXXXXX", path[64];
    enum { WIDTH = 37, HEIGHT = 21 };
    static uint8_t pixels[3 * WIDTH * HEIGHT], back[3 * WIDTH * HEIGHT];
    assert_non_null(mkdtemp(folder));
    (void)snprintf(path, sizeof(path), "%s/a.png", folder);
    for (size_t i = 0; i < sizeof(pixels); i++)
        pixels[i] = (uint8_t)(i * 7919);
    assert_ok(ctx, pc_png_write(ctx, path, pixels, WIDTH, HEIGHT));
    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&image, path));
    assert_int_equal(image.width, WIDTH);
    assert_int_equal(image.height, HEIGHT);
    image.format = PNG_FORMAT_RGB;
    assert_true(png_image_finish_read(&image, NULL, back, 0, NULL));
    assert_memory_equal(pixels, back, sizeof(pixels));

    pixels[0] ^= 255;
    assert_ok(ctx, pc_png_write(ctx, path, pixels, WIDTH, HEIGHT)); /* replaces it */
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0); /* no temporary file is left */
}

/* Rows that go on as they are take almost no room, and are read back. */
static void even_pictures_are_small(void **state) {
    pc_context *ctx = *state;
    enum { WIDTH = 300, HEIGHT = 200 };
    static uint8_t pixels[3 * WIDTH * HEIGHT], back[3 * WIDTH * HEIGHT];
    for (size_t i = 0; i < sizeof(pixels); i++)
        pixels[i] = (uint8_t)(i % (3 * WIDTH) * 31);
    uint8_t *data;
    size_t size;
    assert_ok(ctx, pc_png_encode(&data, &size, ctx, pixels, WIDTH, HEIGHT));
    assert_true(size < sizeof(pixels) / 50);
    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_memory(&image, data, size));
    image.format = PNG_FORMAT_RGB;
    assert_true(png_image_finish_read(&image, NULL, back, 0, NULL));
    assert_memory_equal(pixels, back, sizeof(pixels));
    pc_free(ctx, data);
}

static void missing_folder_is_named(void **state) {
    pc_context *ctx = *state;
    const uint8_t pixels[3] = {1, 2, 3};
    assert_int_equal(pc_png_write(ctx, "/nowhere/at/all.png", pixels, 1, 1), PC_E_IO);
    assert_non_null(strstr(pc_context_message(ctx), "/nowhere/at"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(pixels_come_back, make_context, free_context),
        cmocka_unit_test_setup_teardown(even_pictures_are_small, make_context, free_context),
        cmocka_unit_test_setup_teardown(missing_folder_is_named, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
