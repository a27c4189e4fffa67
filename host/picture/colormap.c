#include "colormap.h"

static const pc_color diverging[] = {0x1f3f7f, 0x2f6db3, 0x5fa0d0, 0xa4cbe3, 0xd9e6ee, 0xf4f1ec,
                                     0xf6ddcd, 0xf0b193, 0xdc7a5f, 0xbd3c3f, 0x7f1730};
static const pc_color sequential[] = {0xf7f4df, 0xf9e3a2, 0xfbc76b, 0xf79f57, 0xe9735a,
                                      0xcb4c6a, 0x9c3277, 0x682377, 0x35185f};

const pc_colormap pc_colormap_diverging = {sizeof(diverging) / sizeof(diverging[0]), diverging};
const pc_colormap pc_colormap_sequential = {sizeof(sequential) / sizeof(sequential[0]), sequential};

pc_color pc_colormap_at(const pc_colormap *map, float t) {
    if (t != t) return 0xb4b4b4;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    float x = t * (float)(map->count - 1);
    int i = (int)x;
    if (i > map->count - 2) i = map->count - 2;
    return pc_color_mix(map->color[i], map->color[i + 1], x - (float)i);
}
