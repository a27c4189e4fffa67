/* From a scan to a smooth surface, and points on it:   example_spline SCAN OUT */
#include <percale/percale.h>

/* The T-spline of a run of pc_convert (or of `percale convert --tolerance`). */
static pc_status load(pc_tspline *surface, pc_context *ctx, const char *out) {
    pc_status status = PC_OK;
    pc_store *store = NULL;
    char path[4096];
    snprintf(path, sizeof path, "%s/result.h5", out);
    PC_TRY(pc_store_open(&store, ctx, path));
    PC_TRY(pc_tspline_load(surface, store, "spline"));
done:
    pc_store_close(store);
    return status;
}

/* The point in the middle of face 0, and what is nearest to a point above it. */
static pc_status look(pc_context *ctx, const pc_tspline *surface) {
    pc_status status = PC_OK;
    pc_facets facets = {0};
    const double *size = surface->mesh.face[0].size;
    pc_surface_place place = pc_tspline_place(surface, 0, size[0] / 2, size[1] / 2);
    pc_surface_point at = pc_tspline_evaluate(surface, place);
    pc_vec3 normal = pc_surface_normal(&at);
    printf("point   %.6f %.6f %.6f\n", at.p.x, at.p.y, at.p.z);
    printf("normal  %.6f %.6f %.6f\n", normal.x, normal.y, normal.z);

    pc_vec3 above = pc_madd(at.p, 0.01, normal); /* 0.01 along the normal, in the units of the scan */
    const double points[3] = {above.x, above.y, above.z};
    pc_nearest nearest;
    PC_TRY(pc_facets_make(&facets, ctx, surface, 4, false));
    pc_nearest_all(&nearest, surface, &facets, points, 1);
    printf("nearest %.6f %.6f %.6f, %.6f away\n", nearest.point.x, nearest.point.y, nearest.point.z,
           nearest.distance);
done:
    pc_facets_free(&facets, ctx);
    return status;
}

int main(int argc, char **argv) {
    pc_status status = PC_OK;
    pc_context *ctx = pc_context_make();
    pc_convert_options options = PC_CONVERT_DEFAULTS;
    pc_tspline surface = {0};
    char *report = NULL;
    if (!ctx || argc != 3) return 2;
    options.tolerance = 0.005; /* of the diagonal of the scan's box */
    options.tolerance_relative = true;
    options.resume = true;    /* what an earlier run has finished is taken */
    options.pictures = false; /* no previews */
    PC_TRY(pc_convert(&report, ctx, argv[1], argv[2], &options));
    PC_TRY(load(&surface, ctx, argv[2]));
    PC_TRY(look(ctx, &surface));
done:
    if (status != PC_OK) fprintf(stderr, "example_spline: %s\n", pc_context_message(ctx));
    pc_tspline_free(&surface, ctx);
    pc_free(ctx, report);
    pc_context_free(ctx);
    return pc_status_exit_code(status);
}
