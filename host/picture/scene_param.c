/* Numbers per vertex, iso-lines of a parameterization, cells of a layout. */
#include "lettering.h"
#include "memory.h"
#include "scene.h"
#include "stroke.h"
#include "surface.h"
#include "transition.h"
#include "vec3.h"
#include <stdlib.h>

enum { QUANTILE_MOST = 200000, LINES_PER_FACE = 200 };

typedef struct line_list {
    pc_stroke *stroke;
    size_t count, room;
} line_list;

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* A range that a few wild values do not spoil. */
static pc_status robust_range(double *low, double *high, pc_context *ctx, const double *value, size_t count,
                              int symmetric) {
    double *sorted = NULL;
    size_t step = count / QUANTILE_MOST + 1, n = 0;
    pc_status status = pc_new(&sorted, ctx, count / step + 1);
    if (status != PC_OK) return status;
    for (size_t i = 0; i < count; i += step)
        if (isfinite(value[i])) sorted[n++] = symmetric ? fabs(value[i]) : value[i];
    qsort(sorted, n, sizeof(*sorted), compare_doubles);
    *high = n ? sorted[(size_t)((symmetric ? 0.95 : 0.99) * (double)(n - 1))] : 1;
    *low = symmetric ? -*high : n ? fmin(0, sorted[0]) : 0;
    if (!(*high > *low)) *high = *low + 1, *low -= symmetric;
    pc_free(ctx, sorted);
    return PC_OK;
}

pc_status pc_scene_values(pc_picture *picture, pc_context *ctx, const pc_mesh *mesh, const double *value,
                          const pc_colormap *map, double low, double high, const char *title) {
    pc_status status;
    float *shown = NULL;
    if (!(low < high))
        PC_TRY(robust_range(&low, &high, ctx, value, mesh->vertex_count, map == &pc_colormap_diverging));
    PC_TRY(pc_new(&shown, ctx, mesh->vertex_count));
    /* to 0..1 here, in double: the range may lie far from 0 */
    for (size_t i = 0; i < mesh->vertex_count; i++)
        shown[i] = (float)((value[i] - low) / (high - low));
    pc_surface s = pc_surface_of(mesh->position, mesh->vertex_count, mesh->triangle, mesh->face_count);
    s.value = shown, s.map = map, s.low = 0, s.high = 1, s.cavity = 0.5F, s.even = 0.45F;
    PC_TRY(pc_surface_draw(picture, ctx, &s));
    PC_TRY(pc_legend_draw(picture, ctx, map, low, high, title));
done:
    pc_free(ctx, shown);
    return status;
}

/* The corners of a closed face in the frame of its first vertex. */
static void face_coordinates(pc_point2 corner[3], const pc_mesh *mesh, const pc_param *param, size_t face) {
    for (size_t k = 0; k < 3; k++) {
        size_t v = mesh->triangle[3 * face + k];
        corner[k] = (pc_point2){param->coordinate[2 * v], param->coordinate[2 * v + 1]};
    }
    corner[1] = pc_transition_apply(pc_transition_of(param, 3 * face), corner[1]);
    corner[2] = pc_transition_apply(pc_transition_inverse(pc_transition_of(param, 3 * face + 2)), corner[2]);
}

static int64_t floor_div(int64_t a, int64_t b) {
    return a / b - (a % b != 0 && (a < 0) != (b < 0));
}

/* The line value = level across a face: from one crossed side to the other. */
static int level_line(double from[3], double to[3], const pc_mesh *mesh, size_t face, const int64_t value[3],
                      int64_t level) {
    int found = 0;
    for (int k = 0; k < 3 && found < 2; k++) {
        int n = (k + 1) % 3;
        if ((value[k] < level) == (value[n] < level)) continue;
        double t = (double)(level - value[k]) / (double)(value[n] - value[k]);
        pc_vec3 p = pc_vec3_at(mesh->position, mesh->triangle[3 * face + (size_t)k]);
        pc_vec3 q = pc_vec3_at(mesh->position, mesh->triangle[3 * face + (size_t)n]);
        pc_vec3_put(found++ ? to : from, 0, pc_madd(p, t, pc_sub(q, p)));
    }
    return found == 2;
}

static pc_status grow(line_list *list, pc_context *ctx, size_t more) {
    if (list->stroke && list->count + more <= list->room) return PC_OK;
    size_t room = 2 * (list->count + more);
    pc_status status = pc_resize(&list->stroke, ctx, room);
    if (status == PC_OK) list->room = room;
    return status;
}

/* The lines of one coordinate in a face at multiples of half a period, or of whole ones where step says so.
 */
static pc_status face_lines(line_list *list, pc_context *ctx, const pc_mesh *mesh, size_t face,
                            const int64_t value[3], int64_t step, float width) {
    int64_t low = value[0], high = value[0];
    for (int k = 1; k < 3; k++) {
        low = value[k] < low ? value[k] : low;
        high = value[k] > high ? value[k] : high;
    }
    int64_t first = floor_div(low, step) + 1, last = floor_div(high, step);
    if (last - first >= LINES_PER_FACE) return PC_OK;
    if (last < first) return PC_OK;
    pc_status status = grow(list, ctx, (size_t)(last - first + 1));
    if (status != PC_OK) return status;
    pc_vec3 a = pc_vec3_at(mesh->position, mesh->triangle[3 * face]);
    pc_vec3 n = pc_cross(pc_sub(pc_vec3_at(mesh->position, mesh->triangle[3 * face + 1]), a),
                         pc_sub(pc_vec3_at(mesh->position, mesh->triangle[3 * face + 2]), a));
    n = pc_unit(n);
    for (int64_t m = first; m <= last; m++) {
        pc_stroke *s = &list->stroke[list->count];
        s->normal[0] = (float)n.x, s->normal[1] = (float)n.y, s->normal[2] = (float)n.z;
        int whole = (m * step) % PC_PERIOD == 0;
        s->color = whole ? 0x17324d : 0x6f8ba3, s->width = whole ? width : 0.5F * width;
        list->count += (size_t)level_line(s->from, s->to, mesh, face, value, m * step);
    }
    return PC_OK;
}

