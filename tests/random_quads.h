/* Random closed quad meshes: a cube's sides, in which faces at random are folded up along a diagonal, which
 * leaves vertices of valence 3, 5, 6 and 7 in all sorts of company. */
#ifndef PC_RANDOM_QUADS_H
#define PC_RANDOM_QUADS_H

#include "memory.h"
#include "polygraph.h"
#include "random.h"
#include "synth_quads.h"
#include "testing.h"

/* Folds face f: its corner k goes onto corner k+2. */
static inline void fold_quad(pc_polymesh *mesh, pc_context *ctx, pc_index f, pc_index k) {
    pc_index gone = mesh->corner[4 * (size_t)f + k];
    pc_index kept = mesh->corner[4 * (size_t)f + (k + 2) % 4];
    uint8_t *removed = NULL;
    assert_ok(ctx, pc_new(&removed, ctx, mesh->face_count));
    for (size_t c = 0; c < 4 * (size_t)mesh->face_count; c++)
        if (mesh->corner[c] == gone) mesh->corner[c] = kept;
    removed[f] = 1;
    assert_ok(ctx, pc_polymesh_compact(mesh, ctx, removed));
    pc_free(ctx, removed);
}

static inline bool is_sound(const pc_polymesh *mesh, pc_context *ctx) {
    pc_polygraph graph;
    pc_index *valence = NULL;
    assert_ok(ctx, pc_polygraph_of_polymesh(&graph, ctx, mesh));
    const pc_surface_count *n = &graph.count;
    bool sound = !n->boundary_edges && !n->overfull_edges && !n->clashing_edges && !n->broken_faces &&
                 !n->split_vertices && n->chi == 2;
    assert_ok(ctx, pc_new(&valence, ctx, mesh->vertex_count));
    for (size_t c = 0; c < 4 * (size_t)mesh->face_count; c++)
        valence[mesh->corner[c]]++;
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        sound = sound && valence[v] >= 3 && valence[v] <= 7;
    pc_free(ctx, valence);
    pc_polygraph_free(&graph, ctx);
    return sound;
}

static inline void copy_quads(pc_polymesh *copy, pc_context *ctx, const pc_polymesh *mesh) {
    size_t corners = 4 * (size_t)mesh->face_count;
    assert_ok(ctx, pc_polymesh_make(copy, ctx, mesh->vertex_count, mesh->face_count, corners));
    memcpy(copy->position, mesh->position, 3 * sizeof(double) * mesh->vertex_count);
    memcpy(copy->corner, mesh->corner, corners * sizeof(pc_index));
    for (pc_index f = 0; f <= mesh->face_count; f++)
        copy->start[f] = 4 * f;
}

/* `n` x `n` faces per side of the cube, `folds` of them tried. */
static inline void make_random_quads(pc_polymesh *mesh, pc_context *ctx, uint64_t seed, pc_index n,
                                     int folds) {
    pc_random random = {seed};
    assert_ok(ctx, pc_synth_quad_sphere(mesh, ctx, n));
    for (int i = 0; i < folds; i++) {
        pc_polymesh folded;
        copy_quads(&folded, ctx, mesh);
        pc_index f = (pc_index)(pc_random_uniform(&random) * folded.face_count);
        fold_quad(&folded, ctx, f, (pc_index)(2 * pc_random_uniform(&random)));
        bool sound = is_sound(&folded, ctx);
        pc_polymesh_free(sound ? mesh : &folded, ctx);
        if (sound) *mesh = folded;
    }
}

#endif
