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
    bool opposed;      /* the scan faces the other way there: another sheet, or the surface is folded */
    float stress;      /* how often its distance was too large: a factor of its weight (pc_samples_make) */
    bool held;         /* stays where it is while the surface is far (pc_folds_open) */
} pc_foot;

typedef struct pc_footpoints {
    int per_side;
    pc_index face_count; /* of the T-mesh */
    double *size;        /* 2 per face: its parameters */
    pc_foot *foot;       /* per_side^2 per face, the centres of as many equal parts, s first */
} pc_footpoints;

/* Feet of all faces. */
static inline size_t pc_footpoints_count(const pc_footpoints *feet) {
    return (size_t)feet->face_count * (size_t)(feet->per_side * feet->per_side);
}
/* Grids without feet. PC_E_NOMEM. */
pc_status pc_footpoints_make(pc_footpoints *feet, pc_context *ctx, const pc_tmesh *mesh, int per_side);
void pc_footpoints_free(pc_footpoints *feet, pc_context *ctx);

/* The feet of the bilinear faces with wanted[f] (NULL: all) between the control points on a scan, from `at`,
 * the triangle below each control point. The same bytes for any number of threads, as all here. */
void pc_footpoints_land(pc_footpoints *feet, const pc_tspline *spline, const pc_mesh *scan,
                        const pc_adjacency *adjacency, const pc_index *at, const uint8_t *wanted);
/* The same places on a scan of the same triangles with other positions. */
void pc_footpoints_lift(pc_footpoints *feet, const pc_mesh *scan);
/* Between feet i and j, beside each other on bilinear face f, a part of the scan is missing, or one of them
 * is opposed. */
bool pc_footpoints_gap(const pc_footpoints *feet, const pc_tspline *spline, pc_index f, int i, int j);

/* No foot of face f is farther than that from the surface's point above it. */
bool pc_footpoints_near(const pc_footpoints *feet, const pc_tspline *spline, pc_index f, double far);
/* Feet i and j of face f are much farther apart than `step`, which the points above them are. */
bool pc_footpoints_torn(const pc_footpoints *feet, pc_index f, int i, int j, double step);

/* Where a foot below a point of the surface goes: see pc_footpoints_follow. */
pc_foot pc_foot_follow(const pc_foot *foot, const pc_target *target, const pc_surface_point *above,
                       double let_go);
/* Every foot of a face with active[f] (NULL: all) walks downhill to the point of the scan nearest to the
 * surface's; one that is held only where that ends within `let_go` of the surface, and not opposed. */
void pc_footpoints_follow(pc_footpoints *feet, const pc_tspline *spline, const pc_target *target,
                          double let_go, const uint8_t *active);
/* Grids of a mesh whose faces are parts of those so far (pc_tface.root), each foot where the nearest of
 * the old ones is, to be followed. PC_E_NOMEM. */
pc_status pc_footpoints_carry(pc_footpoints *feet, pc_context *ctx, const pc_tmesh *refined);

/* Where a foot is on a scan of the same triangles. */
pc_vec3 pc_footpoints_point(const pc_mesh *scan, const pc_foot *foot);
/* Parameters of point i of the grid of a face. */
void pc_footpoints_at(double at[2], const pc_footpoints *feet, pc_index face, int i);
#endif
