/* All that `check` tells about a scan without converting it. */
#ifndef PC_INSPECT_H
#define PC_INSPECT_H

#include "geometry.h"
#include "repair.h"
#include "topology.h"

typedef struct pc_inspection {
    pc_index given_vertex_count, given_face_count;
    pc_repair_report repair; /* every defect, counted, and what repair does about it; also where it refuses */
    bool convertible; /* false: repair refuses, `refusal` says why, and what follows is of the mesh as given,
                         with pieces torn where they have no orientation */
    char refusal[512];
    pc_mesh mesh; /* the repaired mesh that all the following is about; empty where nothing is left */
    pc_topology topology;
    pc_index edge_count, boundary_edge_count;
    pc_index valence_least, valence_most;
    pc_box box;
    double diagonal, area, volume; /* volume only means something without boundary */
    pc_spread edge_length;         /* the user's units */
    pc_spread angle;               /* corner angles in degrees */
    pc_spread least_angle;         /* of each face, degrees */
    pc_spread boundary_length;     /* of the boundary loops */
    pc_spread component_faces;     /* faces per component */
} pc_inspection;

/* Runs the repair on a copy. PC_OK also for meshes that cannot be converted; PC_E_MESH only for indices out
 * of range and coordinates that are not finite. The context's message is left as it was. */
pc_status pc_inspect(pc_inspection *inspection, pc_context *ctx, const pc_mesh *mesh,
                     const pc_repair_options *options);
void pc_inspection_free(pc_inspection *inspection, pc_context *ctx);

#endif
