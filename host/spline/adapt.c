#include "adapt.h"
#include "fold.h"
#include "insertion.h"
#include "memory.h"
#include "region.h"
#include <string.h>

/* The error above which faces are refined now: others may profit from that. */
static double threshold(const pc_face_error *error, size_t faces, double tolerance) {
    const double part = 0.5, most = 2; /* of the largest; of the tolerance */
    double max = 0;
    for (size_t f = 0; f < faces; f++)
        max = fmax(max, error[f].max);
    return fmax(tolerance, fmin(part * max, most * tolerance));
}

/* A face shorter than that cannot be off for want of control points. */
static bool is_small(const pc_tspline *spline, pc_index f, double least) {
    const double *size = spline->mesh.face[f].size;
    pc_vec3 corner[4];
    for (int k = 0; k < 4; k++)
        corner[k] = pc_tspline_point(
            spline, pc_tspline_place(spline, f, k == 1 || k == 2 ? size[0] : 0, k > 1 ? size[1] : 0));
    return fmin(pc_distance(corner[0], corner[2]), pc_distance(corner[1], corner[3])) < least;
}

/* Faces over the limit, and which way to halve them. */
static void choose(uint8_t *wish, const pc_tspline *spline, const pc_face_error *error, double limit,
                   double least, double anisotropy) {
    for (pc_index f = 0; f < spline->mesh.face_count; f++) {
        const double *change = error[f].change;
        wish[f] = 0;
        if (!(error[f].max > limit) || is_small(spline, f, least)) continue;
        wish[f] = change[0] > anisotropy * change[1]   ? PC_HALVE_S
                  : change[1] > anisotropy * change[0] ? PC_HALVE_T
                                                       : PC_HALVE_S | PC_HALVE_T;
    }
}

/* A surface and its matching as they were before folds were opened or smoothed out. */
typedef struct snapshot {
    double *position; /* NULL: none was taken */
    pc_foot *foot;
    pc_spot *spot;
    pc_foot *summit; /* those of the summits */
    pc_index summits;
    pc_accuracy accuracy;
    pc_index folds;
} snapshot;

/* An adaptation under way, and the best surface so far. */
typedef struct adapting {
    pc_tspline *spline;
    pc_adapt_stats *stats;
    const pc_target *target;
    const pc_adapt_options *options;
    pc_matching matching;
    pc_face_error *error; /* per face of the present mesh */
    pc_gauge gauge;
    pc_tspline best; /* mesh and control points only */
    pc_adapt_stats best_stats;
    pc_index far;     /* faces too far away, in the last round */
    int vain;         /* rounds since it became much better, or they much fewer */
    bool fitted;      /* at least once */
    bool opened;      /* folds, instead of refining, in the last round */
    float *stiffness; /* per face, where folds are smoothed out; else NULL */
    pc_region smooth; /* what moves then */
    snapshot before;  /* folds were opened or smoothed out */
} adapting;

static void drop_snapshot(snapshot *s, pc_context *ctx) {
    pc_free(ctx, s->position);
    pc_free(ctx, s->foot);
    pc_free(ctx, s->spot);
    pc_free(ctx, s->summit);
    *s = (snapshot){0};
}

static pc_status take_snapshot(adapting *a, pc_context *ctx, pc_index folds) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &a->spline->mesh;
    snapshot *s = &a->before;
    drop_snapshot(s, ctx); /* of an opening that has served */
    s->accuracy = a->stats->accuracy, s->folds = folds, s->summits = a->matching.summits.places.count;
    PC_TRY(pc_new(&s->position, ctx, 3 * (size_t)mesh->vertex_count));
    PC_TRY(pc_new(&s->foot, ctx, pc_footpoints_count(&a->matching.feet)));
    PC_TRY(pc_new(&s->spot, ctx, a->matching.vertices.count));
    PC_TRY(pc_new(&s->summit, ctx, s->summits));
    memcpy(s->position, a->spline->position, 3 * (size_t)mesh->vertex_count * sizeof *s->position);
    memcpy(s->foot, a->matching.feet.foot, pc_footpoints_count(&a->matching.feet) * sizeof *s->foot);
    memcpy(s->spot, a->matching.vertices.spot, a->matching.vertices.count * sizeof *s->spot);
    for (pc_index i = 0; i < s->summits; i++)
        s->summit[i] = a->matching.summits.foot[i];
