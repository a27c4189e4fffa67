/* How the error of a T-spline falls with its number of control points, on shapes that are known exactly.
 * bench_convergence [MOST control points, default 20000]; a line of JSON per spline.
 * uniform: finer and finer quads. adaptive: from coarse quads, the worst faces refined (local knot
 * insertion).
 */
#include "exactfit.h"
#include "insertion.h"
#include "memory.h"
#include "synth_quads.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The cube's grid at equal angles instead of equal steps, so that the cells of the sphere are about equal. */
static void even_out(pc_polymesh *sphere) {
    for (size_t v = 0; v < sphere->vertex_count; v++) {
        double *p = sphere->position + 3 * v, most = fmax(fabs(p[0]), fmax(fabs(p[1]), fabs(p[2])));
        for (int k = 0; k < 3; k++)
            p[k] = tan(p[k] / most * PC_PI / 4);
        pc_vec3_put(sphere->position, v, pc_unit(pc_vec3_at(sphere->position, v)));
    }
}

static pc_status coarse(pc_polymesh *quads, pc_context *ctx, const pc_exact_shape *shape, pc_index n) {
    if (shape == &pc_exact_torus) return pc_synth_quad_torus(quads, ctx, 2, 1, 2 * n, n);
    pc_status status = pc_synth_quad_sphere(quads, ctx, n);
    if (status == PC_OK) even_out(quads);
    return status;
}

static void print_row(const pc_exact_shape *shape, const char *way, const pc_tspline *spline,
                      pc_index junctions, const pc_exact_error *error) {
    printf("{\"bench\": \"convergence\", \"shape\": \"%s\", \"way\": \"%s\", \"points\": %u, \"junctions\": "
           "%u, \"max\": %.4g, \"rms\": %.4g, \"away_max\": %.4g}\n",
           shape->name, way, spline->mesh.vertex_count, junctions, error->max, error->rms, error->away_max);
    (void)fflush(stdout);
}

static pc_status fitted(pc_tspline *spline, pc_context *ctx, const pc_exact_shape *shape, pc_index n) {
    static const pc_tmesh_options making = PC_TMESH_DEFAULTS;
    pc_status status = PC_OK;
    pc_polymesh quads = {0};
    PC_TRY(coarse(&quads, ctx, shape, n));
    PC_TRY(pc_tspline_make(spline, ctx, &quads, &making));
    PC_TRY(pc_exact_fit(spline, ctx, shape));
done:
    pc_polymesh_free(&quads, ctx);
    return status;
}

/* Extraordinary vertices as deep as at first: a refinement beside them takes a step from their depth. */
static pc_status deepen(pc_tspline *spline, pc_context *ctx) {
    static const pc_tmesh_options making = PC_TMESH_DEFAULTS;
    pc_status status = PC_OK;
    for (pc_index v = 0; v < spline->mesh.vertex_count; v++)
        if (spline->mesh.vertex[v].extraordinary) spline->mesh.vertex[v].depth = making.depth;
    pc_basis_free(&spline->basis, ctx);
    PC_TRY(pc_basis_make(&spline->basis, ctx, &spline->mesh));
    PC_TRY(pc_resize(&spline->bezier, ctx, 48 * (size_t)spline->basis.element_count));
    pc_tspline_update(spline);
done:
    return status;
}

/* All faces in four. */
static pc_status halve(pc_tspline *spline, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_closure_stats stats;
    uint8_t *wish = NULL;
    PC_TRY(pc_new(&wish, ctx, spline->mesh.face_count));
    memset(wish, PC_HALVE_S | PC_HALVE_T, spline->mesh.face_count);
    PC_TRY(pc_insertion_refine(spline, &stats, ctx, wish));
    PC_TRY(deepen(spline, ctx));
done:
    pc_free(ctx, wish);
    return status;
}

/* From n quads along a side, and twice as many, again and again. */
static pc_status uniform(pc_context *ctx, const pc_exact_shape *shape, pc_index n, pc_index most) {
    pc_status status = PC_OK;
    pc_tspline spline = {0};
    PC_TRY(fitted(&spline, ctx, shape, n));
    for (;;) {
        pc_exact_error error;
        pc_exact_measure(&error, NULL, NULL, &spline, shape);
        print_row(shape, "uniform", &spline, 0, &error);
        if (4 * spline.mesh.vertex_count > most) break;
        PC_TRY(halve(&spline, ctx));
        PC_TRY(pc_exact_fit(&spline, ctx, shape));
    }
done:
    pc_tspline_free(&spline, ctx);
    return status;
}

