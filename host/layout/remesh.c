#include "remesh.h"
#include "collapse.h"
#include "memory.h"
#include "sizing.h"
#include "vec3.h"

/* The count follows the density but for a noise of a few cells; more tries than these gain nothing. */
enum { MOST_COLLAPSES = 5, MOST_TRIES = 9, MOST_TRIES_FOR_COUNT = 5 };
static const double CLOSE_ENOUGH = 0.02; /* the promise is 5 % */

/* In rounds: relaxed as a whole, the last upside down ones set up one by one, and those that stay so drawn
 * together. */
static pc_status set_upright(pc_polymesh *quads, uint8_t **folded, pc_remesh_quads_stats *stats,
                             pc_context *ctx, pc_ngons ngons, const pc_ground *ground) {
    pc_status status = PC_OK;
    pc_relax_options options = PC_RELAX_DEFAULTS;
    const pc_upright_options upright = PC_UPRIGHT_DEFAULTS;
    for (int round = 0;; round++) {
        pc_index collapsed, doublets;
        pc_free(ctx, *folded);
        *folded = NULL;
        PC_TRY(pc_new(folded, ctx, quads->face_count));
        if (round == 0) PC_TRY(pc_relax(quads, &stats->relaxed, *folded, ctx, ground, &options));
        PC_TRY(pc_upright_make(quads, *folded, &stats->folded, ctx, ground, &upright));
        if (stats->folded == 0 || ngons == PC_NGONS_KEEP || round == MOST_COLLAPSES) break;
        PC_TRY(pc_quads_collapse(quads, &collapsed, ctx, *folded));
        if (collapsed == 0) break;
        stats->collapsed += collapsed;
        PC_TRY(pc_doublets_remove(quads, &doublets, ctx));
        stats->doublets += doublets;
    }
done:
    return status;
}

pc_status pc_remesh_quads(pc_polymesh *quads, uint8_t **folded, pc_remesh_quads_stats *stats, pc_context *ctx,
                          const pc_layout *layout, pc_ngons ngons, const pc_ground *ground) {
    pc_status status = PC_OK;
    uint8_t *upside_down = NULL;
    *stats = (pc_remesh_quads_stats){0};
    if (folded) *folded = NULL;
    PC_TRY(pc_quads_make(quads, ctx, layout, ngons));
    if (ngons == PC_NGONS_SPLIT) PC_TRY(pc_doublets_remove(quads, &stats->doublets, ctx));
    PC_TRY(set_upright(quads, &upside_down, stats, ctx, ngons, ground));
    if (folded) *folded = upside_down, upside_down = NULL;
done:
    pc_free(ctx, upside_down);
    if (status != PC_OK) pc_polymesh_free(quads, ctx);
    return status;
}

typedef struct remeshing {
    pc_param *param;
    pc_layout *layout;
    double *scale;
    pc_remesh_stats *stats;
    pc_context *ctx;
    pc_device *device;
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    const pc_field *field;
    const pc_remesh_options *options;
    pc_ground ground;
} remeshing;

static pc_status attempt(remeshing *r, double period) {
    pc_param_options options = PC_PARAM_DEFAULTS;
    options.period_length = period, options.seed = r->options->seed;
    pc_layout_free(r->layout, r->ctx);
    pc_param_free(r->param, r->ctx);
    pc_status status = pc_param_make(r->param, &r->stats->param, r->ctx, r->device, r->mesh, r->adjacency,
                                     r->field, r->scale, &options);
    if (status == PC_OK) status = pc_layout_make(r->layout, &r->stats->layout, r->ctx, r->mesh, r->param);
    return status;
}

