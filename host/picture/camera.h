/* Where a picture is seen from: a mild perspective, framed on a cloud of points. */
#ifndef PC_CAMERA_H
#define PC_CAMERA_H

#include "context.h"
#include "vec3.h"

typedef enum pc_view {
    PC_VIEW_PAIR, /* front iso and back iso side by side: nothing stays unseen but deep cavities */
    PC_VIEW_ISO,  /* three quarters from the front, right and above */
    PC_VIEW_BACK_ISO,
    PC_VIEW_FRONT,
    PC_VIEW_BACK,
    PC_VIEW_LEFT,
    PC_VIEW_RIGHT,
    PC_VIEW_TOP,
    PC_VIEW_BOTTOM
} pc_view;

typedef enum pc_up { PC_UP_AUTO, PC_UP_X, PC_UP_Y, PC_UP_Z } pc_up;

typedef struct pc_camera {
    pc_vec3 centre;          /* what is looked at */
    pc_vec3 right, up, back; /* orthonormal; `back` points to the viewer */
    double distance;         /* of the eye from the centre, model units */
    double scale;            /* samples per model unit at the centre */
    double column, row;      /* where the centre falls, in samples from the upper left corner */
} pc_camera;

/* The view of a name: pair iso back-iso front back left right top bottom. PC_E_USAGE lists them. */
pc_status pc_view_parse(pc_view *view, pc_context *ctx, const char *name);

/* The axis of the model that most likely points up, and the one that most likely points to the viewer; a
 * scan's file does not say. Never fails: y up and z to the viewer where nothing speaks for another choice. */
void pc_camera_guess(pc_vec3 *up, pc_vec3 *front, const double *position, size_t count, pc_up wish);

/* Looks from `view` (not PC_VIEW_PAIR) with the axes given. Not framed yet. */
void pc_camera_make(pc_camera *camera, pc_view view, pc_vec3 up, pc_vec3 front, const double *position,
                    size_t count);
/* Scales and shifts so that all points fit the box of samples [x0,x1) x [y0,y1) with a margin; returns the
 * scale. Points that are not finite are passed over. */
double pc_camera_frame(pc_camera *camera, const double *position, size_t count, const int box[4]);

/* column, row (samples) and depth (view z / distance from the eye: linear on the screen, larger is nearer) of
 * a point. depth is NaN where the point cannot be drawn. */
static inline void pc_camera_project(float out[3], const pc_camera *c, pc_vec3 p) {
    pc_vec3 d = pc_sub(p, c->centre);
    double z = pc_dot(d, c->back), w = c->distance - z;
    double s = c->scale * c->distance / w;
    double x = c->column + s * pc_dot(d, c->right), y = c->row - s * pc_dot(d, c->up);
    int fine = w > 0.05 * c->distance && fabs(x) < 1e5 && fabs(y) < 1e5;
    out[0] = fine ? (float)x : 0, out[1] = fine ? (float)y : 0, out[2] = fine ? (float)(z / w) : NAN;
}

/* View z (model units, towards the viewer) of a depth. */
static inline float pc_camera_view_z(const pc_camera *c, float depth) {
    return (float)c->distance * depth / (1 + depth);
}

#endif
