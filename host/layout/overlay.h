/* A scan with the iso-lines of its parameterization drawn into it as edges (digest C28, C29 "realised").
 *
 * Lines are s = k*PC_PERIOD and t = k*PC_PERIOD. Coordinates are odd, so no line meets a vertex; edges jump
 * less than a period, so an edge meets at most one line of each family and a triangle holds at most one chord
 * of each. Where the lines cross an edge, and in which order, is decided once per edge in integers; whether
 * two chords cross follows from the order of their ends around the triangle. Rounding can therefore move a
 * point, but never break the graph. */
#ifndef PC_OVERLAY_H
#define PC_OVERLAY_H

#include "cone.h"

typedef struct pc_overlay {
    pc_mesh mesh;          /* scan vertices first, then points on edges, then crossings inside triangles */
    pc_index *source_face; /* per triangle of mesh: the triangle of the scan */
    uint8_t *drawn;        /* per half-edge of mesh: 1 where it lies on an iso-line */
} pc_overlay;

/* `adjacency` is that of coned->mesh. Lines run into cones; at a dislocation the line too many ends, at a
 * field singularity without a cone all do, and dangle. */
pc_status pc_overlay_make(pc_overlay *overlay, pc_context *ctx, const pc_coned *coned,
                          const pc_adjacency *adjacency);
void pc_overlay_free(pc_overlay *overlay, pc_context *ctx);

/* Splits the faces with flag[f] = 1 at their centroid, and those of their edges that are not in `keep` (per
 * half-edge, 1 = leave whole) and have a flagged face on both sides at the middle. drawn is carried over. */
pc_status pc_overlay_refine(pc_overlay *overlay, pc_context *ctx, const pc_adjacency *adjacency,
                            const uint8_t *flag, const uint8_t *keep);

#endif
