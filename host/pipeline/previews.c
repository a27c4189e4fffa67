#include "previews.h"
#include "folder.h"
#include "memory.h"
#include "png_file.h"
#include "scene.h"

static const struct {
    const char *name;
    pc_stage_id stage;
} previews[PC_PREVIEW_COUNT] = {
    [PC_PREVIEW_SCAN] = {"scan", PC_STAGE_MESH},
    [PC_PREVIEW_CURVATURE] = {"curvature", PC_STAGE_CURVATURE},
    [PC_PREVIEW_FIELD] = {"field", PC_STAGE_FIELD},
    [PC_PREVIEW_ISOLINES] = {"isolines", PC_STAGE_PARAM},
    [PC_PREVIEW_LAYOUT] = {"layout", PC_STAGE_LAYOUT},
    [PC_PREVIEW_QUADS] = {"quads", PC_STAGE_QUADS},
};

const char *pc_preview_name(pc_preview_kind kind) {
    return previews[kind].name;
}

pc_stage_id pc_preview_stage(pc_preview_kind kind) {
    return previews[kind].stage;
}

/* Mean curvature: what tells ridges from valleys at a glance. */
static pc_status draw_curvature(pc_picture *picture, pc_context *ctx, const pc_held *held) {
    double *mean = NULL;
    const pc_curvature *curvature = &held->curvature;
    pc_status status = pc_new(&mean, ctx, curvature->vertex_count);
    if (status != PC_OK) return status;
    for (size_t v = 0; v < curvature->vertex_count; v++)
        mean[v] = 0.5 * (curvature->value[2 * v] + curvature->value[2 * v + 1]);
    status =
        pc_scene_values(picture, ctx, &held->mesh.mesh, mean, &pc_colormap_diverging, 0, 0, "mean curvature");
    pc_free(ctx, mean);
    return status;
}

static pc_status draw(pc_picture *picture, pc_context *ctx, const pc_held *held, pc_preview_kind kind) {
    const pc_mesh *mesh = &held->mesh.mesh;
    pc_status status = PC_OK;
    switch (kind) {
    case PC_PREVIEW_SCAN:
        return pc_scene_scan(picture, ctx, mesh);
    case PC_PREVIEW_CURVATURE:
        return draw_curvature(picture, ctx, held);
    case PC_PREVIEW_FIELD:
        status = pc_scene_scan(picture, ctx, mesh);
        return status == PC_OK ? pc_scene_field(picture, ctx, mesh, &held->field) : status;
    case PC_PREVIEW_ISOLINES:
        return pc_scene_param(picture, ctx, mesh, &held->param);
    case PC_PREVIEW_LAYOUT:
        return pc_scene_layout(picture, ctx, &held->layout);
    case PC_PREVIEW_QUADS:
        return pc_scene_quads(picture, ctx, &held->quads);
    case PC_PREVIEW_COUNT:
        break;
    }
    return pc_fail(ctx, PC_E_BUG, "no such picture");
}

pc_status pc_preview_save(pc_context *ctx, const char *path, const pc_held *held, pc_preview_kind kind,
                          const pc_picture_options *options) {
    pc_picture_options with_legend = *options;
    pc_picture picture;
    const pc_mesh *mesh = &held->mesh.mesh;
    /* All pictures of a run are framed on the scan, so that they can be laid beside each other. */
    with_legend.legend = kind == PC_PREVIEW_CURVATURE;
    pc_status status = pc_picture_make(&picture, ctx, mesh->position, mesh->vertex_count, &with_legend);
    if (status != PC_OK) return status;
    PC_TRY(draw(&picture, ctx, held, kind));
    PC_TRY(pc_png_save(ctx, path, &picture));
done:
    pc_picture_free(&picture, ctx);
    return status;
}

pc_status pc_preview_write(pc_run *run, pc_preview_kind kind) {
    const pc_picture_options options = PC_PICTURE_DEFAULTS;
    char *path;
    pc_status status = pc_folder_join(&path, run->ctx, run->out, pc_preview_name(kind), ".png");
    if (status == PC_OK) status = pc_preview_save(run->ctx, path, &run->product, kind, &options);
    pc_free(run->ctx, path);
    return status;
}
