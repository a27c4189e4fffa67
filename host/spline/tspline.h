/* A T-spline surface: control mesh, basis and control points. All weights are 1: the basis sums to one. */
#ifndef PC_TSPLINE_H
#define PC_TSPLINE_H

#include "basis.h"
#include "vec3.h"

typedef struct pc_tspline {
    pc_tmesh mesh;
    pc_basis basis;
    double *position; /* 3 per vertex of the mesh, in model units */
    double *bezier;   /* 48 per element: its Bezier points, up to date with `position` */
} pc_tspline;

/* A place on the surface: an element and parameters in its face's frame. */
typedef struct pc_surface_place {
    pc_index element;
    double s, t;
} pc_surface_place;

/* Position and derivatives per unit of the face's parameters. */
typedef struct pc_surface_point {
    pc_vec3 p, s, t, ss, st, tt;
} pc_surface_point;

/* The control points are the vertices of the quads; those of ghosts lie opposite the quads' inner ones. Other
 * polygons and T-junctions are made fit as pc_tlayout_make and pc_closure_settle do; vertices that this adds
 * lie where the polygons were. PC_E_MESH as pc_tmesh_make. */
pc_status pc_tspline_make(pc_tspline *spline, pc_context *ctx, const pc_polymesh *polygons,
                          const pc_tmesh_options *options);
/* Basis and Bezier points, where mesh and control points are there already. PC_E_NOMEM, PC_E_BUG as
 * pc_basis_make. */
pc_status pc_tspline_complete(pc_tspline *spline, pc_context *ctx);
void pc_tspline_free(pc_tspline *spline, pc_context *ctx);
/* Of the mesh and of the basis. */
pc_status pc_tspline_check(const pc_tspline *spline, pc_basis_facts *facts, pc_context *ctx);

/* Bezier points after a change of control points; of the elements of faces with active[f] (NULL: all). */
void pc_tspline_update(pc_tspline *spline);
void pc_tspline_update_faces(pc_tspline *spline, const uint8_t *active);
pc_surface_point pc_tspline_evaluate(const pc_tspline *spline, pc_surface_place place);
/* Only the position. */
pc_vec3 pc_tspline_point(const pc_tspline *spline, pc_surface_place place);
/* The place with these parameters of a face. */
pc_surface_place pc_tspline_place(const pc_tspline *spline, pc_index face, double s, double t);

/* The place on an element where u and v run from 0 to 1 across it. */
static inline pc_surface_place pc_element_place(const pc_basis *basis, pc_index element, double u, double v) {
    const pc_element *e = basis->element + element;
    return (pc_surface_place){element, e->low[0] + u * (e->high[0] - e->low[0]),
                              e->low[1] + v * (e->high[1] - e->low[1])};
}

/* How much of its face an element is, along s and along t. */
static inline void pc_tspline_part(double part[2], const pc_tspline *spline, pc_index element) {
    const pc_element *e = spline->basis.element + element;
    for (int k = 0; k < 2; k++)
        part[k] = (e->high[k] - e->low[k]) / spline->mesh.face[e->face].size[k];
}

/* The same point of the surface seen from the element on the other side of side k (0..3: low t, high s, high
 * t, low s) of the place's element, on which it lies. False on the border of the surface. */
bool pc_tspline_cross(pc_surface_place *beyond, const pc_tspline *spline, pc_surface_place place, int side);

#endif
