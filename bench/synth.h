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

#endif
