/* How hollow or exposed each pixel of a drawn surface is: read off the depth buffer. */
#ifndef PC_OCCLUSION_H
#define PC_OCCLUSION_H

#include "picture.h"

/* Per pixel of the picture, within the pane and where something is: about -1 (deep hollow) .. 0 (flat) .. 1
 * (ridge). The average over opposite neighbours at several radii, so that a slope alone says nothing. `shade`
 * has width*height floats. */
pc_status pc_occlusion_make(float *shade, pc_context *ctx, const pc_picture *picture, const pc_pane *pane);

#endif
