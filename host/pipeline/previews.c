#include "previews.h"
#include "folder.h"
#include "memory.h"
#include "png_file.h"
#include "scene.h"
#include "scene_spline.h"
#include <math.h>

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
    [PC_PREVIEW_SURFACE] = {"surface", PC_STAGE_SPLINE},
    [PC_PREVIEW_ZEBRA] = {"zebra", PC_STAGE_SPLINE},
    [PC_PREVIEW_ERROR] = {"error", PC_STAGE_SPLINE},
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

static pc_status measure_errors(pc_errors *errors, pc_context *ctx, const pc_held *held) {
    const pc_held_spline *spline = &held->spline;
    pc_adjacency own = {0};
    const pc_adjacency *adjacency = &held->mesh.adjacency;
    pc_target target = {0};
    pc_status status = PC_OK;
    if (!adjacency->twin) { /* a mesh out of a file comes without one */
        PC_TRY(pc_adjacency_make(&own, ctx, &held->mesh.mesh));
        adjacency = &own;
    }
    PC_TRY(pc_target_make(&target, ctx, &held->mesh.mesh, adjacency));
    PC_TRY(pc_errors_make(errors, ctx, &spline->surface, &target, spline->tolerance,
                          spline->stats.accuracy.max));
done:
    pc_target_free(&target, ctx);
    pc_adjacency_free(&own, ctx);
    return status;
}

static void keep_errors(pc_album *album, pc_context *ctx, pc_errors *errors) {
    if (!album) return;
    album->errors = *errors, album->errors.distance = NULL;
    album->has_errors = true;
    pc_errors_free(errors, ctx);
}

pc_status pc_album_measure(pc_album *album, pc_context *ctx, const pc_held *held) {
    pc_errors errors;
    if (album->has_errors) return PC_OK;
    pc_status status = measure_errors(&errors, ctx, held);
    if (status == PC_OK) keep_errors(album, ctx, &errors);
    return status;
}

void pc_album_free(pc_album *album, pc_context *ctx) {
    for (int kind = 0; kind < PC_PREVIEW_COUNT; kind++)
        for (int k = 0; k < 2; k++) {
            pc_album_page *page = k ? &album->full[kind] : &album->page[kind];
            pc_free(ctx, page->pixels);
            pc_free(ctx, page->png);
        }
    pc_picture_free(&album->picture, ctx);
    *album = (pc_album){0};
}

static pc_status draw_errors(pc_picture *picture, pc_context *ctx, const pc_held *held, pc_album *album) {
    pc_errors errors;
    pc_status status = measure_errors(&errors, ctx, held);
    if (status != PC_OK) return status;
    status = pc_scene_errors(picture, ctx, &held->spline.surface, &errors, held->spline.tolerance);
    keep_errors(album, ctx, &errors);
    pc_errors_free(&errors, ctx);
    return status;
}

static pc_status draw(pc_picture *picture, pc_context *ctx, const pc_held *held, pc_preview_kind kind,
                      pc_album *album) {
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
    case PC_PREVIEW_SURFACE:
        return pc_scene_spline(picture, ctx, &held->spline.surface);
    case PC_PREVIEW_ZEBRA:
        return pc_scene_zebra(picture, ctx, &held->spline.surface);
    case PC_PREVIEW_ERROR:
        return draw_errors(picture, ctx, held, album);
    case PC_PREVIEW_COUNT:
        break;
    }
    return pc_fail(ctx, PC_E_BUG, "no such picture");
}

/* The rows of pixels that show something, with a margin; never less than a legend needs. */
static void rows_used(int rows[2], const pc_picture *picture) {
    const int margin = picture->height / 40;
    int low = picture->height * 5 / 6, high = picture->height / 6;
    for (int y = 0; y < picture->rows; y++)
        for (int x = 0; x < picture->columns; x++) {
            if (!isfinite(picture->depth[(size_t)y * (size_t)picture->columns + (size_t)x])) continue;
            int row = y / picture->samples;
            low = row < low ? row : low;
            high = row > high ? row : high;
            break;
        }
    if (low > picture->height / 6) low = picture->height / 6;
    if (high < picture->height * 5 / 6) high = picture->height * 5 / 6;
    rows[0] = low > margin ? low - margin : 0;
    rows[1] = high + 1 + margin < picture->height ? high + 1 + margin : picture->height;
}

/* Leaves seven bits of each value: they look like eight, and the file is a fifth smaller. */
static void coarsen(uint8_t *pixels, size_t count) {
    for (size_t i = 0; i < count; i++)
        pixels[i] = (uint8_t)((pixels[i] & 0xfe) | pixels[i] >> 7);
}

