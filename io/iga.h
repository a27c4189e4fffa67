/* .iga files: Bezier extraction as the T-spline plug-in for Rhino wrote it and programs for isogeometric
 * analysis read it (Scott, Hughes, Sederberg, Sederberg 2014). */
#ifndef PC_IGA_H
#define PC_IGA_H

#include "tspline.h"

/* Every element of the surface, those beside extraordinary vertices too, as `belem n 3 3`, the n nodes
 * (counted from 0) and per node its 16 Bernstein coefficients, i + 4j with i along s. Nodes are the control
 * points that have a function on the surface, `node x y z 1`. Numbers are the shortest that read back the
 * same. PC_E_NOMEM, PC_E_IO as pc_writer_open. */
pc_status pc_iga_write(pc_context *ctx, const pc_tspline *spline, const char *path, bool force);

#endif
