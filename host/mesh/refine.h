/* Splits long edges until none is longer than a limit; the surface stays where it is. */
#ifndef PC_REFINE_H
#define PC_REFINE_H

#include "adjacency.h"

typedef struct pc_refine_options {
    double max_edge;                  /* in the user's units; every edge gets at most this long */
    const double *component_max_edge; /* a limit per component instead of max_edge, or NULL */
    const pc_index *face_component;   /* component per face (pc_topology); needed with component_max_edge */
    size_t max_faces;                 /* refuse a result with more; 0: as far as 32-bit indices go */
} pc_refine_options;
#define PC_REFINE_DEFAULTS                                                                                   \
    { 0, NULL, NULL, 0 }

typedef struct pc_refined {
    pc_mesh mesh;
    pc_index *face_source;          /* per face: the face of the given mesh that it is a part of; ascending */
    pc_index original_vertex_count; /* these keep their numbers and come first */
    pc_index *parent; /* 2 per further vertex, parent[2*(v-original_vertex_count)]: the two earlier vertices
                         that it stands halfway between */
    pc_index rounds;  /* rounds of splitting; 0 where nothing was too long */
} pc_refined;

/* Rounds of midpoint splits: all edges over the limit at once, the longest edge of a face first, so that
 * every new edge is at most sqrt(3)/2 of the longest one in its face; it ends for any needle. Conforming, the
 * same bytes for any thread count. PC_E_USAGE: no positive limit. PC_E_MESH: over max_faces, with a hint.
 * PC_E_INTERRUPT. */
pc_status pc_refine(pc_refined *refined, pc_context *ctx, const pc_mesh *mesh,
                    const pc_refine_options *options);
void pc_refined_free(pc_refined *refined, pc_context *ctx);

#endif
