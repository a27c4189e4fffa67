#include "stroke.h"
#include "memory.h"
#include "pick.h"
#include "tiles.h"
#include <string.h>

typedef struct screen_line { /* a stroke on the screen */
    float a[3], b[3];        /* column, row, depth */
    float half;              /* half the width, samples */
} screen_line;

typedef struct cover {
    float weight[PC_TILE][PC_TILE];
    pc_color color[PC_TILE][PC_TILE];
} cover;

static float depth_at(const pc_picture *picture, int x, int y) {
    if (x < 0 || y < 0 || x >= picture->columns || y >= picture->rows) return -INFINITY;
    return picture->depth[(size_t)y * (size_t)picture->columns + (size_t)x];
}

/* How much the drawn surface rises within one sample: the smaller step of each direction, which is that of
 * the surface and not of an edge against the background. */
static float surface_slope(const pc_picture *picture, int x, int y) {
    float d = depth_at(picture, x, y);
    float sx = pc_lesser(fabsf(depth_at(picture, x + 1, y) - d), fabsf(depth_at(picture, x - 1, y) - d));
    float sy = pc_lesser(fabsf(depth_at(picture, x, y + 1) - d), fabsf(depth_at(picture, x, y - 1) - d));
    float slope = sx + sy;
    return isfinite(slope) ? slope : 0;
}

/* Whether the line's point (x,y,depth) is not hidden. */
static int visible(const pc_picture *picture, float x, float y, float depth, float bias) {
    int i = (int)x, j = (int)y;
    float limit = depth + bias, nearest = depth_at(picture, i, j);
    if (nearest <= limit) return 1;
    return nearest <= limit + pc_lesser(surface_slope(picture, i, j), 12 * bias);
}

static void cover_line(cover *tile, const pc_picture *picture, const screen_line *l, pc_span s, int x0,
                       int y0, pc_color color, float bias) {
    float dx = l->b[0] - l->a[0], dy = l->b[1] - l->a[1], square = dx * dx + dy * dy;
    float inverse = square > 0 ? 1 / square : 0;
    for (int y = s.y0; y <= s.y1; y++)
        for (int x = s.x0; x <= s.x1; x++) {
            float px = (float)x + 0.5F - l->a[0], py = (float)y + 0.5F - l->a[1];
            float t = (px * dx + py * dy) * inverse;
            t = t < 0 ? 0 : t > 1 ? 1 : t;
            float ex = px - t * dx, ey = py - t * dy, distance2 = ex * ex + ey * ey, reach = l->half + 0.5F;
            if (distance2 >= reach * reach) continue;
            float weight = pc_lesser(1, reach - sqrtf(distance2)) * pc_lesser(1, 2 * l->half);
            if (weight <= tile->weight[y - y0][x - x0]) continue;
            float depth = l->a[2] + t * (l->b[2] - l->a[2]);
            if (!visible(picture, l->a[0] + t * dx, l->a[1] + t * dy, depth, bias)) continue;
            tile->weight[y - y0][x - x0] = weight;
            tile->color[y - y0][x - x0] = color;
        }
}

static pc_span cut_to_tile(pc_span s, int x0, int y0) {
    if (s.x0 < x0) s.x0 = (int16_t)x0;
    if (s.y0 < y0) s.y0 = (int16_t)y0;
    if (s.x1 >= x0 + PC_TILE) s.x1 = (int16_t)(x0 + PC_TILE - 1);
    if (s.y1 >= y0 + PC_TILE) s.y1 = (int16_t)(y0 + PC_TILE - 1);
    return s;
}

static void blend_tile(pc_picture *picture, const cover *tile, int x0, int y0) {
    for (int y = 0; y < PC_TILE && y0 + y < picture->rows; y++)
        for (int x = 0; x < PC_TILE && x0 + x < picture->columns; x++) {
            float w = tile->weight[y][x];
            if (!(w > 0)) continue;
            pc_color *c = picture->color + (size_t)(y0 + y) * (size_t)picture->columns + (size_t)(x0 + x);
            *c = pc_color_mix(*c, tile->color[y][x], w);
        }
}

