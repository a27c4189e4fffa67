/* A picture in the making: colour and depth per sample, seen through one or two panes. */
#ifndef PC_PICTURE_H
#define PC_PICTURE_H

#include "camera.h"
#include "color.h"

typedef struct pc_picture_options {
    int width, height; /* pixels */
    int samples;       /* 1..4: samples per pixel and direction */
    pc_view view;
    pc_up up;
    int legend; /* nonzero: keep room for a legend on the right */
} pc_picture_options;
#define PC_PICTURE_DEFAULTS                                                                                  \
    ((pc_picture_options){                                                                                   \
        .width = 1600, .height = 1200, .samples = 2, .view = PC_VIEW_PAIR, .up = PC_UP_AUTO, .legend = 0})

typedef struct pc_pane {
    int box[4]; /* samples: x0 y0 x1 y1, half open */
    pc_camera camera;
} pc_pane;

typedef struct pc_picture {
    int width, height; /* pixels */
    int samples;       /* per pixel and direction */
    int columns, rows; /* samples: width*samples, height*samples */
    float *depth;      /* per sample, larger is nearer; -INFINITY where nothing is */
    pc_color *color;   /* per sample */
    pc_index *owner;   /* per sample, and */
    float *shade;      /* per pixel: room that surfaces draw with, made by the first one */
    int pane_count;    /* 1 or 2 */
    pc_pane pane[2];
    int legend_box[4]; /* pixels kept free for the legend; empty without one */
} pc_picture;

/* An empty picture whose panes are framed on `count` points (3 doubles each; not finite ones are passed
 * over). PC_E_USAGE on sizes outside 16..16000 pixels. */
pc_status pc_picture_make(pc_picture *picture, pc_context *ctx, const double *position, size_t count,
                          const pc_picture_options *options);
/* An empty picture again, with the same size and points but with or without room for a legend: cheaper than a
 * new one. */
void pc_picture_clear(pc_picture *picture, const double *position, size_t count,
                      const pc_picture_options *options);
void pc_picture_free(pc_picture *picture, pc_context *ctx);

/* The finished pixels, 3 bytes (red, green, blue) each, row by row from above; free with pc_free. */
pc_status pc_picture_pixels(uint8_t **pixels, pc_context *ctx, const pc_picture *picture);

/* Smaller pixels of finished ones, each the mean of the area that it covers: `to_width` x `to_height`,
 * neither larger than before. `*shrunk` is freed with pc_free. */
pc_status pc_picture_shrink(uint8_t **shrunk, pc_context *ctx, const uint8_t *pixels, int width, int height,
                            int to_width, int to_height);

/* How long a screen distance of `pixels` is in model units around the centre of the view. */
double pc_picture_pixel_length(const pc_picture *picture, double pixels);

/* The thickness that lines, balls and letters are measured in, in pixels: 1 at 1600 x 1200, never much less.
 */
double pc_picture_unit(const pc_picture *picture);

#endif
