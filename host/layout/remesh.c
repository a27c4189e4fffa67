#include "remesh.h"
#include "collapse.h"
#include "geometry.h"
#include "memory.h"
#include "mosaic_quads.h"
#include "pilot.h"
#include "room.h"
#include "sizing.h"
#include "strips.h"
#include "vec3.h"
#include <string.h>

enum { MOST_RESCUES = 2, MOST_COLLAPSES = 24, MOST_TRIES_FOR_COUNT = 5, MOST_STRIPS = 12, MOST_FAILURES = 6 };
/* Of the count: a miss that ends the search at once, and one that ends it where more tries have not helped;
 * the promise is 5 %. */
static const double CLOSE = 0.025, CLOSE_ENOUGH = 0.045;
static const double FAR_OFF = 0.15; /* strips cannot make up for more */
static const double MOST_FINER = 6; /* cells, for the sake of a coarser rest */
static const double FEW = 1e-3;     /* of the scan's vertices: so few alone are not worth another round */
static const double LOST = 1.4;     /* times the reach: a part of the scan that far off is lost */
/* ... and worth another try where sizes have been tried on likenesses. */
static const double LOST_ALTOGETHER = 2;
/* A round of refinement for the same count that leaves more than this part of the distances is in vain. */
static const double WORTHWHILE = 0.9;
enum { LARGE = 1000000 }; /* faces: another try costs as much as all before it */

/* Flags also the faces that share a vertex with a flagged one. */
static pc_status flag_around(uint8_t *flag, pc_context *ctx, const pc_polymesh *quads) {
    pc_status status = PC_OK;
    uint8_t *near = NULL;
    PC_TRY(pc_new(&near, ctx, quads->vertex_count));
    for (pc_index f = 0; f < quads->face_count; f++)
        for (pc_index c = quads->start[f]; flag[f] && c < quads->start[f + 1]; c++)
            near[quads->corner[c]] = 1;
    for (pc_index f = 0; f < quads->face_count; f++)
        for (pc_index c = quads->start[f]; c < quads->start[f + 1]; c++)
            flag[f] = flag[f] || near[quads->corner[c]];
done:
    pc_free(ctx, near);
    return status;
}

/* In rounds: relaxed as a whole, the last upside down ones set up one by one, and those that stay so drawn
 * together. */
static pc_status set_upright(pc_polymesh *quads, uint8_t **folded, pc_remesh_quads_stats *stats,
                             pc_context *ctx, const pc_ground *ground) {
    pc_status status = PC_OK;
    pc_relax_options options = PC_RELAX_DEFAULTS;
    const pc_upright_options upright = PC_UPRIGHT_DEFAULTS;
    pc_upright_memory *memory = NULL; /* a round changes the mesh in few places */
    for (int round = 0;; round++) {
        pc_index collapsed, doublets;
        pc_free(ctx, *folded);
        *folded = NULL;
        PC_TRY(pc_new(folded, ctx, quads->face_count));
        if (round == 0) PC_TRY(pc_relax(quads, &stats->relaxed, *folded, ctx, ground, &options));
        PC_TRY(pc_upright_make(quads, *folded, &stats->folded, &memory, ctx, ground, &upright));
        pc_log(ctx, PC_LOG_DEBUG, "quads: %u faces folded after %u have been collapsed", stats->folded,
               stats->collapsed);
        if (stats->folded == 0 || round == MOST_COLLAPSES) break;
        PC_TRY(pc_quads_collapse(quads, &collapsed, ctx, *folded));
        if (collapsed == 0) { /* one of those around may do */
            PC_TRY(flag_around(*folded, ctx, quads));
            PC_TRY(pc_quads_collapse(quads, &collapsed, ctx, *folded));
        }
        if (collapsed == 0) break;
        stats->collapsed += collapsed;
        PC_TRY(pc_doublets_remove(quads, &doublets, ctx, false));
        stats->doublets += doublets;
    }
done:
    pc_upright_memory_free(memory, ctx);
    return status;
}

