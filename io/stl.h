/* Reads STL, ascii and binary; equal corners become one vertex. */
#ifndef PC_STL_H
#define PC_STL_H

#include "scan_input.h"

/* Whether the bytes are a binary STL: 84 + 50 n of them for the n that stands at byte 80, or no text at the
 * start. */
bool pc_stl_is_binary(const char *data, size_t size);

/* Vertices in the order in which the file first names them; normals are ignored (they may be nan). A triangle
 * with equal corners is kept. The mesh owns its arrays. PC_E_FORMAT, PC_E_NOMEM. */
pc_status pc_stl_read(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const pc_scan_input *input);

#endif
