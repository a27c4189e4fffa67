/* Draws triangles: hidden surfaces by depth, soft light, colours by vertex value or by face. */
#ifndef PC_SURFACE_H
#define PC_SURFACE_H

#include "colormap.h"
#include "picture.h"

typedef struct pc_surface {
    pc_index vertex_count, face_count;
    const double *position;     /* 3 per vertex */
    const pc_index *triangle;   /* 3 per face */
    const float *normal;        /* 3 per vertex, or NULL: computed from the triangles */
    const pc_color *face_color; /* per face, or NULL */
    const float *value; /* per vertex, shown through `map` from `low` to `high`; NaN is grey. Or NULL */
    const pc_colormap *map;
    float low, high;
    pc_color color; /* where neither faces nor values have one */
    float flat;     /* 0: light by vertex normals, 1: by face normals */
    float cavity;   /* 0..1: how much hollows darken and ridges brighten */
    float even;     /* 0..1: 0 full light and shade, 1 the bare colours: for colours that are to be read */
    float stripes;  /* > 0: reflection lines instead of other colours, that many from pole to pole of the
                       surroundings; they take the vertex normals as they are */
    const pc_index *face_owner; /* per face: faces of equal owner share one face normal (n-gons); or NULL */
} pc_surface;

/* A light warm grey scan. */
pc_surface pc_surface_of(const double *position, pc_index vertex_count, const pc_index *triangle,
                         pc_index face_count);
/* Draws into all panes, over what is farther away. Faces without area or with points that are not finite or
 * behind the viewer are passed over. */
pc_status pc_surface_draw(pc_picture *picture, pc_context *ctx, const pc_surface *surface);

/* Unit normals at the vertices, 3 floats each, weighted by area; zero where no face gives one. */
void pc_surface_normals(float *normal, const double *position, pc_index vertex_count,
                        const pc_index *triangle, pc_index face_count);

#endif
