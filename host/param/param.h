/* A periodic global parameterization: (s,t) on the vertices, exact transitions on the edges. */
#ifndef PC_PARAM_H
#define PC_PARAM_H

#include "adjacency.h"
#include "device.h"
#include "field.h"
#include "pgp.h"

/* One period (one cell side) in the fixed-point units of pc_param.coordinate. Coordinates are odd, so that no
 * iso-line s = k*PC_PERIOD ever meets a vertex. */
#define PC_PERIOD (1 << 24)

typedef struct pc_param {
    pc_index vertex_count;
    pc_index face_count;
    double period_length; /* L: the length of one period in model units, where no density scales it */
    float *phase;         /* 4 per vertex: cos s, sin s, cos t, sin t as solved (norms are kept) */
    int32_t *coordinate;  /* 2 per vertex: (s,t), fixed point, odd */
    uint8_t *turn;        /* per half-edge h = i->j: quarter turns r that bring j's frame to i's */
    int32_t *shift;       /* 2 per half-edge: whole periods (a,b). Seen from i, the head of h lies at
                             S^r(s_j,t_j) + PC_PERIOD (a,b) with S(s,t) = (t,-s) */
    uint8_t *singular;    /* per face: PC_REGULAR, PC_DISLOCATION, PC_FIELD_SINGULARITY or PC_FLIPPED */
} pc_param;

enum {
    PC_REGULAR = 0,
    PC_DISLOCATION = 1,       /* once around comes back shifted by whole periods */
    PC_FIELD_SINGULARITY = 2, /* once around comes back turned */
    PC_FLIPPED = 3            /* closed, but with area <= 0 in the parameter plane */
};

typedef struct pc_param_options {
    double period_length; /* L, model units; every edge must be shorter than half of it (see pc_refine) */
    pc_pgp_options pgp;
    double cancel_reach; /* dislocations this many periods apart are cancelled, see pc_dislocations_cancel; 0:
                            PGP's own */
} pc_param_options;
#define PC_PARAM_DEFAULTS                                                                                    \
    { 0.0, PC_PGP_DEFAULTS, 8.0 }

typedef struct pc_param_stats {
    double energy; /* of the phases, see pc_pgp_stats */
    pc_index iterations;
    pc_index steps, pgp_iterations; /* of the outer scheme of PGP, and of the solver in it */
    double pgp_cpu_seconds;
    pc_index raw_dislocations, raw_flipped;              /* faces, as PGP leaves them */
    pc_index cancelled;                                  /* dislocations */
    pc_index dislocations, field_singularities, flipped; /* faces */
} pc_param_stats;

/* Periodic global parameterization along `field` (digest C20-C27). `scale`: per vertex, what the side of a
 * cell is divided by there (curl correction C19, local refinement), or NULL. PC_E_MESH names an edge that is
 * too long for the period. */
pc_status pc_param_make(pc_param *param, pc_param_stats *stats, pc_context *ctx, pc_device *device,
                        const pc_mesh *mesh, const pc_adjacency *adjacency, const pc_field *field,
                        const double *scale, const pc_param_options *options);
void pc_param_free(pc_param *param, pc_context *ctx);
/* Coordinates odd, transitions inverse to each other across edges, jumps below a period, flags right.
 * PC_E_BUG else. */
pc_status pc_param_check(const pc_param *param, pc_context *ctx, const pc_mesh *mesh,
                         const pc_adjacency *adjacency);

#endif
