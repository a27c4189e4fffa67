/* Who touches whom on a mesh of polygons, however broken it is: nothing is refused, everything is counted. */
#ifndef PC_POLYGRAPH_H
#define PC_POLYGRAPH_H

#include "polymesh.h"
#include "trimesh.h"

/* What a mesh is as a surface. An edge is a pair of vertices. */
typedef struct pc_surface_count {
    pc_index vertices;        /* used by a face */
    pc_index unused_vertices; /* by none */
    pc_index edges;
    pc_index faces;
    pc_index boundary_edges; /* of exactly one face */
    pc_index overfull_edges; /* of more than two */
    pc_index clashing_edges; /* of two that run in the same direction */
    pc_index broken_faces;   /* with a repeated vertex or fewer than three */
    pc_index split_vertices; /* where more than one fan of faces meets */
    pc_index loops;          /* boundary loops */
    pc_index components;     /* joined across edges */
    int64_t chi;             /* vertices - edges + faces */
} pc_surface_count;

/* Half-edge c runs from corner c to the next corner of the same face. */
typedef struct pc_polygraph {
    pc_index corner_count;
    pc_surface_count count;
    pc_index *face;    /* per corner */
    pc_index *twin;    /* per half-edge: the opposite one where the edge has exactly two faces that run in
                          opposite directions, else PC_NONE */
    uint8_t *boundary; /* per half-edge: 1 where its edge has no other face */
    pc_index *face_component; /* numbered by their smallest faces */
} pc_polygraph;

/* `start` may be NULL for triangles. Linear in the size but for vertices of huge valence. PC_E_BUG where a
 * corner or offset is out of range; PC_E_NOMEM. */
pc_status pc_polygraph_make(pc_polygraph *graph, pc_context *ctx, pc_index vertex_count, pc_index face_count,
                            const pc_index *start, const pc_index *corner);
pc_status pc_polygraph_of_mesh(pc_polygraph *graph, pc_context *ctx, const pc_mesh *mesh);
pc_status pc_polygraph_of_polymesh(pc_polygraph *graph, pc_context *ctx, const pc_polymesh *mesh);
void pc_polygraph_free(pc_polygraph *graph, pc_context *ctx);

#endif