/* Strips are doubled or drawn together while that brings the count nearer and folds nothing. */
static pc_status meet_count(pc_polymesh *quads, uint8_t **folded, pc_remesh_quads_stats *stats,
                            pc_context *ctx, double wanted, const pc_ground *ground) {
    pc_status status = PC_OK;
    pc_polymesh changed = {0};
    uint8_t *upside_down = NULL;
    stats->laid_out = quads->face_count;
    if (fabs(quads->face_count / wanted - 1) > FAR_OFF) return PC_OK;
    for (int failures = 0, rank = 0; failures < MOST_FAILURES && stats->strips < MOST_STRIPS;) {
        bool made;
        pc_remesh_quads_stats after = *stats;
        double miss = fabs(quads->face_count / wanted - 1);
        if (miss <= CLOSE_ENOUGH) break;
        PC_TRY(pc_strips_change(&changed, &made, ctx, quads, ground, wanted, CLOSE, rank));
        if (!made) break;
        PC_TRY(set_upright(&changed, &upside_down, &after, ctx, ground));
        if (after.folded > stats->folded || fabs(changed.face_count / wanted - 1) >= miss) {
            pc_polymesh_free(&changed, ctx);
            rank++, failures++;
            continue;
        }
        pc_polymesh_free(quads, ctx);
        pc_free(ctx, *folded);
        *quads = changed, changed = (pc_polymesh){0};
        *folded = upside_down, upside_down = NULL;
        *stats = after;
        stats->strips++, rank = 0;
    }
done:
    pc_polymesh_free(&changed, ctx);
    pc_free(ctx, upside_down);
    return status;
}

pc_status pc_remesh_quads(pc_polymesh *quads, uint8_t **folded, pc_remesh_quads_stats *stats, pc_context *ctx,
                          const pc_layout *layout, pc_ngons ngons, double wanted, const pc_ground *ground) {
    pc_status status = PC_OK;
    uint8_t *upside_down = NULL;
    *stats = (pc_remesh_quads_stats){0};
    if (folded) *folded = NULL;
    if (ngons == PC_NGONS_KEEP) {
        pc_mosaic_quads_stats kept;
        PC_TRY(pc_mosaic_quads(quads, &upside_down, &kept, ctx, layout, ground));
        stats->relaxed = kept.relaxed, stats->folded = kept.folded, stats->collapsed = kept.dissolved;
    } else {
        PC_TRY(pc_quads_make(quads, ctx, layout, ngons));
        PC_TRY(pc_doublets_remove(quads, &stats->doublets, ctx, false));
        PC_TRY(set_upright(quads, &upside_down, stats, ctx, ground));
        if (wanted > 0) PC_TRY(meet_count(quads, &upside_down, stats, ctx, wanted, ground));
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
    pc_remesh_looked *looked; /* or NULL */
    pc_context *ctx;
    pc_device *device;
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    const pc_field *field;
    const pc_remesh_options *options;
    double *tried;  /* the scale that the present parameterization is made with */
    double *base;   /* the scale before any refinement: curl correction, and room for singularities */
    double period;  /* that the scale belongs to */
    double nominal; /* the period of cells that are all as large, for the wanted count */
    bool piloted;   /* both have been found on likenesses of the scan */
    struct remeshing *whole; /* that this is a likeness of, or NULL */
    bool fresh;              /* the likeness has not been used yet */
    pc_pilot pilot;
} remeshing;

/* The scale of a vertex at a period `change` times as long. Places that have been refined follow it only
 * half: what was found there would be lost again. */
static double scale_at(const remeshing *r, pc_index v, double change) {
    const double finer = r->scale[v] / r->base[v];
    if (!(finer > 1)) return r->scale[v];
    return r->base[v] * fmax(1, fmin(finer * pow(change, fmin(0.5, finer - 1)), fmax(finer, MOST_FINER)));
}

static void set_period(remeshing *r, double period) {
    const double change = period / r->period;
    for (pc_index v = 0; v < r->mesh->vertex_count; v++)
        r->scale[v] = scale_at(r, v, change);
    r->period = period;
}

/* No cell may meet an edge of half its side. */
static void limit_by_edges(remeshing *r) {
    pc_sizing_limit_by_edges(r->scale, r->mesh, r->adjacency, 0.48 * r->period, 0);
}

static double largest(const double *scale, pc_index count) {
    double most = 0;
    for (pc_index v = 0; v < count; v++)
        most = fmax(most, scale[v]);
    return most;
}

static pc_status vertex_areas(double **area, const remeshing *r) {
    const pc_status status = pc_new(area, r->ctx, r->mesh->vertex_count);
    if (status == PC_OK) pc_geometry_vertex_areas(*area, r->mesh, 1e-6);
    return status;
}

/* How many cells a period would give if all were as large as asked. */
static double cells_at(const remeshing *r, const double *area, double period) {
    double sum = 0;
    for (pc_index v = 0; v < r->mesh->vertex_count; v++)
        sum += area[v] * pow(scale_at(r, v, period / r->period) / period, 2);
    return sum;
}

static pc_status count_cells(double *cells, const remeshing *r) {
    double *area = NULL;
    const pc_status status = vertex_areas(&area, r);
    if (status == PC_OK) *cells = cells_at(r, area, r->period);
    pc_free(r->ctx, area);
    return status;
}

/* The period at which there are so many. */
static pc_status period_for(double *period, const remeshing *r, double cells) {
    enum { STEPS = 8 };
    pc_status status = PC_OK;
    double *area = NULL, slope = -2;
    PC_TRY(vertex_areas(&area, r));
    double at = r->period, asked = cells_at(r, area, at);
    for (int k = 0; k < STEPS && fabs(log(asked / cells)) > 1e-3; k++) { /* secants of the logarithms */
        const double next = at * exp(log(cells / asked) / slope), there = cells_at(r, area, next);
        slope = fmin(fmax(log(there / asked) / log(next / at), -2), -0.5);
        at = next, asked = there;
    }
    *period = at;
done:
    pc_free(r->ctx, area);
    return status;
}

static double mean_square(const double *scale, const pc_mesh *mesh) {
    double sum = 0, area = 0;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        pc_vec3 p = pc_vec3_at(mesh->position, t[0]), a = pc_sub(pc_vec3_at(mesh->position, t[1]), p);
        double size = pc_norm(pc_cross(a, pc_sub(pc_vec3_at(mesh->position, t[2]), p)));
        double mean = (scale[t[0]] + scale[t[1]] + scale[t[2]]) / 3;
        sum += size * mean * mean, area += size;
    }
    return area > 0 ? sum / area : 1;
}

