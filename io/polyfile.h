/* Writes meshes as OBJ and binary PLY: the whole file or none, the same bytes every time. */
#ifndef PC_POLYFILE_H
#define PC_POLYFILE_H

#include "polymesh.h"
#include "trimesh.h"

/* OBJ has the shortest decimals that read back as the same doubles; PLY is binary little-endian with doubles.
 * Faces keep their order, corners and orientation (T-junction vertices are corners). PC_E_IO, also where
 * `path` exists and `force` is false: then it stays as it was. */
pc_status pc_polyfile_write_obj(pc_context *ctx, const pc_polymesh *mesh, const char *path, bool force);
pc_status pc_polyfile_write_ply(pc_context *ctx, const pc_polymesh *mesh, const char *path, bool force);
pc_status pc_polyfile_write_mesh_obj(pc_context *ctx, const pc_mesh *mesh, const char *path, bool force);
pc_status pc_polyfile_write_mesh_ply(pc_context *ctx, const pc_mesh *mesh, const char *path, bool force);

#endif
