#include "lettering.h"
#include "memory.h"
#include "stroke.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Letters as chains of points, two hexadecimal digits (x, y) each, chains parted by blanks; '~' begins a
 * chain whose corners are rounded. Baseline y = 4, capitals up to 12, small letters up to 9, tails down to 1.
 */
static const char *const alphabet[95] = {
    ['!' - ' '] = "0c06 0404",
    ['"' - ' '] = "0c0a 2c2a",
    ['#' - ' '] = "142c 344c 0757 1959",
    ['%' - ' '] = "045c ~0a1c2a180a ~3648564436",
    ['&' - ' '] = "~541a1b2c3b3a0706143457",
    ['\'' - ' '] = "0c0a",
    ['(' - ' '] = "~2d0a0622",
    [')' - ' '] = "~0d2a2602",
    ['*' - ' '] = "2b27 0a48 4a08",
    ['+' - ' '] = "0848 2a26",
    [',' - ' '] = "1402",
    ['-' - ' '] = "0848",
    ['.' - ' '] = "0404",
    ['/' - ' '] = "024d",
    ['0' - ' '] = "~060a2c3c5a56342406",
    ['1' - ' '] = "0a2c24",
    ['2' - ' '] = "~0a1c4c5a5804 0454",
    ['3' - ' '] = "~0b1c4c5b5928 ~285855441405",
    ['4' - ' '] = "444c0656",
    ['5' - ' '] = "5c0c08 ~0839595755441405",
    ['6' - ' '] = "~4c2b0906 ~062434565739290706",
    ['7' - ' '] = "0c5c14",
    ['8' - ' '] = "~0a1c4c5a48180a ~06184856441406",
    ['9' - ' '] = "~092737595a3c2c0a09 ~5a573514",
    [':' - ' '] = "0404 0909",
    [';' - ' '] = "1402 1919",
    ['<' - ' '] = "4a0846",
    ['=' - ' '] = "0949 0747",
    ['>' - ' '] = "0a4806",
    ['?' - ' '] = "~0a1c3c4a4926 2424",
    ['A' - ' '] = "043c64 1757",
    ['B' - ' '] = "040c ~0c4c5b594808 ~084857554404",
    ['C' - ' '] = "~5b4c2c0a06244455",
    ['D' - ' '] = "040c ~0c3c5a563404",
    ['E' - ' '] = "5c0c0454 0848",
    ['F' - ' '] = "5c0c04 0848",
    ['G' - ' '] = "~5b4c2c0a06244455 385855",
    ['H' - ' '] = "040c 545c 0858",
    ['I' - ' '] = "0c04",
    ['J' - ' '] = "~4c46241405",
    ['K' - ' '] = "040c 5c07 2954",
    ['L' - ' '] = "0c0454",
    ['M' - ' '] = "040c366c64",
    ['N' - ' '] = "040c545c",
    ['O' - ' '] = "~060a2c4c6a66442406",
    ['P' - ' '] = "040c ~0c4c5b594808",
    ['Q' - ' '] = "~060a2c4c6a66442406 4664",
    ['R' - ' '] = "040c ~0c4c5b594808 2854",
    ['S' - ' '] = "~5b4c1c0b0918485755441405",
    ['T' - ' '] = "0c6c 3c34",
    ['U' - ' '] = "~0c062434565c",
    ['V' - ' '] = "0c346c",
    ['W' - ' '] = "0c244c648c",
    ['X' - ' '] = "0c54 045c",
    ['Y' - ' '] = "0c386c 3834",
    ['Z' - ' '] = "0c5c0454",
    ['[' - ' '] = "2d0d0222",
    ['\\' - ' '] = "0d42",
    [']' - ' '] = "0d2d2202",
    ['^' - ' '] = "0a2c4a",
    ['_' - ' '] = "0252",
    ['a' - ' '] = "~060719394746341406 4944",
    ['b' - ' '] = "~060719394746341406 0c04",
    ['c' - ' '] = "~4839190706143445",
    ['d' - ' '] = "~060719394746341406 4c44",
    ['e' - ' '] = "0747 ~4739190706143445",
    ['f' - ' '] = "~3c2c1b14 0939",
    ['g' - ' '] = "~060719394746341406 ~4942311102",
    ['h' - ' '] = "0c04 ~0719394744",
    ['i' - ' '] = "0904 0b0b",
    ['j' - ' '] = "~191201 1b1b",
    ['k' - ' '] = "0c04 3906 1734",
    ['l' - ' '] = "0c04",
    ['m' - ' '] = "0904 ~0719293734 ~3749596764",
    ['n' - ' '] = "0904 ~0719394744",
    ['o' - ' '] = "~060719394746341406",
    ['p' - ' '] = "0901 ~060719394746341406",
    ['q' - ' '] = "4941 ~060719394746341406",
    ['r' - ' '] = "0904 ~071939",
    ['s' - ' '] = "~48391908173645341405",
    ['t' - ' '] = "~1b152434 0939",
    ['u' - ' '] = "~0906143446 4944",
    ['v' - ' '] = "092449",
    ['w' - ' '] = "0914395469",
    ['x' - ' '] = "0944 0449",
    ['y' - ' '] = "0924 4911",
    ['z' - ' '] = "09490444",
    ['{' - ' '] = "~2d1b1908171322",
    ['|' - ' '] = "0d02",
    ['}' - ' '] = "~0d1b1928171302",
    ['~' - ' '] = "~0819283748",
};

