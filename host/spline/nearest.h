/* The nearest point of a spline surface. */
#ifndef PC_NEAREST_H
#define PC_NEAREST_H

#include "bvh.h"
#include "tspline.h"

/* The surface as triangles, a grid of them in every element, in a tree. */
typedef struct pc_facets {
    int per_side; /* squares of two triangles along each side of an element */
    const pc_basis *basis;
    pc_index *element; /* those that are in it, ascending; NULL: all */
    pc_mesh mesh;      /* (per_side+1)^2 vertices per element, none shared */
    pc_bvh tree;
} pc_facets;

typedef struct pc_nearest {
    pc_surface_place place; /* element PC_NONE where there is no surface */
    pc_vec3 point;
    double distance;
} pc_nearest;

/* `flat`: of the bilinear faces between the control points instead, for a first guess where these lie on the
 * scan. `facets` must not move: the tree points into it. PC_E_NOMEM. */
pc_status pc_facets_make(pc_facets *facets, pc_context *ctx, const pc_tspline *spline, int per_side,
                         bool flat);
/* Only of the elements that may have a place within `reach` of one of `count` points (3 each). */
pc_status pc_facets_make_near(pc_facets *facets, pc_context *ctx, const pc_tspline *spline, int per_side,
                              const double *points, size_t count, double reach);
void pc_facets_free(pc_facets *facets, pc_context *ctx);
/* The place on a triangle of the facets with barycentric weights. */
pc_surface_place pc_facets_place(const pc_facets *facets, pc_index triangle, const double weight[3]);

/* Newton's method from a place near by, across borders of elements where it leads there; a step that does not
 * come nearer is halved, and the last one kept. */
pc_nearest pc_nearest_from(const pc_tspline *spline, pc_surface_place place, pc_vec3 target);

/* For `count` points (3 each; neighbours in the list should be near in space), through the facets. */
void pc_nearest_all(pc_nearest *nearest, const pc_tspline *spline, const pc_facets *facets,
                    const double *points, size_t count);

#endif
