/* Reads a scan from a file: PLY, OBJ, STL or OFF, packed by gzip or not. */
#ifndef PC_SCAN_H
#define PC_SCAN_H

#include "scan_input.h"

/* Triangles in the file's frame and units; polygons are cut, nothing is repaired: faces with a repeated
 * vertex, duplicates and unused vertices stay (pc_repair sees to them; pc_mesh_check may refuse a raw scan).
 * The content decides the format; a name that says another of these formats is refused. The mesh owns its
 * arrays (pc_mesh_free). `info` tells what the file held. PC_E_IO where the file cannot be read; PC_E_FORMAT,
 * with file, line or byte, and element, where it is damaged; the mesh then is empty. */
pc_status pc_scan_read(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const char *path);

/* The same from memory; `name` stands for the path. */
pc_status pc_scan_read_bytes(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const char *name,
                             const char *data, size_t size);

#endif
