/* The scan that a spline surface should follow, and what samples of the two say about each other (digest C37:
 * here every correspondence is the nearest point, corrected before every fit, so that errors are geometric).
 */
#ifndef PC_TARGET_H
#define PC_TARGET_H

#include "adjacency.h"
#include "energy.h"
#include "track.h"

typedef struct pc_target {
    const pc_mesh *mesh; /* borrowed, as `adjacency` */
    const pc_adjacency *adjacency;
    pc_bvh tree;
    double *normal;  /* 3 per vertex */
    double diagonal; /* of the box around the mesh */
} pc_target;

/* `target` must not move: the tree points into the mesh it borrows. PC_E_NOMEM. */
pc_status pc_target_make(pc_target *target, pc_context *ctx, const pc_mesh *mesh,
                         const pc_adjacency *adjacency);
void pc_target_free(pc_target *target, pc_context *ctx);

/* A track of the scan's vertices; nothing known yet. */
pc_status pc_target_track(pc_track *track, pc_context *ctx, const pc_target *target);

typedef struct pc_samples {
    size_t count;
    pc_sample *sample; /* sorted by element */
    double *stiffness; /* per element: 1 where the scan says enough, up to a thousand where none of its own
                          samples found a partner and only fairing can keep it in shape */
    size_t refused;    /* pairs whose normals point away from each other: another sheet of the surface */
    size_t flipped;    /* triangles of the scan whose parameters ran the wrong way round; their corners are
                          refused as well */
} pc_samples;

/* The scan's triangles nearest to the grids; starts as zeros. */
typedef struct pc_hints {
    size_t count;
    pc_index *triangle;
} pc_hints;
void pc_hints_free(pc_hints *hints, pc_context *ctx);

typedef struct pc_samples_options {
    bool flat;    /* through the bilinear faces between the control points, which are on the scan: before the
                     first fit */
    int per_side; /* samples along the side of a face from the surface to the scan */
    const uint8_t *active; /* per element: samples on these only (NULL: all) */
    bool near; /* from triangle to triangle from the last ones in `hints`: a nearest point, but there may
                  be a nearer one elsewhere */
} pc_samples_options;
#define PC_SAMPLES_DEFAULTS                                                                                  \
    { false, 5, NULL, false }

/* Pairs of points: every vertex of the scan with its place in `track`, which is brought up to date, and a
 * grid of every face of the surface with its nearest points of the scan. The weights of a face sum to one, an
 * element's share is its share of the face. `hints` carries what the
 * next call with the same elements and options finds faster. PC_E_NOMEM. */
pc_status pc_samples_make(pc_samples *samples, pc_hints *hints, pc_track *track, pc_context *ctx,
                          const pc_tspline *spline, const pc_target *target,
                          const pc_samples_options *options);
void pc_samples_free(pc_samples *samples, pc_context *ctx);

#endif
