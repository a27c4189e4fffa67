#include "raster.h"
#include "memory.h"
#include "pick.h"
#include "tiles.h"

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

/* Value of the line through p and q at the middle of sample (x,y), and its steps; whole numbers of 1/256^2.
 */
static int64_t edge_setup(int64_t step[2], const float *p, const float *q, int x, int y) {
    int64_t px = (int64_t)(p[0] * SUB), py = (int64_t)(p[1] * SUB);
    int64_t dx = (int64_t)(q[0] * SUB) - px, dy = (int64_t)(q[1] * SUB) - py;
    int64_t cx = (int64_t)x * SUB + SUB / 2 - px, cy = (int64_t)y * SUB + SUB / 2 - py;
    step[0] = -dy * SUB;
    step[1] = dx * SUB;
    return dx * cy - dy * cx;
}

static void draw_triangle(pc_picture *picture, pc_index *owner, const float *a, const float *b,
                          const float *c, pc_index face, pc_span s) {
    float area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if (area < 0) {
        const float *swap = b;
        b = c, c = swap, area = -area;
    }
    if (!(area > 0)) return;
    int64_t step[3][2], row[3];
    row[0] = edge_setup(step[0], b, c, s.x0, s.y0);
    row[1] = edge_setup(step[1], c, a, s.x0, s.y0);
    row[2] = edge_setup(step[2], a, b, s.x0, s.y0);
    int64_t twice = row[0] + row[1] + row[2];
    if (twice <= 0) return;
    float inverse = 1.0F / (float)twice, low = min3(a[2], b[2], c[2]), high = max3(a[2], b[2], c[2]);
    float db = b[2] - a[2], dc = c[2] - a[2];
    for (int y = s.y0; y <= s.y1; y++) {
        int64_t e0 = row[0], e1 = row[1], e2 = row[2];
        size_t line = (size_t)y * (size_t)picture->columns;
        for (int x = s.x0; x <= s.x1; x++) {
            if ((e0 | e1 | e2) >= 0) {
                float depth = a[2] + inverse * ((float)e1 * db + (float)e2 * dc);
                depth = pc_lesser(pc_greater(depth, low), high);
                if (depth > picture->depth[line + (size_t)x]) {
                    picture->depth[line + (size_t)x] = depth;
                    owner[line + (size_t)x] = face;
                }
            }
            e0 += step[0][0], e1 += step[1][0], e2 += step[2][0];
        }
        row[0] += step[0][1], row[1] += step[1][1], row[2] += step[2][1];
    }
}

static void draw_tile(pc_picture *picture, pc_index *owner, const pc_tiles *tiles, size_t t,
                      const pc_span *span, const float *screen, const pc_index *triangle) {
    int x0 = (int)(t % (size_t)tiles->columns) * PC_TILE, y0 = (int)(t / (size_t)tiles->columns) * PC_TILE;
    for (size_t k = tiles->start[t]; k < tiles->start[t + 1]; k++) {
        pc_index f = tiles->item[k];
        pc_span s = span[f];
        if (s.x0 < x0) s.x0 = (int16_t)x0;
        if (s.y0 < y0) s.y0 = (int16_t)y0;
        if (s.x1 >= x0 + PC_TILE) s.x1 = (int16_t)(x0 + PC_TILE - 1);
        if (s.y1 >= y0 + PC_TILE) s.y1 = (int16_t)(y0 + PC_TILE - 1);
        const pc_index *v = triangle + 3 * (size_t)f;
        draw_triangle(picture, owner, screen + 3 * (size_t)v[0], screen + 3 * (size_t)v[1],
                      screen + 3 * (size_t)v[2], f, s);
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
#pragma omp parallel for schedule(static)
    for (int y = pane->box[1]; y < pane->box[3]; y++)
        for (int x = pane->box[0]; x < pane->box[2]; x++)
            owner[(size_t)y * (size_t)picture->columns + (size_t)x] = PC_NONE;
            /* No tile reads what another writes, so who draws it when does not matter. */
#pragma omp parallel for schedule(dynamic, 4)
    for (size_t t = 0; t < (size_t)tiles.columns * (size_t)tiles.rows; t++)
        draw_tile(picture, owner, &tiles, t, span, screen, triangle);
done:
    pc_tiles_free(&tiles, ctx);
    pc_free(ctx, span);
    return status;
}