/* Looks at the quads of the present layout; returns their number, and raises the scale where they fail. */
static pc_status look(remeshing *r, double *count, double period, bool refine) {
    pc_status status = PC_OK;
    pc_polymesh quads = {0};
    uint8_t *folded = NULL;
    pc_remesh_quads_stats made;
    pc_sizing_options sizing = PC_SIZING_DEFAULTS;
    r->stats->wanting = 0;
    *count = (double)pc_quads_count(r->layout, r->options->ngons);
    if (!refine && r->options->quads == 0) return PC_OK; /* nobody asks: a line in the log at most */
    /* Not pc_quads_count: doublets and collapsed quads do not count. */
    PC_TRY(pc_remesh_quads(&quads, &folded, &made, r->ctx, r->layout, r->options->ngons, &r->ground));
    *count = quads.face_count;
    if (!refine) goto done;
    sizing.edge_length = r->options->ngons == PC_NGONS_SPLIT ? period / 2 : period;
    sizing.period_length = period;
    PC_TRY(pc_sizing_update(r->scale, &r->stats->wanting, r->ctx, r->mesh, r->adjacency, &quads, folded,
                            &sizing));
done:
    pc_polymesh_free(&quads, r->ctx);
    pc_free(r->ctx, folded);
    return status;
}

/* A smaller period than the mesh was refined for must not meet an edge of half of it. */
static void limit_scale(remeshing *r, double period) {
    for (pc_index e = 0; e < r->adjacency->edge_count; e++) {
        pc_index h = r->adjacency->edge_half[e], a = pc_tail(r->mesh, h), b = pc_head(r->mesh, h);
        double most =
            0.48 * period / pc_distance(pc_vec3_at(r->mesh->position, a), pc_vec3_at(r->mesh->position, b));
        r->scale[a] = fmin(r->scale[a], most), r->scale[b] = fmin(r->scale[b], most);
    }
}

static pc_status search(remeshing *r) {
    pc_status status = PC_OK;
    double period = r->options->period_length, wanted = r->options->quads, best_miss = INFINITY,
           best_period = period;
    int tries_for_count = 0;
    for (r->stats->tries = 1;; r->stats->tries++) {
        double count;
        bool refine = r->stats->refinements < r->options->refinements;
        limit_scale(r, period);
        PC_TRY(attempt(r, period));
        PC_TRY(look(r, &count, period, refine));
        pc_log(r->ctx, PC_LOG_INFO, "cells of side %.5g give %.0f quads%s", period, count,
               r->stats->wanting ? ", finer ones are needed in places" : "");
        bool again = refine && r->stats->wanting;
        r->stats->refinements += again;
        if (again && r->stats->tries < MOST_TRIES) {
            if (wanted > 0) period *= sqrt(count / wanted);
            continue;
        }
        if (wanted == 0) break;
        double miss = fabs(count / wanted - 1);
        if (miss < best_miss) best_miss = miss, best_period = period;
        if (miss <= CLOSE_ENOUGH) break;
        if (r->stats->tries >= MOST_TRIES || ++tries_for_count == MOST_TRIES_FOR_COUNT) {
            if (best_period != period) status = attempt(r, best_period);
            break;
        }
        r->stats->refinements =
            r->options->refinements; /* sizes are settled: only the density is sought now */
        period *= sqrt(count / wanted);
    }
done:
    return status;
}

pc_status pc_remesh_make(pc_param *param, pc_layout *layout, double **scale, pc_remesh_stats *stats,
                         pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                         const pc_adjacency *adjacency, const pc_field *field, const double *curl,
                         const pc_remesh_options *options) {
    pc_status status = PC_OK;
    remeshing r = {param, layout, NULL, stats, ctx, device, mesh, adjacency, field, options, {0}};
    *stats = (pc_remesh_stats){0};
    *param = (pc_param){0};
    *layout = (pc_layout){0};
    PC_TRY(pc_new(&r.scale, ctx, mesh->vertex_count));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        r.scale[v] = curl ? curl[v] : 1;
    PC_TRY(pc_ground_make(&r.ground, ctx, mesh, adjacency));
    PC_TRY(search(&r));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        stats->finest_scale = fmax(stats->finest_scale, r.scale[v]);
done:
    pc_ground_free(&r.ground, ctx);
    *scale = r.scale;
    if (status != PC_OK) {
        pc_free(ctx, r.scale);
        *scale = NULL;
        pc_param_free(param, ctx);
        pc_layout_free(layout, ctx);
    }
    return status;
}