done:
    return status;
}

/* The mesh has not changed since; distances are to be measured again. */
static void go_back_to(adapting *a, const snapshot *s) {
    const pc_tmesh *mesh = &a->spline->mesh;
    memcpy(a->spline->position, s->position, 3 * (size_t)mesh->vertex_count * sizeof *s->position);
    memcpy(a->matching.feet.foot, s->foot, pc_footpoints_count(&a->matching.feet) * sizeof *s->foot);
    memcpy(a->matching.vertices.spot, s->spot, a->matching.vertices.count * sizeof *s->spot);
    a->matching.summits.places.count = s->summits; /* later ones come after */
    for (pc_index i = 0; i < s->summits; i++)
        a->matching.summits.foot[i] = s->summit[i];
    pc_tspline_update(a->spline);
}

static pc_accuracy_options measuring(const adapting *a) {
    return (pc_accuracy_options){.per_side = a->options->per_side, .near = 0.75 * a->options->tolerance};
}

/* Faces that are near at their feet and vertices are measured only where nothing else is too far. */
static pc_status measure(adapting *a, pc_context *ctx) {
    const double part = 0.5;
    pc_status status = PC_OK;
    const double tolerance = a->options->tolerance;
    uint8_t *suspect = NULL;
    PC_TRY(pc_new(&suspect, ctx, a->spline->mesh.face_count));
    pc_matching_suspect(suspect, &a->matching, a->spline, a->target, part * tolerance);
    pc_accuracy_options options = measuring(a);
    options.places = &a->matching.vertices, options.gauge = &a->gauge;
    options.suspect = suspect, options.enough = tolerance;
    pc_free(ctx, a->error), a->error = NULL;
    PC_TRY(pc_new(&a->error, ctx, a->spline->mesh.face_count));
    PC_TRY(pc_accuracy_measure(&a->stats->accuracy, a->error, ctx, a->spline, a->target, &options));
done:
    pc_free(ctx, suspect);
    return status;
}

enum { SMOOTHING_ROUNDS = 8 }; /* of a fit with stiff faces: more change little */

static pc_status fit(adapting *a, pc_context *ctx, pc_device *device) {
    pc_status status = PC_OK;
    pc_adapt_stats *stats = a->stats;
    const pc_accuracy *accuracy = &stats->accuracy;
    pc_fit_options fitting = a->options->fit;
    fitting.within = a->options->tolerance;
    fitting.rough = !a->fitted;
    if (a->stiffness) {
        fitting.stiffness = a->stiffness, fitting.region = &a->smooth;
        if (fitting.rounds > SMOOTHING_ROUNDS) fitting.rounds = SMOOTHING_ROUNDS;
    }
    PC_TRY(pc_fit(a->spline, &stats->fit, ctx, device, a->target, &a->matching, &fitting));
    PC_TRY(measure(a, ctx));
    if (!a->fitted) stats->first_max = accuracy->max;
    a->fitted = true;
    pc_log(ctx, PC_LOG_DEBUG,
           "spline: %u control points, %u T-junctions, max %g to the surface, %g to the scan, mean %g; "
           "%zu samples, %d rounds",
           a->spline->mesh.vertex_count, stats->junctions, accuracy->scan_max, accuracy->surface_max,
           accuracy->scan_mean, stats->fit.samples, stats->fit.rounds);
done:
    return status;
}

static bool is_within_budget(const adapting *a) {
    return !a->options->max_points || a->spline->mesh.vertex_count <= a->options->max_points;
}

/* Keeps the surface where none was nearer. Where folds are laid flat it is farther away at first, in fewer
 * and fewer places. */
