/* The pictures of a run. */
#ifndef PC_PREVIEWS_H
#define PC_PREVIEWS_H

#include "errors.h"
#include "picture.h"
#include "stage.h"

typedef enum pc_preview_kind {
    PC_PREVIEW_SCAN,
    PC_PREVIEW_CURVATURE,
    PC_PREVIEW_FIELD,
    PC_PREVIEW_ISOLINES,
    PC_PREVIEW_LAYOUT,
    PC_PREVIEW_QUADS,
    PC_PREVIEW_SURFACE,
    PC_PREVIEW_ZEBRA,
    PC_PREVIEW_ERROR,
    PC_PREVIEW_COUNT
} pc_preview_kind;

/* Pixels on their way to a PNG file in memory. */
typedef struct pc_album_page {
    uint8_t *pixels; /* 3 bytes each; NULL where there are none any more */
    uint8_t *png;    /* NULL: there is none (yet) */
    size_t size;
    int width, height;
} pc_album_page;

/* What the pictures of a run leave for its report. */
typedef struct pc_album {
    pc_album_page page[PC_PREVIEW_COUNT]; /* smaller, for the report */
    pc_album_page full[PC_PREVIEW_COUNT]; /* for the files */
    pc_picture picture;                   /* the last one drawn */
    int drawn;                            /* its kind + 1, or 0 */
    bool has_errors;
    pc_errors errors; /* of the spline, without `distance` */
} pc_album;

void pc_album_free(pc_album *album, pc_context *ctx);
/* Fills the errors of the album where no picture did; the spline and the mesh are held. PC_E_NOMEM. */
pc_status pc_album_measure(pc_album *album, pc_context *ctx, const pc_held *held);

/* "scan", "curvature", ...: also the names of the files. */
const char *pc_preview_name(pc_preview_kind kind);
/* The stage whose product it shows, on the mesh. */
pc_stage_id pc_preview_stage(pc_preview_kind kind);
/* Draws what is held into a file of its own. `legend` of the options is set here. A file that is there is
 * replaced. */
pc_status pc_preview_save(pc_context *ctx, const char *path, const pc_held *held, pc_preview_kind kind,
                          const pc_picture_options *options);
/* Draws it into the album, in the size of a run's pictures: the field in less time right after the scan. All
 * of one album are of one run. */
pc_status pc_preview_draw(pc_album *album, pc_context *ctx, const pc_held *held, pc_preview_kind kind);
/* Packs all that was drawn, with all threads, and writes out/<name>.png. The pages are there then. */
pc_status pc_album_write(pc_album *album, pc_run *run);

#endif
