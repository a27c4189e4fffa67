/* How smooth a spline surface is across the borders of its elements, measured. */
#ifndef PC_CONTINUITY_H
#define PC_CONTINUITY_H

#include "tspline.h"

typedef enum pc_joint {
    PC_JOINT_REGULAR, /* between elements of regular faces: C2 */
    PC_JOINT_MIXED,   /* with an element of an irregular face that touches no extraordinary vertex: C2 */
    PC_JOINT_CLOSING, /* the outer sides of closing patches: C1 */
    PC_JOINT_SPOKE,   /* edges that leave an extraordinary vertex, between closing patches: C0 */
    PC_JOINT_COUNT
} pc_joint;

typedef struct pc_jump {
    pc_index sample_count;
    double gap;         /* largest distance of the two sides, in model units */
    double normal_mean; /* angle between the normals, radians */
    double normal_max;
    double curvature_mean; /* of the normal curvature across the joint, times the element's size across */
    double curvature_max;
} pc_jump;

/* "regular", "mixed", "closing", "spoke". */
const char *pc_joint_name(pc_joint joint);
/* One row per class, from `samples` points inside of every side of every element. */
void pc_continuity_measure(pc_jump jump[PC_JOINT_COUNT], const pc_tspline *spline, int samples);

#endif
