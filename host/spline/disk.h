/* A part of a triangle mesh that is a disk, laid flat into the unit circle by mean value coordinates (Floater
 * 2003): one to one, whatever the part looks like in space. */
#ifndef PC_DISK_H
#define PC_DISK_H

#include "adjacency.h"
#include "bvh.h"

typedef struct pc_disk {
    pc_mesh mesh; /* the part; once laid, z is 0 and the rim is on the unit circle */
    pc_adjacency adjacency;
    pc_index *vertex, *triangle; /* what they are in the whole mesh; triangles ascending */
    pc_index *loop;              /* vertices of the rim, the disk on their left */
    pc_index loop_count;
    pc_bvh tree; /* once laid */
} pc_disk;

/* The largest connected part of the triangles with `inside` (one per triangle of the mesh), its small holes
 * filled and no vertex of its rim met twice: `inside` is changed to that. `disk` is empty (no loop) where
 * this is no disk. PC_E_NOMEM. */
pc_status pc_disk_make(pc_disk *disk, pc_context *ctx, const pc_mesh *mesh, const pc_adjacency *adjacency,
                       uint8_t *inside);
void pc_disk_free(pc_disk *disk, pc_context *ctx);

/* `angle`: ascending, one per vertex of the loop. `length`: one per half-edge of the part, in any metric that
 * the triangles have. `disk` must not move: the tree points into it. PC_E_NOMEM, PC_E_NOCONV. */
pc_status pc_disk_lay(pc_disk *disk, pc_context *ctx, const double *angle, const double *length);

/* The part's number of triangle t of the whole mesh, PC_NONE if it is not in it. */
pc_index pc_disk_find(const pc_disk *disk, pc_index t);

#endif
