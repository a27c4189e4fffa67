#include "scene_spline.h"
#include "lettering.h"
#include "memory.h"
#include "stroke.h"
#include "surface.h"
#include "tessellation.h"
#include <stdio.h>

static const double grain = 2.5; /* pixels between the points of surfaces and lines */
enum { LINE_MOST = 64 };

static double pixel_length(const pc_picture *picture) {
    return pc_picture_pixel_length(picture, pc_picture_unit(picture));
}

static pc_status tessellate(pc_tessellation *t, pc_surface *surface, pc_context *ctx,
                            const pc_picture *picture, const pc_tspline *spline) {
    pc_status status = pc_tessellation_make(t, ctx, spline, pc_picture_pixel_length(picture, grain));
    *surface = pc_surface_of(t->position, t->vertex_count, t->triangle, t->face_count);
    surface->normal = t->normal;
    return status;
}

/* An edge of the T-mesh that is drawn once: by the half-edge of lower number, or the one that has a face. */
static bool is_drawn(const pc_tmesh *mesh, pc_index h) {
    pc_index face = mesh->half[h].face, beyond = mesh->half[mesh->half[h].twin].face;
    if (face == PC_NONE || mesh->face[face].ghost) return false;
    return beyond == PC_NONE || mesh->face[beyond].ghost || h < mesh->half[h].twin;
}

static pc_surface_point point_on(const pc_tspline *spline, pc_index h, double part) {
    double at[2], to[2];
    const pc_tmesh *mesh = &spline->mesh;
    const pc_thalf *e = mesh->half + h;
    pc_thalf_place(at, mesh, h);
    to[0] = at[0] + (e->side == 0 ? e->interval : e->side == 2 ? -e->interval : 0);
    to[1] = at[1] + (e->side == 1 ? e->interval : e->side == 3 ? -e->interval : 0);
    return pc_tspline_evaluate(spline, pc_tspline_place(spline, e->face, at[0] + part * (to[0] - at[0]),
                                                        at[1] + part * (to[1] - at[1])));
}

static double edge_length(const pc_tspline *spline, pc_index h) {
    double sum = 0;
    pc_vec3 last = point_on(spline, h, 0).p;
    for (int k = 1; k <= 4; k++) {
        pc_vec3 p = point_on(spline, h, 0.25 * k).p;
        sum += pc_distance(last, p);
        last = p;
    }
    return sum;
}

static int pieces(double length, double spacing) {
    double n = ceil(length / spacing);
    return n >= LINE_MOST ? LINE_MOST : n > 1 ? (int)n : 1;
}

static void put_line(pc_stroke *stroke, const pc_tspline *spline, pc_index h, int n, float width) {
    pc_surface_point last = point_on(spline, h, 0);
    for (int k = 1; k <= n; k++) {
        pc_surface_point next = point_on(spline, h, (double)k / n);
        pc_vec3 normal =
            pc_unit(pc_add(pc_unit(pc_cross(last.s, last.t)), pc_unit(pc_cross(next.s, next.t))));
        pc_stroke *s = stroke + k - 1;
        *s = (pc_stroke){.color = 0x1e3346, .width = width};
        s->normal[0] = (float)normal.x, s->normal[1] = (float)normal.y, s->normal[2] = (float)normal.z;
        pc_vec3_put(s->from, 0, last.p);
        pc_vec3_put(s->to, 0, next.p);
        last = next;
    }
}

/* The same lines for who sees the back of an open surface. */
static void put_backs(pc_stroke *stroke, size_t count) {
    for (size_t i = 0; i < count; i++) {
        stroke[count + i] = stroke[i];
        for (int k = 0; k < 3; k++)
            stroke[count + i].normal[k] = -stroke[i].normal[k];
    }
}

