#include "raster.h"
#include "memory.h"
#include "pick.h"
#include "tiles.h"
#include <stdlib.h>
#include <string.h>

enum { SUB = 256 }; /* steps per sample: edges are tested in whole numbers, so that neighbours leave no gap */

void pc_raster_project(float *screen, const pc_camera *camera, const double *position, size_t count) {
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < count; i++) {
        float *s = screen + 3 * i;
        pc_camera_project(s, camera, pc_vec3_at(position, i));
        s[0] = rintf(s[0] * SUB) / SUB;
        s[1] = rintf(s[1] * SUB) / SUB;
    }
}

static float min3(float a, float b, float c) {
    return pc_lesser(a, pc_lesser(b, c));
}
static float max3(float a, float b, float c) {
    return pc_greater(a, pc_greater(b, c));
}

static pc_span triangle_span(const float *a, const float *b, const float *c, const int box[4]) {
    pc_span span;
    if (!isfinite(a[2] + b[2] + c[2])) return PC_SPAN_NONE;
    pc_span_cut(&span.x0, &span.x1, min3(a[0], b[0], c[0]), max3(a[0], b[0], c[0]), box[0], box[2]);
    pc_span_cut(&span.y0, &span.y1, min3(a[1], b[1], c[1]), max3(a[1], b[1], c[1]), box[1], box[3]);
    return span;
}

/* One tile of the picture, to be drawn in without leaving the nearest cache. Parts outside of the pane or the
 * picture are not kept. */
typedef struct canvas {
    _Alignas(16) float depth[PC_TILE][PC_TILE];
    _Alignas(16) pc_index owner[PC_TILE][PC_TILE];
    int x0, y0; /* its corner in the picture */
} canvas;

/* A triangle on the screen, counter-clockwise in columns and rows, in steps of 1/SUB sample. */
typedef struct corners {
    int x[3], y[3];
    float depth[3];
    int64_t twice; /* the area, in square steps */
} corners;

/* False where it has no area. */
static bool take_corners(corners *t, const float *a, const float *b, const float *c) {
    const float *p[3] = {a, b, c};
    for (int k = 0; k < 3; k++)
        t->x[k] = (int)(p[k][0] * SUB), t->y[k] = (int)(p[k][1] * SUB), t->depth[k] = p[k][2];
    t->twice = (int64_t)(t->x[1] - t->x[0]) * (t->y[2] - t->y[0]) -
               (int64_t)(t->y[1] - t->y[0]) * (t->x[2] - t->x[0]);
    if (t->twice >= 0) return t->twice > 0;
    const corners old = *t;
    t->x[1] = old.x[2], t->y[1] = old.y[2], t->depth[1] = old.depth[2];
    t->x[2] = old.x[1], t->y[2] = old.y[1], t->depth[2] = old.depth[1];
    t->twice = -old.twice;
    return true;
}

/* On which side of the edge from corner k the middle of sample (x,y) lies, >= 0 inside; `step`: how it
 * changes from one sample to the next, right and down. All are in SUB square steps, rounded down: as the
 * changes are whole numbers, that keeps the sign. */
static int64_t edge_value(int step[2], const corners *t, int k, int x, int y) {
    const int n = (k + 1) % 3, dx = t->x[n] - t->x[k], dy = t->y[n] - t->y[k];
    step[0] = -dy, step[1] = dx;
    return ((int64_t)dx * (y * SUB + SUB / 2 - t->y[k]) - (int64_t)dy * (x * SUB + SUB / 2 - t->x[k])) >> 8;
}

/* Depth as a plane over the screen: the value at the first corner and the changes per sample. */
static void take_plane(float plane[3], const corners *t) {
    const float inverse = (float)SUB / (float)t->twice;
    float db = t->depth[1] - t->depth[0], dc = t->depth[2] - t->depth[0];
    plane[0] = t->depth[0];
    plane[1] = (db * (float)(t->y[2] - t->y[0]) - dc * (float)(t->y[1] - t->y[0])) * inverse;
    plane[2] = (dc * (float)(t->x[1] - t->x[0]) - db * (float)(t->x[2] - t->x[0])) * inverse;
}

/* LANES samples beside each other at a time. */
enum { LANES = 4 };
typedef int32_t int_lanes __attribute__((vector_size(4 * LANES)));
typedef float float_lanes __attribute__((vector_size(4 * LANES)));

