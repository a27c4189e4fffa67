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
    picture->width = options->width, picture->height = options->height, picture->samples = options->samples;
    picture->columns = options->samples * options->width, picture->rows = options->samples * options->height;
    const size_t total = (size_t)picture->columns * (size_t)picture->rows;
    pc_status status;
    PC_TRY(pc_new(&picture->depth, ctx, total));
    PC_TRY(pc_new(&picture->color, ctx, total));
    pc_picture_clear(picture, position, count, options);
done:
    if (status != PC_OK) pc_picture_free(picture, ctx);
    return status;
}

void pc_picture_clear(pc_picture *picture, const double *position, size_t count,
                      const pc_picture_options *options) {
    const int wish = legend_width(picture->width);
    const int legend = options->legend && picture->width > 3 * wish ? wish : 0;
    const int free_box[4] = {picture->width - legend, 0, picture->width, picture->height};
    memcpy(picture->legend_box, free_box, sizeof(free_box));
    const int box[4] = {0, 0, picture->samples * (picture->width - legend), picture->rows};
    make_panes(picture, position, count, options, box);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < picture->rows; y++) {
        pc_color color = background(y, picture->rows);
        for (int x = 0; x < picture->columns; x++) {
            size_t i = (size_t)y * (size_t)picture->columns + (size_t)x;
            picture->depth[i] = -INFINITY;
            picture->color[i] = color;
        }
    }
}

void pc_picture_free(pc_picture *picture, pc_context *ctx) {
    pc_free(ctx, picture->depth);
    pc_free(ctx, picture->color);
    pc_free(ctx, picture->owner);
    pc_free(ctx, picture->shade);
    *picture = (pc_picture){0};
}

static int clamp(int value, int end) {
    return value < 0 ? 0 : value < end ? value : end - 1;
}

/* A pixel is the average of its samples and, at a third of the weight, of those just around it: edges get
 * smoother than the samples inside alone could make them. Weights along a direction are 1 3 .. 3 1; they sum
 * to at most 14, so that two channels in one number, 16 bits each, do not run into each other. */
enum { BLOCK = 256, MOST_SAMPLES = 4 };

typedef struct mixed_rows { /* BLOCK pixels wide, one sample more at both ends */
    uint32_t red_blue[MOST_SAMPLES * BLOCK + 2], green[MOST_SAMPLES * BLOCK + 2];
} mixed_rows;

/* Weighted sums of the samples above each other: s rows inside of the pixels, and the two at their rims. */
static inline __attribute__((always_inline)) void mix_down(mixed_rows *m, const pc_color *const *row, int s,
                                                           int count) {
    const uint32_t two = 0xff00ff, one = 0xff;
    for (int x = 0; x < count; x++) {
        uint32_t a = 0, b = 0;
        for (int j = 1; j <= s; j++)
            a += row[j][x] & two, b += row[j][x] >> 8 & one;
        a *= 3, b *= 3;
        if (s > 1) a += (row[0][x] & two) + (row[s + 1][x] & two);
        if (s > 1) b += (row[0][x] >> 8 & one) + (row[s + 1][x] >> 8 & one);
        m->red_blue[x + 1] = a, m->green[x + 1] = b;
    }
}

/* The same beside each other, then the mean. */
static inline __attribute__((always_inline)) void mix_across(uint8_t *out, const mixed_rows *m, int s,
                                                             int pixels) {
    const uint32_t side = (uint32_t)(s > 1 ? 3 * s + 2 : 3), total = side * side;
    for (int x = 0; x < pixels; x++) {
        const uint32_t *two = m->red_blue + x * s, *one = m->green + x * s;
        uint32_t a = 0, b = 0;
        for (int i = 1; i <= s; i++)
            a += two[i], b += one[i];
        a *= 3, b *= 3;
        if (s > 1) a += two[0] + two[s + 1], b += one[0] + one[s + 1];
        out[3 * x] = (uint8_t)(((a >> 16) + total / 2) / total);
        out[3 * x + 1] = (uint8_t)((b + total / 2) / total);
        out[3 * x + 2] = (uint8_t)(((a & 0xffff) + total / 2) / total);
    }
}

