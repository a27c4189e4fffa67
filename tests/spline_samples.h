/* Splines for tests of what reads and writes them, and places on them. */
#ifndef PC_SPLINE_SAMPLES_H
#define PC_SPLINE_SAMPLES_H

#include "insertion.h"
#include "memory.h"
#include "random.h"
#include "random_quads.h"
#include "shell.h"
#include "synth_quads.h"
#include "testing.h"

/* Faces at random, one in `rarity`, are halved one way or both. */
static inline void refine_at_random(pc_tspline *spline, pc_context *ctx, uint64_t seed, int rarity) {
    pc_random random = {seed};
    uint8_t *wish = NULL;
    pc_closure_stats stats;
    assert_ok(ctx, pc_new(&wish, ctx, spline->mesh.face_count));
    for (pc_index f = 0; f < spline->mesh.face_count; f++)
        if (pc_random_uniform(&random) * rarity < 1)
            wish[f] = (uint8_t)(1 + (int)(3 * pc_random_uniform(&random)));
    assert_ok(ctx, pc_insertion_refine(spline, &stats, ctx, wish));
    pc_free(ctx, wish);
}

enum { SAMPLE_SPHERE, SAMPLE_TORUS, SAMPLE_PLANE, SAMPLE_FOLDED, SAMPLE_COUNT };

/* Closed with eight extraordinary vertices, closed without, open (a bent plane), closed with all sorts of
 * them. */
static inline void make_sample_quads(pc_tspline *spline, pc_context *ctx, int kind) {
    const pc_tmesh_options options = PC_TMESH_DEFAULTS;
    pc_polymesh quads;
    if (kind == SAMPLE_SPHERE) assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 3));
    if (kind == SAMPLE_TORUS) assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 1, 12, 8));
    if (kind == SAMPLE_PLANE) assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 6, 4, 7, 5));
    if (kind == SAMPLE_FOLDED) make_random_quads(&quads, ctx, 42, 3, 4);
    if (kind == SAMPLE_PLANE)
        for (pc_index v = 0; v < quads.vertex_count; v++)
            quads.position[3 * v + 2] = 0.1 * quads.position[3 * v] * quads.position[3 * v + 1];
    assert_ok(ctx, pc_tspline_make(spline, ctx, &quads, &options));
    pc_polymesh_free(&quads, ctx);
}

/* All but the torus are refined. */
static inline void make_sample_spline(pc_tspline *spline, pc_context *ctx, int kind) {
    make_sample_quads(spline, ctx, kind);
    for (int i = 0; i < 2 && kind != SAMPLE_TORUS; i++)
        refine_at_random(spline, ctx, (uint64_t)kind + 7, 15);
}

/* Places of the spline on face f of its shell, u and v in 0..1 of it; which faces there are is the order of
 * pc_shell_make: blocks, then the elements of the others. */
static inline pc_surface_place place_on_shell(const pc_tspline *spline, const pc_blocks *blocks, pc_index f,
                                              double u, double v) {
    const pc_basis *basis = &spline->basis;
    if (f >= blocks->block_count) {
        pc_index rest = f - blocks->block_count, e = 0;
        for (;; e++)
            if (blocks->of_face[basis->element[e].face] == PC_NONE && rest-- == 0) break;
        const pc_element *element = basis->element + e;
        return (pc_surface_place){e, element->low[0] + u * (element->high[0] - element->low[0]),
                                  element->low[1] + v * (element->high[1] - element->low[1])};
    }
    const pc_block *block = blocks->block + f;
    double s = u * block->size[0], t = v * block->size[1];
    for (pc_index c = 0; c < block->cell_count; c++) {
        const pc_block_cell *cell = blocks->cell + block->cell + c;
        const double *size = spline->mesh.face[cell->face].size;
        double x = s - cell->origin[0], y = t - cell->origin[1]; /* turned back by R^-turn */
        double p = cell->turn == 0 ? x : cell->turn == 1 ? y : cell->turn == 2 ? -x : -y;
        double q = cell->turn == 0 ? y : cell->turn == 1 ? -x : cell->turn == 2 ? -y : x;
        if (p >= 0 && q >= 0 && p <= size[0] && q <= size[1])
            return pc_tspline_place(spline, cell->face, p, q);
    }
    fail_msg("no cell of block %u holds (%g,%g)", f, u, v);
    return (pc_surface_place){0, 0, 0};
}

#endif
