/* A smooth direction field on the vertices: the product of the field stage. */
#ifndef PC_FIELD_H
#define PC_FIELD_H

#include "curvature.h"
#include "solver.h"
#include "trimesh.h"

typedef struct pc_field {
    int symmetry; /* N: 1 vectors, 2 lines, 4 crosses */
    pc_index vertex_count;
    pc_index face_count;
    pc_index loop_count; /* boundary loops */
    double *normal;      /* 3 per vertex, unit */
    double *direction;   /* 3 per vertex: unit tangent K; K_perp = normal x K */
    int8_t *index;       /* per face: N times the singularity index inside it */
    int32_t *loop_index; /* per boundary loop, in order of its smallest half-edge: N times its index. Always
                            sum(index) + sum(loop_index) = N * chi */
    double
        *angle; /* per vertex: K's angle in the frames of pc_connection_make, in which transport is exact */
    uint8_t *turn; /* per half-edge i->j: turns by 2 pi/N, 0..N-1, that bring the direction at j (transported)
                      nearest to the one at i; `index` counts with the same turns */
} pc_field;

typedef enum pc_border_rule { PC_BORDERS_OFF, PC_BORDERS_AUTO, PC_BORDERS_ALL } pc_border_rule;

typedef struct pc_field_options {
    int symmetry;          /* 1, 2 or 4 */
    double smoothness;     /* rho in [0,1): 0 keeps the curvature directions, near 1 forgets them */
    double feature_length; /* model units, 0 takes feature_edges mean edge lengths: details of the field
                              shorter than about feature_length * sqrt(rho/(1-rho)) are smoothed away */
    double feature_edges;
    double relief_edges; /* relief shorter than this many mean edges attracts no singularities */
    double feature_gain; /* strong bends k count 1 + feature_gain (k r)^4 times, r the curvature's radius */
    pc_border_rule borders;
    int rounds;       /* of solving and normalising, beyond the first solve */
    double tolerance; /* relative residual of each solve */
    pc_solver_options solver;
} pc_field_options;
#define PC_FIELD_DEFAULTS                                                                                    \
    { 4, 0.8, 0, 10.0, 7.0, 60.0, PC_BORDERS_AUTO, 4, 1e-4, PC_SOLVER_DEFAULTS }

/* The field of least (1-rho) sum A_i w_i |z_i - z0_i|^2 + rho l^2 sum lambda_e |z_j - Rot z_i|^2 over z =
 * exp(i N alpha) with |z| = 1 (Li, thesis D.4, eq. D.19, D.20 as corrected in the digest: angles are
 * multiplied by N), where w and z0 come from the curvature (or the border) and l is the feature length. For N
 * = 1 the curvature, which has no sign, is not used. PC_E_NOMEM, PC_E_DEVICE, PC_E_NOCONV, PC_E_USAGE. */
pc_status pc_field_make(pc_field *field, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                        const pc_adjacency *adjacency, const pc_curvature *curvature,
                        const pc_field_options *options);
/* The field of `given` on a mesh made of some of its vertices (vertex v here is source[v] there), evened out
 * over an edge or two, so that a singularity is one there too. Errors as above. */
pc_status pc_field_sample(pc_field *field, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                          const pc_adjacency *adjacency, const pc_field *given, const pc_index *source);
void pc_field_free(pc_field *field, pc_context *ctx);
/* Directions unit and tangent, turns in range, and the sum of all indices N * chi. PC_E_BUG else. */
pc_status pc_field_check(const pc_field *field, pc_context *ctx, const pc_mesh *mesh,
                         const pc_adjacency *adjacency);

#endif
