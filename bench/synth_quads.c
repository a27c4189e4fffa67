#include "synth_quads.h"
#include "synth.h"
#include "vec3.h"
#include <string.h>

static void grid_quads(pc_polymesh *mesh, pc_index nx, pc_index ny, pc_index columns, pc_index rows) {
    pc_index *corner = mesh->corner, *start = mesh->start;
    for (pc_index j = 0; j < ny; j++)
        for (pc_index i = 0; i < nx; i++) {
            pc_index right = (i + 1) % columns, up = (j + 1) % rows;
            const pc_index quad[4] = {i + j * columns, right + j * columns, right + up * columns,
                                      i + up * columns};
            memcpy(corner, quad, sizeof quad);
            corner += 4;
            *++start = (pc_index)(corner - mesh->corner);
        }
}

pc_status pc_synth_quad_plane(pc_polymesh *mesh, pc_context *ctx, double width, double height, pc_index nx,
                              pc_index ny) {
    size_t faces = (size_t)nx * ny;
    pc_status status = pc_polymesh_make(mesh, ctx, ((size_t)nx + 1) * ((size_t)ny + 1), faces, 4 * faces);
    if (status != PC_OK) return status;
    for (pc_index j = 0; j <= ny; j++)
        for (pc_index i = 0; i <= nx; i++)
            pc_vec3_put(mesh->position, i + (size_t)j * (nx + 1),
                        (pc_vec3){width * i / nx, height * j / ny, 0});
    grid_quads(mesh, nx, ny, nx + 1, ny + 1);
    return PC_OK;
}

pc_status pc_synth_quad_torus(pc_polymesh *mesh, pc_context *ctx, double major, double minor, pc_index around,
                              pc_index across) {
    size_t faces = (size_t)around * across;
    pc_status status = pc_polymesh_make(mesh, ctx, faces, faces, 4 * faces);
    if (status != PC_OK) return status;
    for (pc_index j = 0; j < across; j++)
        for (pc_index i = 0; i < around; i++) {
            double u = 2 * PC_PI * i / around, v = 2 * PC_PI * j / across, r = major + minor * cos(v);
            pc_vec3_put(mesh->position, i + (size_t)j * around,
                        (pc_vec3){r * cos(u), r * sin(u), minor * sin(v)});
        }
    grid_quads(mesh, around, across, around, across);
    return PC_OK;
}

pc_status pc_synth_quad_sphere(pc_polymesh *mesh, pc_context *ctx, pc_index n) {
    size_t faces = 6 * (size_t)n * n;
    pc_status status = pc_polymesh_make(mesh, ctx, faces + 2, faces, 4 * faces);
    if (status != PC_OK) return status;
    pc_index f = 0;
    for (int side = 0; side < 6; side++)
        for (pc_index j = 0; j < n; j++)
            for (pc_index i = 0; i < n; i++, f++) {
                pc_synth_cube_square(mesh->corner + 4 * (size_t)f, mesh->position, side, i, j, n);
                mesh->start[f + 1] = 4 * f + 4;
            }
    for (size_t v = 0; v < mesh->vertex_count; v++)
        pc_vec3_put(mesh->position, v, pc_unit(pc_vec3_at(mesh->position, v)));
    return PC_OK;
}

pc_status pc_synth_quad_tee(pc_polymesh *mesh, pc_context *ctx) {
    static const double position[24] = {0, 0,   0, 1, 0, 0, 2, 0, 0, 1, 0.5, 0,
                                        2, 0.5, 0, 0, 1, 0, 1, 1, 0, 2, 1,   0};
    static const pc_index corner[13] = {0, 1, 3, 6, 5, 1, 2, 4, 3, 3, 4, 7, 6};
    static const pc_index start[4] = {0, 5, 9, 13};
    pc_status status = pc_polymesh_make(mesh, ctx, 8, 3, 13);
    if (status != PC_OK) return status;
    memcpy(mesh->position, position, sizeof position);
    memcpy(mesh->corner, corner, sizeof corner);
    memcpy(mesh->start, start, sizeof start);
    mesh->corner_flat[2] = 1;
    return PC_OK;
}
