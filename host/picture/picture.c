#include "picture.h"
#include "memory.h"
#include <string.h>

/* Of the legend, in pixels: letters as large beside the model in pictures of any size. */
static int legend_width(int width) {
    return width > 900 ? width / 6 : 150;
}

static pc_color background(int row, int rows) {
    return pc_color_mix(0xfdfdfc, 0xebeef0, (float)row / (float)rows);
}

/* Shrinks a framed view about the middle of its pane, so that both panes show the model equally large. */
static void lower_scale(pc_pane *pane, double scale) {
    pc_camera *c = &pane->camera;
    double ratio = scale / c->scale;
    double x = 0.5 * (pane->box[0] + pane->box[2]), y = 0.5 * (pane->box[1] + pane->box[3]);
    c->column = x + ratio * (c->column - x);
    c->row = y + ratio * (c->row - y);
    c->scale = scale;
}

/* Cuts the box in two, beside each other (0) or above each other (1), and frames both; returns the scale. */
static double frame_pair(pc_pane pane[2], const double *position, size_t count, const int box[4],
                         int stacked) {
    double scale = INFINITY;
    for (int k = 0; k < 2; k++) {
        memcpy(pane[k].box, box, sizeof(pane[k].box));
        pane[k].box[k == 0 ? 2 + stacked : stacked] = (box[stacked] + box[2 + stacked]) / 2;
        scale = fmin(scale, pc_camera_frame(&pane[k].camera, position, count, pane[k].box));
    }
    for (int k = 0; k < 2; k++)
        lower_scale(&pane[k], scale);
    return scale;
}

static void make_panes(pc_picture *picture, const double *position, size_t count,
                       const pc_picture_options *options, const int box[4]) {
    pc_vec3 up, front;
    pc_camera_guess(&up, &front, position, count, options->up);
    pc_pane *pane = picture->pane;
    if (options->view != PC_VIEW_PAIR) {
        picture->pane_count = 1;
        pc_camera_make(&pane[0].camera, options->view, up, front, position, count);
        memcpy(pane[0].box, box, sizeof(pane[0].box));
        pc_camera_frame(&pane[0].camera, position, count, box);
        return;
    }
    picture->pane_count = 2;
    pc_camera_make(&pane[0].camera, PC_VIEW_ISO, up, front, position, count);
    pc_camera_make(&pane[1].camera, PC_VIEW_BACK_ISO, up, front, position, count);
    double stacked = frame_pair(pane, position, count, box, 1);
    if (frame_pair(pane, position, count, box, 0) < stacked) frame_pair(pane, position, count, box, 1);
}

pc_status pc_picture_make(pc_picture *picture, pc_context *ctx, const double *position, size_t count,
                          const pc_picture_options *options) {
    *picture = (pc_picture){0};
    if (options->width < 16 || options->width > 16000 || options->height < 16 || options->height > 16000 ||
        options->samples < 1 || options->samples > 4 ||
        options->samples * (options->width > options->height ? options->width : options->height) > 32000)
        return pc_fail(ctx, PC_E_USAGE,
                       "a picture of %d x %d pixels with %d x %d samples each: 16 to 16000 pixels "
                       "and 1 to 4 samples, their product at most 32000, can be drawn",
                       options->width, options->height, options->samples, options->samples);
    int s = options->samples;
    picture->width = options->width, picture->height = options->height, picture->samples = s;
    picture->columns = s * options->width, picture->rows = s * options->height;
    const int wish = legend_width(options->width);
    int legend = options->legend && options->width > 3 * wish ? wish : 0;
    int free_box[4] = {options->width - legend, 0, options->width, options->height};
    memcpy(picture->legend_box, free_box, sizeof(free_box));
    int box[4] = {0, 0, s * (options->width - legend), picture->rows};
    make_panes(picture, position, count, options, box);

    pc_status status;
    size_t total = (size_t)picture->columns * (size_t)picture->rows;
    PC_TRY(pc_new(&picture->depth, ctx, total));
    PC_TRY(pc_new(&picture->color, ctx, total));
#pragma omp parallel for schedule(static)
    for (int y = 0; y < picture->rows; y++) {
        pc_color color = background(y, picture->rows);
        for (int x = 0; x < picture->columns; x++) {
            size_t i = (size_t)y * (size_t)picture->columns + (size_t)x;
            picture->depth[i] = -INFINITY;
            picture->color[i] = color;
        }
    }
done:
    if (status != PC_OK) pc_picture_free(picture, ctx);
    return status;
}

