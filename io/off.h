/* Reads OFF text with its prefixes C, N, ST (in any order), comments, and the counts where they like to
 * stand. */
#ifndef PC_OFF_H
#define PC_OFF_H

#include "scan_input.h"

/* One vertex or face per line; what follows the coordinates or corners on its line (normals, colours) is
 * ignored. Faces with a repeated vertex are kept as they are. The mesh owns its arrays. PC_E_FORMAT (also for
 * 4OFF, nOFF and OFF BINARY), PC_E_NOMEM. */
pc_status pc_off_read(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const pc_scan_input *input);

#endif
