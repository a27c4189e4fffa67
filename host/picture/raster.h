/* Which triangle each sample of a pane sees. */
#ifndef PC_RASTER_H
#define PC_RASTER_H

#include "picture.h"

/* Projects points to 3 floats each: column, row, depth (NaN where not drawable), snapped to 1/256 sample. */
void pc_raster_project(float *screen, const pc_camera *camera, const double *position, size_t count);

/* Writes picture->depth and, per sample of the pane's box, the nearest triangle so far into `owner` (one per
 * sample of the picture, PC_NONE where no triangle of this call is seen). Neighbours leave no gap; of two
 * equally near ones the first wins. */
pc_status pc_raster_triangles(pc_picture *picture, pc_context *ctx, pc_index *owner, const pc_pane *pane,
                              const float *screen, const pc_index *triangle, size_t face_count);

#endif
