#include "mosaic_quads.h"
#include "memory.h"
#include "upright.h"

enum { MOST_ROUNDS = 6 };

static pc_status place(pc_polymesh *quads, uint8_t **folded, pc_index **face_cell,
                       pc_mosaic_quads_stats *stats, pc_context *ctx, const pc_mosaic *mosaic,
                       const pc_ground *ground) {
    pc_status status = PC_OK;
    const pc_relax_options options = PC_RELAX_DEFAULTS;
    const pc_upright_options upright = PC_UPRIGHT_DEFAULTS;
    pc_relax_stats relaxed;
    PC_TRY(pc_mosaic_polygons(quads, face_cell, ctx, mosaic));
    PC_TRY(pc_new(folded, ctx, quads->face_count));
    PC_TRY(pc_relax(quads, &relaxed, *folded, ctx, ground, &options));
    if (stats->dissolved == 0) stats->relaxed.bad_before = relaxed.bad_before;
    stats->relaxed.bad_after = relaxed.bad_after;
    PC_TRY(pc_upright_make(quads, *folded, &stats->folded, NULL, ctx, ground, &upright));
done:
    return status;
}

/* Joins the cells of folded faces to neighbours; returns in *joins how many. */
static pc_status dissolve_folded(pc_mosaic *mosaic, pc_index *joins, pc_context *ctx, const uint8_t *folded,
                                 const pc_index *face_cell, pc_index faces) {
    uint8_t *wanted = NULL;
    pc_status status = pc_new(&wanted, ctx, mosaic->cell_count);
    if (status != PC_OK) return status;
    for (pc_index f = 0; f < faces; f++)
        if (folded[f]) wanted[face_cell[f]] = 1;
    *joins = pc_mosaic_dissolve(mosaic, wanted);
    pc_free(ctx, wanted);
    return PC_OK;
}

pc_status pc_mosaic_quads(pc_polymesh *quads, uint8_t **folded, pc_mosaic_quads_stats *stats, pc_context *ctx,
                          const pc_layout *layout, const pc_ground *ground) {
    pc_status status = PC_OK;
    pc_mosaic mosaic = {0};
    uint8_t *upside_down = NULL;
    pc_index *face_cell = NULL;
    *quads = (pc_polymesh){0};
    *stats = (pc_mosaic_quads_stats){0};
    if (folded) *folded = NULL;
    PC_TRY(pc_mosaic_make(&mosaic, ctx, layout));
    stats->mended = pc_mosaic_mend(&mosaic);
    PC_TRY(pc_mosaic_drop_lines(&mosaic, &stats->lines_gone, ctx, PC_MOSAIC_LONGEST, PC_MOSAIC_SLIMMEST));
    for (int round = 0;; round++) {
        pc_index joins;
        PC_TRY(place(quads, &upside_down, &face_cell, stats, ctx, &mosaic, ground));
        if (stats->folded == 0 || round == MOST_ROUNDS) break;
        PC_TRY(dissolve_folded(&mosaic, &joins, ctx, upside_down, face_cell, quads->face_count));
        if (joins == 0) break;
        stats->dissolved += joins;
        pc_free(ctx, upside_down);
        pc_free(ctx, face_cell);
        upside_down = NULL, face_cell = NULL;
        pc_polymesh_free(quads, ctx);
    }
    if (folded) *folded = upside_down, upside_down = NULL;
done:
    pc_mosaic_free(&mosaic, ctx);
    pc_free(ctx, upside_down);
    pc_free(ctx, face_cell);
    if (status != PC_OK) pc_polymesh_free(quads, ctx);
    return status;
}
