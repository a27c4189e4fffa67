/* How far a parameterization is from isometric, as in the table F.1 of the thesis (stretch and shear). */
#ifndef PC_DISTORTION_H
#define PC_DISTORTION_H

#include "param.h"

typedef struct pc_distortion {
    pc_index regular_faces; /* those that the figures below are about */
    pc_index dislocations, field_singularities, flipped;
    double singular_percent; /* of all faces: all but the regular ones */
    double stretch; /* normalised L2 stretch (Sander et al. 2001, equations 3 and 4): 1 for an isometry of any
                       scale; a handful of nearly collapsed faces can make it large */
    double stretch_core; /* the same without the most stretched faces, 1 % of the area */
    double shear;        /* mean |cos| of the angle between dX/ds and dX/dt, weighted by area; ideal 0 */
    double length_error; /* area-weighted root mean square of log2(singular value / its mean) */
} pc_distortion;

/* The same for any number of threads. PC_E_NOMEM; PC_E_BUG where mesh and param do not belong together. */
pc_status pc_distortion_measure(pc_distortion *distortion, pc_context *ctx, const pc_mesh *mesh,
                                const pc_param *param);

#endif
