/* Joins polygons with an odd number of corners in pairs, so that quads can fill what comes of them without
 * T-junctions. */
#ifndef PC_ODDPAIR_H
#define PC_ODDPAIR_H

#include "polymesh.h"

/* Each pair, nearest ones first, becomes one polygon with all that lies on the way from the one to the other,
 * no more than `farthest` edges long. Polygons with kept[f] != 0 stay as they are and in nobody's way.
 * `source` (the caller frees it) tells the former number of each polygon, that of one end for joined ones;
 * vertices stay where they are. Paths that would enclose something are not taken. PC_E_NOMEM, PC_E_BUG where
 * a corner is out of range. */
pc_status pc_oddpair_join(pc_polymesh *mesh, pc_index **source, pc_index *pairs, pc_context *ctx,
                          const uint8_t *kept, int farthest);

#endif
