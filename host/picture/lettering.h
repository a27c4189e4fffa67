/* Text and legends on a picture, in an alphabet of strokes. */
#ifndef PC_LETTERING_H
#define PC_LETTERING_H

#include "colormap.h"
#include "picture.h"

/* Width of a text in pixels where capitals are `height` pixels tall. */
double pc_lettering_width(const char *text, double height);
/* Writes with the baseline's left end at (x,y) pixels. Printable ASCII; other bytes leave a gap. */
pc_status pc_lettering_draw(pc_picture *picture, pc_context *ctx, double x, double y, double height,
                            pc_color color, const char *text);

/* A bar of colours with numbers from `low` to `high`, in the room that the picture keeps for it; nothing is
 * drawn where it keeps none. */
pc_status pc_legend_draw(pc_picture *picture, pc_context *ctx, const pc_colormap *map, double low,
                         double high, const char *title);

/* A place on a legend's scale, with a word under its number (or NULL). */
typedef struct pc_tick {
    double value;
    const char *word;
} pc_tick;
/* The same from 0 to `high` in units of the scan, as is written below, with numbers where they are asked for.
 * A mark with a word crosses the bar. */
pc_status pc_legend_draw_ticks(pc_picture *picture, pc_context *ctx, const pc_colormap *map, double high,
                               const char *title, const pc_tick *tick, int count);

#endif
