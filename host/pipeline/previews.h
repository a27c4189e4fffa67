/* The pictures of a run. */
#ifndef PC_PREVIEWS_H
#define PC_PREVIEWS_H

#include "picture.h"
#include "stage.h"

typedef enum pc_preview_kind {
    PC_PREVIEW_SCAN,
    PC_PREVIEW_CURVATURE,
    PC_PREVIEW_FIELD,
    PC_PREVIEW_ISOLINES,
    PC_PREVIEW_LAYOUT,
    PC_PREVIEW_QUADS,
    PC_PREVIEW_COUNT
} pc_preview_kind;

/* "scan", "curvature", ...: also the names of the files. */
const char *pc_preview_name(pc_preview_kind kind);
/* The stage whose product it shows, on the mesh. */
pc_stage_id pc_preview_stage(pc_preview_kind kind);
/* Draws what is held. `legend` of the options is set here. PC_E_IO where `path` is there and `force` is not
 * set. */
pc_status pc_preview_save(pc_context *ctx, const char *path, const pc_held *held, pc_preview_kind kind,
                          const pc_picture_options *options);
/* Into out/<name>.png, in the default size. */
pc_status pc_preview_write(pc_run *run, pc_preview_kind kind);

#endif