typedef struct chain {
    int count;
    double x[160], y[160];
} chain;

static int digit(char c) {
    return c >= 'a' ? c - 'a' + 10 : c - '0';
}

/* Reads one chain and returns what follows it. */
static const char *read_chain(chain *out, int *rounded, const char *text) {
    *rounded = *text == '~';
    if (*rounded) text++;
    for (out->count = 0; text[0] > ' ' && text[1] > ' ' && out->count < 20; text += 2) {
        out->x[out->count] = digit(text[0]);
        out->y[out->count++] = digit(text[1]);
    }
    return *text == ' ' ? text + 1 : text;
}

/* Cuts every corner at a quarter; a closed chain stays closed, an open one keeps its ends. */
static void round_corners(chain *c) {
    chain fine = {0};
    int n = c->count, closed = c->x[0] == c->x[n - 1] && c->y[0] == c->y[n - 1];
    for (int i = 0; i + 1 < n; i++)
        for (int k = 1; k < 4; k += 2) {
            fine.x[fine.count] = c->x[i] + 0.25 * k * (c->x[i + 1] - c->x[i]);
            fine.y[fine.count++] = c->y[i] + 0.25 * k * (c->y[i + 1] - c->y[i]);
        }
    if (closed) {
        fine.x[fine.count] = fine.x[0], fine.y[fine.count++] = fine.y[0];
    } else {
        fine.x[0] = c->x[0], fine.y[0] = c->y[0];
        fine.x[fine.count - 1] = c->x[n - 1], fine.y[fine.count - 1] = c->y[n - 1];
    }
    *c = fine;
}

static const char *strokes_of(char c) {
    const char *s = c > ' ' && c <= '~' ? alphabet[c - ' '] : NULL;
    return s ? s : "";
}

static double advance(char c) {
    double widest = -1;
    chain part;
    int rounded;
    for (const char *s = strokes_of(c); *s;) {
        s = read_chain(&part, &rounded, s);
        for (int i = 0; i < part.count; i++)
            widest = fmax(widest, part.x[i]);
    }
    return widest < 0 ? 4 : widest + 2.4;
}

double pc_lettering_width(const char *text, double height) {
    double sum = 0;
    for (; *text; text++)
        sum += advance(*text);
    return sum * height / 8;
}

/* The lines of one letter at (x,y), of at most 160 per chain and four chains; returns how many. */
static size_t put_letter(pc_stroke *stroke, char c, double x, double y, double height, pc_color color) {
    size_t count = 0;
    double u = height / 8;
    chain part;
    int rounded;
    for (const char *s = strokes_of(c); *s;) {
        s = read_chain(&part, &rounded, s);
        for (int pass = 0; pass < 2 && rounded && part.count > 2 && part.count < 70; pass++)
            round_corners(&part);
        for (int i = 0; i + 1 < part.count; i++) {
            pc_stroke *l = &stroke[count++];
            *l = (pc_stroke){.color = color, .width = (float)(0.135 * height)};
            l->from[0] = x + u * part.x[i], l->from[1] = y - u * (part.y[i] - 4);
            l->to[0] = x + u * part.x[i + 1], l->to[1] = y - u * (part.y[i + 1] - 4);
        }
    }
    return count;
}

pc_status pc_lettering_draw(pc_picture *picture, pc_context *ctx, double x, double y, double height,
                            pc_color color, const char *text) {
    pc_stroke *stroke = NULL;
    size_t count = 0;
    pc_status status = pc_new(&stroke, ctx, 640 * (strlen(text) + 1));
    if (status != PC_OK) return status;
    for (; *text; text++) {
        count += put_letter(stroke + count, *text, x, y, height, color);
        x += advance(*text) * height / 8;
    }
    status = pc_stroke_draw_flat(picture, ctx, stroke, count);
    pc_free(ctx, stroke);
    return status;
}

