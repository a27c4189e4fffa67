/* A scan that surfaces are fitted to and measured against. */
#ifndef PC_SCAN_SCENE_H
#define PC_SCAN_SCENE_H

#include "device.h"
#include "synth.h"
#include "target.h"
#include "testing.h"
#include <math.h>

typedef struct scene {
    pc_mesh scan;
    pc_adjacency adjacency;
    pc_target target;
    pc_device *host;
} scene;

/* Where the scan is there already. */
static inline void open_scene(scene *s, pc_context *ctx) {
    assert_ok(ctx, pc_adjacency_make(&s->adjacency, ctx, &s->scan));
    assert_ok(ctx, pc_target_make(&s->target, ctx, &s->scan, &s->adjacency));
    assert_ok(ctx, pc_device_open(&s->host, ctx, "host"));
}

static inline void close_scene(scene *s, pc_context *ctx) {
    pc_device_close(s->host, ctx);
    pc_target_free(&s->target, ctx);
    pc_adjacency_free(&s->adjacency, ctx);
    pc_mesh_free(&s->scan, ctx);
}

/* A square of `squares` x `squares` with a bump around (x, y) that falls to 1/e at a distance whose square is
 * `width`. */
static inline void open_bump(scene *s, pc_context *ctx, double side, pc_index squares, double x, double y,
                             double height, double width) {
    assert_ok(ctx, pc_synth_plane(&s->scan, ctx, side, side, squares, squares));
    for (pc_index v = 0; v < s->scan.vertex_count; v++) {
        double *p = s->scan.position + 3 * (size_t)v;
        p[2] = height * exp(-(pow(p[0] - x, 2) + pow(p[1] - y, 2)) / width);
    }
    open_scene(s, ctx);
}

#endif