static pc_status sample(double **out, const remeshing *r, const double *value) {
    const pc_coarse *coarse = &r->pilot.coarse;
    pc_free(r->ctx, *out), *out = NULL;
    pc_status status = pc_new(out, r->ctx, coarse->mesh.vertex_count);
    for (pc_index v = 0; status == PC_OK && v < coarse->mesh.vertex_count; v++)
        (*out)[v] = value[coarse->source[v]];
    return status;
}

/* The whole takes over the scale and the period of its likeness. */
static pc_status take_over(remeshing *r) {
    r->whole->period = r->period;
    return pc_pilot_carry(r->whole->scale, r->ctx, &r->pilot, r->scale, r->whole->mesh, r->whole->adjacency);
}

/* A likeness as fine as the present cells need it; *worthwhile is false where none is much smaller. */
static pc_status renew_pilot(remeshing *r, bool *worthwhile) {
    pc_status status = PC_OK;
    const remeshing *whole = r->whole;
    pc_pilot_free(&r->pilot, r->ctx);
    PC_TRY(pc_pilot_make(&r->pilot, r->ctx, r->device, whole->mesh, whole->adjacency, whole->field,
                         whole->scale, whole->period));
    *worthwhile = r->pilot.coarse.mesh.face_count > 0;
    if (!*worthwhile) goto done;
    r->mesh = &r->pilot.coarse.mesh, r->adjacency = &r->pilot.adjacency, r->field = &r->pilot.field;
    PC_TRY(sample(&r->scale, r, whole->scale));
    PC_TRY(sample(&r->base, r, whole->base));
    r->period = whole->period;
    r->fresh = true;
done:
    return status;
}