static pc_status remember(adapting *a, pc_context *ctx) {
    const double worthwhile = 0.97, fewer = 0.9;
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &a->spline->mesh;
    const bool first = !a->best.position;
    pc_index far = 0;
    for (pc_index f = 0; f < mesh->face_count; f++)
        far += a->error[f].max > a->options->tolerance;
    const bool better = first || a->stats->accuracy.max < worthwhile * a->best_stats.accuracy.max;
    a->vain = better || far < fewer * a->far ? 0 : a->vain + 1;
    a->far = far;
    if (!first && !(a->stats->accuracy.max < a->best_stats.accuracy.max)) return PC_OK;
    pc_tspline_free(&a->best, ctx);
    PC_TRY(pc_tmesh_copy(&a->best.mesh, ctx, mesh));
    PC_TRY(pc_new(&a->best.position, ctx, 3 * (size_t)mesh->vertex_count));
    memcpy(a->best.position, a->spline->position, 3 * sizeof(double) * mesh->vertex_count);
    a->best_stats = *a->stats;
done:
    return status;
}

/* What is folded is matched anew; `folded` is about the mesh before refinement where that was `refined`. */
static pc_status open_folds(adapting *a, pc_context *ctx, const uint8_t *folded, bool refined) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &a->spline->mesh;
    uint8_t *now = NULL;
    PC_TRY(pc_new(&now, ctx, mesh->face_count));
    for (pc_index f = 0; f < mesh->face_count; f++)
        now[f] = !mesh->face[f].ghost && folded[refined ? mesh->face[f].root : f];
    PC_TRY(pc_folds_open(&a->matching, NULL, ctx, a->spline, a->target, now, a->options->tolerance));
done:
    pc_free(ctx, now);
    return status;
}

static pc_index find_folds(const adapting *a, uint8_t *folded) {
    return pc_folds_find(folded, a->spline, a->target, &a->matching, a->error, a->options->tolerance);
}

/* Where opening folds has made things worse they are as they were before, and left alone this time. */
static pc_status take_back(adapting *a, pc_context *ctx, uint8_t *folded, pc_index *folds) {
    pc_status status = PC_OK;
    if (a->before.position && a->stats->accuracy.max > a->before.accuracy.max && *folds >= a->before.folds) {
        go_back_to(a, &a->before);
        PC_TRY(measure(a, ctx));
        const pc_index left = find_folds(a, folded);
        pc_log(ctx, PC_LOG_DEBUG, "spline: %u faces stay folded, what was laid flat is taken back", left);
        *folds = 0;
    }
done:
    drop_snapshot(&a->before, ctx);
    return status;
}

/* Faces that are too far away where the fit has not looked: it will; they are not refined yet, unless a
 * vertex of the scan is farther still. */
static pc_status look_closer(pc_index *found, uint8_t *wish, adapting *a, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_index faces = a->spline->mesh.face_count;
    uint8_t *unseen = NULL;
    *found = 0;
    PC_TRY(pc_new(&unseen, ctx, faces));
    PC_TRY(pc_summits_find(&a->matching.summits, unseen, ctx, a->spline, &a->matching.feet, &a->gauge,
                           a->options->tolerance));
    pc_summits_follow(&a->matching.summits, a->spline, a->target, NULL);
    for (pc_index f = 0; f < faces; f++) {
        *found += unseen[f];
        if (unseen[f] && !(a->error[f].max > a->gauge.face[f].max)) wish[f] = 0;
    }
    if (*found) pc_log(ctx, PC_LOG_DEBUG, "spline: %u places between samples are too far away", *found);
done:
    pc_free(ctx, unseen);
    return status;
}

/* `more` is false where there is nothing to refine, no fold and no summit, or refinement took more control
 * points than allowed. */
