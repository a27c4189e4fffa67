/* Synthetic scans: shapes with known answers, for tests and benchmarks. The same seed gives the same bytes.
 */
#ifndef PC_SYNTH_H
#define PC_SYNTH_H

#include "trimesh.h"

/* Unit sphere: an octahedron, every triangle cut in steps x steps. 8*steps^2 faces. */
pc_status pc_synth_sphere(pc_mesh *mesh, pc_context *ctx, pc_index steps);
/* Torus around z: centre circle radius `major`, tube radius `minor`; 2*around*across faces. */
pc_status pc_synth_torus(pc_mesh *mesh, pc_context *ctx, double major, double minor, pc_index around,
                         pc_index across);
/* Open cylinder around z, radius 1, of the given height; 2*around*along faces. */
pc_status pc_synth_cylinder(pc_mesh *mesh, pc_context *ctx, double height, pc_index around, pc_index along);
/* The rectangle [0,width] x [0,height] at z = 0; 2*nx*ny faces. */
pc_status pc_synth_plane(pc_mesh *mesh, pc_context *ctx, double width, double height, pc_index nx,
                         pc_index ny);
/* The cube [-1,1]^3 with sharp edges: 12*steps^2 faces. */
pc_status pc_synth_cube(pc_mesh *mesh, pc_context *ctx, pc_index steps);
/* The corners, counter-clockwise from outside, of square (i,j) of a side (0..5) of that cube, and their
 * positions. */
void pc_synth_cube_square(pc_index corner[4], double *position, int side, pc_index i, pc_index j, pc_index n);
/* Surface of revolution around z: `profile` has `count` points (radius, z), from bottom to top for outward
 * normals. A first or last radius of 0 closes that end, else it is open; no other radius may be 0. */
pc_status pc_synth_revolution(pc_mesh *mesh, pc_context *ctx, const double *profile, pc_index count,
                              pc_index around);
/* A closed vase by pc_synth_revolution: rings*around vertices and two poles. */
pc_status pc_synth_vase(pc_mesh *mesh, pc_context *ctx, pc_index rings, pc_index around);

#endif