static int_lanes pick(int_lanes where, int_lanes yes, int_lanes no) {
    return (yes & where) | (no & ~where);
}

/* A triangle with all corners less than MOST_SMALL samples from the first: its edges' values fit 32 bits in
 * and around it. */
enum { MOST_SMALL = 500 };
static void draw_small(canvas *tile, const corners *t, pc_index face, pc_span s) {
    const int_lanes lane = {0, 1, 2, 3}, owner = (int_lanes){0} + (int32_t)face;
    const int x0 = s.x0 - s.x0 % LANES;
    int_lanes row[3], right[3], down[3];
    for (int k = 0; k < 3; k++) {
        int step[2];
        int32_t first = (int32_t)edge_value(step, t, k, x0, s.y0);
        row[k] = first + lane * step[0], right[k] = (int_lanes){0} + LANES * step[0];
        down[k] = (int_lanes){0} + step[1];
    }
    float plane[3], low = min3(t->depth[0], t->depth[1], t->depth[2]),
                    high = max3(t->depth[0], t->depth[1], t->depth[2]);
    take_plane(plane, t);
    const float_lanes lows = (float_lanes){0} + low, highs = (float_lanes){0} + high;
    const float_lanes across = {0.5F, 1.5F, 2.5F, 3.5F};
    for (int y = s.y0; y <= s.y1; y++) {
        int_lanes e0 = row[0], e1 = row[1], e2 = row[2];
        float_lanes line = plane[0] + plane[2] * ((float)y + 0.5F - (float)t->y[0] / SUB) +
                           plane[1] * (across - (float)t->x[0] / SUB);
        for (int x = x0; x <= s.x1; x += LANES) {
            const int_lanes outside = e0 | e1 | e2 | (lane + (x - s.x0)) | ((s.x1 - x) - lane);
            float_lanes *depth = (float_lanes *)&tile->depth[y - tile->y0][x - tile->x0];
            int_lanes *owners = (int_lanes *)&tile->owner[y - tile->y0][x - tile->x0];
            float_lanes d = line + plane[1] * (float)x;
            d = (float_lanes)pick(d > lows, (int_lanes)d, (int_lanes)lows);
            d = (float_lanes)pick(d < highs, (int_lanes)d, (int_lanes)highs);
            const int_lanes seen = (outside >= 0) & (d > *depth);
            *depth = (float_lanes)pick(seen, (int_lanes)d, (int_lanes)*depth);
            *owners = pick(seen, owner, *owners);
            e0 += right[0], e1 += right[1], e2 += right[2];
        }
        row[0] += down[0], row[1] += down[1], row[2] += down[2];
    }
}

static void draw_large(canvas *tile, const corners *t, pc_index face, pc_span s) {
    float plane[3], low = min3(t->depth[0], t->depth[1], t->depth[2]),
                    high = max3(t->depth[0], t->depth[1], t->depth[2]);
    take_plane(plane, t);
    for (int y = s.y0; y <= s.y1; y++) {
        int step[3][2];
        int64_t e[3];
        for (int k = 0; k < 3; k++)
            e[k] = edge_value(step[k], t, k, s.x0, y);
        for (int x = s.x0; x <= s.x1; x++) {
            float *depth = &tile->depth[y - tile->y0][x - tile->x0];
            float d = plane[0] + plane[1] * ((float)x + 0.5F - (float)t->x[0] / SUB) +
                      plane[2] * ((float)y + 0.5F - (float)t->y[0] / SUB);
            d = pc_lesser(pc_greater(d, low), high);
            if ((e[0] | e[1] | e[2]) >= 0 && d > *depth)
                *depth = d, tile->owner[y - tile->y0][x - tile->x0] = face;
            e[0] += step[0][0], e[1] += step[1][0], e[2] += step[2][0];
        }
    }
}

static void draw_triangle(canvas *tile, const float *a, const float *b, const float *c, pc_index face,
                          pc_span s) {
    corners t;
    if (!take_corners(&t, a, b, c)) return;
    const int most = MOST_SMALL * SUB;
    bool small = true;
    for (int k = 0; k < 3; k++)
        small = small && abs(t.x[k] - t.x[0]) < most && abs(t.y[k] - t.y[0]) < most;
    if (small)
        draw_small(tile, &t, face, s);
    else
        draw_large(tile, &t, face, s);
}

