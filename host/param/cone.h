/* Field singularities as cones: the point that turning around a singular triangle leaves where it is.
 *
 * Once around such a triangle is g(p) = S^r p + PC_PERIOD (a,b) with r != 0, which has one fixed point: a
 * corner, the centre or the middle of a side of the cells. With a vertex put there the three parts of the
 * triangle are regular, and the iso-lines run on to the singularity instead of ending around it. */
#ifndef PC_CONE_H
#define PC_CONE_H

#include "transition.h"

/* The fixed point in the frame of the face's first corner; false where the face has no field singularity. */
bool pc_cone_point(pc_point2 *point, const pc_param *param, pc_index face);

/* A scan with a vertex in each triangle that holds a cone within a period of its corners. */
typedef struct pc_coned {
    pc_mesh mesh; /* faces with a cone have it as their last corner */
    pc_param param;
    pc_index *source_face; /* per face: the face of the scan */
    pc_index first_cone;   /* vertices from here on are cones */
} pc_coned;

pc_status pc_coned_make(pc_coned *coned, pc_context *ctx, const pc_mesh *mesh, const pc_param *param);
void pc_coned_free(pc_coned *coned, pc_context *ctx);

#endif
