#include "refine.h"
#include "bisect.h"
#include "memory.h"
#include "vec3.h"
#include <float.h>
#include <string.h>

static double limit_of(const pc_refine_options *options, pc_index face) {
    if (!options->component_max_edge) return options->max_edge;
    return options->component_max_edge[options->face_component[face]];
}

/* An edge whose midpoint would round to one of its ends is as short as it gets. */
static bool too_long(const pc_refined *refined, pc_index h, double limit) {
    const pc_mesh *mesh = &refined->mesh;
    pc_vec3 a = pc_vec3_at(mesh->position, pc_tail(mesh, h)),
            b = pc_vec3_at(mesh->position, pc_head(mesh, h));
    double length = pc_distance(a, b);
    return length > limit && length > 8 * DBL_EPSILON * (pc_norm(a) + pc_norm(b));
}

static bool any_too_long(const pc_refined *refined, const pc_refine_options *options) {
    bool found = false;
#pragma omp parallel for schedule(static) reduction(|| : found)
    for (pc_index h = 0; h < 3 * refined->mesh.face_count; h++)
        found = found || too_long(refined, h, limit_of(options, refined->face_source[h / 3]));
    return found;
}

/* Fills `midpoint` per half-edge and `parent` per new vertex, numbered in edge order. */
static size_t mark_edges(pc_index *midpoint, pc_index *parent, const pc_refined *refined,
                         const pc_adjacency *adjacency, const pc_refine_options *options) {
    size_t count = 0;
    const pc_mesh *mesh = &refined->mesh;
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        pc_index h = adjacency->edge_half[e], twin = adjacency->twin[h], mark = PC_NONE;
        double limit = limit_of(options, refined->face_source[h / 3]);
        if (twin != PC_NONE) limit = fmin(limit, limit_of(options, refined->face_source[twin / 3]));
        if (too_long(refined, h, limit)) {
            mark = (pc_index)count;
            parent[2 * count] = pc_tail(mesh, h), parent[2 * count + 1] = pc_head(mesh, h);
            count++;
        }
        midpoint[h] = mark;
        if (twin != PC_NONE) midpoint[twin] = mark;
    }
    return count;
}

static pc_status check_budget(pc_context *ctx, const pc_refined *refined, const pc_index *midpoint,
                              const pc_refine_options *options) {
    size_t faces = refined->mesh.face_count;
    for (pc_index h = 0; h < 3 * refined->mesh.face_count; h++)
        faces += midpoint[h] != PC_NONE;
    if (options->max_faces && faces > options->max_faces)
        return pc_fail(
            ctx, PC_E_MESH,
            "splitting long edges needs more than %zu faces (%zu so far): allow more of them, or ask for "
            "fewer, larger quads",
            options->max_faces, faces);
    return PC_OK;
}

/* One round; the products replace those in `refined`. */
static pc_status split_round(pc_refined *refined, pc_context *ctx, const pc_refine_options *options) {
    pc_status status = PC_OK;
    pc_adjacency adjacency = {0};
    pc_mesh finer = {0};
    pc_index *midpoint = NULL, *parent = NULL, *source = NULL;
    size_t added = refined->mesh.vertex_count - refined->original_vertex_count, count;
    PC_TRY(pc_adjacency_make(&adjacency, ctx, &refined->mesh));
    PC_TRY(pc_new(&midpoint, ctx, 3 * (size_t)refined->mesh.face_count));
    PC_TRY(pc_new(&parent, ctx, 2 * (size_t)adjacency.edge_count));
    count = mark_edges(midpoint, parent, refined, &adjacency, options);
    PC_TRY(check_budget(ctx, refined, midpoint, options));
    PC_TRY(pc_bisect_edges(&finer, &source, ctx, &refined->mesh, midpoint, parent, count));
    PC_TRY(pc_resize(&refined->parent, ctx, 2 * (added + count)));
    memcpy(refined->parent + 2 * added, parent, 2 * count * sizeof *parent);
    for (size_t f = 0; f < finer.face_count; f++)
        source[f] = refined->face_source[source[f]];
    pc_mesh_free(&refined->mesh, ctx);
    pc_free(ctx, refined->face_source);
    refined->mesh = finer, finer = (pc_mesh){0};
    refined->face_source = source, source = NULL;
    refined->rounds++;
done:
    pc_adjacency_free(&adjacency, ctx);
    pc_mesh_free(&finer, ctx);
    pc_free(ctx, midpoint);
    pc_free(ctx, parent);
    pc_free(ctx, source);
    return status;
}

static pc_status check_limits(pc_context *ctx, const pc_mesh *mesh, const pc_refine_options *options) {
    if (options->component_max_edge && !options->face_component)
        return pc_fail(ctx, PC_E_USAGE, "limits per component need the component of each face");
    for (pc_index f = 0; f < mesh->face_count; f++)
        if (!(limit_of(options, f) > 0))
            return pc_fail(ctx, PC_E_USAGE, "the longest edge allowed must be positive, not %g",
                           limit_of(options, f));
    return PC_OK;
}

pc_status pc_refine(pc_refined *refined, pc_context *ctx, const pc_mesh *mesh,
                    const pc_refine_options *options) {
    pc_status status = PC_OK;
    *refined = (pc_refined){.original_vertex_count = mesh->vertex_count};
    PC_TRY(check_limits(ctx, mesh, options));
    PC_TRY(pc_mesh_copy(&refined->mesh, ctx, mesh));
    PC_TRY(pc_new(&refined->face_source, ctx, mesh->face_count));
    PC_TRY(pc_new(&refined->parent, ctx, 0));
    for (pc_index f = 0; f < mesh->face_count; f++)
        refined->face_source[f] = f;
    while (any_too_long(refined, options)) {
        PC_TRY(pc_check_interrupt(ctx));
        PC_TRY(split_round(refined, ctx, options));
    }
done:
    if (status != PC_OK) pc_refined_free(refined, ctx);
    return status;
}

void pc_refined_free(pc_refined *refined, pc_context *ctx) {
    if (!refined) return;
    pc_mesh_free(&refined->mesh, ctx);
    pc_free(ctx, refined->face_source);
    pc_free(ctx, refined->parent);
    *refined = (pc_refined){0};
}