static pc_status attempt(remeshing *r, double period) {
    pc_param_options options = PC_PARAM_DEFAULTS;
    options.period_length = period;
    options.pgp.seed = r->options->seed;
    options.pgp.scheme = r->options->scheme;
    /* As far in the edges of what is written as for cells that will be split. */
    if (r->options->ngons == PC_NGONS_KEEP) options.cancel_reach *= 2;
    set_period(r, period);
    if (r->whole && !r->fresh) {
        bool worthwhile;
        pc_status status = take_over(r);
        if (status == PC_OK) status = renew_pilot(r, &worthwhile);
        if (status != PC_OK) return status;
        if (!worthwhile) return pc_fail(r->ctx, PC_E_NOCONV, "the cells are too small for a likeness");
    }
    limit_by_edges(r);
    if (!r->whole) memcpy(r->tried, r->scale, sizeof *r->tried * r->mesh->vertex_count);
    r->fresh = false;
    r->stats->tries++;
    pc_layout_free(r->layout, r->ctx);
    pc_param_free(r->param, r->ctx);
    if (r->looked) pc_polymesh_free(&r->looked->quads, r->ctx);
    pc_status status = pc_param_make(r->param, &r->stats->param, r->ctx, r->device, r->mesh, r->adjacency,
                                     r->field, r->scale, &options);
    if (status == PC_OK) status = pc_layout_make(r->layout, &r->stats->layout, r->ctx, r->mesh, r->param);
    return status;
}

/* What a look at the quads of the present layout finds. */
typedef struct outcome {
    double count;   /* as the layout gives it */
    double reached; /* ... after strips have been doubled or drawn together for it */
    pc_index folded;
    double asked; /* cells, for that count; 0 where nobody wants to know */
    double far;   /* of the farthest vertex, times the reach */
    double loss;  /* typical distance of the scan's vertices, farther ones count more */
    bool wanting; /* the scale has been raised, and it is worth another try */
} outcome;

static int most_refinements(const remeshing *r) {
    const int asked = r->options->refinements;
    return asked > 1 && !r->piloted && r->mesh->face_count > LARGE ? 1 : asked;
}

/* `far`: of the farthest vertex, times the reach. A spline needs all of the scan; after the rounds that were
 * asked for there are others only where a part of the scan is lost. */
static bool is_worth_another(const remeshing *r, const pc_sizing_stats *sizes, pc_index folded, double far) {
    const bool for_spline = r->options->reach > 0;
    if (sizes->wanting == 0) return false;
    if (r->piloted && !for_spline) return far > LOST_ALTOGETHER;
    if (r->stats->refinements >= most_refinements(r)) return far > LOST;
    return r->stats->refinements == 0 || folded || sizes->wanting > FEW * r->mesh->vertex_count ||
           far > (for_spline ? 1 : LOST);
}

/* Hands on what would be made once more, strips or not. */
static void keep_quads(remeshing *r, pc_polymesh *quads, const pc_remesh_quads_stats *made, double wanted) {
    const double asked = r->options->quads, miss = asked > 0 ? fabs(quads->face_count / asked - 1) : 0;
    if (!r->looked || (wanted != asked && miss > CLOSE_ENOUGH)) return;
    pc_polymesh_free(&r->looked->quads, r->ctx);
    r->looked->quads = *quads, r->looked->stats = *made;
    *quads = (pc_polymesh){0};
}

