#include "tlayout.h"
#include "intervals.h"
#include "memory.h"
#include "pattern.h"
#include <string.h>

/* The smallest interval, in parts of what is usual. */
static const double least = 0.25;

bool pc_tlayout_is_plain(const pc_polymesh *polygons) {
    pc_index corners = polygons->start[polygons->face_count];
    for (pc_index f = 0; f < polygons->face_count; f++)
        if (polygons->start[f + 1] - polygons->start[f] != 4) return false;
    for (pc_index c = 0; polygons->corner_flat && c < corners; c++)
        if (polygons->corner_flat[c]) return false;
    return true;
}

/* One try; `more` where a polygon has to go apart for it. */
static pc_status try_once(pc_tlayout *layout, bool *more, uint8_t *apart, pc_context *ctx,
                          const pc_polymesh *polygons) {
    pc_status status = PC_OK;
    pc_pattern pattern = {0};
    pc_intervals_stats stats;
    uint8_t *refused = NULL;
    PC_TRY(pc_pattern_make(&pattern, ctx, polygons, apart));
    PC_TRY(pc_new(&refused, ctx, pattern.faces.face_count));
    PC_TRY(pc_intervals_solve(pattern.interval, refused, &stats, ctx, &pattern.faces, pattern.whole, least));
    *more = stats.refused > 0;
    for (pc_index f = 0; f < pattern.faces.face_count; f++)
        if (refused[f]) apart[pattern.source[f]] = 1;
    pc_log(ctx, PC_LOG_DEBUG,
           "spline: %u polygons, %u faces: %u pairs, %u cuts, %u even and %u odd centres; %u rows of knot "
           "intervals, %u faces refused",
           polygons->face_count, pattern.faces.face_count, pattern.pairs, pattern.cuts, pattern.even,
           pattern.odd, stats.rows, stats.refused);
    if (*more) goto done;
    layout->faces = pattern.faces, pattern.faces = (pc_polymesh){0};
    layout->interval = pattern.interval, pattern.interval = NULL;
done:
    pc_free(ctx, refused);
    pc_pattern_free(&pattern, ctx);
    return status;
}

pc_status pc_tlayout_make(pc_tlayout *layout, pc_context *ctx, const pc_polymesh *polygons) {
    pc_status status = PC_OK;
    uint8_t *apart = NULL;
    *layout = (pc_tlayout){0};
    PC_TRY(pc_new(&apart, ctx, polygons->face_count));
    for (bool more = true; more;) {
        PC_TRY(try_once(layout, &more, apart, ctx, polygons));
        PC_TRY(pc_check_interrupt(ctx));
    }
done:
    pc_free(ctx, apart);
    return status;
}

void pc_tlayout_free(pc_tlayout *layout, pc_context *ctx) {
    pc_polymesh_free(&layout->faces, ctx);
    pc_free(ctx, layout->interval);
    *layout = (pc_tlayout){0};
}
