/* BEXT files: Bezier extraction for LS-DYNA (*IGA_INCLUDE_BEZIER), version 2.0 in text. */
#ifndef PC_BEXT_H
#define PC_BEXT_H

#include "tspline.h"

/* One patch: `B E X T 2.0`; patch, nodes, elements, coefficient vectors, 0 for no weights; nodes as x y z 1;
 * blocks of elements with the same number of functions (type 1, that number twice, degrees 3 3); per element
 * its nodes (ascending) and their coefficient vectors, counted from 1; dense vectors of 16 Bernstein
 * coefficients, i + 4j with i along s, equal ones once. Integers take 8 columns, ten in a line, reals 24,
 * five in a line, the shortest that read back the same (below 1e-99: 0). Elements come block by block, in
 * their order within. PC_E_NOMEM; PC_E_IO as pc_writer_open, and where a number would not fit its columns. */
pc_status pc_bext_write(pc_context *ctx, const pc_tspline *spline, const char *path, bool force);

#endif
