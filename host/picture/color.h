/* Colours as 0xRRGGBB in sRGB, and what one does with them. */
#ifndef PC_COLOR_H
#define PC_COLOR_H

#include <stdint.h>

typedef uint32_t pc_color;

static inline int pc_color_channel(pc_color c, int k) {
    return (int)(c >> (16 - 8 * k)) & 255;
}

/* a towards b by t in 0..1, in sRGB: thin dark lines keep their weight that way. */
static inline pc_color pc_color_mix(pc_color a, pc_color b, float t) {
    pc_color c = 0;
    int weight = t <= 0 ? 0 : t >= 1 ? 256 : (int)(256 * t + 0.5F);
    for (int k = 0; k < 3; k++) {
        int x = pc_color_channel(a, k), y = pc_color_channel(b, k);
        c = c << 8 | (pc_color)((x * (256 - weight) + y * weight + 128) >> 8);
    }
    return c;
}

/* One soft colour per key, neighbours in key far apart in hue. */
pc_color pc_color_pastel(uint32_t key);

/* sRGB byte to linear light 0..1, and back. */
float pc_color_to_linear(int byte);
int pc_color_from_linear(float light);

#endif
