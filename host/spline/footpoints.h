/* Where on the scan each part of the surface belongs: the foot points of a grid on every face, followed over
 * the scan from fit to fit (digest C37). Every face has its grid, however small it is beside the triangles of
 * the scan; and feet walk, so that they do not change to the other sheet of a thin wall. */
#ifndef PC_FOOTPOINTS_H
#define PC_FOOTPOINTS_H

#include "target.h"

typedef struct pc_foot {
    pc_index triangle; /* of the scan; PC_NONE: no foot yet */
    double weight[3];  /* of its corners */
    pc_vec3 point;     /* on it */
    bool lost;         /* the scan faces the other way there: it has no meaning */
} pc_foot;

typedef struct pc_footpoints {
    int per_side;
    pc_index face_count; /* of the T-mesh */
    double *size;        /* 2 per face: its parameters */
    pc_foot *foot;       /* per_side^2 per face, the centres of as many equal parts, s first */
    uint8_t *torn;       /* per face: between two of its feet a part of the scan is missing, or one is lost */
    uint8_t *held;       /* per face: the nearest points would be torn, and the feet are where they were */
} pc_footpoints;

/* Grids without feet. PC_E_NOMEM. */
pc_status pc_footpoints_make(pc_footpoints *feet, pc_context *ctx, const pc_tmesh *mesh, int per_side);
void pc_footpoints_free(pc_footpoints *feet, pc_context *ctx);

/* The feet of the bilinear faces between the control points on a scan, from `at`, the triangle below each
 * control point. The same bytes for any number of threads, as all here. */
void pc_footpoints_land(pc_footpoints *feet, const pc_tspline *spline, const pc_mesh *scan,
                        const pc_adjacency *adjacency, const pc_index *at);
/* The same places on a scan of the same triangles with other positions. */
void pc_footpoints_lift(pc_footpoints *feet, const pc_mesh *scan);
/* A part of the scan is missing between feet i and j, beside each other on bilinear face f. */
bool pc_footpoints_gap(const pc_footpoints *feet, const pc_tspline *spline, pc_index f, int i, int j);

/* Every foot walks downhill to the point of the scan nearest to the surface's; where that tears a grid which
 * was whole, this one stays. */
void pc_footpoints_follow(pc_footpoints *feet, const pc_tspline *spline, const pc_target *target);
/* Grids of a mesh whose faces are parts of those so far (pc_tface.root), with feet between the old ones.
 * PC_E_NOMEM. */
pc_status pc_footpoints_carry(pc_footpoints *feet, pc_context *ctx, const pc_tmesh *refined,
                              const pc_target *target);

/* Parameters of point i of the grid of a face. */
void pc_footpoints_at(double at[2], const pc_footpoints *feet, pc_index face, int i);
/* The foot of the grid's point next to a place on a face. */
const pc_foot *pc_footpoints_near(const pc_footpoints *feet, pc_index face, const double at[2]);
/* How far foot points beside each other on a face are apart, about: the longer diagonal of the grid, shared
 * out. */
double pc_footpoints_step(const pc_footpoints *feet, pc_index face);

#endif