static inline __attribute__((always_inline)) void mix_block(uint8_t *out, const pc_picture *picture, int s,
                                                            int x0, int y, int pixels) {
    const pc_color *row[MOST_SAMPLES + 2];
    mixed_rows m;
    const int first = x0 * s, count = pixels * s;
    for (int j = 0; j < s + 2; j++)
        row[j] = picture->color + (size_t)clamp(y * s - 1 + j, picture->rows) * (size_t)picture->columns +
                 (size_t)first;
    mix_down(&m, row, s, count);
    /* the samples beside the block, or the outermost ones again */
    const pc_color *end[MOST_SAMPLES + 2];
    mixed_rows rim;
    const int beside[2] = {clamp(first - 1, picture->columns), clamp(first + count, picture->columns)};
    for (int k = 0; k < 2; k++) {
        for (int j = 0; j < s + 2; j++)
            end[j] = row[j] + (beside[k] - first);
        mix_down(&rim, end, s, 1);
        m.red_blue[k ? count + 1 : 0] = rim.red_blue[1], m.green[k ? count + 1 : 0] = rim.green[1];
    }
    mix_across(out, &m, s, pixels);
}

static void mix_row(uint8_t *out, const pc_picture *picture, int y) {
    for (int x = 0; x < picture->width; x += BLOCK) {
        const int pixels = picture->width - x < BLOCK ? picture->width - x : BLOCK;
        switch (picture->samples) { /* each with its own constants */
        case 1:
            mix_block(out + 3 * (size_t)x, picture, 1, x, y, pixels);
            break;
        case 2:
            mix_block(out + 3 * (size_t)x, picture, 2, x, y, pixels);
            break;
        case 3:
            mix_block(out + 3 * (size_t)x, picture, 3, x, y, pixels);
            break;
        default:
            mix_block(out + 3 * (size_t)x, picture, 4, x, y, pixels);
        }
    }
}

pc_status pc_picture_pixels(uint8_t **pixels, pc_context *ctx, const pc_picture *picture) {
    pc_status status = pc_new(pixels, ctx, 3 * (size_t)picture->width * (size_t)picture->height);
    if (status != PC_OK) return status;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < picture->height; y++)
        mix_row(*pixels + 3 * (size_t)y * (size_t)picture->width, picture, y);
    return PC_OK;
}

/* How much of the old pixel k lies in new pixel x, in parts of which an old pixel has `to`. */
static uint32_t share_of(int k, int x, int from, int to) {
    int low = k * to > x * from ? k * to : x * from;
    int high = (k + 1) * to < (x + 1) * from ? (k + 1) * to : (x + 1) * from;
    return (uint32_t)(high - low);
}

/* The rows that new row y covers, summed by how much of each it covers; then the same along them. */
static void shrink_row(uint8_t *out, uint32_t *sum, const uint8_t *pixels, const int from[2], const int to[2],
                       int y) {
    const double part = 1 / ((double)from[0] * (double)from[1]);
    const size_t width = 3 * (size_t)from[0];
    memset(sum, 0, width * sizeof(*sum));
    for (int j = y * from[1] / to[1]; j * to[1] < (y + 1) * from[1]; j++) {
        const uint8_t *row = pixels + (size_t)j * width;
        const uint32_t weight = share_of(j, y, from[1], to[1]);
        for (size_t i = 0; i < width; i++)
            sum[i] += weight * row[i];
    }
    for (int x = 0; x < to[0]; x++) {
        uint64_t all[3] = {0, 0, 0};
        for (int i = x * from[0] / to[0]; i * to[0] < (x + 1) * from[0]; i++) {
            const uint64_t weight = share_of(i, x, from[0], to[0]);
            for (int k = 0; k < 3; k++)
                all[k] += weight * sum[3 * i + k];
        }
        for (int k = 0; k < 3; k++)
            out[3 * x + k] = (uint8_t)((double)all[k] * part + 0.5);
    }
}

pc_status pc_picture_shrink(uint8_t **shrunk, pc_context *ctx, const uint8_t *pixels, int width, int height,
                            int to_width, int to_height) {
    const int from[2] = {width, height}, to[2] = {to_width, to_height};
    enum { BLOCKS = 32 };
    uint32_t *sum = NULL;
    pc_status status;
    *shrunk = NULL;
    PC_TRY(pc_new(&sum, ctx, (size_t)BLOCKS * 3 * (size_t)width));
    PC_TRY(pc_new(shrunk, ctx, 3 * (size_t)to_width * (size_t)to_height));
#pragma omp parallel for schedule(static)
    for (int block = 0; block < BLOCKS; block++)
        for (int y = block * to_height / BLOCKS; y < (block + 1) * to_height / BLOCKS; y++)
            shrink_row(*shrunk + 3 * (size_t)y * (size_t)to_width, sum + (size_t)block * 3 * (size_t)width,
                       pixels, from, to, y);
done:
    pc_free(ctx, sum);
    return status;
}

double pc_picture_pixel_length(const pc_picture *picture, double pixels) {
    return pixels * picture->samples / picture->pane[0].camera.scale;
}

double pc_picture_unit(const pc_picture *picture) {
    return fmax(0.6, sqrt((double)picture->width * picture->height / (1600.0 * 1200.0)));
}
