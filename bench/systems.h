/* Synthetic block systems for tests and benchmarks. The same seed gives the same system. */
#ifndef PC_SYSTEMS_H
#define PC_SYSTEMS_H

#include "system.h"

/* How a torus system is made. The mesh: a noisy torus, `around` x `across` vertices, cut along random
 * diagonals. */
typedef struct pc_synth_options {
    pc_index around;
    pc_index across;
    double jitter;       /* of the vertices, as a share of an edge */
    double shift;        /* times the mean diagonal, added to the diagonal */
    double period;       /* edges per period of the phases */
    double least;        /* cotangent weights are at least this */
    uint64_t seed;       /* of the mesh */
    uint64_t frame_seed; /* of the frames: any seed gives an equivalent system */
    bool combed;         /* TURNED: equal representatives all over the torus */
    bool folded;         /* neighbours have near numbers, as in the order that scans are brought into */
} pc_synth_options;
#define PC_SYNTH_DEFAULTS                                                                                    \
    { 100, 100, 0.3, 1e-6, 8, 0.05, 1, 1, false, false }

/* SCALAR: the Laplacian. COMPLEX: the connection Laplacian of 4-fold directions in random tangent frames.
 * TURNED: both phases of PGP for the field along the tube's rings, in random representatives. All with
 * cotangent weights. */
pc_status pc_synth_torus_system(pc_system *system, pc_context *ctx, pc_block_kind kind,
                                const pc_synth_options *options);

/* Rows with up to `degree` random neighbours and unrelated random blocks of both signs, diagonally dominant
 * by the factor `dominance`; some rows have no neighbour at all. */
pc_status pc_synth_random_system(pc_system *system, pc_context *ctx, pc_block_kind kind, pc_index rows,
                                 pc_index degree, double dominance, uint64_t seed);

#endif