/* Faces over the tolerance, cut in four, or only halved along the direction in which the offsets change twice
 * as much as in the other. */
static pc_status refine(pc_tspline *spline, pc_closure_stats *stats, pc_context *ctx,
                        const pc_exact_shape *shape, double tolerance, bool in_four) {
    pc_status status = PC_OK;
    pc_exact_error error;
    uint8_t *wish = NULL;
    double *face_max = NULL, *change = NULL;
    PC_TRY(pc_new(&wish, ctx, spline->mesh.face_count));
    PC_TRY(pc_new(&face_max, ctx, spline->mesh.face_count));
    PC_TRY(pc_new(&change, ctx, 2 * (size_t)spline->mesh.face_count));
    pc_exact_measure(&error, face_max, change, spline, shape);
    for (size_t f = 0; f < spline->mesh.face_count; f++) {
        double s = change[2 * f], t = change[2 * f + 1];
        if (face_max[f] <= tolerance) continue;
        wish[f] = PC_HALVE_S | PC_HALVE_T;
        if (!in_four && s > 2 * t) wish[f] = PC_HALVE_S;
        if (!in_four && t > 2 * s) wish[f] = PC_HALVE_T;
    }
    PC_TRY(pc_insertion_refine(spline, stats, ctx, wish));
done:
    pc_free(ctx, wish);
    pc_free(ctx, face_max);
    pc_free(ctx, change);
    return status;
}

/* To one tolerance; with more than `most` points it ends without a row. */
static pc_status adapt(pc_index *points, pc_context *ctx, const pc_exact_shape *shape, pc_index n,
                       pc_index most, double tolerance, bool in_four) {
    pc_status status = PC_OK;
    pc_tspline spline = {0};
    pc_closure_stats stats = {0};
    pc_exact_error error;
    PC_TRY(fitted(&spline, ctx, shape, n));
    for (;;) {
        *points = spline.mesh.vertex_count;
        if (*points > most) goto done;
        pc_exact_measure(&error, NULL, NULL, &spline, shape);
        if (error.max <= tolerance) break;
        PC_TRY(refine(&spline, &stats, ctx, shape, tolerance, in_four));
        PC_TRY(pc_exact_fit(&spline, ctx, shape));
    }
    print_row(shape, in_four ? "in four" : "by direction", &spline, stats.junctions, &error);
done:
    pc_tspline_free(&spline, ctx);
    return status;
}

static pc_status adaptive(pc_context *ctx, const pc_exact_shape *shape, pc_index n, pc_index most,
                          bool in_four) {
    pc_status status = PC_OK;
    pc_index points = 0;
    for (double tolerance = 1e-3; status == PC_OK && points <= most; tolerance /= sqrt(10))
        status = adapt(&points, ctx, shape, n, most, tolerance, in_four);
    return status;
}

static pc_status study(pc_context *ctx, pc_index most) {
    pc_status status = PC_OK;
    PC_TRY(uniform(ctx, &pc_exact_torus, 4, most));
    PC_TRY(uniform(ctx, &pc_exact_torus, 6, most));
    PC_TRY(adaptive(ctx, &pc_exact_torus, 4, most, false));
    PC_TRY(uniform(ctx, &pc_exact_sphere, 2, most));
    PC_TRY(uniform(ctx, &pc_exact_sphere, 3, most));
    PC_TRY(adaptive(ctx, &pc_exact_sphere, 2, most, false));
    PC_TRY(adaptive(ctx, &pc_exact_sphere, 2, most, true));
done:
    return status;
}

int main(int argc, char **argv) {
    pc_context *ctx = pc_context_make();
    pc_index most = argc > 1 ? (pc_index)strtoul(argv[1], NULL, 10) : 9000;
    if (!ctx) return pc_status_exit_code(PC_E_NOMEM);
    pc_status status = study(ctx, most);
    if (status != PC_OK) (void)fprintf(stderr, "bench_convergence: %s\n", pc_context_message(ctx));
    pc_context_free(ctx);
    return pc_status_exit_code(status);
}
