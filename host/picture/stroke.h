/* Draws thin round-ended lines and little balls, hidden by what is nearer. */
#ifndef PC_STROKE_H
#define PC_STROKE_H

#include "picture.h"
#include <stddef.h>

typedef struct pc_stroke {
    double from[3], to[3]; /* the line's ends, model units */
    float normal[3];       /* of the surface it lies on: seen only from that side. Zero: from both */
    pc_color color;
    float width; /* pixels */
} pc_stroke;

typedef struct pc_ball {
    double centre[3];
    float radius; /* model units */
    pc_color color;
} pc_ball;

/* Smooth-edged lines. Where lines of one call overlap, the one that covers a sample more wins, so that the
 * joints of a chain do not show. `bias` (model units) lifts the lines towards the viewer when they are tested
 * against what is drawn; lines leave no depth. */
pc_status pc_stroke_draw(pc_picture *picture, pc_context *ctx, const pc_stroke *stroke, size_t count,
                         double bias);
/* Lines on the picture itself: ends are column and row in pixels, nothing hides them. */
pc_status pc_stroke_draw_flat(pc_picture *picture, pc_context *ctx, const pc_stroke *stroke, size_t count);
/* Shaded balls that hide and are hidden by depth. */
pc_status pc_ball_draw(pc_picture *picture, pc_context *ctx, const pc_ball *ball, size_t count);

#endif
