/* What Percale vouches for: named checks of a quad mesh against its scan, each with its figure. */
#ifndef PC_CERTIFICATE_H
#define PC_CERTIFICATE_H

#include "quality.h"

enum { PC_CERTIFICATE_CHECKS = 16 };
/* Coarse quads cut the folds of a scan short (0.69 on the brain at 17,000), but add no surface. */
#define PC_CERTIFICATE_LEAST_AREA (1.0 / 3)
#define PC_CERTIFICATE_MOST_AREA  1.5

typedef struct pc_check {
    const char *name; /* a word for reports, static */
    double value;     /* the figure found */
    double expected;  /* the one asked for, or the limit */
    bool passed;
    char note[96]; /* what the figure is, and the first offender */
} pc_check;

typedef struct pc_certificate {
    int count;
    bool passed; /* all checks passed */
    pc_check check[PC_CERTIFICATE_CHECKS];
} pc_certificate;

typedef struct pc_certificate_options {
    double faces_asked;     /* 0: no count was asked for, the check is left out */
    double faces_tolerance; /* allowed relative miss of the count */
    double edge_length;     /* the target edge length, model units; 0: the mean one of the quads */
    double reach; /* nothing of the scan is farther from the quads, or the other way, in edge lengths */
} pc_certificate_options;
#define PC_CERTIFICATE_DEFAULTS                                                                              \
    { 0, 0.05, 0, 3 }

/* The checks, in this order; a name, its value, what is expected:
 *   manifold          edges and vertices of the quads that are not: more than two faces, two in the same
 *                     direction, two fans, or vertices of no face; 0
 *   broken cells      faces with a repeated vertex, fewer than three corners, or a coordinate that is not
 *                     finite; 0
 *   components        pieces of the quads; of the scan
 *   Euler number      of the quads; of the scan
 *   boundary loops    of the quads; of the scan
 *   inverted cells    faces whose normal points against the scan's; 0
 *   zero-area cells   faces of less than 1e-12 of the mean area; 0
 *   singularity sum   sum of the field's indices times N; N * Euler number of the scan; left out without a
 * field face count        faces; those asked for; left out where none were no part dropped   the largest
 * distance from the scan to the quads; the limit. Fails also where a component of the scan has no face near
 * it no part added     the largest distance from the quads to the scan; the limit surface area      of the
 * quads, over that of the scan; from PC_CERTIFICATE_LEAST_AREA to ..._MOST_AREA Figures are those of
 * `quality`; `field` may be NULL. Never fails. */
void pc_certificate_make(pc_certificate *certificate, const pc_quality *quality, const pc_field *field,
                         const pc_certificate_options *options);
/* One more check, whose note may be filled in. At most PC_CERTIFICATE_CHECKS in all. */
pc_check *pc_certificate_add(pc_certificate *certificate, const char *name, double value, double expected,
                             bool passed);
/* The check of that name, NULL where it was left out. */
const pc_check *pc_certificate_find(const pc_certificate *certificate, const char *name);

#endif
