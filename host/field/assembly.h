/* The off-diagonal entries of the smoothing system: on the host, and on an OpenCL device. */
#ifndef PC_ASSEMBLY_H
#define PC_ASSEMBLY_H

#include "connection.h"
#include "device.h"
#include "ring.h"

typedef struct pc_assembly {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    const pc_ring *ring;
    const double *weight;    /* per edge */
    const double *transport; /* per half-edge */
    int symmetry;
    double smoothness;
} pc_assembly;

/* value: 2 per ring entry, -rho lambda exp(-i N transport) along the spoke. The device computes in float:
 * values agree to 1e-6 of lambda (tests/kernel/test_field_kernel.c); entries (i,j) and (j,i) are exact
 * conjugates in both. PC_E_NOMEM, PC_E_DEVICE. */
void pc_assembly_ref(double *value, const pc_assembly *work);
pc_status pc_assembly_launch(double *value, pc_context *ctx, pc_device *device, const pc_assembly *work);

#endif
