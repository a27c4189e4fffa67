#include "png_file.h"
#include "file.h"
#include "memory.h"
#include <png.h>
#include <string.h>

/* libpng's simplified writer: no setjmp, errors come back as text. */
pc_status pc_png_encode(uint8_t **data, size_t *size, pc_context *ctx, const uint8_t *pixels, int width,
                        int height) {
    png_image image;
    memset(&image, 0, sizeof(image));
    image.version = PNG_IMAGE_VERSION;
    image.width = (png_uint_32)width, image.height = (png_uint_32)height;
    image.format = PNG_FORMAT_RGB;
    image.flags = PNG_IMAGE_FLAG_FAST; /* half the time, and a fiftieth larger */
    png_alloc_size_t room = PNG_IMAGE_PNG_SIZE_MAX(image);
    *data = NULL;
    pc_status status = pc_new(data, ctx, room);
    if (status != PC_OK) return status;
    if (!png_image_write_to_memory(&image, *data, &room, 0, pixels, 3 * width, NULL)) {
        pc_free(ctx, *data);
        *data = NULL;
        return pc_fail(ctx, PC_E_NOMEM, "cannot pack a picture: %s", image.message);
    }
    *size = room;
    return pc_resize(data, ctx, room);
}

pc_status pc_png_put(pc_context *ctx, const char *path, const uint8_t *data, size_t size) {
    pc_writer writer = {0};
    pc_status status = PC_OK;
    PC_TRY(pc_writer_open(&writer, ctx, path, true));
    PC_TRY(pc_writer_put(&writer, data, size));
    PC_TRY(pc_writer_commit(&writer));
done:
    pc_writer_abandon(&writer);
    return status;
}

pc_status pc_png_write(pc_context *ctx, const char *path, const uint8_t *pixels, int width, int height) {
    uint8_t *data = NULL;
    size_t size = 0;
    pc_status status = pc_png_encode(&data, &size, ctx, pixels, width, height);
    if (status == PC_OK) status = pc_png_put(ctx, path, data, size);
    pc_free(ctx, data);
    return status;
}

pc_status pc_png_save(pc_context *ctx, const char *path, const pc_picture *picture) {
    uint8_t *pixels = NULL;
    pc_status status = pc_picture_pixels(&pixels, ctx, picture);
    if (status == PC_OK) status = pc_png_write(ctx, path, pixels, picture->width, picture->height);
    pc_free(ctx, pixels);
    return status;
}
