/* What scanners and bad exports do to a shape: noise, holes, random order, needles, unwelded faces; and ways
 * to make big scans of small ones. All work in place; the same seed gives the same bytes. */
#ifndef PC_SYNTH_WEAR_H
#define PC_SYNTH_WEAR_H

#include "trimesh.h"
#include "vec3.h"

/* Mean length of the faces' sides. */
double pc_synth_mean_edge(const pc_mesh *mesh);

/* White noise: each vertex moves along its normal by a nearly Gaussian amount, deviation `amount` mean edges.
 */
pc_status pc_synth_noise(pc_mesh *mesh, pc_context *ctx, double amount, uint64_t seed);
/* Smooth noise as scanners leave it: the same deviation, but correlated over about `wavelength` mean edges.
 */
pc_status pc_synth_ripple(pc_mesh *mesh, pc_context *ctx, double amount, double wavelength, uint64_t seed);
/* Cuts `count` ragged holes of about `faces_each` faces. Each removes a disk that touches no border and no
 * other hole, so that the mesh stays manifold, each hole adds one boundary loop and lowers the Euler number
 * by one. The mesh must be manifold; PC_E_MESH where there is no room. */
pc_status pc_synth_holes(pc_mesh *mesh, pc_context *ctx, pc_index count, pc_index faces_each, uint64_t seed);
/* Random numbering of vertices and faces, and a random first corner. */
pc_status pc_synth_shuffle(pc_mesh *mesh, pc_context *ctx, uint64_t seed);
/* One face into four. `curved` lifts the new vertices on the cubic of the vertex normals (Vlachos et al.,
 * Curved PN triangles, 2001), else they are the midpoints. The mesh must be manifold. */
pc_status pc_synth_subdivide(pc_mesh *mesh, pc_context *ctx, bool curved);
/* Splits about `fraction` of the interior edges very near an end: two needles each. The mesh must be
 * manifold. */
pc_status pc_synth_needles(pc_mesh *mesh, pc_context *ctx, double fraction, uint64_t seed);
/* Adds a copy of another mesh, moved: a further component. */
pc_status pc_synth_append(pc_mesh *mesh, pc_context *ctx, const pc_mesh *other, pc_vec3 move);
/* Every face gets three vertices of its own, as in an STL file. */
pc_status pc_synth_unweld(pc_mesh *mesh, pc_context *ctx);
/* `faces` random triangles among `vertices` random points of the unit cube: anything but manifold. No face
 * uses a vertex twice. */
pc_status pc_synth_soup(pc_mesh *mesh, pc_context *ctx, pc_index vertices, pc_index faces, uint64_t seed);

#endif
