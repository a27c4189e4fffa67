/* What the tests of quad meshes share: a mesh is a manifold of a known Euler number. */
#ifndef PC_SURFACE_TESTING_H
#define PC_SURFACE_TESTING_H

#include "polygraph.h"
#include "testing.h"

/* Fails, naming the seed, where the mesh is no manifold, has unused vertices or another Euler number. */
static inline pc_surface_count is_manifold(pc_context *ctx, const pc_polymesh *mesh, int64_t chi,
                                           uint64_t seed) {
    pc_polygraph graph;
    assert_ok(ctx, pc_polygraph_of_polymesh(&graph, ctx, mesh));
    pc_surface_count count = graph.count;
    pc_polygraph_free(&graph, ctx);
    if (count.overfull_edges || count.clashing_edges || count.broken_faces || count.split_vertices ||
        count.unused_vertices || count.chi != chi)
        fail_msg("seed %llu: %u overfull and %u clashing edges, %u broken faces, %u split and %u unused "
                 "vertices, chi %lld instead of %lld",
                 (unsigned long long)seed, count.overfull_edges, count.clashing_edges, count.broken_faces,
                 count.split_vertices, count.unused_vertices, (long long)count.chi, (long long)chi);
    return count;
}

#endif
