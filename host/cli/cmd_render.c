#include "command.h"
#include "folder.h"
#include "memory.h"
#include "previews.h"
#include "result.h"
#include <string.h>
#include <sys/stat.h>

static const char usage[] = "render OUT|FILE -o PICTURE.png [OPTIONS]";
static const char about[] =
    "Draws what `percale convert` left in the folder OUT, or in a result or stage file, or a "
    "scan as it is.";

pc_status pc_command_render(pc_context *ctx, int argc, const char **argv) {
    const char *out = NULL, *view = "pair";
    int what = -1, up = 0;
    bool force = false;
    uint32_t size[2] = {1600, 1200};
    pc_option table[] = {
        PC_TEXT("output", 'o', &out, "PICTURE", "the PNG file to write"),
        PC_CHOICE("what", &what, "scan|curvature|field|isolines|layout|quads|surface|zebra|error",
                  "scan, curvature, field, isolines, layout, quads, or of the spline surface, zebra "
                  "(reflection lines) or error (distance to the scan); default: the last of the others that "
                  "is there"),
        PC_TEXT("view", 0, &view, "VIEW",
                "pair (default), iso, back-iso, front, back, left, right, top or bottom"),
        PC_CHOICE("up", &up, "auto|x|y|z", "which axis points up: auto (default), x, y or z"),
        PC_SIZE("size", size, "in pixels (default 1600x1200)"),
        PC_FLAG("force", 0, &force, "overwrite the picture"),
        PC_OPTIONS_END,
    };
    pc_operands operands;
    pc_picture_options options = PC_PICTURE_DEFAULTS;
    pc_status status = PC_OK;
    PC_TRY(pc_options_read(&operands, ctx, table, argc, argv));
    if (operands.help_asked) {
        pc_command_help(usage, about, table);
        goto done;
    }
    PC_TRY(pc_command_operands(ctx, &operands, 1, usage));
    if (!out) {
        status = pc_fail(ctx, PC_E_USAGE, "render wants the name of the picture: -o PICTURE.png");
        goto done;
    }
    PC_TRY(pc_view_parse(&options.view, ctx, view));
    options.up = (pc_up)up;
    options.width = (int)size[0], options.height = (int)size[1];
    struct stat there;
    if (!force && stat(out, &there) == 0) {
        status = pc_fail(ctx, PC_E_USAGE, "%s: exists; --force overwrites it", out);
        goto done;
    }
    status = pc_render(ctx, operands.text[0], out, what, &options);
done:
    return status;
}
