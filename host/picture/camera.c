#include "camera.h"
#include <string.h>

static const char *const view_names[] = {"pair", "iso",   "back-iso", "front", "back",
                                         "left", "right", "top",      "bottom"};

pc_status pc_view_parse(pc_view *view, pc_context *ctx, const char *name) {
    for (int i = 0; i < (int)(sizeof(view_names) / sizeof(view_names[0])); i++)
        if (strcmp(name, view_names[i]) == 0) {
            *view = (pc_view)i;
            return PC_OK;
        }
    return pc_fail(ctx, PC_E_USAGE,
                   "unknown view '%s': pair, iso, back-iso, front, back, left, right, top, bottom", name);
}

static int finite3(const double *p) {
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

static void bounds(double low[3], double high[3], const double *position, size_t count) {
    for (int k = 0; k < 3; k++)
        low[k] = INFINITY, high[k] = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        const double *p = position + 3 * i;
        if (!finite3(p)) continue;
        for (int k = 0; k < 3; k++) {
            low[k] = p[k] < low[k] ? p[k] : low[k];
            high[k] = p[k] > high[k] ? p[k] : high[k];
        }
    }
    for (int k = 0; k < 3; k++)
        if (!(low[k] <= high[k])) low[k] = high[k] = 0;
}

/* How much more of the points lies on the model's floor than at its ceiling, in percent, were `axis` up. */
static double footing(const double *position, size_t count, int axis, double low, double high) {
    double slab = 0.004 * (high - low);
    size_t floor_count = 0, ceiling_count = 0;
    for (size_t i = 0; i < count; i++) {
        double p = position[3 * i + (size_t)axis];
        floor_count += p < low + slab;
        ceiling_count += p > high - slab;
    }
    return count ? 100 * ((double)floor_count - (double)ceiling_count) / (double)count : 0;
}

/* Scans come with y or z up. A thing stands on what is flat or, failing that, as tall as it can; y in doubt.
 */
static pc_up guess_up(const double *position, size_t count, const double low[3], const double high[3]) {
    double y = footing(position, count, 1, low[1], high[1]), z = footing(position, count, 2, low[2], high[2]);
    if (z > 0.3 + 2 * fmax(y, 0)) return PC_UP_Z;
    if (y > 0.3 + 2 * fmax(z, 0)) return PC_UP_Y;
    return high[2] - low[2] > 1.25 * fmax(high[1] - low[1], high[0] - low[0]) ? PC_UP_Z : PC_UP_Y;
}

void pc_camera_guess(pc_vec3 *up, pc_vec3 *front, const double *position, size_t count, pc_up wish) {
    double low[3], high[3], extent[3];
    bounds(low, high, position, count);
    for (int k = 0; k < 3; k++)
        extent[k] = high[k] - low[k];
    if (wish == PC_UP_AUTO) wish = guess_up(position, count, low, high);
    const pc_vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    if (wish == PC_UP_X)
        *up = x, *front = z;
    else if (wish == PC_UP_Z)
        *up = z, *front = pc_scale(-1, y);
    else
        *up = y, *front = z;
    /* The broad side to the viewer, where the front is clearly the narrow one. */
    pc_vec3 side = pc_cross(*up, *front), d = {extent[0], extent[1], extent[2]};
    if (fabs(pc_dot(d, side)) < 0.6 * fabs(pc_dot(d, *front))) *front = side;
}

void pc_camera_make(pc_camera *camera, pc_view view, pc_vec3 up, pc_vec3 front, const double *position,
                    size_t count) {
    double low[3], high[3];
    bounds(low, high, position, count);
    pc_vec3 a = {low[0], low[1], low[2]}, b = {high[0], high[1], high[2]};
    pc_vec3 side = pc_cross(up, front), top = up;
    /* right, up and front share of the direction to the viewer */
    static const double share[][3] = {{0.55, 0.42, 0.9}, {0.55, 0.42, 0.9}, {-0.55, 0.42, -0.9},
                                      {0, 0, 1},         {0, 0, -1},        {-1, 0, 0},
                                      {1, 0, 0},         {0, 1, 0},         {0, -1, 0}};
    const double *s = share[view];
    pc_vec3 toward = pc_unit(pc_add(pc_add(pc_scale(s[0], side), pc_scale(s[1], up)), pc_scale(s[2], front)));
    if (view == PC_VIEW_TOP) top = pc_scale(-1, front);
    if (view == PC_VIEW_BOTTOM) top = front;
    *camera = (pc_camera){.centre = pc_scale(0.5, pc_add(a, b)), .back = toward, .scale = 1};
    camera->right = pc_unit(pc_cross(top, toward));
    camera->up = pc_cross(toward, camera->right);
    double radius = 0.5 * pc_distance(a, b);
    camera->distance = 4.5 * (radius > 0 ? radius : 1);
}

double pc_camera_frame(pc_camera *camera, const double *position, size_t count, const int box[4]) {
    double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
    camera->scale = 1, camera->column = camera->row = 0;
    for (size_t i = 0; i < count; i++) {
        if (!finite3(position + 3 * i)) continue;
        pc_vec3 d = pc_sub(pc_vec3_at(position, i), camera->centre);
        double s = camera->distance / (camera->distance - pc_dot(d, camera->back));
        double x = s * pc_dot(d, camera->right), y = -s * pc_dot(d, camera->up);
        x0 = x < x0 ? x : x0, x1 = x > x1 ? x : x1;
        y0 = y < y0 ? y : y0, y1 = y > y1 ? y : y1;
    }
    if (!(x0 <= x1)) x0 = x1 = y0 = y1 = 0;
    const double margin = 0.93;
    double width = box[2] - box[0], height = box[3] - box[1];
    double tiny = 1e-6 * camera->distance;
    camera->scale = margin * fmin(width / fmax(x1 - x0, tiny), height / fmax(y1 - y0, tiny));
    camera->column = 0.5 * (box[0] + box[2]) - camera->scale * 0.5 * (x0 + x1);
    camera->row = 0.5 * (box[1] + box[3]) - camera->scale * 0.5 * (y0 + y1);
    return camera->scale;
}
