/* From a direction field to quads of the wanted size: parameterize, lay out, look, and where the quads lose
 * the scan or miss the count, once more with finer lines there or another density. */
#ifndef PC_REMESH_H
#define PC_REMESH_H

#include "doublet.h"
#include "quads.h"
#include "relax.h"
#include "upright.h"

typedef struct pc_remesh_options {
    double period_length; /* to start from, model units */
    double quads;         /* wanted number of faces; 0: as many as the period gives */
    pc_ngons ngons;
    uint64_t seed;
    int refinements; /* at most this many rounds of local refinement, and two more where a part of the scan is
                        lost; 0: cells as equal as the field lets them */
    pc_pgp_scheme scheme;
    double reach, floor; /* of pc_sizing_options; 0: its defaults */
    bool walls;          /* of pc_sizing_options */
} pc_remesh_options;
#define PC_REMESH_DEFAULTS                                                                                   \
    { 0, 0, PC_NGONS_SPLIT, 1, 3, PC_PGP_NORMALISE, 0, 0, false }

typedef struct pc_remesh_stats {
    pc_param_stats param;
    pc_layout_stats layout;
    int tries, refinements;
    int pilot_tries;     /* on a likeness of the scan, before; their refinements are counted */
    pc_index wanting;    /* scan vertices that still want finer quads at the end */
    double finest_scale; /* 1 / the size of the smallest cells, in cells as asked */
} pc_remesh_stats;

typedef struct pc_remesh_quads_stats {
    pc_index doublets;  /* removed */
    pc_index collapsed; /* quads that nothing could set upright, drawn together */
    pc_index folded;    /* that are upside down nevertheless */
    pc_index strips;    /* doubled or drawn together for the count */
    pc_index laid_out;  /* faces before that; 0 where no count was wanted */
    pc_relax_stats relaxed;
} pc_remesh_quads_stats;

/* The quads of the last layout, exactly those that pc_remesh_quads makes; without faces where the search has
 * had no need of them. */
typedef struct pc_remesh_looked {
    pc_polymesh quads;
    pc_remesh_quads_stats stats;
} pc_remesh_looked;

/* Makes `param`, `layout` and `scale` (one per vertex of `mesh`: what cells are divided by, curl correction
 * included; the caller frees it with pc_free). `curl`: a factor per vertex or NULL. `looked`: NULL, or freed
 * by the caller. */
pc_status pc_remesh_make(pc_param *param, pc_layout *layout, double **scale, pc_remesh_looked *looked,
                         pc_remesh_stats *stats, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                         const pc_adjacency *adjacency, const pc_field *field, const double *curl,
                         const pc_remesh_options *options);

/* The quads of a layout in their final place: made, doublets removed, folds relaxed; with `wanted` > 0 also
 * strips of quads doubled or drawn together where the count misses it by nearly 5 % or more. `folded` (one
 * per face, the caller frees it; or NULL) tells those that are upside down nevertheless. */
pc_status pc_remesh_quads(pc_polymesh *quads, uint8_t **folded, pc_remesh_quads_stats *stats, pc_context *ctx,
                          const pc_layout *layout, pc_ngons ngons, double wanted, const pc_ground *ground);

#endif
