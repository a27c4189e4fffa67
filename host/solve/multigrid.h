/* Smoothed aggregation multigrid whose prolongators carry the couplings' rotations: a preconditioner for any
 * symmetric positive definite pc_system. Levels in float, V-cycle with Chebyshev smoothing. */
#ifndef PC_MULTIGRID_H
#define PC_MULTIGRID_H

#include "aggregate.h"

enum { PC_MOST_LEVELS = 24, PC_SMOOTH_STEPS = 2 };

/* Steps of a Chebyshev smoother: d = alpha d + beta D^-1 (b - A x), x += d. */
typedef struct pc_chebyshev {
    float alpha[PC_SMOOTH_STEPS];
    float beta[PC_SMOOTH_STEPS];
} pc_chebyshev;

typedef struct pc_level {
    pc_blockmat matrix;
    pc_blockmat prolongator; /* to this level from the next; empty on the last */
    pc_blockmat restriction;
    pc_aggregates aggregates;
    float *first_diagonal; /* of the matrix as built, from its first change on; in the mean for TURNED */
    double largest;        /* eigenvalue of D^-1 A, estimated */
    pc_chebyshev chebyshev;
    float *x, *x_other, *d, *b; /* of the host cycle; residuals go to x_other */
} pc_level;

typedef struct pc_multigrid {
    int level_count;
    bool finest_only; /* one level to hold the matrix, without smoother */
    double scale;     /* the levels hold scale*A, of mean diagonal 1 */
    float *inverse;   /* dense, of the last level; NULL where smoothing alone solves it */
    pc_level level[PC_MOST_LEVELS];
} pc_multigrid;

/* Builds all levels. The finest one needs `system` until its couplings are freed. */
pc_status pc_multigrid_make(pc_multigrid *multigrid, pc_context *ctx, const pc_system *system);
/* The finest level alone, for block-Jacobi on a device. */
pc_status pc_multigrid_make_finest(pc_multigrid *multigrid, pc_context *ctx, const pc_system *system);
/* New values on the same graph: groups stay, all else is made anew. On failure the hierarchy is empty. */
pc_status pc_multigrid_update(pc_multigrid *multigrid, pc_context *ctx, const pc_system *system);
/* The system's diagonal of row i that the levels were built with. */
double pc_multigrid_first_diagonal(const pc_multigrid *multigrid, pc_index i);
/* The system's diagonal becomes `diagonal`, nowhere below that first one. On coarse levels the changes are
 * summed over the groups. Works on a hierarchy without couplings too. */
pc_status pc_multigrid_set_diagonal(pc_multigrid *multigrid, pc_context *ctx, const double *diagonal);
void pc_multigrid_free(pc_multigrid *multigrid, pc_context *ctx);
/* Frees all but the groups, which an update needs. */
void pc_multigrid_free_values(pc_multigrid *multigrid, pc_context *ctx);
void pc_multigrid_free_transfers(pc_multigrid *multigrid, pc_context *ctx, int level);
/* Frees what a level needs for its own cycle alone: its matrix, but for the diagonal, and its transfers. The
 * matrix of a last level that has an inverse stays. */
void pc_multigrid_free_couplings(pc_multigrid *multigrid, pc_context *ctx, int level);

/* The vectors of the host cycle; not needed where a device runs it. */
pc_status pc_multigrid_make_vectors(pc_multigrid *multigrid, pc_context *ctx);
/* One V-cycle on the host: level[0].x = about (scale A)^-1 level[0].b. */
void pc_multigrid_cycle(pc_multigrid *multigrid);

#endif
