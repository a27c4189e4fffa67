/* Numbers to colours. */
#ifndef PC_COLORMAP_H
#define PC_COLORMAP_H

#include "color.h"
#include <stddef.h>

typedef struct pc_colormap {
    int count;
    const pc_color *color; /* evenly spaced from low to high */
} pc_colormap;

extern const pc_colormap pc_colormap_diverging;  /* blue, near white, red: for signed numbers */
extern const pc_colormap pc_colormap_sequential; /* pale yellow to dark violet: for sizes and errors */

/* Colour at t in 0..1; below and above take the ends, NaN is grey. */
pc_color pc_colormap_at(const pc_colormap *map, float t);

#endif
