/* A coarse likeness of a scan and its field: how fine cells must be, and where, is tried on it first. */
#ifndef PC_PILOT_H
#define PC_PILOT_H

#include "coarsen.h"
#include "field.h"

typedef struct pc_pilot {
    pc_coarse coarse;
    pc_adjacency adjacency;
    pc_field field;
} pc_pilot;

/* `scale`: one per vertex, what cells of side `period_length` are divided by. Empty (no faces) where the scan
 * has too few triangles for its cells for a likeness to be much smaller. PC_E_NOMEM. */
pc_status pc_pilot_make(pc_pilot *pilot, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                        const pc_adjacency *adjacency, const pc_field *field, const double *scale,
                        double period_length);
void pc_pilot_free(pc_pilot *pilot, pc_context *ctx);

/* Values at the vertices of the likeness for those of the scan: of the one that it went into, evened out over
 * the next few. `value` keeps what it has where a vertex has no face. */
pc_status pc_pilot_carry(double *value, pc_context *ctx, const pc_pilot *pilot, const double *coarse,
                         const pc_mesh *mesh, const pc_adjacency *adjacency);

#endif