static pc_status refine(bool *more, adapting *a, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_adapt_options *options = a->options;
    const pc_index faces = a->spline->mesh.face_count;
    pc_closure_stats closed;
    uint8_t *wish = NULL, *folded = NULL;
    pc_index summits;
    bool cut = false;
    *more = false;
    PC_TRY(pc_new(&folded, ctx, faces));
    PC_TRY(pc_new(&wish, ctx, faces));
    pc_index folds = find_folds(a, folded);
    PC_TRY(take_back(a, ctx, folded, &folds));
    a->opened = folds && !a->opened;
    if (a->opened)
        PC_TRY(take_snapshot(a, ctx, folds));
    else
        choose(wish, a->spline, a->error, threshold(a->error, faces, options->tolerance),
               0.5 * options->tolerance, options->anisotropy);
    PC_TRY(look_closer(&summits, wish, a, ctx));
    for (pc_index f = 0; f < faces && !cut; f++)
        cut = wish[f];
    if (cut) {
        PC_TRY(pc_insertion_refine(a->spline, &closed, ctx, wish));
        a->stats->junctions = closed.junctions;
        PC_TRY(pc_matching_carry(&a->matching, ctx, a->spline, a->target));
        PC_TRY(pc_gauge_carry(&a->gauge, ctx, a->spline));
    }
    if (folds) PC_TRY(open_folds(a, ctx, folded, cut));
    *more = (cut || folds || summits) && is_within_budget(a);
done:
    pc_free(ctx, wish);
    pc_free(ctx, folded);
    return status;
}

static pc_status take_best(adapting *a, pc_context *ctx) {
    pc_tspline_free(a->spline, ctx);
    *a->spline = a->best, a->best = (pc_tspline){0};
    *a->stats = a->best_stats;
    return pc_tspline_complete(a->spline, ctx);
}

/* The nearest surface, measured everywhere. */
static pc_status go_back(adapting *a, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_accuracy_options options = measuring(a);
    PC_TRY(take_best(a, ctx));
    PC_TRY(pc_accuracy_measure(&a->stats->accuracy, NULL, ctx, a->spline, a->target, &options));
    PC_TRY(pc_fail(ctx, PC_E_NOCONV, "the surface of %u control points is %g from the scan, not %g",
                   a->spline->mesh.vertex_count, a->stats->accuracy.max, a->options->tolerance));
done:
    return status;
}

/* ---- Folds that are within the tolerance ---- */

/* Faces with folded[f], and those around that share control points with them or with their neighbours, become
 * stiff; as far around those everything moves. */
static pc_status stiffen(adapting *a, pc_context *ctx, const uint8_t *folded) {
    const float factor = 30;
    pc_status status = PC_OK;
    const pc_index faces = a->spline->mesh.face_count;
    double *marked = NULL;
    PC_TRY(pc_new(&marked, ctx, faces));
    PC_TRY(pc_resize(&a->stiffness, ctx, faces));
    for (pc_index f = 0; f < faces; f++)
        marked[f] = folded[f];
    pc_region_free(&a->smooth, ctx);
    PC_TRY(pc_region_make(&a->smooth, ctx, a->spline, marked, 0));
    for (pc_index f = 0; f < faces; f++) {
        marked[f] = a->smooth.active[f];
        a->stiffness[f] = a->smooth.active[f] ? factor : 1;
    }
    pc_region_free(&a->smooth, ctx);
    PC_TRY(pc_region_make(&a->smooth, ctx, a->spline, marked, 0));
done:
    pc_free(ctx, marked);
    return status;
}

/* What surrounds faces beyond the tolerance is as it was before, matching included. */
static pc_status take_back_around(adapting *a, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_index faces = a->spline->mesh.face_count;
    const size_t side = (size_t)a->matching.feet.per_side, each = side * side;
    pc_region region = {0};
    double *far = NULL;
    PC_TRY(pc_new(&far, ctx, faces));
    for (pc_index f = 0; f < faces; f++)
        far[f] = a->error[f].max;
    PC_TRY(pc_region_make(&region, ctx, a->spline, far, a->options->tolerance));
    for (size_t i = 0; i < 3 * (size_t)a->spline->mesh.vertex_count; i++)
        if (region.free[i / 3]) a->spline->position[i] = a->before.position[i];
    for (pc_index f = 0; f < faces; f++)
        if (region.active[f])
            memcpy(a->matching.feet.foot + f * each, a->before.foot + f * each, each * sizeof(pc_foot));
    for (pc_index v = 0; v < a->matching.vertices.count; v++) {
        const pc_index now = a->matching.vertices.spot[v].face, then = a->before.spot[v].face;
        if ((now != PC_NONE && region.active[now]) || (then != PC_NONE && region.active[then]))
            a->matching.vertices.spot[v] = a->before.spot[v];
    }
    for (pc_index i = 0; i < a->before.summits; i++)
        if (region.active[a->matching.summits.places.spot[i].face])
            a->matching.summits.foot[i] = a->before.summit[i];
    pc_tspline_update(a->spline);
    PC_TRY(measure(a, ctx));
done:
    pc_region_free(&region, ctx);
    pc_free(ctx, far);
    return status;
}

