#include "png_file.h"
#include "memory.h"
#include <errno.h>
#include <png.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* libpng's simplified writer: no setjmp, errors come back as text. */
static pc_status write_whole(pc_context *ctx, FILE *file, const char *path, const uint8_t *pixels, int width,
                             int height) {
    png_image image;
    memset(&image, 0, sizeof(image));
    image.version = PNG_IMAGE_VERSION;
    image.width = (png_uint_32)width, image.height = (png_uint_32)height;
    image.format = PNG_FORMAT_RGB;
    image.flags = PNG_IMAGE_FLAG_FAST;
    if (!png_image_write_to_stdio(&image, file, 0, pixels, 3 * width, NULL))
        return pc_fail(ctx, PC_E_IO, "cannot write %s: %s", path, image.message);
    if (fflush(file) != 0 || fsync(fileno(file)) != 0)
        return pc_fail(ctx, PC_E_IO, "cannot write %s: %s", path, strerror(errno));
    return PC_OK;
}

pc_status pc_png_write(pc_context *ctx, const char *path, const uint8_t *pixels, int width, int height) {
    pc_status status;
    char *temporary = NULL;
    FILE *file = NULL;
    size_t length = strlen(path) + 32;
    PC_TRY(pc_new(&temporary, ctx, length));
    (void)snprintf(temporary, length, "%s.%ld.tmp", path, (long)getpid());
    file = fopen(temporary, "wb");
    if (!file) PC_TRY(pc_fail(ctx, PC_E_IO, "cannot create %s: %s", temporary, strerror(errno)));
    PC_TRY(write_whole(ctx, file, path, pixels, width, height));
    int closed = fclose(file);
    file = NULL;
    if (closed != 0 || rename(temporary, path) != 0)
        PC_TRY(pc_fail(ctx, PC_E_IO, "cannot write %s: %s", path, strerror(errno)));
done:
    if (file) (void)fclose(file);
    if (status != PC_OK && temporary) (void)unlink(temporary);
    pc_free(ctx, temporary);
    return status;
}

pc_status pc_png_save(pc_context *ctx, const char *path, const pc_picture *picture) {
    uint8_t *pixels = NULL;
    pc_status status = pc_picture_pixels(&pixels, ctx, picture);
    if (status == PC_OK) status = pc_png_write(ctx, path, pixels, picture->width, picture->height);
    pc_free(ctx, pixels);
    return status;
}
