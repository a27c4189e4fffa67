/* How far a spline surface and a scan are apart, both ways (digest C41, but geometric). */
#ifndef PC_ACCURACY_H
#define PC_ACCURACY_H

#include "correspondence.h"
#include "gauge.h"

/* Distances in model units. */
typedef struct pc_accuracy {
    double max;         /* over both directions */
    double scan_max;    /* from the vertices of the scan to the surface */
    double surface_max; /* from samples of the surface to the scan */
    double scan_mean, surface_mean;
    size_t samples;
    size_t beyond; /* samples of the surface that are nearest to a border of the scan: there is no data there,
                      and they do not count */
} pc_accuracy;

/* What one face needs. */
typedef struct pc_face_error {
    double max;       /* the largest distance of a sample on it, either way */
    double change[2]; /* sum of squared differences of the residual between neighbours along s and along t */
} pc_face_error;

typedef struct pc_accuracy_options {
    int per_side; /* samples along the side of a face; 3 x 3 on each element beside an extraordinary vertex */
    double near; /* model units: where samples are farther away, the places between them that are farthest are
                    climbed to */
    const pc_correspondence *places; /* of the vertices of the scan, NULL: unknown. A vertex counts for the
                     face of its place, and one nearer to it than `near` is taken to be as far as that. */
    pc_gauge *gauge; /* of the same scan and options, NULL: none. What has not moved is not measured again. */
    const uint8_t *suspect; /* faces to begin with, NULL: all. The others are left out, and the means are
                               about these, as soon as something is farther than `enough`. */
    double enough;
} pc_accuracy_options;

/* `error` (may be NULL) has one entry per face of the T-mesh. The same bytes for any number of threads.
 * PC_E_NOMEM. */
pc_status pc_accuracy_measure(pc_accuracy *accuracy, pc_face_error *error, pc_context *ctx,
                              const pc_tspline *spline, const pc_target *target,
                              const pc_accuracy_options *options);

#endif
