/* Strips of quads: the quads that follow each other across opposite edges, from border to border or around.
 * One more or one fewer of them changes the count of a mesh and neither its topology nor, along it, its
 * regularity.
 */
#ifndef PC_STRIPS_H
#define PC_STRIPS_H

#include "ground.h"
#include "polymesh.h"

/* Makes `changed` from `quads` with one strip doubled or drawn together, such that its count comes nearer to
 * `wanted`. `rank`: 0 takes the strip that fits best, 1 the next one, and so on; of those that fit within
 * `tolerance` (relative) the widest is doubled first, the narrowest drawn together. `*made` is false, and
 * `changed` empty, where there is no such strip, or a face is no quad. New vertices stand in the middles of
 * edges and quads, or of the two they were; on the border of `ground` (or NULL) where those are. The result
 * is manifold where `quads` is, with the same Euler number and border loops. PC_E_NOMEM, PC_E_BUG for corners
 * out of range. */
pc_status pc_strips_change(pc_polymesh *changed, bool *made, pc_context *ctx, const pc_polymesh *quads,
                           const pc_ground *ground, double wanted, double tolerance, int rank);

#endif
