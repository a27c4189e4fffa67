#include "blocks.h"
#include "cubic.h"
#include "memory.h"
#include <stdlib.h>
#include <string.h>

static void rotate(double to[2], int turn, const double from[2]) {
    double x = from[0], y = from[1];
    to[0] = turn == 0 ? x : turn == 1 ? -y : turn == 2 ? -x : y;
    to[1] = turn == 0 ? y : turn == 1 ? x : turn == 2 ? -y : -x;
}

/* The block that grows: its sides as half-edges of its outermost faces. */
typedef struct growth {
    const pc_tspline *spline;
    pc_blocks *blocks;
    pc_index *side[4]; /* counter-clockwise each */
    pc_index count[4];
    pc_index *strip; /* the row that is tried */
    size_t cells;
    double low[2], high[2];
} growth;

static bool is_free(const growth *g, pc_index f) {
    return f != PC_NONE && !g->spline->mesh.face[f].ghost && g->blocks->of_face[f] == PC_NONE &&
           !pc_tface_is_irregular(&g->spline->mesh, f);
}

/* The half-edge of the face of h on the next side, where that side is one half-edge. */
static pc_index whole_side(const pc_tmesh *mesh, pc_index h) {
    const pc_thalf *e = mesh->half + h;
    return e->along <= 0 && e->interval == mesh->face[e->face].size[e->side & 1] ? h : PC_NONE;
}

/* Whether the faces beyond side k are a row that fits: whole sides against whole sides, the same height, each
 * the neighbour of the last. Puts their inner half-edges into the strip. */
static bool finds_row(growth *g, int k, pc_index block) {
    const pc_tmesh *mesh = &g->spline->mesh;
    double height = 0;
    for (pc_index i = 0; i < g->count[k]; i++) {
        pc_index inner = mesh->half[g->side[k][i]].twin;
        pc_index f = mesh->half[inner].face;
        if (!is_free(g, f) || whole_side(mesh, inner) == PC_NONE) return false;
        double own = mesh->face[f].size[(mesh->half[inner].side + 1) & 1];
        if (i == 0) height = own;
        if (own != height) return false;
        if (i > 0) { /* along the side counter-clockwise: the next face is beyond the last one's left side */
            pc_index left = mesh->half[g->strip[i - 1]].prev;
            pc_index right = mesh->half[inner].next;
            if (whole_side(mesh, left) == PC_NONE || mesh->half[left].twin != right) return false;
        }
        for (pc_index j = 0; j < i; j++)
            if (mesh->half[g->strip[j]].face == f) return false;
        for (pc_index h = mesh->half[inner].next; h != inner; h = mesh->half[h].next) {
            pc_index beyond = mesh->half[mesh->half[h].twin].face; /* no block meets itself */
            if (beyond == f || (beyond != PC_NONE && g->blocks->of_face[beyond] == block)) return false;
        }
        g->strip[i] = inner;
    }
    return true;
}

static void add_cell(growth *g, pc_index inner, int k, double *along) {
    const pc_tmesh *mesh = &g->spline->mesh;
    pc_block_cell *cell = g->blocks->cell + g->cells++;
    const pc_thalf *e = mesh->half + inner;
    double at[2], local[2], turned[2];
    /* `inner` runs against side k; its head is where the side's half-edge begins. */
    at[0] = k == 0 ? g->low[0] + *along : k == 1 ? g->high[0] : k == 2 ? g->high[0] - *along : g->low[0];
    at[1] = k == 0 ? g->low[1] : k == 1 ? g->low[1] + *along : k == 2 ? g->high[1] : g->high[1] - *along;
    *along += e->interval;
    *cell = (pc_block_cell){.face = e->face, .turn = (k + 2 - e->side) & 3};
    pc_thalf_place(local, mesh, e->next);
    rotate(turned, cell->turn, local);
    cell->origin[0] = at[0] - turned[0];
    cell->origin[1] = at[1] - turned[1];
}