static pc_span line_span(const screen_line *l, const int box[4]) {
    pc_span span;
    float r = l->half + 0.5F;
    if (!isfinite(l->a[2] + l->b[2])) return PC_SPAN_NONE;
    pc_span_cut(&span.x0, &span.x1, pc_lesser(l->a[0], l->b[0]) - r, pc_greater(l->a[0], l->b[0]) + r, box[0],
                box[2]);
    pc_span_cut(&span.y0, &span.y1, pc_lesser(l->a[1], l->b[1]) - r, pc_greater(l->a[1], l->b[1]) + r, box[1],
                box[3]);
    return span;
}

/* Draws lines that are already on the screen, within their spans. */
static pc_status draw_lines(pc_picture *picture, pc_context *ctx, const screen_line *line,
                            const pc_span *span, const pc_stroke *stroke, size_t count, float lift) {
    pc_tiles tiles = {0};
    pc_status status = pc_tiles_make(&tiles, ctx, picture->columns, picture->rows, span, count);
    if (status != PC_OK) return status;
#pragma omp parallel for schedule(dynamic, 4)
    for (size_t t = 0; t < (size_t)tiles.columns * (size_t)tiles.rows; t++) {
        int x0 = (int)(t % (size_t)tiles.columns) * PC_TILE, y0 = (int)(t / (size_t)tiles.columns) * PC_TILE;
        if (tiles.start[t] == tiles.start[t + 1]) continue;
        cover tile;
        memset(tile.weight, 0, sizeof(tile.weight));
        for (size_t k = tiles.start[t]; k < tiles.start[t + 1]; k++) {
            pc_index i = tiles.item[k];
            cover_line(&tile, picture, &line[i], cut_to_tile(span[i], x0, y0), x0, y0, stroke[i].color, lift);
        }
        blend_tile(picture, &tile, x0, y0);
    }
    pc_tiles_free(&tiles, ctx);
    return PC_OK;
}

/* 0 where the line is seen from behind, 1 where it is seen well, between in grazing views: fields and lines
 * would turn the rim of a model black otherwise. */
static float presence(const pc_camera *c, const pc_stroke *stroke) {
    pc_vec3 n = {stroke->normal[0], stroke->normal[1], stroke->normal[2]};
    pc_vec3 p = pc_sub(pc_vec3_at(stroke->from, 0), c->centre);
    double facing = pc_dot(n, pc_unit(pc_sub(pc_scale(c->distance, c->back), p)));
    if (pc_dot(n, n) < 0.5) return 1;
    return facing <= 0 ? 0 : facing >= 0.18 ? 1 : (float)(facing / 0.18);
}

/* On one pane, or, where `pane` is NULL, flat on the picture. */
static pc_status draw_strokes(pc_picture *picture, pc_context *ctx, const pc_pane *pane,
                              const pc_stroke *stroke, size_t count, double bias) {
    pc_status status;
    screen_line *line = NULL;
    pc_span *span = NULL;
    const int whole[4] = {0, 0, picture->columns, picture->rows};
    float s = (float)picture->samples;
    PC_TRY(pc_new(&line, ctx, count));
    PC_TRY(pc_new(&span, ctx, count));
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < count; i++) {
        screen_line *l = &line[i];
        l->half = 0.5F * stroke[i].width * s;
        if (pane) {
            pc_camera_project(l->a, &pane->camera, pc_vec3_at(stroke[i].from, 0));
            pc_camera_project(l->b, &pane->camera, pc_vec3_at(stroke[i].to, 0));
        } else {
            l->a[0] = (float)stroke[i].from[0] * s, l->a[1] = (float)stroke[i].from[1] * s;
            l->b[0] = (float)stroke[i].to[0] * s, l->b[1] = (float)stroke[i].to[1] * s;
        }
        if (pane) l->half *= presence(&pane->camera, &stroke[i]);
        span[i] = l->half > 0 ? line_span(l, pane ? pane->box : whole) : PC_SPAN_NONE;
    }
    float lift = pane ? (float)(bias / pane->camera.distance) : INFINITY;
    PC_TRY(draw_lines(picture, ctx, line, span, stroke, count, lift));
done:
    pc_free(ctx, span);
    pc_free(ctx, line);
    return status;
}

pc_status pc_stroke_draw(pc_picture *picture, pc_context *ctx, const pc_stroke *stroke, size_t count,
                         double bias) {
    pc_status status = PC_OK;
    for (int k = 0; k < picture->pane_count && status == PC_OK; k++)
        status = draw_strokes(picture, ctx, &picture->pane[k], stroke, count, bias);
    return status;
}

