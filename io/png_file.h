/* Writes pictures as PNG. */
#ifndef PC_PNG_FILE_H
#define PC_PNG_FILE_H

#include "picture.h"

/* A PNG file in memory. `pixels`: 3 bytes each, row by row from above. `*data` is freed with pc_free. Several
 * threads may encode pictures of theirs at the same time. PC_E_NOMEM. */
pc_status pc_png_encode(uint8_t **data, size_t *size, pc_context *ctx, const uint8_t *pixels, int width,
                        int height);
/* Writes what was encoded. The file appears whole or not at all. A file that is there is replaced. PC_E_IO
 * names the path. */
pc_status pc_png_put(pc_context *ctx, const char *path, const uint8_t *data, size_t size);
/* Both. */
pc_status pc_png_write(pc_context *ctx, const char *path, const uint8_t *pixels, int width, int height);
/* Finishes the picture and writes it. */
pc_status pc_png_save(pc_context *ctx, const char *path, const pc_picture *picture);

#endif
