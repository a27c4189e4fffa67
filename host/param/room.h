/* How fine cells must be for every field singularity to have one of its own. */
#ifndef PC_ROOM_H
#define PC_ROOM_H

#include "adjacency.h"
#include "device.h"
#include "field.h"

typedef struct pc_room_options {
    double period_length; /* where the scale is 1, model units */
    double cells;         /* this many for each singularity, on the mean over about a period */
    double most;          /* no scale becomes larger */
} pc_room_options;
#define PC_ROOM_DEFAULTS                                                                                     \
    { 0, 1.5, 6.0 }

/* Raises `scale` (one per vertex, what the side of a cell is divided by there) where singularities stand
 * closer than the cells would let them: a handle or a bump smaller than a cell. The density of singularities
 * is spread by one step of heat flow over a period, so that the scale is smooth. */
pc_status pc_room_make(double *scale, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                       const pc_adjacency *adjacency, const pc_field *field, const pc_room_options *options);

#endif