pc_status pc_stroke_draw_flat(pc_picture *picture, pc_context *ctx, const pc_stroke *stroke, size_t count) {
    return draw_strokes(picture, ctx, NULL, stroke, count, 0);
}

typedef struct disk { /* a ball on the screen */
    float centre[3];  /* column, row, depth */
    float radius;     /* samples */
    float bulge;      /* depth of its nearest point over that of its centre */
} disk;

static pc_color ball_color(pc_color base, float x, float y, float z) {
    float light = 0.62F + 0.38F * pc_greater(0, -0.5F * x - 0.6F * y + 0.62F * z);
    float gloss = pc_greater(0, -0.33F * x - 0.40F * y + 0.86F * z);
    gloss *= gloss, gloss *= gloss, gloss *= gloss, gloss *= gloss;
    pc_color c = pc_color_mix(0x101010, base, light * (0.55F + 0.45F * z));
    return pc_color_mix(c, 0xffffff, 0.55F * gloss * gloss);
}

static void draw_disk(pc_picture *picture, const disk *d, pc_span s, pc_color color) {
    for (int y = s.y0; y <= s.y1; y++)
        for (int x = s.x0; x <= s.x1; x++) {
            float nx = ((float)x + 0.5F - d->centre[0]) / d->radius;
            float ny = ((float)y + 0.5F - d->centre[1]) / d->radius, square = nx * nx + ny * ny;
            if (square >= 1) continue;
            float nz = sqrtf(1 - square), depth = d->centre[2] + nz * d->bulge;
            size_t at = (size_t)y * (size_t)picture->columns + (size_t)x;
            if (!(depth > picture->depth[at])) continue;
            picture->depth[at] = depth;
            picture->color[at] = ball_color(color, nx, ny, nz);
        }
}

static pc_status draw_balls(pc_picture *picture, pc_context *ctx, const pc_pane *pane, const pc_ball *ball,
                            size_t count) {
    pc_status status;
    disk *disks = NULL;
    pc_span *span = NULL;
    pc_tiles tiles = {0};
    PC_TRY(pc_new(&disks, ctx, count));
    PC_TRY(pc_new(&span, ctx, count));
    for (size_t i = 0; i < count; i++) {
        disk *d = &disks[i];
        pc_camera_project(d->centre, &pane->camera, pc_vec3_at(ball[i].centre, 0));
        d->radius = (float)pane->camera.scale * (1 + d->centre[2]) * ball[i].radius;
        d->bulge = ball[i].radius / (float)pane->camera.distance;
        span[i] = PC_SPAN_NONE;
        if (!isfinite(d->centre[2]) || !(d->radius > 0)) continue;
        float r = d->radius;
        pc_span_cut(&span[i].x0, &span[i].x1, d->centre[0] - r, d->centre[0] + r, pane->box[0], pane->box[2]);
        pc_span_cut(&span[i].y0, &span[i].y1, d->centre[1] - r, d->centre[1] + r, pane->box[1], pane->box[3]);
    }
    PC_TRY(pc_tiles_make(&tiles, ctx, picture->columns, picture->rows, span, count));
#pragma omp parallel for schedule(dynamic, 4)
    for (size_t t = 0; t < (size_t)tiles.columns * (size_t)tiles.rows; t++) {
        int x0 = (int)(t % (size_t)tiles.columns) * PC_TILE, y0 = (int)(t / (size_t)tiles.columns) * PC_TILE;
        for (size_t k = tiles.start[t]; k < tiles.start[t + 1]; k++) {
            pc_index i = tiles.item[k];
            draw_disk(picture, &disks[i], cut_to_tile(span[i], x0, y0), ball[i].color);
        }
    }
done:
    pc_tiles_free(&tiles, ctx);
    pc_free(ctx, span);
    pc_free(ctx, disks);
    return status;
}

pc_status pc_ball_draw(pc_picture *picture, pc_context *ctx, const pc_ball *ball, size_t count) {
    pc_status status = PC_OK;
    for (int k = 0; k < picture->pane_count && status == PC_OK; k++)
        status = draw_balls(picture, ctx, &picture->pane[k], ball, count);
    return status;
}