/* The part of a tile that lies in the pane. */
static pc_span visible_part(const canvas *tile, const int box[4]) {
    const int x1 = tile->x0 + PC_TILE < box[2] ? tile->x0 + PC_TILE : box[2];
    const int y1 = tile->y0 + PC_TILE < box[3] ? tile->y0 + PC_TILE : box[3];
    return (pc_span){(int16_t)(tile->x0 > box[0] ? tile->x0 : box[0]),
                     (int16_t)(tile->y0 > box[1] ? tile->y0 : box[1]), (int16_t)(x1 - 1), (int16_t)(y1 - 1)};
}

typedef struct scene {
    const float *screen;
    const pc_index *triangle;
    const pc_span *span;
} scene;

static void draw_tile(pc_picture *picture, pc_index *owner, const pc_tiles *tiles, size_t t,
                      const scene *what, const int box[4]) {
    canvas tile;
    tile.x0 = (int)(t % (size_t)tiles->columns) * PC_TILE;
    tile.y0 = (int)(t / (size_t)tiles->columns) * PC_TILE;
    const pc_span part = visible_part(&tile, box);
    if (part.x1 < part.x0 || part.y1 < part.y0) return;
    const size_t width = (size_t)part.x1 - (size_t)part.x0 + 1;
    const bool empty = tiles->start[t] == tiles->start[t + 1];
    memset(tile.owner, 0xff, sizeof(tile.owner)); /* PC_NONE */
    memset(tile.depth, 0, sizeof(tile.depth));
    for (int y = part.y0; y <= part.y1 && !empty; y++)
        memcpy(&tile.depth[y - tile.y0][part.x0 - tile.x0],
               picture->depth + (size_t)y * (size_t)picture->columns + (size_t)part.x0,
               width * sizeof(float));
    for (size_t k = tiles->start[t]; k < tiles->start[t + 1]; k++) {
        pc_index f = tiles->item[k];
        pc_span s = what->span[f];
        if (s.x0 < part.x0) s.x0 = part.x0;
        if (s.y0 < part.y0) s.y0 = part.y0;
        if (s.x1 > part.x1) s.x1 = part.x1;
        if (s.y1 > part.y1) s.y1 = part.y1;
        const pc_index *v = what->triangle + 3 * (size_t)f;
        draw_triangle(&tile, what->screen + 3 * (size_t)v[0], what->screen + 3 * (size_t)v[1],
                      what->screen + 3 * (size_t)v[2], f, s);
    }
    for (int y = part.y0; y <= part.y1; y++) {
        const size_t at = (size_t)y * (size_t)picture->columns + (size_t)part.x0;
        memcpy(owner + at, &tile.owner[y - tile.y0][part.x0 - tile.x0], width * sizeof(pc_index));
        if (!empty)
            memcpy(picture->depth + at, &tile.depth[y - tile.y0][part.x0 - tile.x0], width * sizeof(float));
    }
}

pc_status pc_raster_triangles(pc_picture *picture, pc_context *ctx, pc_index *owner, const pc_pane *pane,
                              const float *screen, const pc_index *triangle, size_t face_count) {
    pc_status status;
    pc_span *span = NULL;
    pc_tiles tiles = {0};
    PC_TRY(pc_new(&span, ctx, face_count));
#pragma omp parallel for schedule(static)
    for (size_t f = 0; f < face_count; f++) {
        const pc_index *v = triangle + 3 * f;
        span[f] = triangle_span(screen + 3 * (size_t)v[0], screen + 3 * (size_t)v[1],
                                screen + 3 * (size_t)v[2], pane->box);
    }
    PC_TRY(pc_tiles_make(&tiles, ctx, picture->columns, picture->rows, span, face_count));
    const scene what = {screen, triangle, span};
    /* No tile reads what another writes, so who draws it when does not matter. */
#pragma omp parallel for schedule(dynamic, 4)
    for (size_t t = 0; t < (size_t)tiles.columns * (size_t)tiles.rows; t++)
        draw_tile(picture, owner, &tiles, t, &what, pane->box);
done:
    pc_tiles_free(&tiles, ctx);
    pc_free(ctx, span);
    return status;
}
