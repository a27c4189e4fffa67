/* XML files of G+Smo (Geometry + Simulation Modules). */
#ifndef PC_GISMO_H
#define PC_GISMO_H

#include "shell.h"

/* A MultiPatch of one TensorBSpline2 per face, fourfold knots at the ends. Its interfaces are the pairs of
 * sides that meet from end to end, its boundary the sides on the border of the surface; sides that meet
 * several patches, or a part of one, are in neither list, since the format has no word for them. Numbers are
 * the shortest that read back the same. PC_E_NOMEM, PC_E_IO as pc_writer_open. */
pc_status pc_gismo_write(pc_context *ctx, const pc_shell *shell, const char *path, bool force);

#endif
