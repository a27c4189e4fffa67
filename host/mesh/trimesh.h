/* A triangle mesh as two arrays: what readers make and every stage borrows as const. */
#ifndef PC_TRIMESH_H
#define PC_TRIMESH_H

#include "context.h"

typedef struct pc_mesh {
    pc_index vertex_count;
    pc_index face_count;
    double *position;   /* 3 per vertex, the user's frame and units */
    pc_index *triangle; /* 3 per face, counter-clockwise seen from outside */
} pc_mesh;

/* Half-edge 3f+k runs from corner k to corner k+1 of face f. */
static inline pc_index pc_next(pc_index h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}
static inline pc_index pc_prev(pc_index h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}
static inline pc_index pc_tail(const pc_mesh *mesh, pc_index h) {
    return mesh->triangle[h];
}
static inline pc_index pc_head(const pc_mesh *mesh, pc_index h) {
    return mesh->triangle[pc_next(h)];
}

/* Arrays of the given sizes, zeroed; the mesh owns them. PC_E_NOMEM; PC_E_MESH over 2^32/3-2 faces. */
pc_status pc_mesh_make(pc_mesh *mesh, pc_context *ctx, size_t vertex_count, size_t face_count);
void pc_mesh_free(pc_mesh *mesh, pc_context *ctx);
/* Indices in range, positions finite, no face with a repeated vertex. PC_E_MESH names the first offender. */
pc_status pc_mesh_check(const pc_mesh *mesh, pc_context *ctx);
pc_status pc_mesh_copy(pc_mesh *copy, pc_context *ctx, const pc_mesh *mesh);

#endif
