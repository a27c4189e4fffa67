/* Where on the scan each part of the surface belongs: the foot points of a grid on every face, followed over
 * the scan from fit to fit. Every face has its grid, however small it is beside the triangles of the scan, and
 * a foot does not jump from one sheet of a thin wall to the other: it walks (digest C37). */
#ifndef PC_FOOTPOINTS_H
#define PC_FOOTPOINTS_H

#include "target.h"

typedef struct pc_foot {
    pc_index triangle; /* of the scan */
    pc_vec3 point;     /* on it */
    bool lost;         /* the scan faces the other way there: it has no meaning */
} pc_foot;

typedef struct pc_footpoints {
    int per_side;
    pc_index face_count; /* of the T-mesh */
    double *size;        /* 2 per face: its parameters */
    pc_foot *foot;       /* per_side^2 per face, the centres of as many equal parts, s first */
} pc_footpoints;

/* Those of the bilinear faces between the control points, which are still on the scan. PC_E_NOMEM. */
pc_status pc_footpoints_make(pc_footpoints *feet, pc_context *ctx, const pc_tspline *spline,
                             const pc_target *target, int per_side);
void pc_footpoints_free(pc_footpoints *feet, pc_context *ctx);

/* Every foot walks downhill to the point of the scan nearest to the surface's. The same bytes for any number
 * of threads. PC_E_NOMEM. */
pc_status pc_footpoints_follow(pc_footpoints *feet, pc_context *ctx, const pc_tspline *spline,
                               const pc_target *target);
/* Grids of a mesh whose faces are parts of those so far (pc_tface.root); each foot waits where the nearest one
 * of the old grid is, to be followed. PC_E_NOMEM. */
pc_status pc_footpoints_carry(pc_footpoints *feet, pc_context *ctx, const pc_tmesh *refined);

/* Parameters of point i of the grid of a face. */
void pc_footpoints_at(double at[2], const pc_footpoints *feet, pc_index face, int i);
/* The foot of the grid's point next to a place on a face. */
const pc_foot *pc_footpoints_near(const pc_footpoints *feet, pc_index face, const double at[2]);
/* How far foot points beside each other on a face are apart, about: the longer diagonal of the grid, shared
 * out. */
double pc_footpoints_step(const pc_footpoints *feet, pc_index face);

#endif
