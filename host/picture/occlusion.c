#include "occlusion.h"
#include "memory.h"
#include "pick.h"
#include "random.h"

typedef struct heights {
    const float *z; /* per pixel: towards the viewer, in pixels; -INFINITY where nothing is */
    int width, x0, y0, x1, y1;
} heights;

static float height_at(const heights *h, int x, int y) {
    if (x < h->x0 || x >= h->x1 || y < h->y0 || y >= h->y1) return -INFINITY;
    return h->z[(size_t)y * (size_t)h->width + (size_t)x];
}

/* Rise of two opposite neighbours at distance r above the point, as a slope. Where one side falls off steeply
 * (a silhouette) or is empty, nothing is known; what towers over the point darkens it by a bounded amount. */
static float pair_rise(const heights *h, int x, int y, int dx, int dy, float r) {
    const float steep = 1.2F;
    float z = height_at(h, x, y), a = (height_at(h, x + dx, y + dy) - z) / r;
    float b = (height_at(h, x - dx, y - dy) - z) / r;
    if (a < -2.5F * steep || b < -2.5F * steep) {
        float rest = pc_greater(a, b);
        return rest > 0 && a + b > 0 ? pc_lesser(rest, steep) * 0.5F : 0;
    }
    return pc_greater(-steep, pc_lesser(steep, 0.5F * (a + b)));
}

enum { RADII = 4, PAIRS = 3 * RADII };

typedef struct offset {
    int dx, dy;
    float length, weight;
} offset;

/* Where to look, turned anew for each pixel of a 4x4 pattern: the blur after it averages exactly one of each.
 */
static void make_offsets(offset table[16][PAIRS], float unit) {
    static const float radius[RADII] = {1.0F, 2.6F, 6.5F, 15.0F};
    static const float weight[RADII] = {0.6F, 0.9F, 1.1F, 1.1F};
    for (int pattern = 0; pattern < 16; pattern++)
        for (int k = 0; k < PAIRS; k++) {
            offset *o = &table[pattern][k];
            int ring = k / 3, spoke = k % 3;
            float turn = (float)((pattern * 7) & 15) / 16.0F, r = pc_greater(1, radius[ring] * unit);
            float angle = (float)PC_PI * ((float)spoke + turn) / 3.0F + 0.4F * (float)ring;
            o->dx = (int)lrintf(r * cosf(angle)), o->dy = (int)lrintf(r * sinf(angle));
            o->length = sqrtf((float)(o->dx * o->dx + o->dy * o->dy));
            o->weight = weight[ring] / 3.0F;
        }
}

static float hollow(const heights *h, int x, int y, const offset *table) {
    float sum = 0;
    for (int k = 0; k < PAIRS; k++)
        sum += table[k].weight * pair_rise(h, x, y, table[k].dx, table[k].dy, table[k].length);
    return -sum;
}

/* Average over 4 x 4 pixels of about the same depth. */
static float blurred(const heights *h, const float *rough, int x, int y) {
    float z = height_at(h, x, y), sum = 0, weight = 0;
    for (int j = -2; j < 2; j++)
        for (int i = -2; i < 2; i++) {
            float other = height_at(h, x + i, y + j);
            if (!(fabsf(other - z) < 12)) continue;
            sum += rough[(size_t)(y + j) * (size_t)h->width + (size_t)(x + i)];
            weight += 1;
        }
    return weight > 0 ? sum / weight : 0;
}

pc_status pc_occlusion_make(float *shade, pc_context *ctx, const pc_picture *picture, const pc_pane *pane) {
    pc_status status;
    float *z = NULL, *rough = NULL;
    int s = picture->samples;
    size_t total = (size_t)picture->width * (size_t)picture->height;
    PC_TRY(pc_new(&z, ctx, total));
    PC_TRY(pc_new(&rough, ctx, total));
    heights h = {z, picture->width, pane->box[0] / s, pane->box[1] / s, pane->box[2] / s, pane->box[3] / s};
    float scale = (float)pane->camera.scale / (float)s, unit = (float)picture->height / 800.0F;
    offset table[16][PAIRS];
    make_offsets(table, unit);
#pragma omp parallel
    {
#pragma omp for schedule(static)
        for (int y = h.y0; y < h.y1; y++)
            for (int x = h.x0; x < h.x1; x++) {
                size_t at = (size_t)(y * s + s / 2) * (size_t)picture->columns + (size_t)(x * s + s / 2);
                float d = picture->depth[at];
                z[(size_t)y * (size_t)h.width + (size_t)x] =
                    isfinite(d) ? scale * pc_camera_view_z(&pane->camera, d) : -INFINITY;
            }
#pragma omp for schedule(dynamic, 8)
        for (int y = h.y0; y < h.y1; y++)
            for (int x = h.x0; x < h.x1; x++) {
                size_t i = (size_t)y * (size_t)h.width + (size_t)x;
                rough[i] = isfinite(z[i]) ? hollow(&h, x, y, table[(x & 3) + 4 * (y & 3)]) : 0;
            }
#pragma omp for schedule(dynamic, 8)
        for (int y = h.y0; y < h.y1; y++)
            for (int x = h.x0; x < h.x1; x++) {
                size_t i = (size_t)y * (size_t)h.width + (size_t)x;
                shade[i] = isfinite(z[i]) ? blurred(&h, rough, x, y) : 0;
            }
    }
done:
    pc_free(ctx, z);
    pc_free(ctx, rough);
    return status;
}
