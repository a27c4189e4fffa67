#include "occlusion.h"
#include "memory.h"
#include "pick.h"

/* Rows of pixels sorted by column modulo PHASES: what a pixel looks at depends on its place in a pattern of
 * PHASES x PHASES, so that the pixels of one phase, which lie beside each other here, look at pixels that do
 * too. Around the pane are `reach` rows and columns where nothing is. */
enum { PHASES = 4, RADII = 4, PAIRS = 3 * RADII };

typedef struct heights {
    float *z;       /* towards the viewer, in pixels; EMPTY where nothing is */
    float *rough;   /* how hollow it is there */
    int (*used)[2]; /* per row: the columns / PHASES from and before which something is */
    int width, height, reach;
    int stride; /* of a phase, and PHASES times that of a row */
} heights;

/* Where nothing is: so far below that no sum of heights comes near it, and no infinity in the sums. */
static const float empty = -1e30F;

typedef struct offset {
    int dx, dy;
    float inverse, weight; /* of the length */
} offset;

/* In `field`, one of the above: the pixels (x + dx, y + dy) for x = phase, phase + PHASES, ... */
static float *shifted(const heights *h, float *field, int phase, int dx, int y) {
    const int column = phase + dx + h->reach;
    return field + ((ptrdiff_t)(y + h->reach) * PHASES + column % PHASES) * h->stride + column / PHASES;
}

static pc_status make_heights(heights *h, pc_context *ctx, const float unit, int width, int height) {
    pc_status status = PC_OK;
    const int reach = (int)(16 * unit) + 4;
    *h = (heights){.width = width, .height = height, .reach = (reach + PHASES - 1) / PHASES * PHASES};
    h->stride = (width + 2 * h->reach) / PHASES + 1;
    const size_t total = (size_t)h->stride * PHASES * (size_t)(height + 2 * h->reach);
    PC_TRY(pc_new(&h->z, ctx, total));
    PC_TRY(pc_new(&h->rough, ctx, total));
    PC_TRY(pc_new(&h->used, ctx, (size_t)height));
done:
    return status;
}

static void free_heights(heights *h, pc_context *ctx) {
    pc_free(ctx, h->z);
    pc_free(ctx, h->rough);
    pc_free(ctx, h->used);
}

static void clear_row(const heights *h, int y) {
    float *row = h->z + (ptrdiff_t)(y + h->reach) * PHASES * h->stride;
    for (int i = 0; i < PHASES * h->stride; i++)
        row[i] = empty;
}

/* The middle sample of each pixel. */
static void take_row(const heights *h, const pc_picture *picture, const pc_pane *pane, int y) {
    const int s = picture->samples, x0 = pane->box[0] / s, y0 = pane->box[1] / s;
    const float scale = (float)pane->camera.scale / (float)s;
    const float *depth = picture->depth + (size_t)((y0 + y) * s + s / 2) * (size_t)picture->columns;
    int first = h->width, last = -1;
    for (int x = 0; x < h->width; x++) {
        float d = depth[(x0 + x) * s + s / 2];
        if (!isfinite(d)) continue;
        shifted(h, h->z, x % PHASES, 0, y)[x / PHASES] = scale * pc_camera_view_z(&pane->camera, d);
        first = x < first ? x : first, last = x;
    }
    h->used[y][0] = first / PHASES, h->used[y][1] = last < 0 ? 0 : last / PHASES + 1;
}

/* Where to look, turned anew for each pixel of a 4x4 pattern: the blur after it averages exactly one of each.
 */
static void make_offsets(offset table[PHASES * PHASES][PAIRS], float unit) {
    static const float radius[RADII] = {1.0F, 2.6F, 6.5F, 15.0F};
    static const float weight[RADII] = {0.6F, 0.9F, 1.1F, 1.1F};
    for (int pattern = 0; pattern < PHASES * PHASES; pattern++)
        for (int k = 0; k < PAIRS; k++) {
            offset *o = &table[pattern][k];
            int ring = k / 3, spoke = k % 3;
            float turn = (float)((pattern * 7) & 15) / 16.0F, r = pc_greater(1, radius[ring] * unit);
            float angle = (float)PC_PI * ((float)spoke + turn) / 3.0F + 0.4F * (float)ring;
            o->dx = (int)lrintf(r * cosf(angle)), o->dy = (int)lrintf(r * sinf(angle));
            o->inverse = 1 / sqrtf((float)(o->dx * o->dx + o->dy * o->dy));
            o->weight = weight[ring] / 3.0F;
        }
}

