#include "remesh.h"
#include "collapse.h"
#include "memory.h"
#include "mosaic.h"
#include "sizing.h"
#include "vec3.h"

/* The count follows the density but for a noise of a few cells; more tries than these gain nothing. */
enum { MOST_COLLAPSES = 5, MOST_TRIES = 9, MOST_TRIES_FOR_COUNT = 5 };
static const double CLOSE_ENOUGH = 0.02; /* the promise is 5 % */

/* Which cells nothing could set upright. */
static pc_index mark_folded_cells(uint8_t *wanted, const pc_polymesh *quads, const uint8_t *folded,
                                  const pc_index *face_cell) {
    pc_index count = 0;
    for (pc_index f = 0; f < quads->face_count; f++)
        if (folded[f]) wanted[face_cell[f]] = 1, count++;
    return count;
}

/* The cells themselves; those that stay upside down are joined to a neighbour each. */
static pc_status keep_cells(pc_polymesh *quads, uint8_t **folded, pc_remesh_quads_stats *stats,
                            pc_context *ctx, const pc_layout *layout, const pc_mesh *mesh,
                            const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    const pc_relax_options options = PC_RELAX_DEFAULTS;
    pc_mosaic mosaic = {0};
    uint8_t *upside_down = NULL, *wanted = NULL;
    pc_index *face_cell = NULL, gone, bad_before = 0;
    *quads = (pc_polymesh){0};
    PC_TRY(pc_mosaic_make(&mosaic, ctx, layout));
    pc_mosaic_mend(&mosaic);
    PC_TRY(pc_mosaic_drop_lines(&mosaic, &gone, ctx, PC_MOSAIC_LONGEST, PC_MOSAIC_SLIMMEST));
    for (int round = 0;; round++) {
        PC_TRY(pc_mosaic_polygons(quads, &face_cell, ctx, &mosaic));
        PC_TRY(pc_new(&upside_down, ctx, quads->face_count));
        PC_TRY(pc_relax(quads, &stats->relaxed, upside_down, ctx, mesh, adjacency, &options));
        if (round == 0) bad_before = stats->relaxed.bad_before;
        stats->relaxed.bad_before = bad_before;
        if (round == MOST_COLLAPSES) break;
        PC_TRY(pc_new(&wanted, ctx, mosaic.cell_count));
        if (mark_folded_cells(wanted, quads, upside_down, face_cell) == 0) break;
        pc_index joined = pc_mosaic_dissolve(&mosaic, wanted);
        if (joined == 0) break;
        stats->collapsed += joined;
        pc_free(ctx, wanted), pc_free(ctx, upside_down), pc_free(ctx, face_cell);
        wanted = upside_down = NULL, face_cell = NULL;
        pc_polymesh_free(quads, ctx);
    }
    if (folded) *folded = upside_down, upside_down = NULL;
done:
    pc_mosaic_free(&mosaic, ctx);
    pc_free(ctx, upside_down);
    pc_free(ctx, wanted);
    pc_free(ctx, face_cell);
    if (status != PC_OK) pc_polymesh_free(quads, ctx);
    return status;
}

pc_status pc_remesh_quads(pc_polymesh *quads, uint8_t **folded, pc_remesh_quads_stats *stats, pc_context *ctx,
                          const pc_layout *layout, pc_ngons ngons, const pc_mesh *mesh,
                          const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    const pc_relax_options options = PC_RELAX_DEFAULTS;
    uint8_t *upside_down = NULL;
    pc_index bad_before = 0;
    *stats = (pc_remesh_quads_stats){0};
    if (folded) *folded = NULL;
    if (ngons == PC_NGONS_KEEP) return keep_cells(quads, folded, stats, ctx, layout, mesh, adjacency);
    PC_TRY(pc_quads_make(quads, ctx, layout, ngons));
    PC_TRY(pc_doublets_remove(quads, &stats->doublets, ctx));
    for (int round = 0;; round++) {
        pc_index collapsed, doublets;
        PC_TRY(pc_new(&upside_down, ctx, quads->face_count));
        PC_TRY(pc_relax(quads, &stats->relaxed, upside_down, ctx, mesh, adjacency, &options));
        if (round == 0) bad_before = stats->relaxed.bad_before;
        stats->relaxed.bad_before = bad_before;
        if (round == MOST_COLLAPSES) break;
        PC_TRY(pc_quads_collapse(quads, &collapsed, ctx, upside_down));
        if (collapsed == 0) break;
        stats->collapsed += collapsed;
        PC_TRY(pc_doublets_remove(quads, &doublets, ctx));
        stats->doublets += doublets;
        pc_free(ctx, upside_down);
        upside_down = NULL;
    }
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
} remeshing;

static pc_status attempt(remeshing *r, double period) {
    pc_param_options options = PC_PARAM_DEFAULTS;
    options.period_length = period, options.seed = r->options->seed;
    /* As far in the edges of what is written as for cells that will be split. */
    if (r->options->ngons == PC_NGONS_KEEP) options.cancel_reach *= 2;
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
    PC_TRY(
        pc_remesh_quads(&quads, &folded, &made, r->ctx, r->layout, r->options->ngons, r->mesh, r->adjacency));
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
    remeshing r = {param, layout, NULL, stats, ctx, device, mesh, adjacency, field, options};
    *stats = (pc_remesh_stats){0};
    *param = (pc_param){0};
    *layout = (pc_layout){0};
    PC_TRY(pc_new(&r.scale, ctx, mesh->vertex_count));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        r.scale[v] = curl ? curl[v] : 1;
    PC_TRY(search(&r));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        stats->finest_scale = fmax(stats->finest_scale, r.scale[v]);
done:
    *scale = r.scale;
    if (status != PC_OK) {
        pc_free(ctx, r.scale);
        *scale = NULL;
        pc_param_free(param, ctx);
        pc_layout_free(layout, ctx);
    }
    return status;
}
