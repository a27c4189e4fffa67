/* The passes of the curvature stage over a mesh: on the host, and on an OpenCL device. */
#ifndef PC_NORMALCYCLE_H
#define PC_NORMALCYCLE_H

#include "curvature.h"
#include "ring.h"

/* One size of the neighbourhood. */
typedef struct pc_normalcycle_level {
    int passes;   /* of averaging, from the start */
    double flat;  /* curvatures below count as flat, 1/length */
    double noise; /* coherence of pure noise after so many passes */
} pc_normalcycle_level;

enum { PC_NORMALCYCLE_LEVELS = 3 };
/* A larger neighbourhood is taken at a vertex where its weight is so many times that of the smaller. */
#define PC_NORMALCYCLE_PREFER 1.5

typedef struct pc_normalcycle {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    const pc_ring *ring;
    double step; /* edges longer than this are walked less often, model units */
    int level_count;
    pc_normalcycle_level level[PC_NORMALCYCLE_LEVELS]; /* smallest first */
} pc_normalcycle;

/* Both fill the arrays of `curvature`, which are there. The host computes in double; the device in float,
 * with edges from positions in two floats, to a relative 1e-4 of the largest curvature around
 * (tests/kernel/test_curvature_kernel.c). Lengths on the device are in mean edges. PC_E_NOMEM,
 * PC_E_INTERRUPT, PC_E_DEVICE. */
pc_status pc_normalcycle_ref(pc_curvature *curvature, pc_context *ctx, const pc_normalcycle *work);
pc_status pc_normalcycle_launch(pc_curvature *curvature, pc_context *ctx, pc_device *device,
                                const pc_normalcycle *work);

#endif
