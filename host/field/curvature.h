/* The curvature tensor of a scan at each vertex, its principal directions, and how far to trust them. */
#ifndef PC_CURVATURE_H
#define PC_CURVATURE_H

#include "adjacency.h"
#include "device.h"

typedef struct pc_curvature_options {
    double radius; /* of the neighbourhood, model units; 0 takes radius_edges mean edge lengths */
    double radius_edges;
    double flatness; /* curvatures below flatness/radius count as flat */
    int levels; /* 1 to 3 neighbourhoods, each twice as large: where noise drowns one, the next is asked */
} pc_curvature_options;
#define PC_CURVATURE_DEFAULTS                                                                                \
    { 0, 3.0, 0.03, 2 }

typedef struct pc_curvature {
    pc_index vertex_count;
    double radius;    /* of the smallest neighbourhood, model units */
    double mean_edge; /* mean edge length of the mesh, model units */
    double *normal;   /* 3 per vertex: unit, averaged over the neighbourhood */
    double
        *tensor;   /* 6 per vertex, xx xy xz yy yz zz: mean normal-cycle tensor, 1/length. Its eigenvector
                      along an   edge of a cylinder carries 1/r: eigenvectors are swapped against curvatures */
    double *value; /* 2 per vertex: k1 >= k2, 1/length, positive where convex */
    double
        *direction; /* 3 per vertex: unit tangent (to normal) along which the curvature is k1; k2 is across */
    double *weight; /* per vertex in [0,1]: 0 where directions mean nothing (umbilic, flat, noise), 1 where
                       sure */
} pc_curvature;

/* Normal-cycle tensor (Li, thesis D.2.1, eq. D.8 with factor 1: the printed 2 doubles all curvatures)
 *   T(v) = 1/|B| sum over edges of beta(e) |e| w_v(e) e e^T,    |B| = sum over areas with the same weights,
 * beta the signed dihedral angle. The neighbourhood w_v is a smooth one: the k-step distribution of a walk on
 * the edges with self-loops, long edges taken less often, k such that its variance is that of a disk of
 * `radius`; where the mesh is finer than its mean, it reaches k rings. A smooth window measures better than a
 * ball with a sharp rim (tests/unit/test_curvature.c), and costs k sparse passes at any radius. Principal
 * directions are those of the restriction to the tangent plane with curvatures swapped (thesis D.2,
 * corrected). The weight is |k1-k2|/(|k1|+|k2|+flatness/radius), times the coherence of the edges' terms
 * measured against that of pure noise. PC_E_NOMEM, PC_E_DEVICE. */
pc_status pc_curvature_make(pc_curvature *curvature, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                            const pc_adjacency *adjacency, const pc_curvature_options *options);
void pc_curvature_free(pc_curvature *curvature, pc_context *ctx);
/* Values finite, k1 >= k2, directions unit and tangent, weights in [0,1]. PC_E_BUG names the first offender.
 */
pc_status pc_curvature_check(const pc_curvature *curvature, pc_context *ctx);

#endif
