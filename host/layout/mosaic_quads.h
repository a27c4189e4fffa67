/* From a layout to its cells in their final place. */
#ifndef PC_MOSAIC_QUADS_H
#define PC_MOSAIC_QUADS_H

#include "mosaic.h"
#include "relax.h"

typedef struct pc_mosaic_quads_stats {
    pc_index mended;     /* joins of cells that were no polygons, or triangles with pentagons */
    pc_index lines_gone; /* short lines between T-junctions */
    pc_index dissolved;  /* joins of cells that nothing could set upright */
    pc_index folded;     /* left upside down */
    pc_relax_stats relaxed;
} pc_mosaic_quads_stats;

/* Cells mended, short lines dropped, the polygons relaxed and set upright; those that stay upside down are
 * joined to a neighbour, in rounds. `folded` (one per face, the caller frees it; or NULL) tells those that
 * are left. */
pc_status pc_mosaic_quads(pc_polymesh *quads, uint8_t **folded, pc_mosaic_quads_stats *stats, pc_context *ctx,
                          const pc_layout *layout, const pc_ground *ground);

#endif
