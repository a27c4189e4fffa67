/* Faces as a reader meets them: triangles, and polygons as fans that are cut well once all positions are
 * known. */
#ifndef PC_FACELIST_H
#define PC_FACELIST_H

#include "scan_input.h"

typedef struct pc_polygon {
    pc_index first; /* its first triangle: the fan (c0 c1 c2) (c0 c2 c3) ... holds the corners in order */
    pc_index sides; /* 4 or more */
} pc_polygon;

typedef struct pc_facelist {
    pc_index *triangle;
    size_t count;
    size_t capacity;
    pc_polygon *polygon;
    size_t polygon_count;
    size_t polygon_capacity;
} pc_facelist;

void pc_facelist_free(pc_facelist *list, pc_context *ctx);
/* Room for so many triangles (polygons) in all. PC_E_FORMAT beyond the range of half-edges. */
pc_status pc_facelist_reserve(pc_facelist *list, pc_context *ctx, size_t triangles);
pc_status pc_facelist_reserve_polygons(pc_facelist *list, pc_context *ctx, size_t polygons);
/* One face of three or more corners. */
pc_status pc_facelist_add(pc_facelist *list, pc_context *ctx, const pc_index *corner, size_t sides);
/* Cuts the polygons well by mesh->position, hands the triangles to the mesh, and empties the list. */
pc_status pc_facelist_finish(pc_facelist *list, pc_context *ctx, pc_mesh *mesh);

#endif