/* One more fit, what is folded stiffer than the rest, and with `open` matched anew; taken back around what
 * that has brought beyond the tolerance, and altogether if no fewer faces are folded. */
static pc_status smooth_out(adapting *a, pc_context *ctx, pc_device *device, bool open) {
    enum { TRIES = 8 };
    pc_status status = PC_OK;
    const double tolerance = a->options->tolerance;
    const pc_adapt_stats stats = *a->stats;
    uint8_t *folded = NULL;
    PC_TRY(pc_new(&folded, ctx, a->spline->mesh.face_count));
    const pc_index before = pc_folds_find(folded, a->spline, a->target, &a->matching, NULL, tolerance);
    if (!before) goto done;
    PC_TRY(take_snapshot(a, ctx, before));
    PC_TRY(stiffen(a, ctx, folded));
    if (open) PC_TRY(open_folds(a, ctx, folded, false));
    status = fit(a, ctx, device);
    for (int k = 0; k < TRIES && status == PC_OK && a->stats->accuracy.max > tolerance; k++)
        status = take_back_around(a, ctx);
    if (status != PC_OK && status != PC_E_NOCONV) goto done;
    const pc_index left = pc_folds_find(folded, a->spline, a->target, &a->matching, NULL, tolerance);
    pc_log(ctx, PC_LOG_DEBUG, "spline: %u faces are folded within the tolerance, %u were; max %g", left,
           before, a->stats->accuracy.max);
    if (status != PC_OK || a->stats->accuracy.max > tolerance || left >= before) {
        pc_context_clear_message(ctx);
        go_back_to(a, &a->before);
        *a->stats = stats;
        status = PC_OK;
    }
done:
    pc_free(ctx, folded);
    return status;
}

pc_status pc_adapt(pc_tspline *spline, pc_adapt_stats *stats, pc_context *ctx, pc_device *device,
                   const pc_target *target, const pc_adapt_options *options) {
    pc_status status = PC_OK;
    adapting a = {.spline = spline, .stats = stats, .target = target, .options = options};
    *stats = (pc_adapt_stats){.first_points = spline->mesh.vertex_count};
    PC_TRY(pc_matching_make(&a.matching, ctx, spline, target, options->feet));
    for (bool more = true; more; stats->rounds++) {
        status = fit(&a, ctx, device);
        if (status == PC_E_NOCONV && a.best.position) { /* the solver: the best so far stands */
            pc_context_clear_message(ctx);
            break;
        }
        PC_TRY(status);
        if (stats->accuracy.max <= options->tolerance) {
            PC_TRY(smooth_out(&a, ctx, device, false));
            status = smooth_out(&a, ctx, device, true);
            goto done;
        }
        PC_TRY(remember(&a, ctx));
        if (stats->rounds == options->max_rounds || a.vain == options->patience || !is_within_budget(&a))
            break;
        PC_TRY(refine(&more, &a, ctx));
    }
    const bool full = !is_within_budget(&a);
    status = go_back(&a, ctx);
    stats->full = full;
done:
    pc_matching_free(&a.matching, ctx);
    pc_tspline_free(&a.best, ctx);
    drop_snapshot(&a.before, ctx);
    pc_gauge_free(&a.gauge, ctx);
    pc_region_free(&a.smooth, ctx);
    pc_free(ctx, a.stiffness);
    pc_free(ctx, a.error);
    return status;
}