static pc_status draw_lines(pc_picture *picture, pc_context *ctx, const pc_tspline *spline,
                            const double *length, double mean) {
    pc_status status = PC_OK;
    pc_stroke *stroke = NULL;
    const pc_tmesh *mesh = &spline->mesh;
    double pixel = pixel_length(picture), spacing = pc_picture_pixel_length(picture, grain);
    float width = (float)(fmin(1.4, fmax(0.25, 0.1 * mean / pixel)) * pc_picture_unit(picture));
    size_t count = 0;
    bool open = false;
    for (pc_index h = 0; h < mesh->half_count; h++) {
        if (is_drawn(mesh, h)) count += (size_t)pieces(length[h], spacing);
        open = open || mesh->half[h].face == PC_NONE;
    }
    PC_TRY(pc_new(&stroke, ctx, open ? 2 * count : count));
    count = 0;
    for (pc_index h = 0; h < mesh->half_count; h++) {
        if (!is_drawn(mesh, h)) continue;
        int n = pieces(length[h], spacing);
        put_line(stroke + count, spline, h, n, width);
        count += (size_t)n;
    }
    if (open) put_backs(stroke, count);
    PC_TRY(pc_stroke_draw(picture, ctx, stroke, open ? 2 * count : count, 0.25 * pixel));
done:
    pc_free(ctx, stroke);
    return status;
}

static pc_index valence_of(const pc_tmesh *mesh, pc_index v) {
    pc_index h = mesh->vertex[v].out, first = h, valence = 0;
    do {
        valence++;
        h = pc_thalf_ccw(mesh, h);
    } while (h != first);
    return valence;
}

/* A half-edge of the surface that leaves v straight ahead into no face's corner: v is a T-junction. */
static bool is_junction(const pc_tmesh *mesh, pc_index h) {
    return mesh->half[h].face != PC_NONE && !mesh->face[mesh->half[h].face].ghost && !pc_thalf_turns(mesh, h);
}

static pc_color marker_color(const pc_tmesh *mesh, pc_index v) {
    if (!mesh->vertex[v].extraordinary) return 0xe8912a;
    pc_index valence = valence_of(mesh, v);
    return valence == 3 ? 0xd62f3c : valence == 5 ? 0x2166c4 : 0x7a3fa8;
}

static pc_status draw_markers(pc_picture *picture, pc_context *ctx, const pc_tspline *spline, double mean) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &spline->mesh;
    pc_ball *ball = NULL;
    uint8_t *seen = NULL;
    size_t count = 0;
    double pixel = pixel_length(picture);
    float radius = (float)fmin(6 * pixel, fmax(1.7 * pixel, 0.2 * mean));
    PC_TRY(pc_new(&seen, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&ball, ctx, mesh->vertex_count));
    for (pc_index h = 0; h < mesh->half_count; h++) {
        const pc_thalf *e = mesh->half + h;
        bool extraordinary = mesh->vertex[e->tail].extraordinary;
        if (e->face == PC_NONE || mesh->face[e->face].ghost || seen[e->tail]) continue;
        if (!extraordinary && !is_junction(mesh, h)) continue;
        seen[e->tail] = 1;
        pc_ball *b = ball + count++;
        pc_vec3_put(b->centre, 0, point_on(spline, h, 0).p);
        b->radius = extraordinary ? radius : 0.6F * radius;
        b->color = marker_color(mesh, e->tail);
    }
    PC_TRY(pc_ball_draw(picture, ctx, ball, count));
done:
    pc_free(ctx, seen);
    pc_free(ctx, ball);
    return status;
}

static pc_status measure_lines(double **length, double *mean, pc_context *ctx, const pc_tspline *spline) {
    const pc_tmesh *mesh = &spline->mesh;
    size_t count = 0;
    pc_status status = pc_new(length, ctx, mesh->half_count);
    if (status != PC_OK) return status;
    *mean = 0;
#pragma omp parallel for schedule(static)
    for (pc_index h = 0; h < mesh->half_count; h++)
        if (is_drawn(mesh, h)) (*length)[h] = edge_length(spline, h);
    for (pc_index h = 0; h < mesh->half_count; h++)
        if (is_drawn(mesh, h)) *mean += (*length)[h], count++;
    if (count) *mean /= (double)count;
    return PC_OK;
}

pc_status pc_scene_spline(pc_picture *picture, pc_context *ctx, const pc_tspline *spline) {
    pc_status status = PC_OK;
    pc_tessellation t = {0};
    pc_surface surface;
    double *length = NULL, mean;
    PC_TRY(tessellate(&t, &surface, ctx, picture, spline));
    surface.cavity = 0.7F;
    PC_TRY(pc_surface_draw(picture, ctx, &surface));
    pc_tessellation_free(&t, ctx);
    PC_TRY(measure_lines(&length, &mean, ctx, spline));
    PC_TRY(draw_lines(picture, ctx, spline, length, mean));
    PC_TRY(draw_markers(picture, ctx, spline, mean));
done:
    pc_tessellation_free(&t, ctx);
    pc_free(ctx, length);
    return status;
}

