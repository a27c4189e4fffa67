/* The spline surface in pictures; scene.h shows what leads to it. */
#ifndef PC_SCENE_SPLINE_H
#define PC_SCENE_SPLINE_H

#include "errors.h"
#include "picture.h"

/* The surface in a light clay with the lines of the T-mesh's faces; balls at extraordinary vertices (3 red, 5
 * blue, more violet), small orange ones at T-junctions. PC_E_NOMEM, as below. */
pc_status pc_scene_spline(pc_picture *picture, pc_context *ctx, const pc_tspline *spline);

/* Reflection lines: stripes of light around the model as the surface mirrors them. They are as smooth as the
 * surface but for one derivative: a kink of theirs is a jump of its curvature, a break one of its normal. */
pc_status pc_scene_zebra(pc_picture *picture, pc_context *ctx, const pc_tspline *spline);

/* The distances to the scan as colours, pale and blue within the tolerance, red beyond it; grey where the
 * scan has no data. A legend in model units, with the tolerance marked (0: none). */
pc_status pc_scene_errors(pc_picture *picture, pc_context *ctx, const pc_tspline *spline,
                          const pc_errors *errors, double tolerance);

enum { PC_ERROR_COLORS = 256 };
/* The colours of 0..high, whose change lies at the tolerance; a colour map points to `color`. */
void pc_error_colors(pc_color color[PC_ERROR_COLORS], double tolerance, double high);

#endif