/* The spline's pictures, which are looked at closely, larger than the others. */
static pc_status keep_page(pc_album_page *page, pc_context *ctx, const uint8_t *pixels,
                           const pc_picture *picture, pc_preview_kind kind) {
    const int most = previews[kind].stage == PC_STAGE_SPLINE ? 900 : 720;
    int rows[2];
    rows_used(rows, picture);
    const int width = picture->width, height = rows[1] - rows[0];
    page->width = width < most ? width : most;
    page->height = (page->width * height + width / 2) / width;
    pc_status status = pc_picture_shrink(&page->pixels, ctx, pixels + 3 * (size_t)width * (size_t)rows[0],
                                         width, height, page->width, page->height);
    if (status == PC_OK) coarsen(page->pixels, 3 * (size_t)page->width * (size_t)page->height);
    return status;
}

static pc_status finish(pc_album_page *page, pc_context *ctx, const pc_picture *picture) {
    page->width = picture->width, page->height = picture->height;
    return pc_picture_pixels(&page->pixels, ctx, picture);
}

/* All pictures of a run are framed on the scan, so that they can be laid beside each other. */
static bool has_legend(pc_preview_kind kind) {
    return kind == PC_PREVIEW_CURVATURE || kind == PC_PREVIEW_ERROR;
}

pc_status pc_preview_save(pc_context *ctx, const char *path, const pc_held *held, pc_preview_kind kind,
                          const pc_picture_options *options) {
    pc_picture_options own = *options;
    pc_picture picture;
    pc_album_page full = {0};
    const pc_mesh *mesh = &held->mesh.mesh;
    own.legend = has_legend(kind);
    pc_status status = pc_picture_make(&picture, ctx, mesh->position, mesh->vertex_count, &own);
    if (status != PC_OK) return status;
    PC_TRY(draw(&picture, ctx, held, kind, NULL));
    PC_TRY(finish(&full, ctx, &picture));
    PC_TRY(pc_png_write(ctx, path, full.pixels, full.width, full.height));
done:
    pc_free(ctx, full.pixels);
    pc_picture_free(&picture, ctx);
    return status;
}

/* An empty picture in the album, or the scan's to draw the field over. */
static pc_status start(pc_album *album, pc_context *ctx, const pc_mesh *mesh, pc_preview_kind kind) {
    pc_picture_options options = PC_PICTURE_DEFAULTS;
    options.width = 1200, options.height = 900, options.legend = has_legend(kind);
    if (!album->drawn)
        return pc_picture_make(&album->picture, ctx, mesh->position, mesh->vertex_count, &options);
    pc_picture_clear(&album->picture, mesh->position, mesh->vertex_count, &options);
    return PC_OK;
}

pc_status pc_preview_draw(pc_album *album, pc_context *ctx, const pc_held *held, pc_preview_kind kind) {
    pc_status status = PC_OK;
    pc_album_page *full = &album->full[kind];
    if (kind == PC_PREVIEW_FIELD && album->drawn == PC_PREVIEW_SCAN + 1) {
        PC_TRY(pc_scene_field(&album->picture, ctx, &held->mesh.mesh, &held->field));
    } else {
        PC_TRY(start(album, ctx, &held->mesh.mesh, kind));
        PC_TRY(draw(&album->picture, ctx, held, kind, album));
    }
    album->drawn = (int)kind + 1;
    PC_TRY(finish(full, ctx, &album->picture));
    PC_TRY(keep_page(&album->page[kind], ctx, full->pixels, &album->picture, kind));
done:
    return status;
}

static pc_status pack(pc_album_page *page, pc_context *ctx) {
    if (!page->pixels) return PC_OK;
    pc_status status = pc_png_encode(&page->png, &page->size, ctx, page->pixels, page->width, page->height);
    pc_free(ctx, page->pixels);
    page->pixels = NULL;
    return status;
}

pc_status pc_album_write(pc_album *album, pc_run *run) {
    enum { TASKS = 2 * PC_PREVIEW_COUNT };
    pc_status status = PC_OK, packed[TASKS];
    char *path = NULL;
    pc_picture_free(&album->picture, run->ctx);
    album->drawn = 0;
#pragma omp parallel for schedule(dynamic, 1)
    for (int k = 0; k < TASKS; k++)
        packed[k] =
            pack(k < PC_PREVIEW_COUNT ? &album->page[k] : &album->full[k - PC_PREVIEW_COUNT], run->ctx);
    for (int k = 0; k < TASKS; k++)
        PC_TRY(packed[k]);
    for (int kind = 0; kind < PC_PREVIEW_COUNT; kind++) {
        pc_album_page *full = &album->full[kind];
        if (!full->png) continue;
        PC_TRY(pc_folder_join(&path, run->ctx, run->out, pc_preview_name((pc_preview_kind)kind), ".png"));
        PC_TRY(pc_png_put(run->ctx, path, full->png, full->size));
        pc_free(run->ctx, path);
        path = NULL;
        pc_free(run->ctx, full->png);
        full->png = NULL;
    }
done:
    pc_free(run->ctx, path);
    return status;
}