void pc_picture_free(pc_picture *picture, pc_context *ctx) {
    pc_free(ctx, picture->depth);
    pc_free(ctx, picture->color);
    *picture = (pc_picture){0};
}

/* Three channels in one number, 21 bits each, so that they are added at once. */
static uint64_t spread(pc_color c) {
    return (c & 0xff) | (uint64_t)(c & 0xff00) << 13 | (uint64_t)(c & 0xff0000) << 26;
}

static int clamp(int value, int end) {
    return value < 0 ? 0 : value < end ? value : end - 1;
}

/* A pixel is the average of its samples and, at a third of the weight, of those just around it: edges get
 * smoother than the samples inside alone could make them. */
static void mix_pixel(uint8_t out[3], const pc_picture *picture, int x, int y) {
    static const unsigned weight[][6] = {{3}, {1, 3, 3, 1}, {1, 3, 3, 3, 1}, {1, 3, 3, 3, 3, 1}};
    int s = picture->samples, rim = s > 1, n = s + 2 * rim;
    const unsigned *w = weight[s - 1];
    unsigned side = (unsigned)(3 * s + 2 * rim), total = side * side;
    uint64_t sum = 0;
    for (int j = 0; j < n; j++) {
        const pc_color *row =
            picture->color + (size_t)clamp(y * s - rim + j, picture->rows) * (size_t)picture->columns;
        uint64_t part = 0;
        for (int i = 0; i < n; i++)
            part += w[i] * spread(row[clamp(x * s - rim + i, picture->columns)]);
        sum += w[j] * part;
    }
    for (int k = 0; k < 3; k++)
        out[k] = (uint8_t)(((sum >> (42 - 21 * k) & 0x1fffff) + total / 2) / total);
}

pc_status pc_picture_pixels(uint8_t **pixels, pc_context *ctx, const pc_picture *picture) {
    pc_status status = pc_new(pixels, ctx, 3 * (size_t)picture->width * (size_t)picture->height);
    if (status != PC_OK) return status;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < picture->height; y++)
        for (int x = 0; x < picture->width; x++)
            mix_pixel(*pixels + 3 * ((size_t)y * (size_t)picture->width + (size_t)x), picture, x, y);
    return PC_OK;
}

/* How much of the old pixel k lies in new pixel x, in parts of which an old pixel has `to`. */
static int share_of(int k, int x, int from, int to) {
    int low = k * to > x * from ? k * to : x * from;
    int high = (k + 1) * to < (x + 1) * from ? (k + 1) * to : (x + 1) * from;
    return high - low;
}

static void shrink_pixel(uint8_t out[3], const uint8_t *pixels, const int from[2], const int to[2], int x,
                         int y) {
    uint64_t sum[3] = {0, 0, 0}, total = (uint64_t)from[0] * (uint64_t)from[1];
    for (int j = y * from[1] / to[1]; j * to[1] < (y + 1) * from[1]; j++)
        for (int i = x * from[0] / to[0]; i * to[0] < (x + 1) * from[0]; i++) {
            uint64_t weight =
                (uint64_t)share_of(i, x, from[0], to[0]) * (uint64_t)share_of(j, y, from[1], to[1]);
            const uint8_t *pixel = pixels + 3 * ((size_t)j * (size_t)from[0] + (size_t)i);
            for (int k = 0; k < 3; k++)
                sum[k] += weight * pixel[k];
        }
    for (int k = 0; k < 3; k++)
        out[k] = (uint8_t)((sum[k] + total / 2) / total);
}

pc_status pc_picture_shrink(uint8_t **shrunk, pc_context *ctx, const uint8_t *pixels, int width, int height,
                            int to_width, int to_height) {
    const int from[2] = {width, height}, to[2] = {to_width, to_height};
    pc_status status = pc_new(shrunk, ctx, 3 * (size_t)to_width * (size_t)to_height);
    if (status != PC_OK) return status;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < to_height; y++)
        for (int x = 0; x < to_width; x++)
            shrink_pixel(*shrunk + 3 * ((size_t)y * (size_t)to_width + (size_t)x), pixels, from, to, x, y);
    return PC_OK;
}

double pc_picture_pixel_length(const pc_picture *picture, double pixels) {
    return pixels * picture->samples / picture->pane[0].camera.scale;
}

double pc_picture_unit(const pc_picture *picture) {
    return fmax(0.6, sqrt((double)picture->width * picture->height / (1600.0 * 1200.0)));
}
