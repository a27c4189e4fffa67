#include "synth.h"
#include "memory.h"
#include "vec3.h"

/* Two triangles per quad of an nx x ny grid whose vertex (i,j) is i + j*stride, indices taken modulo wrap. */
static void grid_triangles(pc_mesh *mesh, pc_index nx, pc_index ny, pc_index columns, pc_index rows) {
    pc_index *t = mesh->triangle;
    for (pc_index j = 0; j < ny; j++)
        for (pc_index i = 0; i < nx; i++) {
            pc_index i1 = (i + 1) % columns, j1 = (j + 1) % rows;
            pc_index a = i + j * columns, b = i1 + j * columns, c = i1 + j1 * columns, d = i + j1 * columns;
            bool flip = (i + j) % 2;
            pc_index quad[6] = {a, b, flip ? d : c, flip ? b : a, c, d};
            for (int k = 0; k < 6; k++)
                *t++ = quad[k];
        }
}

pc_status pc_synth_plane(pc_mesh *mesh, pc_context *ctx, double width, double height, pc_index nx,
                         pc_index ny) {
    pc_status status = pc_mesh_make(mesh, ctx, (size_t)(nx + 1) * (ny + 1), 2 * (size_t)nx * ny);
    if (status != PC_OK) return status;
    for (pc_index j = 0; j <= ny; j++)
        for (pc_index i = 0; i <= nx; i++)
            pc_vec3_put(mesh->position, i + (size_t)j * (nx + 1),
                        (pc_vec3){width * i / nx, height * j / ny, 0});
    grid_triangles(mesh, nx, ny, nx + 1, ny + 1);
    return PC_OK;
}

pc_status pc_synth_cylinder(pc_mesh *mesh, pc_context *ctx, double height, pc_index around, pc_index along) {
    pc_status status = pc_mesh_make(mesh, ctx, (size_t)around * (along + 1), 2 * (size_t)around * along);
    if (status != PC_OK) return status;
    for (pc_index j = 0; j <= along; j++)
        for (pc_index i = 0; i < around; i++) {
            double u = 2 * PC_PI * i / around;
            pc_vec3_put(mesh->position, i + (size_t)j * around,
                        (pc_vec3){cos(u), sin(u), height * j / along});
        }
    grid_triangles(mesh, around, along, around, along + 1);
    return PC_OK;
}

pc_status pc_synth_torus(pc_mesh *mesh, pc_context *ctx, double major, double minor, pc_index around,
                         pc_index across) {
    pc_status status = pc_mesh_make(mesh, ctx, (size_t)around * across, 2 * (size_t)around * across);
    if (status != PC_OK) return status;
    for (pc_index j = 0; j < across; j++)
        for (pc_index i = 0; i < around; i++) {
            double u = 2 * PC_PI * i / around, v = 2 * PC_PI * j / across, r = major + minor * cos(v);
            pc_vec3_put(mesh->position, i + (size_t)j * around,
                        (pc_vec3){r * cos(u), r * sin(u), minor * sin(v)});
        }
    grid_triangles(mesh, around, across, around, across);
    return PC_OK;
}

/* Vertices of the octahedron's surface are the lattice points with |x|+|y|+|z| = steps, listed by layers of
 * z. */
static pc_index lattice_vertex(int x, int y, int z, int n) {
    int a = z < 0 ? -z : z, ring = n - a; /* 4*ring points on this layer, one at a pole */
    pc_index before;
    if (z <= 0)
        before = z == -n ? 0 : (pc_index)(1 + 2 * (ring - 1) * ring);
    else
        before = (pc_index)(4 * n * n + 2 - 1 - 2 * ring * (ring + 1));
    if (ring == 0) return z < 0 ? 0 : (pc_index)(4 * n * n + 1);
    int at = y >= 0 ? (x > 0 ? y : ring - x) : (x < 0 ? 2 * ring - y : 3 * ring + x);
    if (y == 0 && x > 0) at = 0;
    return before + (pc_index)at % (pc_index)(4 * ring);
}

pc_status pc_synth_sphere(pc_mesh *mesh, pc_context *ctx, pc_index steps) {
    int n = (int)steps;
    pc_status status = pc_mesh_make(mesh, ctx, 4 * (size_t)n * n + 2, 8 * (size_t)n * n);
    if (status != PC_OK) return status;
    pc_index *t = mesh->triangle;
    for (int octant = 0; octant < 8; octant++) {
        int sx = octant & 1 ? -1 : 1, sy = octant & 2 ? -1 : 1, sz = octant & 4 ? -1 : 1;
        bool flip = sx * sy * sz < 0;
        for (int i = 0; i < n; i++)
            for (int j = 0; i + j < n; j++)
                for (int half = 0; half < (i + j < n - 1 ? 2 : 1); half++) {
                    int corner[3][2] = {
                        {i + half, j + half}, {i + 1 - half, j + half}, {i + half, j + 1 - half}};
                    if (half) corner[1][0] = i, corner[1][1] = j + 1, corner[2][0] = i + 1, corner[2][1] = j;
                    for (int k = 0; k < 3; k++) {
                        const int *c = corner[flip ? 2 - k : k];
                        int x = sx * c[0], y = sy * c[1], z = sz * (n - c[0] - c[1]);
                        pc_index v = lattice_vertex(x, y, z, n);
                        pc_vec3_put(mesh->position, v, pc_unit((pc_vec3){x, y, z}));
                        *t++ = v;
                    }
                }
    }
    return PC_OK;
}

