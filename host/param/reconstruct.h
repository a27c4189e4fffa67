/* From phases to coordinates: (s,t) in fixed point and exact transitions (digest C26, C27). */
#ifndef PC_RECONSTRUCT_H
#define PC_RECONSTRUCT_H

#include "coupling.h"
#include "param.h"

/* Fills turn, shift, coordinate and singular of `param` (arrays already made) from phases (4 per vertex), by
 * kernels or, on the host device, in plain C; both give the same transitions for the same coordinates, and
 * coordinates that differ by rounding. PC_E_DEVICE, PC_E_NOMEM, PC_E_INTERRUPT. */
pc_status pc_reconstruct(pc_param *param, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                         const pc_adjacency *adjacency, const pc_coupling *coupling, const double *phase);
/* The fixed-point number for x periods: odd, so that no iso-line meets a vertex; reduced to one period. */
int32_t pc_fixed_coordinate(double periods);
/* Shifts from coordinates: each the whole periods that bring the jump closest to the edge's advance. */
void pc_reconstruct_shifts(pc_param *param, const pc_mesh *mesh, const pc_adjacency *adjacency,
                           const pc_coupling *coupling);
/* The same for those edges only whose coordinates jump a period or more, which iso-lines could not follow. */
void pc_reconstruct_torn(pc_param *param, const pc_mesh *mesh, const pc_adjacency *adjacency,
                         const pc_coupling *coupling);
/* What a face is by its transitions and the sign of its area: PC_REGULAR, PC_DISLOCATION, ... */
int pc_reconstruct_flag(const pc_param *param, const pc_index *triangle, pc_index face);
/* Classifies every face so. */
void pc_reconstruct_flags(pc_param *param, const pc_mesh *mesh);

#endif
