/* IGES 5.3 files of spline surfaces. */
#ifndef PC_IGES_H
#define PC_IGES_H

#include "shell.h"

/* One rational B-spline surface (entity 128) per face, within its natural bounds; the file has no topology,
 * programs that read it sew the faces. Numbers are the shortest that read back the same, with the exponent D
 * of double precision; lengths are taken as millimetres; `size` (the diagonal of the model) sets the stated
 * resolution. `name` is the product's. The dates are 1970-01-01: the same shell gives the same bytes. PC_E_IO
 * as pc_writer_open, and where the file would have more than 9,999,999 lines in one section. */
pc_status pc_iges_write(pc_context *ctx, const pc_shell *shell, double size, const char *name,
                        const char *path, bool force);

#endif
