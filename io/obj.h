/* Reads Wavefront OBJ: vertices and polygons; all other statements are passed over. */
#ifndef PC_OBJ_H
#define PC_OBJ_H

#include "scan_input.h"

/* `v x y z ...` (weights and colours are ignored) and `f a b/c d/e/f g//h ...` with negative indices,
 * comments, any line ends, lines continued by a backslash. Faces with a repeated vertex are kept as they are.
 * The mesh owns its arrays. PC_E_FORMAT, PC_E_NOMEM. */
pc_status pc_obj_read(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const pc_scan_input *input);

#endif