/* The number of the lattice point x on the surface of a cube of n steps: layer by layer of z, around each
 * ring. */
static pc_index cube_vertex(const pc_index x[3], pc_index n) {
    pc_index bottom = (n + 1) * (n + 1), ring = 4 * n;
    if (x[2] == 0) return x[0] + x[1] * (n + 1);
    if (x[2] == n) return bottom + (n - 1) * ring + x[0] + x[1] * (n + 1);
    pc_index at = x[1] == 0 ? x[0] : x[0] == n ? n + x[1] : x[1] == n ? 3 * n - x[0] : 4 * n - x[1];
    return bottom + (x[2] - 1) * ring + at;
}

void pc_synth_cube_square(pc_index corner[4], double *position, int side, pc_index i, pc_index j,
                          pc_index n) {
    int axis = side / 2, far = side % 2;
    for (pc_index k = 0; k < 4; k++) {
        pc_index a = i + (k == 1 || k == 2), b = j + (k >= 2), x[3];
        x[axis] = far ? n : 0;
        x[(axis + 1) % 3] = far ? a : b;
        x[(axis + 2) % 3] = far ? b : a;
        corner[k] = cube_vertex(x, n);
        pc_vec3_put(position, corner[k],
                    (pc_vec3){2.0 * x[0] / n - 1, 2.0 * x[1] / n - 1, 2.0 * x[2] / n - 1});
    }
}

pc_status pc_synth_cube(pc_mesh *mesh, pc_context *ctx, pc_index steps) {
    size_t squares = 6 * (size_t)steps * steps;
    pc_status status = pc_mesh_make(mesh, ctx, squares + 2, 2 * squares);
    if (status != PC_OK) return status;
    pc_index *t = mesh->triangle;
    for (int side = 0; side < 6; side++)
        for (pc_index j = 0; j < steps; j++)
            for (pc_index i = 0; i < steps; i++) {
                pc_index c[4], odd = (i + j) % 2;
                pc_synth_cube_square(c, mesh->position, side, i, j, steps);
                const pc_index two[6] = {c[odd], c[1 + odd], c[2 + odd],
                                         c[odd], c[2 + odd], c[(3 + odd) % 4]};
                for (int k = 0; k < 6; k++)
                    *t++ = two[k];
            }
    return PC_OK;
}

/* Vertices: the bottom pole if any, the rings, the top pole if any. */
pc_status pc_synth_revolution(pc_mesh *mesh, pc_context *ctx, const double *profile, pc_index count,
                              pc_index around) {
    pc_index bottom = profile[0] == 0, top = profile[2 * (size_t)count - 2] == 0,
             rings = count - bottom - top;
    size_t faces = (2 * (size_t)(rings - 1) + bottom + top) * around;
    pc_status status = pc_mesh_make(mesh, ctx, (size_t)rings * around + bottom + top, faces);
    if (status != PC_OK) return status;
    pc_index *t = mesh->triangle, last = bottom + (rings - 1) * around, pole = bottom + rings * around;
    for (pc_index i = 0; i < around; i++) {
        double u = 2 * PC_PI * i / around;
        pc_index next = (i + 1) % around;
        for (pc_index r = 0; r < rings; r++) {
            const double *p = profile + 2 * (size_t)(r + bottom);
            pc_index row = bottom + r * around, a = row + i, b = row + next, c = b + around, d = a + around;
            pc_vec3_put(mesh->position, a, (pc_vec3){p[0] * cos(u), p[0] * sin(u), p[1]});
            if (r + 1 == rings) continue;
            const pc_index two[6] = {a, b, (i + r) % 2 ? d : c, (i + r) % 2 ? b : a, c, d};
            for (int k = 0; k < 6; k++)
                *t++ = two[k];
        }
        if (bottom) *t++ = 0, *t++ = bottom + next, *t++ = bottom + i;
        if (top) *t++ = last + i, *t++ = last + next, *t++ = pole;
    }
    if (bottom) pc_vec3_put(mesh->position, 0, (pc_vec3){0, 0, profile[1]});
    if (top) pc_vec3_put(mesh->position, pole, (pc_vec3){0, 0, profile[2 * (size_t)count - 1]});
    return PC_OK;
}

pc_status pc_synth_vase(pc_mesh *mesh, pc_context *ctx, pc_index rings, pc_index around) {
    double *profile = NULL;
    pc_status status = pc_new(&profile, ctx, 2 * ((size_t)rings + 2));
    if (status != PC_OK) return status;
    for (pc_index i = 0; i < rings + 2; i++) { /* a half circle, with a waist */
        double u = PC_PI * i / (rings + 1.0);
        profile[2 * (size_t)i] = i == 0 || i == rings + 1 ? 0 : sin(u) * (1 + 0.35 * sin(3 * u + 0.4));
        profile[2 * (size_t)i + 1] = -1.8 * cos(u);
    }
    status = pc_synth_revolution(mesh, ctx, profile, rings + 2, around);
    pc_free(ctx, profile);
    return status;
}
