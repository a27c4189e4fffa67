#include "png_file.h"
#include "file.h"
#include "memory.h"
#include <libdeflate.h>
#include <string.h>

enum { SIGNATURE = 8, HEADER = 13, FRAME = 12 /* a chunk's length, name and sum */ };

static void put_number(uint8_t *to, uint32_t value) {
    for (int k = 0; k < 4; k++)
        to[k] = (uint8_t)(value >> (24 - 8 * k));
}

/* Puts length and name before `size` bytes that lie at `to` + 8, and their sum behind; returns the end. */
static uint8_t *frame_chunk(uint8_t *to, const char name[4], size_t size) {
    put_number(to, (uint32_t)size);
    memcpy(to + 4, name, 4);
    put_number(to + 8 + size, libdeflate_crc32(0, to + 4, size + 4));
    return to + FRAME + size;
}

/* Each row as the difference to the one above: in shaded pictures on a pale ground hardly any choice of
 * PNG's filters does better. */
static void filter(uint8_t *out, const uint8_t *pixels, size_t width, size_t height) {
    enum { NONE, UP = 2 };
    *out++ = NONE;
    memcpy(out, pixels, width);
    out += width;
    for (size_t y = 1; y < height; y++, out += width) {
        const uint8_t *row = pixels + y * width, *above = row - width;
        *out++ = UP;
        for (size_t x = 0; x < width; x++)
            out[x] = (uint8_t)(row[x] - above[x]);
    }
}

pc_status pc_png_encode(uint8_t **data, size_t *size, pc_context *ctx, const uint8_t *pixels, int width,
                        int height, pc_png_effort effort) {
    static const uint8_t signature[SIGNATURE] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    const size_t plain_size = (3 * (size_t)width + 1) * (size_t)height;
    struct libdeflate_compressor *compressor = libdeflate_alloc_compressor((int)effort);
    uint8_t *plain = NULL;
    pc_status status = PC_OK;
    *data = NULL;
    if (!compressor) PC_TRY(pc_fail(ctx, PC_E_NOMEM, "out of memory for packing a picture"));
    const size_t room = libdeflate_zlib_compress_bound(compressor, plain_size);
    if (room > INT32_MAX) /* of one chunk */
        PC_TRY(
            pc_fail(ctx, PC_E_USAGE, "a picture of %d x %d pixels is too large for a file", width, height));
    PC_TRY(pc_new(&plain, ctx, plain_size));
    PC_TRY(pc_new(data, ctx, SIGNATURE + 3 * FRAME + HEADER + room));
    filter(plain, pixels, 3 * (size_t)width, (size_t)height);
    uint8_t *at = *data;
    memcpy(at, signature, SIGNATURE);
    at += SIGNATURE;
    put_number(at + 8, (uint32_t)width), put_number(at + 12, (uint32_t)height);
    at[16] = 8, at[17] = 2; /* bits of a channel, three channels */
    at = frame_chunk(at, "IHDR", HEADER);
    at = frame_chunk(at, "IDAT", libdeflate_zlib_compress(compressor, plain, plain_size, at + 8, room));
    at = frame_chunk(at, "IEND", 0);
    *size = (size_t)(at - *data);
    PC_TRY(pc_resize(data, ctx, *size));
done:
    libdeflate_free_compressor(compressor);
    pc_free(ctx, plain);
    if (status != PC_OK) pc_free(ctx, *data), *data = NULL;
    return status;
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
    size_t size;
    pc_status status = pc_png_encode(&data, &size, ctx, pixels, width, height, PC_PNG_QUICK);
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