/* The strip becomes part of the block. */
static void take_row(growth *g, int k, pc_index block) {
    const pc_tmesh *mesh = &g->spline->mesh;
    pc_index n = g->count[k], before = (pc_index)(k + 3) & 3, after = (pc_index)(k + 1) & 3;
    double along = 0;
    double height = mesh->face[mesh->half[g->strip[0]].face].size[(mesh->half[g->strip[0]].side + 1) & 1];
    for (pc_index i = 0; i < n; i++) {
        g->blocks->of_face[mesh->half[g->strip[i]].face] = block;
        add_cell(g, g->strip[i], k, &along);
    }
    /* Side `before` ends and side `after` begins with the new row. */
    pc_index first = mesh->half[g->strip[0]].next, last = mesh->half[g->strip[n - 1]].prev;
    pc_index *longer = g->side[before];
    for (pc_index h = first; mesh->half[h].side == mesh->half[first].side; h = mesh->half[h].next)
        longer[g->count[before]++] = h;
    pc_index extra = 0, h = last;
    while (mesh->half[h].along > 0)
        h = mesh->half[h].prev;
    for (pc_index e = h; mesh->half[e].side == mesh->half[h].side; e = mesh->half[e].next)
        extra++;
    memmove(g->side[after] + extra, g->side[after], g->count[after] * sizeof **g->side);
    for (pc_index i = 0; i < extra; i++, h = mesh->half[h].next)
        g->side[after][i] = h;
    g->count[after] += extra;
    pc_index outer = 0;
    pc_index *fresh = g->side[k];
    /* The new side k: the outer sides of the strip's faces, which may have T-junctions. */
    for (pc_index i = 0; i < n; i++) {
        pc_index side = (pc_index)(mesh->half[g->strip[i]].side + 2) & 3, e = mesh->half[g->strip[i]].next;
        while (mesh->half[e].side != side)
            e = mesh->half[e].next;
        for (; mesh->half[e].side == side; e = mesh->half[e].next)
            fresh[outer++] = e;
    }
    g->count[k] = outer;
    if (k == 0) g->low[1] -= height;
    if (k == 1) g->high[0] += height;
    if (k == 2) g->high[1] += height;
    if (k == 3) g->low[0] -= height;
}

static void begin(growth *g, pc_index f, pc_index block) {
    const pc_tmesh *mesh = &g->spline->mesh;
    pc_index h = mesh->face[f].first;
    memset(g->count, 0, sizeof g->count);
    do {
        int k = mesh->half[h].side;
        g->side[k][g->count[k]++] = h;
        h = mesh->half[h].next;
    } while (h != mesh->face[f].first);
    g->blocks->of_face[f] = block;
    g->blocks->cell[g->cells++] = (pc_block_cell){.face = f};
    g->low[0] = g->low[1] = 0;
    g->high[0] = mesh->face[f].size[0], g->high[1] = mesh->face[f].size[1];
}

static void finish(growth *g, pc_block *block, size_t *sides) {
    block->cell_count = (pc_index)(g->cells - block->cell);
    for (size_t c = block->cell; c < g->cells; c++)
        for (int k = 0; k < 2; k++)
            g->blocks->cell[c].origin[k] -= g->low[k];
    for (int k = 0; k < 2; k++)
        block->size[k] = g->high[k] - g->low[k];
    block->side = *sides;
    for (int k = 0; k < 4; k++) {
        memcpy(g->blocks->side + *sides, g->side[k], g->count[k] * sizeof **g->side);
        *sides += g->count[k];
    }
    block->side_count = (pc_index)(*sides - block->side);
}

pc_status pc_blocks_make(pc_blocks *blocks, pc_context *ctx, const pc_tspline *spline) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &spline->mesh;
    growth g = {.spline = spline, .blocks = blocks};
    size_t sides = 0;
    *blocks = (pc_blocks){0};
    PC_TRY(pc_new(&blocks->of_face, ctx, mesh->face_count));
    PC_TRY(pc_new(&blocks->block, ctx, mesh->face_count));
    PC_TRY(pc_new(&blocks->cell, ctx, mesh->face_count));
    PC_TRY(pc_new(&blocks->side, ctx, mesh->half_count));
    PC_TRY(pc_new(&g.strip, ctx, mesh->half_count));
    for (int k = 0; k < 4; k++)
        PC_TRY(pc_new(&g.side[k], ctx, mesh->half_count));
    memset(blocks->of_face, 0xff, mesh->face_count * sizeof *blocks->of_face);
    for (pc_index f = 0; f < mesh->face_count; f++) {
        if (!is_free(&g, f)) continue;
        pc_index number = blocks->block_count++;
        pc_block *block = blocks->block + number;
        block->cell = g.cells;
        begin(&g, f, number);
        for (int k = 0, vain = 0; vain < 4; k = (k + 1) & 3) {
            if (finds_row(&g, k, number))
                take_row(&g, k, number), vain = 0;
            else
                vain++;
        }
        finish(&g, block, &sides);
    }
done:
    pc_free(ctx, g.strip);
    for (int k = 0; k < 4; k++)
        pc_free(ctx, g.side[k]);
    if (status != PC_OK) pc_blocks_free(blocks, ctx);
    return status;
}

void pc_blocks_free(pc_blocks *blocks, pc_context *ctx) {
    pc_free(ctx, blocks->block);
    pc_free(ctx, blocks->cell);
    pc_free(ctx, blocks->side);
    pc_free(ctx, blocks->of_face);
    *blocks = (pc_blocks){0};
}

static int ascending(const void *x, const void *y) {
    double a = *(const double *)x, b = *(const double *)y;
    return (a > b) - (a < b);
}

