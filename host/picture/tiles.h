/* Sorts drawn things by the square tiles of a picture they touch: each tile is then drawn by one thread, its
 * things in their given order, so that the picture does not depend on the number of threads. */
#ifndef PC_TILES_H
#define PC_TILES_H

#include "context.h"

enum { PC_TILE = 64 }; /* samples per side */

typedef struct pc_span {
    int16_t x0, y0, x1, y1; /* samples, both ends included; nothing where x1 < x0 or y1 < y0 */
} pc_span;

typedef struct pc_tiles {
    int columns, rows; /* tiles */
    size_t *start;     /* columns*rows+1 offsets into item */
    pc_index *item;    /* increasing within each tile */
} pc_tiles;

/* `span` must lie within the picture of `width` x `height` samples. */
pc_status pc_tiles_make(pc_tiles *tiles, pc_context *ctx, int width, int height, const pc_span *span,
                        size_t count);
void pc_tiles_free(pc_tiles *tiles, pc_context *ctx);

/* The samples whose middles lie in [low,high], cut to those from clip0 to before clip1 (clip0 >= 0). */
static inline void pc_span_cut(int16_t *first, int16_t *last, float low, float high, int clip0, int clip1) {
    float a = low - 0.5F, b = high - 0.5F;
    int i = a <= (float)clip0 ? clip0 : a >= (float)clip1 ? clip1 : (int)a;
    if ((float)i < a && i < clip1) i++;
    int j = b < (float)clip0 ? clip0 - 1 : b >= (float)clip1 ? clip1 - 1 : (int)b;
    *first = (int16_t)i, *last = (int16_t)j;
}
#define PC_SPAN_NONE ((pc_span){1, 1, 0, 0})

#endif
