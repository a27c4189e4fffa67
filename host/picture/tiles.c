#include "tiles.h"
#include "memory.h"

enum { BLOCKS = 64 }; /* of items; fixed, so that the order does not depend on the threads */

/* Adds (or places, where item is not NULL) one block's items at its cursors, one per tile. */
static void visit_block(size_t *cursor, pc_index *item, const pc_span *span, size_t begin, size_t end,
                        int columns) {
    for (size_t i = begin; i < end; i++) {
        pc_span s = span[i];
        if (s.x1 < s.x0 || s.y1 < s.y0) continue;
        for (int ty = s.y0 / PC_TILE; ty <= s.y1 / PC_TILE; ty++)
            for (int tx = s.x0 / PC_TILE; tx <= s.x1 / PC_TILE; tx++) {
                size_t at = cursor[(size_t)ty * (size_t)columns + (size_t)tx]++;
                if (item) item[at] = (pc_index)i;
            }
    }
}

pc_status pc_tiles_make(pc_tiles *tiles, pc_context *ctx, int width, int height, const pc_span *span,
                        size_t count) {
    pc_status status;
    size_t *cursor = NULL;
    *tiles = (pc_tiles){.columns = (width + PC_TILE - 1) / PC_TILE, .rows = (height + PC_TILE - 1) / PC_TILE};
    size_t n = (size_t)tiles->columns * (size_t)tiles->rows, block = (count + BLOCKS - 1) / BLOCKS;
    PC_TRY(pc_new(&cursor, ctx, n * BLOCKS));
    PC_TRY(pc_new(&tiles->start, ctx, n + 1));
    for (int pass = 0; pass < 2; pass++) {
#pragma omp parallel for schedule(static)
        for (size_t b = 0; b < BLOCKS; b++) {
            size_t begin = b * block < count ? b * block : count;
            size_t end = begin + block < count ? begin + block : count;
            visit_block(cursor + b * n, tiles->item, span, begin, end, tiles->columns);
        }
        if (pass == 1) break;
        size_t sum = 0;
        for (size_t t = 0; t < n; t++) {
            tiles->start[t] = sum;
            for (size_t b = 0; b < BLOCKS; b++) {
                size_t items = cursor[b * n + t];
                cursor[b * n + t] = sum;
                sum += items;
            }
        }
        tiles->start[n] = sum;
        PC_TRY(pc_new(&tiles->item, ctx, sum));
    }
done:
    pc_free(ctx, cursor);
    if (status != PC_OK) pc_tiles_free(tiles, ctx);
    return status;
}

void pc_tiles_free(pc_tiles *tiles, pc_context *ctx) {
    pc_free(ctx, tiles->start);
    pc_free(ctx, tiles->item);
    *tiles = (pc_tiles){0};
}