/* All corners of the block's elements in direction k, each once. */
static pc_status find_lines(pc_block_surface *surface, pc_context *ctx, const pc_tspline *spline,
                            const pc_blocks *blocks, const pc_block *block, int k) {
    pc_status status = PC_OK;
    size_t count = 0, kept = 0;
    const pc_basis *basis = &spline->basis;
    for (int pass = 0; pass < 2; pass++) {
        if (pass) PC_TRY(pc_new(&surface->line[k], ctx, count));
        count = 0;
        for (pc_index c = 0; c < block->cell_count; c++) {
            const pc_block_cell *cell = blocks->cell + block->cell + c;
            for (pc_index e = basis->face_start[cell->face]; e < basis->face_start[cell->face + 1]; e++) {
                double low[2], high[2];
                rotate(low, cell->turn, basis->element[e].low);
                rotate(high, cell->turn, basis->element[e].high);
                if (pass) surface->line[k][count] = cell->origin[k] + low[k];
                if (pass) surface->line[k][count + 1] = cell->origin[k] + high[k];
                count += 2;
            }
        }
    }
    qsort(surface->line[k], count, sizeof(double), ascending);
    for (size_t i = 0; i < count; i++)
        if (kept == 0 || surface->line[k][i] != surface->line[k][kept - 1])
            surface->line[k][kept++] = surface->line[k][i];
    surface->line_count[k] = (pc_index)kept;
done:
    return status;
}

/* Knot i of the clamped knot vector. */
static double knot_at(const pc_block_surface *surface, int k, pc_index i) {
    pc_index last = surface->line_count[k] - 1;
    return surface->line[k][i < 3 ? 0 : i - 3 > last ? last : i - 3];
}

/* The blossom at s and t (block's frame) of the piece that holds the point `at`. */
static pc_vec3 block_blossom(const pc_tspline *spline, const pc_blocks *blocks, const pc_block *block,
                             const double at[2], const double s[3], const double t[3]) {
    const pc_block_cell *cell = blocks->cell + block->cell;
    double local[2] = {0, 0};
    for (pc_index c = 0; c < block->cell_count; c++) {
        cell = blocks->cell + block->cell + c;
        const double from[2] = {at[0] - cell->origin[0], at[1] - cell->origin[1]};
        const double *size = spline->mesh.face[cell->face].size;
        rotate(local, (4 - cell->turn) & 3, from);
        if (local[0] >= 0 && local[1] >= 0 && local[0] <= size[0] && local[1] <= size[1]) break;
    }
    pc_index e = pc_basis_find(&spline->basis, cell->face, local[0], local[1]);
    const pc_element *element = spline->basis.element + e;
    double argument[2][3], w[2][4];
    for (int i = 0; i < 3; i++) {
        const double from[2] = {s[i] - cell->origin[0], t[i] - cell->origin[1]};
        double to[2];
        rotate(to, (4 - cell->turn) & 3, from);
        argument[0][i] = to[0], argument[1][i] = to[1];
    }
    for (int k = 0; k < 2; k++)
        pc_bezier_blossom_weights(w[k], element->low[k], element->high[k], argument[k]);
    pc_vec3 p = {0, 0, 0};
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++)
            p = pc_madd(p, w[0][i] * w[1][j],
                        pc_vec3_at(spline->bezier, 16 * (size_t)e + (size_t)(i + 4 * j)));
    return p;
}

pc_status pc_block_surface_make(pc_block_surface *surface, pc_context *ctx, const pc_tspline *spline,
                                const pc_blocks *blocks, pc_index number) {
    pc_status status = PC_OK;
    const pc_block *block = blocks->block + number;
    *surface = (pc_block_surface){0};
    for (int k = 0; k < 2; k++)
        PC_TRY(find_lines(surface, ctx, spline, blocks, block, k));
    pc_index n = surface->line_count[0] + 2, m = surface->line_count[1] + 2;
    PC_TRY(pc_new(&surface->point, ctx, 3 * (size_t)n * m));
    for (pc_index i = 0; i < n * m; i++) {
        const pc_index index[2] = {i % n, i / n};
        double knot[2][3], at[2];
        for (int k = 0; k < 2; k++) {
            pc_index spans = surface->line_count[k] - 1, span = index[k] < 2 ? 0 : index[k] - 2;
            span = span < spans ? span : spans - 1;
            at[k] = (surface->line[k][span] + surface->line[k][span + 1]) / 2;
            for (pc_index j = 0; j < 3; j++)
                knot[k][j] = knot_at(surface, k, index[k] + 1 + j);
        }
        pc_vec3_put(surface->point, i, block_blossom(spline, blocks, block, at, knot[0], knot[1]));
    }
done:
    if (status != PC_OK) pc_block_surface_free(surface, ctx);
    return status;
}

void pc_block_surface_free(pc_block_surface *surface, pc_context *ctx) {
    pc_free(ctx, surface->line[0]);
    pc_free(ctx, surface->line[1]);
    pc_free(ctx, surface->point);
    *surface = (pc_block_surface){0};
}
