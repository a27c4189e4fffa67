#include "png_file.h"
#include "file.h"
#include "memory.h"
#include <png.h>
#include <string.h>

/* libpng's simplified writer: no setjmp, errors come back as text. */
static png_image image_of(int width, int height, png_uint_32 flags) {
    png_image image;
    memset(&image, 0, sizeof(image));
    image.version = PNG_IMAGE_VERSION;
    image.width = (png_uint_32)width, image.height = (png_uint_32)height;
    image.format = PNG_FORMAT_RGB;
    image.flags = flags;
    return image;
}

pc_status pc_png_write(pc_context *ctx, const char *path, const uint8_t *pixels, int width, int height) {
    char *temporary = NULL;
    pc_status status = pc_file_temporary(&temporary, ctx, path, true);
    if (status != PC_OK) return status;
    png_image image = image_of(width, height, PNG_IMAGE_FLAG_FAST);
    if (png_image_write_to_file(&image, temporary, 0, pixels, 3 * width, NULL)) {
        status = pc_file_publish(ctx, temporary, path, true);
    } else {
        status = pc_fail(ctx, PC_E_IO, "cannot write %s: %s", path, image.message);
        (void)remove(temporary);
    }
    pc_free(ctx, temporary);
    return status;
}

pc_status pc_png_encode(uint8_t **data, size_t *size, pc_context *ctx, const uint8_t *pixels, int width,
                        int height) {
    png_image image = image_of(width, height, 0);
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

pc_status pc_png_save(pc_context *ctx, const char *path, const pc_picture *picture) {
    uint8_t *pixels = NULL;
    pc_status status = pc_picture_pixels(&pixels, ctx, picture);
    if (status == PC_OK) status = pc_png_write(ctx, path, pixels, picture->width, picture->height);
    pc_free(ctx, pixels);
    return status;
}