/* Looks at the quads of the present layout, and raises the scale where they fail. */
static pc_status look(remeshing *r, outcome *found, bool refine, double wanted) {
    pc_status status = PC_OK;
    pc_polymesh quads = {0};
    pc_ground ground = {0}; /* not kept: the parameterization needs the memory */
    uint8_t *folded = NULL;
    pc_remesh_quads_stats made;
    pc_sizing_options sizing = PC_SIZING_DEFAULTS;
    pc_sizing_stats sizes;
    *found = (outcome){.count = (double)pc_quads_count(r->layout, r->options->ngons)};
    if (r->options->quads > 0) PC_TRY(count_cells(&found->asked, r));
    if (!refine && r->options->quads == 0) return PC_OK; /* nobody asks: a line in the log at most */
    /* Not pc_quads_count: doublets and collapsed quads do not count. */
    PC_TRY(pc_ground_make(&ground, r->ctx, r->mesh, r->adjacency));
    PC_TRY(pc_remesh_quads(&quads, &folded, &made, r->ctx, r->layout, r->options->ngons, wanted, &ground));
    found->reached = quads.face_count;
    found->count = made.strips ? made.laid_out : quads.face_count;
    found->folded = made.folded;
    if (!refine) goto done;
    sizing.edge_length = r->options->ngons == PC_NGONS_SPLIT ? r->period / 2 : r->period;
    sizing.period_length = r->period;
    if (r->options->reach > 0) sizing.reach = r->options->reach;
    if (r->options->floor > 0) sizing.floor = r->options->floor;
    sizing.walls = r->options->walls;
    if (!r->piloted && r->options->quads > 0)
        sizing.farthest = sizing.reach * sizing.edge_length * r->nominal / r->period;
    PC_TRY(pc_sizing_update(r->scale, &sizes, r->ctx, &ground, &quads, folded, &sizing));
    r->stats->wanting = sizes.wanting;
    const double limit = sizing.reach * sizing.edge_length,
                 far = sizes.worst / (sizing.farthest > 0 ? fmin(sizing.farthest, limit) : limit);
    found->far = far, found->loss = sizes.typical;
    found->wanting = is_worth_another(r, &sizes, made.folded, far);
    pc_log(r->ctx, PC_LOG_DEBUG,
           "%u vertices of the scan want finer cells, the farthest is %.3g times the reach off",
           sizes.wanting, far);
    if (r->whole && !found->wanting) { /* what is not worth a try is not wanted of the whole either */
        PC_TRY(sample(&r->scale, r, r->whole->scale));
        limit_by_edges(r);
    }
done:
    if (status == PC_OK) keep_quads(r, &quads, &made, wanted);
    pc_ground_free(&ground, r->ctx);
    pc_polymesh_free(&quads, r->ctx);
    pc_free(r->ctx, folded);
    return status;
}

/* What is known of how the count follows the period: the nearest tries with too few and with too many, and
 * the one before. A count of 0: none yet. */
typedef struct bracket {
    double few_period, few;
    double many_period, many;
    double last_period, last;
} bracket;

/* The period to try next: between the two by their logarithms; where one is missing, along the slope of the
 * last two tries, at first that of a constant count * period^2. */
static double guess(bracket *b, double period, double count, double wanted) {
    double slope = b->last > 0 ? log(count / b->last) / log(period / b->last_period) : -2;
    if (count < wanted)
        b->few_period = period, b->few = count;
    else
        b->many_period = period, b->many = count;
    b->last_period = period, b->last = count;
    if (!(slope > -2)) slope = -2;
    if (slope > -0.7) slope = -0.7;
    if (b->few == 0 || b->many == 0) return period * exp(log(wanted / count) / slope);
    double at = log(wanted / b->many) / log(b->few / b->many);
    return b->many_period * pow(b->few_period / b->many_period, fmin(fmax(at, 0.15), 0.85));
}

/* For the wanted count, as far as one outcome can tell. The scale may have been raised since. */
static pc_status next_period(double *period, const remeshing *r, const outcome *found) {
    if (found->asked > 0) return period_for(period, r, found->asked * r->options->quads / found->count);
    *period = r->period * sqrt(found->count / r->options->quads);
    return PC_OK;
}

/* The best try so far, in terms of the whole scan; of a likeness nobody looks at the layout again. */
typedef struct best_try {
    double miss, period;
    double *scale;
    outcome found;
    bool present; /* the last try is it */
    pc_param param;
    pc_layout layout;
    pc_remesh_stats stats;
    pc_remesh_looked looked;
} best_try;

static pc_status start_best(best_try *best, const remeshing *r) {
    const remeshing *whole = r->whole ? r->whole : r;
    *best = (best_try){.miss = INFINITY};
    return pc_new(&best->scale, r->ctx, whole->mesh->vertex_count);
}

static void free_best(best_try *best, pc_context *ctx) {
    pc_free(ctx, best->scale);
    pc_param_free(&best->param, ctx);
    pc_layout_free(&best->layout, ctx);
    pc_polymesh_free(&best->looked.quads, ctx);
}

