/* Writes pictures as PNG. */
#ifndef PC_PNG_FILE_H
#define PC_PNG_FILE_H

#include "picture.h"

/* `pixels`: 3 bytes each, row by row from above. The file appears whole or not at all. A file that is there
 * is replaced. PC_E_IO names the path. */
pc_status pc_png_write(pc_context *ctx, const char *path, const uint8_t *pixels, int width, int height);
/* The same in memory, packed tightly: for pages that hold their pictures. `*data` is freed with pc_free. */
pc_status pc_png_encode(uint8_t **data, size_t *size, pc_context *ctx, const uint8_t *pixels, int width,
                        int height);
/* Finishes the picture and writes it. */
pc_status pc_png_save(pc_context *ctx, const char *path, const pc_picture *picture);

#endif
