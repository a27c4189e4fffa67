#include "result.h"
#include "folder.h"
#include "memory.h"
#include "scan.h"
#include "spline_store.h"
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool is_folder(const char *path) {
    struct stat there;
    return stat(path, &there) == 0 && S_ISDIR(there.st_mode);
}

static bool is_hdf5(const char *path) {
    static const char signature[8] = "\x89HDF\r\n\x1a\n";
    char start[sizeof signature];
    FILE *file = fopen(path, "rb");
    bool same =
        file && fread(start, sizeof start, 1, file) == 1 && memcmp(start, signature, sizeof start) == 0;
    if (file) (void)fclose(file);
    return same;
}

/* Where a product may be: `path` itself where it is a file, else the result or the stage's file in the
 * folder. */
static pc_status open_for(pc_store **store, pc_context *ctx, const char *path, const char *stage) {
    char *file = NULL, *folder = NULL;
    pc_status status = PC_OK;
    *store = NULL;
    if (!is_folder(path)) return pc_store_open(store, ctx, path);
    PC_TRY(pc_folder_join(&file, ctx, path, PC_OUT_RESULT, ""));
    if (access(file, F_OK) != 0) {
        pc_free(ctx, file);
        file = NULL;
        PC_TRY(pc_folder_join(&folder, ctx, path, PC_OUT_STAGES, ""));
        PC_TRY(pc_folder_join(&file, ctx, folder, stage, ".h5"));
    }
    if (access(file, F_OK) == 0) status = pc_store_open(store, ctx, file);
done:
    pc_free(ctx, folder);
    pc_free(ctx, file);
    return status;
}

static const char *mesh_group(pc_store *store) {
    return pc_store_has(store, "mesh") ? "mesh" : pc_store_has(store, "scan") ? "scan" : NULL;
}

/* A stage's file has no mesh; that of the mesh stage lies beside it. Before that stage there is the scan. */
static pc_status load_mesh(pc_held *held, pc_context *ctx, const char *path) {
    pc_store *store = NULL;
    char *folder = NULL, *file = NULL;
    pc_status status = PC_OK;
    PC_TRY(open_for(&store, ctx, path, "mesh"));
    if (store && !mesh_group(store) && !is_folder(path)) {
        pc_store_close(store);
        store = NULL;
        PC_TRY(pc_folder_join(&folder, ctx, path, "..", ""));
        const char *slash = strrchr(path, '/');
        size_t length = slash ? (size_t)(slash - path) : 0;
        (void)snprintf(folder, strlen(path) + 4, "%.*s", slash ? (int)length : 1, slash ? path : ".");
        PC_TRY(pc_folder_join(&file, ctx, folder, "mesh", ".h5"));
        PC_TRY(pc_store_open(&store, ctx, file));
    }
    if (!store || !mesh_group(store)) {
        status = pc_fail(ctx, PC_E_USAGE, "%s: holds no mesh to draw", path);
        goto done;
    }
    PC_TRY(pc_mesh_load(&held->mesh.mesh, store, mesh_group(store)));
done:
    pc_store_close(store);
    pc_free(ctx, folder);
    pc_free(ctx, file);
    return status;
}

static pc_status load_spline(pc_held_spline *spline, pc_store *store) {
    pc_status status = PC_OK;
    PC_TRY(pc_tspline_load(&spline->surface, store, "spline"));
    PC_TRY(pc_store_get_real(&spline->tolerance, store, "spline", "tolerance"));
    PC_TRY(pc_store_get_real(&spline->stats.accuracy.max, store, "spline", "error"));
done:
    return status;
}

static pc_status load_product(pc_held *held, pc_store *store, pc_preview_kind kind) {
    switch (kind) {
    case PC_PREVIEW_CURVATURE:
        return pc_curvature_load(&held->curvature, store, "curvature");
    case PC_PREVIEW_FIELD:
        return pc_field_load(&held->field, store, "field");
    case PC_PREVIEW_ISOLINES:
        return pc_param_load(&held->param, store, "param");
    case PC_PREVIEW_LAYOUT:
        return pc_layout_load(&held->layout, store, "layout");
    case PC_PREVIEW_QUADS:
        return pc_polymesh_load(&held->quads, store, "quads");
    case PC_PREVIEW_SURFACE:
    case PC_PREVIEW_ZEBRA:
    case PC_PREVIEW_ERROR:
        return load_spline(&held->spline, store);
    case PC_PREVIEW_SCAN:
    case PC_PREVIEW_COUNT:
        break;
    }
    return PC_OK;
}

/* Loads what picture `kind` shows; `found` says whether it is there. */
static pc_status try_product(bool *found, pc_held *held, pc_context *ctx, const char *path,
                             pc_preview_kind kind) {
    pc_store *store;
    const char *stage = pc_stage_title(pc_preview_stage(kind));
    pc_status status = open_for(&store, ctx, path, stage);
    *found = status == PC_OK && store && pc_store_has(store, stage);
    if (kind == PC_PREVIEW_SCAN) *found = status == PC_OK;
    if (*found) status = load_product(held, store, kind);
    pc_store_close(store);
    return status;
}

static pc_status load_result(pc_held *held, int *what, pc_context *ctx, const char *path) {
    const bool any = *what < 0;
    bool found = false;
    pc_status status = load_mesh(held, ctx, path);
    for (int kind = any ? PC_PREVIEW_SURFACE : *what; status == PC_OK && !found && kind >= 0; kind--) {
        status = try_product(&found, held, ctx, path, (pc_preview_kind)kind);
        *what = kind;
        if (!any) break;
    }
    if (status == PC_OK && !found)
        status = pc_fail(ctx, PC_E_USAGE, "%s: holds no %s", path,
                         pc_stage_title(pc_preview_stage((pc_preview_kind)*what)));
    return status;
}

static pc_status load_scan(pc_held *held, int *what, pc_context *ctx, const char *path) {
    pc_scan_info info;
    if (*what > PC_PREVIEW_SCAN)
        return pc_fail(ctx, PC_E_USAGE, "%s: is a scan, which has no %s yet; percale convert makes it", path,
                       pc_preview_name((pc_preview_kind)*what));
    *what = PC_PREVIEW_SCAN;
    return pc_scan_read(&held->mesh.mesh, &info, ctx, path);
}

pc_status pc_render(pc_context *ctx, const char *from, const char *picture, int what,
                    const pc_picture_options *options) {
    pc_held held = {0};
    pc_status status = PC_OK;
    if (is_folder(from) || is_hdf5(from))
        PC_TRY(load_result(&held, &what, ctx, from));
    else
        PC_TRY(load_scan(&held, &what, ctx, from));
    PC_TRY(pc_preview_save(ctx, picture, &held, (pc_preview_kind)what, options));
done:
    pc_mesh_free(&held.mesh.mesh, ctx);
    pc_curvature_free(&held.curvature, ctx);
    pc_field_free(&held.field, ctx);
    pc_param_free(&held.param, ctx);
    pc_layout_free(&held.layout, ctx);
    pc_polymesh_free(&held.quads, ctx);
    pc_tspline_free(&held.spline.surface, ctx);
    return status;
}