/* Subtracts the rise of two opposite neighbours above each pixel, as a slope. Where one side falls off
 * steeply (a silhouette) or is empty, nothing is known; what towers over the point darkens it by a bounded
 * amount. */
static void add_pair(float *restrict sum, const float *restrict z, const float *restrict one,
                     const float *restrict other, offset o, int count) {
    const float steep = 1.2F, far = -2.5F * steep;
    for (int i = 0; i < count; i++) {
        float a = (one[i] - z[i]) * o.inverse, b = (other[i] - z[i]) * o.inverse, both = a + b;
        float rest = a > b ? a : b, least = a < b ? a : b, mean = 0.5F * both;
        float tower = 0.5F * (rest < steep ? rest : steep);
        tower = (rest < both ? rest : both) > 0 ? tower : 0;
        mean = mean < steep ? mean : steep;
        mean = mean > -steep ? mean : -steep;
        sum[i] -= o.weight * (least < far ? tower : mean);
    }
}

static void hollow_row(const heights *h, const offset table[PHASES * PHASES][PAIRS], int y) {
    const int from = h->used[y][0], count = h->used[y][1] - from;
    for (int phase = 0; phase < PHASES && count > 0; phase++) {
        float *sum = shifted(h, h->rough, phase, 0, y) + from;
        const float *z = shifted(h, h->z, phase, 0, y) + from;
        for (int k = 0; k < PAIRS; k++) {
            const offset o = table[phase + PHASES * (y % PHASES)][k];
            add_pair(sum, z, shifted(h, h->z, phase, o.dx, y + o.dy) + from,
                     shifted(h, h->z, phase, -o.dx, y - o.dy) + from, o, count);
        }
    }
}

/* Average over 4 x 4 pixels of about the same depth. */
static void blur_row(float *shade, const heights *h, int y) {
    enum { BLOCK = 64 };
    for (int phase = 0; phase < PHASES; phase++)
        for (int from = h->used[y][0]; from < h->used[y][1]; from += BLOCK) {
            const int count = h->used[y][1] - from < BLOCK ? h->used[y][1] - from : BLOCK;
            const float *z = shifted(h, h->z, phase, 0, y) + from;
            float sum[BLOCK] = {0}, weight[BLOCK] = {0};
            for (int k = 0; k < 16; k++) {
                const float *other = shifted(h, h->z, phase, k % 4 - 2, y + k / 4 - 2) + from;
                const float *rough = shifted(h, h->rough, phase, k % 4 - 2, y + k / 4 - 2) + from;
                for (int i = 0; i < count; i++) {
                    float near = fabsf(other[i] - z[i]) < 12 ? 1.0F : 0.0F;
                    sum[i] += near * rough[i], weight[i] += near;
                }
            }
            for (int i = 0; i < count && (from + i) * PHASES + phase < h->width; i++)
                shade[(from + i) * PHASES + phase] = z[i] > empty ? sum[i] / weight[i] : 0;
        }
}

pc_status pc_occlusion_make(float *shade, pc_context *ctx, const pc_picture *picture, const pc_pane *pane) {
    pc_status status;
    heights h;
    const int s = picture->samples, x0 = pane->box[0] / s, y0 = pane->box[1] / s;
    const float unit = (float)picture->height / 800.0F;
    offset table[PHASES * PHASES][PAIRS];
    PC_TRY(make_heights(&h, ctx, unit, pane->box[2] / s - x0, pane->box[3] / s - y0));
    make_offsets(table, unit);
#pragma omp parallel
    {
#pragma omp for schedule(static)
        for (int y = -h.reach; y < h.height + h.reach; y++) {
            clear_row(&h, y);
            if (y >= 0 && y < h.height) take_row(&h, picture, pane, y);
        }
#pragma omp for schedule(dynamic, 8)
        for (int y = 0; y < h.height; y++)
            hollow_row(&h, table, y);
#pragma omp for schedule(dynamic, 8)
        for (int y = 0; y < h.height; y++)
            blur_row(shade + (size_t)(y0 + y) * (size_t)picture->width + (size_t)x0, &h, y);
    }
done:
    free_heights(&h, ctx);
    return status;
}