static pc_status draw_isolines(pc_picture *picture, pc_context *ctx, const pc_mesh *mesh,
                               const pc_param *param) {
    pc_status status = PC_OK;
    line_list list = {0};
    double pixel = pc_picture_pixel_length(picture, pc_picture_unit(picture));
    double period = param->period_length / pixel;
    int64_t step = period > 12 ? PC_PERIOD / 2 : PC_PERIOD;
    float width = (float)fmin(1.9, fmax(0.6, 0.13 * period)) * (float)pc_picture_unit(picture);
    for (size_t f = 0; f < mesh->face_count; f++) {
        if (param->singular[f] != PC_REGULAR && param->singular[f] != PC_FLIPPED) continue;
        pc_point2 corner[3];
        face_coordinates(corner, mesh, param, f);
        for (int c = 0; c < 2; c++) {
            int64_t value[3];
            for (int k = 0; k < 3; k++)
                value[k] = c ? corner[k].t : corner[k].s;
            PC_TRY(face_lines(&list, ctx, mesh, f, value, step, width));
        }
    }
    PC_TRY(pc_stroke_draw(picture, ctx, list.stroke, list.count, 0.3 * pixel));
done:
    pc_free(ctx, list.stroke);
    return status;
}

static pc_color param_color(uint8_t singular, pc_color regular) {
    switch (singular) {
    case PC_REGULAR:
        return regular;
    case PC_DISLOCATION:
        return 0xf0a030;
    case PC_FIELD_SINGULARITY:
        return 0xe0405a;
    default:
        return 0x9a6fd0;
    }
}

pc_status pc_scene_param(pc_picture *picture, pc_context *ctx, const pc_mesh *mesh, const pc_param *param) {
    pc_status status;
    pc_color *color = NULL;
    pc_surface s = pc_surface_of(mesh->position, mesh->vertex_count, mesh->triangle, mesh->face_count);
    PC_TRY(pc_new(&color, ctx, mesh->face_count));
    for (size_t f = 0; f < mesh->face_count; f++)
        color[f] = param_color(param->singular[f], s.color);
    s.face_color = color;
    PC_TRY(pc_surface_draw(picture, ctx, &s));
    PC_TRY(draw_isolines(picture, ctx, mesh, param));
done:
    pc_free(ctx, color);
    return status;
}

static pc_status draw_arcs(pc_picture *picture, pc_context *ctx, const pc_layout *layout, double pixel) {
    pc_status status;
    line_list list = {0};
    PC_TRY(grow(&list, ctx, layout->arc_start[layout->arc_count]));
    for (size_t a = 0; a < layout->arc_count; a++)
        for (size_t k = layout->arc_start[a]; k + 1 < layout->arc_start[a + 1]; k++) {
            pc_stroke *s = &list.stroke[list.count++];
            *s = (pc_stroke){.color = 0x1e3346, .width = 1.4F * (float)pc_picture_unit(picture)};
            pc_vec3_put(s->from, 0, pc_vec3_at(layout->mesh.position, layout->arc_vertex[k]));
            pc_vec3_put(s->to, 0, pc_vec3_at(layout->mesh.position, layout->arc_vertex[k + 1]));
        }
    PC_TRY(pc_stroke_draw(picture, ctx, list.stroke, list.count, 0.3 * pixel));
done:
    pc_free(ctx, list.stroke);
    return status;
}

pc_status pc_scene_layout(pc_picture *picture, pc_context *ctx, const pc_layout *layout) {
    pc_status status;
    pc_color *color = NULL;
    pc_ball *ball = NULL;
    const pc_mesh *mesh = &layout->mesh;
    double pixel = pc_picture_pixel_length(picture, pc_picture_unit(picture));
    pc_surface s = pc_surface_of(mesh->position, mesh->vertex_count, mesh->triangle, mesh->face_count);
    PC_TRY(pc_new(&color, ctx, mesh->face_count));
    for (size_t f = 0; f < mesh->face_count; f++)
        color[f] = pc_color_pastel(layout->cell[f]);
    s.face_color = color, s.cavity = 0.7F, s.even = 0.25F;
    PC_TRY(pc_surface_draw(picture, ctx, &s));
    PC_TRY(draw_arcs(picture, ctx, layout, pixel));
    PC_TRY(pc_new(&ball, ctx, layout->node_count));
    for (size_t i = 0; i < layout->node_count; i++) {
        pc_vec3_put(ball[i].centre, 0, pc_vec3_at(mesh->position, layout->node_vertex[i]));
        ball[i].radius = (float)(1.9 * pixel), ball[i].color = 0x1e3346;
    }
    PC_TRY(pc_ball_draw(picture, ctx, ball, layout->node_count));
done:
    pc_free(ctx, color);
    pc_free(ctx, ball);
    return status;
}

pc_status pc_scene_caption(pc_picture *picture, pc_context *ctx, const char *text) {
    double size = 13 * pc_picture_unit(picture);
    return pc_lettering_draw(picture, ctx, 1.6 * size, picture->height - 1.6 * size, size, 0x2b3640, text);
}
