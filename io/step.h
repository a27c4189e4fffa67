/* STEP files (ISO 10303-21, schema AP214) of spline surfaces. */
#ifndef PC_STEP_H
#define PC_STEP_H

#include "shell.h"

/* Writes every face as a B_SPLINE_SURFACE_WITH_KNOTS within its edges, which the faces share and which have
 * lines in the parameters of both (PCURVE), so that no reader has to project them. A shell without
 * borders is a MANIFOLD_SOLID_BREP per component, else all components are SHELL_BASED_SURFACE_MODELs. Numbers
 * are the shortest that read back the same; lengths are taken as millimetres; `size` (the diagonal of the
 * model) sets the stated uncertainty. `name` is the product's. No time stamp: the same shell gives the same
 * bytes. PC_E_IO as pc_writer_open. */
pc_status pc_step_write(pc_context *ctx, const pc_shell *shell, double size, const char *name,
                        const char *path, bool force);

#endif