/* From r to `best` or back: what a try has made. */
static void swap_products(best_try *best, remeshing *r) {
    const pc_param param = *r->param;
    const pc_layout layout = *r->layout;
    *r->param = best->param, best->param = param;
    *r->layout = best->layout, best->layout = layout;
    if (!r->looked) return;
    const pc_remesh_looked looked = *r->looked;
    *r->looked = best->looked, best->looked = looked;
}

/* The whole has had the scale of a likeness since the try began. */
static void keep_if_best(best_try *best, remeshing *r, double miss, const outcome *found) {
    const remeshing *whole = r->whole ? r->whole : r;
    best->present = miss < best->miss;
    if (!best->present) return;
    best->miss = miss, best->period = r->period, best->found = *found, best->stats = *r->stats;
    memcpy(best->scale, r->whole ? whole->scale : r->tried, sizeof(double) * whole->mesh->vertex_count);
    if (!r->whole) swap_products(best, r);
}

static pc_status take_best(best_try *best, remeshing *r, outcome *found) {
    remeshing *whole = r->whole ? r->whole : r;
    bool same;
    if (!(best->miss < INFINITY)) return PC_OK;
    memcpy(whole->scale, best->scale, sizeof(double) * whole->mesh->vertex_count);
    whole->period = best->period;
    *found = best->found;
    r->stats->param = best->stats.param, r->stats->layout = best->stats.layout;
    r->stats->wanting = best->stats.wanting;
    if (!r->whole) swap_products(best, r);
    return r->whole && !best->present ? renew_pilot(r, &same) : PC_OK;
}

/* Sizes first: while places want finer cells, and rounds are left. */
static pc_status settle_sizes(remeshing *r, outcome *found) {
    pc_status status = PC_OK;
    const double wanted = r->options->quads;
    const bool compare = !r->piloted && wanted > 0; /* finer cells here are coarser ones there */
    double period = r->period;
    best_try best = {.miss = INFINITY};
    if (compare) PC_TRY(start_best(&best, r));
    for (;;) {
        bool refine =
            r->options->refinements > 0 && r->stats->refinements < most_refinements(r) + MOST_RESCUES;
        PC_TRY(attempt(r, period));
        PC_TRY(look(r, found, refine, r->piloted ? wanted : 0));
        pc_log(r->ctx, PC_LOG_INFO, "cells of side %.5g give %.0f quads%s", period, found->count,
               found->wanting ? ", finer ones are needed in places" : "");
        const double before = best.miss;
        if (compare) keep_if_best(&best, r, found->loss, found);
        if (!found->wanting || (compare && found->loss > WORTHWHILE * before)) break;
        r->stats->refinements++;
        if (r->whole && wanted == 0 && r->stats->refinements >= most_refinements(r))
            break; /* the whole will show */
        if (wanted > 0) PC_TRY(next_period(&period, r, found));
    }
    if (compare) PC_TRY(take_best(&best, r, found));
done:
    free_best(&best, r->ctx);
    return status;
}

/* Then only the density, until the count is near enough. */
static pc_status settle_count(remeshing *r, outcome *found) {
    pc_status status = PC_OK;
    const double wanted = r->options->quads;
    bracket known = {0, 0, 0, 0, 0, 0};
    best_try best;
    PC_TRY(start_best(&best, r));
    for (int tries = 1;; tries++) {
        const double miss = fabs(found->reached / wanted - 1) + (found->folded ? 1 : 0);
        keep_if_best(&best, r, miss, found);
        if (miss <= (tries > 1 || r->piloted ? CLOSE_ENOUGH : CLOSE) || tries == MOST_TRIES_FOR_COUNT) break;
        double period = guess(&known, r->period, found->count, wanted);
        if (found->asked > 0 && (known.few == 0 || known.many == 0)) PC_TRY(next_period(&period, r, found));
        PC_TRY(attempt(r, period));
        PC_TRY(look(r, found, false, tries > 1 || r->piloted ? wanted : 0));
        pc_log(r->ctx, PC_LOG_INFO, "cells of side %.5g give %.0f quads", r->period, found->count);
    }
    PC_TRY(take_best(&best, r, found));
done:
    free_best(&best, r->ctx);
    return status;
}

