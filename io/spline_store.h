/* A T-spline in a store: the control mesh and the control points. The basis follows from the mesh and is made
 * again on loading. What is saved is loaded bit for bit, so that refining and fitting go on as if the spline
 * had never been away. docs/file-format.md lists the arrays. */
#ifndef PC_SPLINE_STORE_H
#define PC_SPLINE_STORE_H

#include "store.h"
#include "tspline.h"

/* Writes the arrays into `group`, by convention "spline". PC_E_IO, PC_E_NOMEM. */
pc_status pc_tspline_save(pc_store *store, const char *group, const pc_tspline *spline);

/* The spline is the caller's to free. PC_E_FORMAT with file and element, and nothing to free, where an array
 * is missing, of another type or size, an index points past its array, or the mesh is not one that
 * pc_tmesh_check accepts or is not analysis-suitable. PC_E_NOMEM. */
pc_status pc_tspline_load(pc_tspline *spline, pc_store *store, const char *group);

#endif