/* Zero without the noise of rounding, others in three digits. */
static void number_text(char text[32], double value, double range) {
    if (fabs(value) < 1e-9 * range) value = 0;
    (void)snprintf(text, 32, "%.3g", value);
}

static void fill_bar(pc_picture *picture, const pc_colormap *map, int x0, int y0, int x1, int y1) {
    int s = picture->samples;
    for (int y = y0 * s; y < y1 * s; y++)
        for (int x = x0 * s; x < x1 * s; x++) {
            pc_color c =
                pc_colormap_at(map, 1 - ((float)y + 0.5F - (float)(y0 * s)) / (float)((y1 - y0) * s));
            picture->color[(size_t)y * (size_t)picture->columns + (size_t)x] = c;
        }
}

/* The bar, from x[0] to x[1] and from y[1] up to y[0], in pixels. */
typedef struct bar {
    int x[2], y[2];
    double letter; /* height of capitals */
} bar;

static const pc_color legend_ink = 0x2b3640;

static bar place_bar(const pc_picture *picture) {
    const int *box = picture->legend_box;
    int width = box[2] - box[0], height = box[3] - box[1], x0 = box[0] + width / 10;
    return (bar){{x0, x0 + width / 6}, {box[1] + height / 4, box[1] + 3 * height / 4}, 11 * width / 150.0};
}

/* At `part` of the scale. */
static pc_status draw_tick(pc_picture *picture, pc_context *ctx, const bar *b, double part, double value,
                           double range, const char *word) {
    pc_status status = PC_OK;
    char text[32];
    double y = b->y[1] + part * (b->y[0] - b->y[1]), left = word ? b->x[0] - 0.4 * b->letter : b->x[1];
    const double x = b->x[1] + 0.9 * b->letter;
    pc_stroke line = {.from = {left, y, 0},
                      .to = {b->x[1] + 0.4 * b->letter, y, 0},
                      .color = legend_ink,
                      .width = (float)(b->letter * (word ? 0.17 : 0.09))};
    PC_TRY(pc_stroke_draw_flat(picture, ctx, &line, 1));
    number_text(text, value, range);
    PC_TRY(pc_lettering_draw(picture, ctx, x, y + 0.5 * b->letter, b->letter, legend_ink, text));
    if (word)
        PC_TRY(pc_lettering_draw(picture, ctx, x, y + 2 * b->letter, 0.85 * b->letter, legend_ink, word));
done:
    return status;
}

static pc_status draw_title(pc_picture *picture, pc_context *ctx, const bar *b, const char *title) {
    const int *box = picture->legend_box;
    const int width = box[2] - box[0];
    double fit =
        title[0] ? b->letter * fmin(1, 0.92 * width / pc_lettering_width(title, b->letter)) : b->letter;
    double x = fmin(b->x[0], box[2] - 0.04 * width - pc_lettering_width(title, fit));
    return pc_lettering_draw(picture, ctx, x, b->y[0] - 1.8 * b->letter, fit, legend_ink, title);
}

pc_status pc_legend_draw(pc_picture *picture, pc_context *ctx, const pc_colormap *map, double low,
                         double high, const char *title) {
    pc_status status = PC_OK;
    if (picture->legend_box[2] - picture->legend_box[0] < 60) return PC_OK;
    const bar b = place_bar(picture);
    fill_bar(picture, map, b.x[0], b.y[0], b.x[1], b.y[1]);
    for (int k = 0; k < 5; k++)
        PC_TRY(draw_tick(picture, ctx, &b, 0.25 * k, low + 0.25 * k * (high - low), high - low, NULL));
    PC_TRY(draw_title(picture, ctx, &b, title));
done:
    return status;
}

pc_status pc_legend_draw_ticks(pc_picture *picture, pc_context *ctx, const pc_colormap *map, double high,
                               const char *title, const pc_tick *tick, int count) {
    pc_status status = PC_OK;
    if (picture->legend_box[2] - picture->legend_box[0] < 60) return PC_OK;
    const bar b = place_bar(picture);
    fill_bar(picture, map, b.x[0], b.y[0], b.x[1], b.y[1]);
    for (int k = 0; k < count; k++)
        PC_TRY(draw_tick(picture, ctx, &b, tick[k].value / high, tick[k].value, high, tick[k].word));
    PC_TRY(draw_title(picture, ctx, &b, title));
    PC_TRY(pc_lettering_draw(picture, ctx, b.x[0], b.y[1] + 2.6 * b.letter, 0.85 * b.letter, legend_ink,
                             "in units of the scan"));
done:
    return status;
}
