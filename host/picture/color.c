#include "color.h"
#include "random.h"
#include <math.h>

float pc_color_to_linear(int byte) {
    float s = (float)byte / 255.0F;
    return s <= 0.04045F ? s / 12.92F : powf((s + 0.055F) / 1.055F, 2.4F);
}

int pc_color_from_linear(float light) {
    if (!(light > 0)) return 0;
    if (light >= 1) return 255;
    float s = light <= 0.0031308F ? 12.92F * light : 1.055F * powf(light, 1 / 2.4F) - 0.055F;
    return (int)(255 * s + 0.5F);
}

static float ramp(float hue) {
    float h = fabsf(fmodf(hue, 6.0F) - 3.0F) - 1.0F;
    return h < 0 ? 0 : h > 1 ? 1 : h;
}

pc_color pc_color_pastel(uint32_t key) {
    uint64_t hash = pc_hash64(key);
    float hue = 6.0F * (float)(hash & 0xffff) / 65536.0F;
    float strength = 0.20F + 0.18F * (float)(hash >> 16 & 0xff) / 255.0F;
    float light = 0.91F + 0.08F * (float)(hash >> 24 & 0xff) / 255.0F;
    pc_color c = 0;
    for (int k = 0; k < 3; k++) {
        float channel = light * (1 - strength * (1 - ramp(hue + 4.0F * (float)k)));
        c = c << 8 | (pc_color)(255 * channel);
    }
    return c;
}
