/* How far one surface is from another, by dense samples. */
#ifndef PC_DEVIATION_H
#define PC_DEVIATION_H

#include "bvh.h"

typedef struct pc_deviation {
    size_t sample_count;
    double mean; /* model units, weighted by the area around each sample */
    double q95;  /* nearest value that 95 % of the area do not exceed */
    double max;
    pc_vec3 worst; /* the sample at the largest distance */
} pc_deviation;

typedef struct pc_deviation_options {
    double spacing;        /* faces with longer sides are sampled inside at about this distance; 0: never */
    int least;             /* least^2 samples inside every face; 0: only where `spacing` asks */
    const pc_index *label; /* per face of `from`, or NULL: ask for the largest distance of each label */
    pc_index label_count;
} pc_deviation_options;
#define PC_DEVIATION_DEFAULTS                                                                                \
    { 0, 0, NULL, 0 }

/* From the surface `from` to the surface in `to`: all used vertices of `from`, and the centres of the k^2
 * equal parts of each face that is large enough. `label_max` (label_count values) may be NULL. The same bytes
 * for any number of threads. All 0 for an empty `from`; infinite towards an empty `to`. PC_E_NOMEM. */
pc_status pc_deviation_measure(pc_deviation *deviation, double *label_max, pc_context *ctx,
                               const pc_mesh *from, const pc_bvh *to, const pc_deviation_options *options);

/* The least value such that the values up to it hold the given fraction of the weight; values are not
 * negative. 0 for no weight. Linear time, nothing is reordered. */
double pc_weighted_quantile(const double *value, const double *weight, size_t count, double fraction);

#endif
