/* Pictures of what is on disk: a result, stage files, or a scan as it is. */
#ifndef PC_RESULT_H
#define PC_RESULT_H

#include "previews.h"

/* Draws `from` into the PNG file `picture`, over whatever is there.
 * `from` is a folder that pc_convert left, a result or stage file in HDF5, or a scan. `what` is a
 * pc_preview_kind, or -1 for the last that is there. PC_E_USAGE where it is not there. */
pc_status pc_render(pc_context *ctx, const char *from, const char *picture, int what,
                    const pc_picture_options *options);

#endif
