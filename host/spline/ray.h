/* Walks straight across a T-mesh, and the knots that they meet (digest C35). */
#ifndef PC_RAY_H
#define PC_RAY_H

#include "tmesh.h"

typedef enum pc_ray_way {
    PC_RAY_ALONG,  /* next it follows half-edge `half` from its tail to its head */
    PC_RAY_ACROSS, /* next it crosses the face of `half`, entering `offset` behind the tail of it */
    PC_RAY_ENDED   /* at an extraordinary vertex or past the rim: intervals repeat */
} pc_ray_way;

typedef struct pc_ray {
    pc_ray_way way;
    pc_index half;
    double offset;
    double last; /* the interval it repeats where it has ended */
} pc_ray;

/* Goes on to the next line across its way and returns the knot interval up to there. */
double pc_ray_step(pc_ray *ray, const pc_tmesh *mesh);
/* Straight ahead behind half-edge h. */
pc_ray pc_ray_behind(const pc_tmesh *mesh, pc_index h);

/* The four directions at a regular vertex, counter-clockwise; direction 0 is along its `out`. At a T-junction
 * one of them crosses a face, on the rim one or two end at once. */
typedef struct pc_star {
    pc_ray ray[4];
} pc_star;
void pc_star_make(pc_star *star, const pc_tmesh *mesh, pc_index v);

/* The five knots of the vertex in direction 0 and in direction 1, relative to it (the third is 0). */
void pc_star_knots(double s[5], double t[5], const pc_tmesh *mesh, const pc_star *star);
/* The same at an extraordinary vertex, for the corner between its half-edge h (+s) and the next one counter-
 * clockwise (+t). Behind it are the spokes next to these two: what a vertex beside it sees there. */
void pc_sector_knots(double s[5], double t[5], const pc_tmesh *mesh, pc_index h);

#endif
