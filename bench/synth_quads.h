/* Quad meshes with known figures. */
#ifndef PC_SYNTH_QUADS_H
#define PC_SYNTH_QUADS_H

#include "polymesh.h"

/* nx x ny squares over [0,width] x [0,height], z = 0, normals up. */
pc_status pc_synth_quad_plane(pc_polymesh *mesh, pc_context *ctx, double width, double height, pc_index nx,
                              pc_index ny);
/* The torus of pc_synth_torus. */
pc_status pc_synth_quad_torus(pc_polymesh *mesh, pc_context *ctx, double major, double minor, pc_index around,
                              pc_index across);
/* The unit sphere as a cube of n x n faces per side, blown up: eight irregular vertices. */
pc_status pc_synth_quad_sphere(pc_polymesh *mesh, pc_context *ctx, pc_index n);
/* The rectangle [0,2] x [0,1] as one cell on the left, with a T-junction on its right side, and two on the
 * right. */
pc_status pc_synth_quad_tee(pc_polymesh *mesh, pc_context *ctx);

#endif