pc_status pc_scene_zebra(pc_picture *picture, pc_context *ctx, const pc_tspline *spline) {
    pc_status status = PC_OK;
    pc_tessellation t = {0};
    pc_surface surface;
    PC_TRY(tessellate(&t, &surface, ctx, picture, spline));
    surface.stripes = 9, surface.cavity = 0.35F, surface.even = 0.8F;
    PC_TRY(pc_surface_draw(picture, ctx, &surface));
done:
    pc_tessellation_free(&t, ctx);
    return status;
}

static pc_color ramp(const pc_color *color, int count, double t) {
    const pc_colormap map = {count, color};
    return pc_colormap_at(&map, (float)t);
}

void pc_error_colors(pc_color color[PC_ERROR_COLORS], double tolerance, double high) {
    static const pc_color inside[] = {0xf5f6f1, 0xcfe6e2, 0x93cbd0, 0x4f9dbd, 0x2a6ba3, 0x1d3f7d};
    static const pc_color outside[] = {0xf0a04b, 0xdd5a3c, 0xb32431, 0x6d0f2b};
    for (int k = 0; k < PC_ERROR_COLORS; k++) {
        double d = high * k / (PC_ERROR_COLORS - 1);
        if (!(tolerance > 0))
            color[k] = pc_colormap_at(&pc_colormap_sequential, (float)k / (PC_ERROR_COLORS - 1));
        else
            color[k] = d <= tolerance ? ramp(inside, 6, sqrt(d / tolerance))
                                      : ramp(outside, 4, (d - tolerance) / (high - tolerance));
    }
}

/* Numbers of one, two or five times a power of ten, about five of them up to `high`. */
static double round_step(double high) {
    double power = pow(10, floor(log10(high / 4))), times = high / 4 / power;
    return power * (times < 1.5 ? 1 : times < 3.5 ? 2 : times < 7.5 ? 5 : 10);
}

static pc_status draw_legend(pc_picture *picture, pc_context *ctx, const pc_colormap *map,
                             const pc_errors *errors, double tolerance) {
    const double high = errors->high;
    const bool more = errors->largest > high;
    pc_tick tick[12];
    int count = 0;
    double step = round_step(high);
    for (int k = 0; k < 10 && k * step <= high * (more ? 0.9 : 1);
         k++) /* none under the mark of the tolerance */
        if (!(tolerance > 0) || k * step > tolerance + 0.03 * high || k * step < tolerance - 0.09 * high)
            tick[count++] = (pc_tick){k * step, NULL};
    if (tolerance > 0) tick[count++] = (pc_tick){tolerance, "tolerance"};
    if (more) tick[count++] = (pc_tick){high, "and more"};
    return pc_legend_draw_ticks(picture, ctx, map, high, "distance to the scan", tick, count);
}

pc_status pc_scene_errors(pc_picture *picture, pc_context *ctx, const pc_tspline *spline,
                          const pc_errors *errors, double tolerance) {
    pc_status status = PC_OK;
    pc_tessellation t = {0};
    pc_surface surface;
    float *value = NULL;
    pc_color color[PC_ERROR_COLORS];
    const pc_colormap map = {PC_ERROR_COLORS, color};
    pc_error_colors(color, tolerance, errors->high);
    PC_TRY(tessellate(&t, &surface, ctx, picture, spline));
    PC_TRY(pc_new(&value, ctx, t.vertex_count));
#pragma omp parallel for schedule(static)
    for (pc_index e = 0; e < spline->basis.element_count; e++) {
        const int row = t.cells[e][0] + 1;
        for (pc_index v = t.start[e]; v < t.start[e + 1]; v++) {
            const int i = (int)(v - t.start[e]), column = i % row, line = i / row;
            value[v] = pc_errors_at(errors, e, (double)column / t.cells[e][0], (double)line / t.cells[e][1]);
        }
    }
    surface.value = value, surface.map = &map, surface.low = 0, surface.high = (float)errors->high;
    surface.cavity = 0.45F, surface.even = 0.55F;
    PC_TRY(pc_surface_draw(picture, ctx, &surface));
    PC_TRY(draw_legend(picture, ctx, &map, errors, tolerance));
done:
    pc_free(ctx, value);
    pc_tessellation_free(&t, ctx);
    return status;
}