static pc_status search(remeshing *r) {
    outcome found;
    pc_status status = settle_sizes(r, &found);
    if (status == PC_OK && r->options->quads > 0) status = settle_count(r, &found);
    return status;
}

static pc_status start_scale(remeshing *r, const double *curl) {
    pc_status status = PC_OK;
    const pc_index n = r->mesh->vertex_count;
    pc_room_options room = PC_ROOM_DEFAULTS;
    room.period_length = r->options->period_length;
    PC_TRY(pc_new(&r->scale, r->ctx, n));
    PC_TRY(pc_new(&r->base, r->ctx, n));
    PC_TRY(pc_new(&r->tried, r->ctx, n));
    for (pc_index v = 0; v < n; v++)
        r->scale[v] = curl ? curl[v] : 1;
    PC_TRY(pc_room_make(r->scale, r->ctx, r->device, r->mesh, r->adjacency, r->field, &room));
    memcpy(r->base, r->scale, sizeof(double) * n);
    r->nominal = r->period;
    if (r->options->quads > 0) r->period *= sqrt(mean_square(r->scale, r->mesh)); /* finer cells count more */
    pc_log(r->ctx, PC_LOG_DEBUG, "singularities want cells up to %.2f times as fine, %.2f on the mean",
           largest(r->scale, n), sqrt(mean_square(r->scale, r->mesh)));
done:
    return status;
}

/* Where the scan has many triangles for each cell: the search on likenesses of it. What one that breaks off
 * has found still serves. */
static pc_status try_on_pilot(remeshing *r) {
    pc_status status = PC_OK;
    pc_param param = {0};
    pc_layout layout = {0};
    pc_remesh_stats stats = {0};
    bool worthwhile;
    remeshing small = *r;
    small.whole = r, small.scale = small.base = NULL;
    small.param = &param, small.layout = &layout, small.stats = &stats, small.looked = NULL;
    PC_TRY(renew_pilot(&small, &worthwhile));
    if (!worthwhile) goto done;
    status = search(&small);
    if (status == PC_E_MESH || status == PC_E_NOCONV) {
        pc_context_clear_message(r->ctx);
        status = PC_OK;
    }
    PC_TRY(status);
    if (small.pilot.coarse.mesh.face_count)
        PC_TRY(take_over(&small)); /* else that was done before the last */
    pc_log(r->ctx, PC_LOG_INFO, "%d tries on likenesses, the last of %u triangles: cells of side %.5g",
           stats.tries, small.mesh->face_count, small.period);
    r->piloted = true;
    r->stats->refinements = stats.refinements, r->stats->pilot_tries = stats.tries;
done:
    pc_free(r->ctx, small.scale);
    pc_free(r->ctx, small.base);
    pc_param_free(&param, r->ctx);
    pc_layout_free(&layout, r->ctx);
    pc_pilot_free(&small.pilot, r->ctx);
    return status;
}

pc_status pc_remesh_make(pc_param *param, pc_layout *layout, double **scale, pc_remesh_looked *looked,
                         pc_remesh_stats *stats, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                         const pc_adjacency *adjacency, const pc_field *field, const double *curl,
                         const pc_remesh_options *options) {
    pc_status status = PC_OK;
    remeshing r = {.param = param,
                   .layout = layout,
                   .stats = stats,
                   .looked = looked,
                   .ctx = ctx,
                   .device = device,
                   .mesh = mesh,
                   .adjacency = adjacency,
                   .field = field,
                   .options = options,
                   .period = options->period_length};
    *stats = (pc_remesh_stats){0};
    *param = (pc_param){0};
    *layout = (pc_layout){0};
    if (looked) *looked = (pc_remesh_looked){0};
    PC_TRY(start_scale(&r, curl));
    PC_TRY(try_on_pilot(&r));
    PC_TRY(search(&r));
    stats->finest_scale = largest(r.scale, mesh->vertex_count);
done:
    pc_free(ctx, r.base);
    pc_free(ctx, r.tried);
    *scale = r.scale;
    if (status != PC_OK) {
        pc_free(ctx, r.scale);
        *scale = NULL;
        if (looked) pc_polymesh_free(&looked->quads, ctx);
        pc_param_free(param, ctx);
        pc_layout_free(layout, ctx);
    }
    return status;
}
