/* Doublets: interior vertices with only two quads, which a sliver between two lines leaves at its centre. */
#ifndef PC_DOUBLET_H
#define PC_DOUBLET_H

#include "polymesh.h"

/* Joins the two quads of each such vertex into one, until none is left; unused vertices are dropped. The
 * faces of `quads` must be manifold; they stay so, with the same Euler number. Faces other than quads are
 * left alone, and without `at_borders` those that would leave one quad only at a border vertex: a corner that
 * is flat. */
pc_status pc_doublets_remove(pc_polymesh *quads, pc_index *removed, pc_context *ctx, bool at_borders);

#endif
