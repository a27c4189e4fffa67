/* The systems of the field and the PGP stage of a real scan, as the pipeline meets them. */
#ifndef PC_SCAN_SYSTEMS_H
#define PC_SCAN_SYSTEMS_H

#include "adjacency.h"
#include "device.h"
#include "field.h"
#include "system.h"

typedef struct pc_scan_options {
    int subdivisions;    /* one triangle into four, so many times; the new vertices on curved patches */
    double noise;        /* then white noise along the normals, in mean edges; nothing where not subdivided */
    double period_edges; /* side of PGP's cells, in mean edges of the result */
} pc_scan_options;
#define PC_SCAN_OPTIONS_DEFAULTS                                                                             \
    { 0, 0.1, 10 }

/* Repaired, subdivided, long edges split, in the pipeline's order. */
typedef struct pc_scan_case {
    pc_mesh mesh;
    pc_adjacency adjacency;
    double mean_edge, area, period;
} pc_scan_case;

pc_status pc_scan_case_make(pc_scan_case *scan, pc_context *ctx, const char *path,
                            const pc_scan_options *options);
void pc_scan_case_free(pc_scan_case *scan, pc_context *ctx);

/* COMPLEX: the connection Laplacian of crosses without data, with the shift of the field's first solve: the
 * hardest one that the pipeline can meet, condition about 1e8 for a million vertices. */
pc_status pc_scan_field_system(pc_system *system, pc_context *ctx, pc_device *device,
                               const pc_scan_case *scan);
/* TURNED: PGP along the scan's own field, with the shift of the first normalise-and-solve step (a diffusion
 * over eight periods). */
pc_status pc_scan_pgp_system(pc_system *system, pc_context *ctx, pc_device *device, const pc_scan_case *scan);

#endif
