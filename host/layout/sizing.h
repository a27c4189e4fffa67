/* Where a quad mesh has lost its scan, and how much finer it must become there (digest C21's guard, made
 * local). */
#ifndef PC_SIZING_H
#define PC_SIZING_H

#include "ground.h"
#include "polymesh.h"

typedef struct pc_sizing_options {
    double edge_length; /* of the quads where scale is 1, model units */
    /* Of the parameterization: no scale may make an edge of the scan half of it or more. */
    double period_length;
    double reach; /* scan vertices farther than this many local edge lengths from the quads want finer ones */
    double floor; /* ... but not nearer than this many edge lengths as asked */
    double farthest;  /* ... and wherever they are farther than this, model units; 0: no such limit */
    bool walls;       /* nearer also where walls or gaps are thin: than 0.4 of their thickness */
    double growth;    /* the most that one update may multiply a scale by */
    double most;      /* no scale becomes larger */
    double gradation; /* a scale falls off by a factor e over this many edge lengths */
} pc_sizing_options;
#define PC_SIZING_DEFAULTS                                                                                   \
    { 0, 0, 1.0, 0.6, 0, false, 2.0, 6.0, 8.0 }

typedef struct pc_sizing_stats {
    pc_index wanting; /* scan vertices that want finer quads */
    double worst;     /* the largest distance from a scan vertex to the quads */
    double typical;   /* fourth root of the mean fourth power of these distances: far ones count most */
} pc_sizing_stats;

/* Raises `scale` (one per scan vertex, 1: cells as asked) around what the quads miss and around the faces
 * with folded[f] != 0, smoothly; not where no vertex wants finer ones. */
pc_status pc_sizing_update(double *scale, pc_sizing_stats *stats, pc_context *ctx, const pc_ground *ground,
                           const pc_polymesh *quads, const uint8_t *folded, const pc_sizing_options *options);

/* PGP cannot take edges of half a period: lowers `scale` at both ends of edges that would be longer than
 * `longest` in cells of scale 1, but not below `least`. */
void pc_sizing_limit_by_edges(double *scale, const pc_mesh *scan, const pc_adjacency *adjacency,
                              double longest, double least);

#endif
