#include "curvature.h"
#include "geometry.h"
#include "memory.h"
#include "normalcycle.h"
#include "vec3.h"

static pc_status new_arrays(pc_curvature *c, pc_context *ctx, size_t n) {
    pc_status status = PC_OK;
    PC_TRY(pc_new(&c->normal, ctx, 3 * n));
    PC_TRY(pc_new(&c->tensor, ctx, 6 * n));
    PC_TRY(pc_new(&c->value, ctx, 2 * n));
    PC_TRY(pc_new(&c->direction, ctx, 3 * n));
    PC_TRY(pc_new(&c->weight, ctx, n));
done:
    return status;
}

/* Coherence of pure noise shrinks with the number of passes: measured on planes with white noise along z. */
static double noise_coherence(int passes) {
    return 0.35 / (1.0 + passes);
}

/* A walk on an even mesh has a variance of 6/7 h^2/2 per axis and step, a disk radius^2/4. */
static void set_levels(pc_normalcycle *work, double radius, const pc_curvature_options *options) {
    work->level_count = options->levels < 1 ? 1 : options->levels;
    if (work->level_count > PC_NORMALCYCLE_LEVELS) work->level_count = PC_NORMALCYCLE_LEVELS;
    for (int k = 0; k < work->level_count; k++) {
        double rings = work->step > 0 ? radius / work->step : 0;
        int passes = 1 + (int)fmin(rings * rings / 1.71, 1000);
        double flat = radius > 0 ? options->flatness / radius : 0;
        work->level[k] = (pc_normalcycle_level){passes, flat, noise_coherence(passes)};
        radius *= 2;
    }
}

pc_status pc_curvature_make(pc_curvature *curvature, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                            const pc_adjacency *adjacency, const pc_curvature_options *options) {
    pc_status status = PC_OK;
    pc_ring ring = {0};
    double mean = pc_geometry_mean_edge(mesh, adjacency);
    double radius = options->radius > 0 ? options->radius : options->radius_edges * mean;
    pc_normalcycle work = {.mesh = mesh, .adjacency = adjacency, .ring = &ring, .step = mean};
    *curvature = (pc_curvature){.vertex_count = mesh->vertex_count, .radius = radius, .mean_edge = mean};
    set_levels(&work, radius, options);
    PC_TRY(new_arrays(curvature, ctx, mesh->vertex_count));
    PC_TRY(pc_ring_make(&ring, ctx, mesh, adjacency));
    if (!device || pc_device_is_host(device))
        PC_TRY(pc_normalcycle_ref(curvature, ctx, &work));
    else
        PC_TRY(pc_normalcycle_launch(curvature, ctx, device, &work));
done:
    pc_ring_free(&ring, ctx);
    if (status != PC_OK) pc_curvature_free(curvature, ctx);
    return status;
}

void pc_curvature_free(pc_curvature *curvature, pc_context *ctx) {
    if (!curvature) return;
    pc_free(ctx, curvature->normal);
    pc_free(ctx, curvature->tensor);
    pc_free(ctx, curvature->value);
    pc_free(ctx, curvature->direction);
    pc_free(ctx, curvature->weight);
    *curvature = (pc_curvature){0};
}

pc_status pc_curvature_check(const pc_curvature *c, pc_context *ctx) {
    for (pc_index v = 0; v < c->vertex_count; v++) {
        pc_vec3 n = pc_vec3_at(c->normal, v), d = pc_vec3_at(c->direction, v);
        const double *k = c->value + 2 * (size_t)v;
        bool good = isfinite(k[0]) && isfinite(k[1]) && k[0] >= k[1] && c->weight[v] >= 0 &&
                    c->weight[v] <= 1 && fabs(pc_norm(n) - 1) < 1e-6 && fabs(pc_norm(d) - 1) < 1e-6 &&
                    fabs(pc_dot(n, d)) < 1e-6;
        if (!good) return pc_fail(ctx, PC_E_BUG, "curvature of vertex %u is not sound", v);
    }
    return PC_OK;
}
