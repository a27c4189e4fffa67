/* Writes pictures as PNG. */
#ifndef PC_PNG_FILE_H
#define PC_PNG_FILE_H

#include "picture.h"

/* Levels of deflate: for files, and for pages that hold their pictures, a tenth smaller in three times the
 * time. */
typedef enum pc_png_effort { PC_PNG_QUICK = 1, PC_PNG_TIGHT = 6 } pc_png_effort;

/* A PNG file in memory. `pixels`: 3 bytes each, row by row from above. `*data` is freed with pc_free. Several
 * threads may encode pictures of theirs at the same time. PC_E_NOMEM; PC_E_USAGE beyond 700 million pixels.
 */
pc_status pc_png_encode(uint8_t **data, size_t *size, pc_context *ctx, const uint8_t *pixels, int width,
                        int height, pc_png_effort effort);
/* Writes what was encoded. The file appears whole or not at all. A file that is there is replaced. PC_E_IO
 * names the path. */
pc_status pc_png_put(pc_context *ctx, const char *path, const uint8_t *data, size_t size);
/* Both, quickly. */
pc_status pc_png_write(pc_context *ctx, const char *path, const uint8_t *pixels, int width, int height);
/* Finishes the picture and writes it. */
pc_status pc_png_save(pc_context *ctx, const char *path, const pc_picture *picture);

#endif
