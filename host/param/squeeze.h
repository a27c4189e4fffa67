/* Where a parameterization gives a region far less room than it has on the scan: a bump laid flat, a horn in
 * one cell. */
#ifndef PC_SQUEEZE_H
#define PC_SQUEEZE_H

#include "edge_rows.h"
#include "param.h"

/* What a parameterization should give: the same while only its coordinates and shifts change. Borrows `rows`
 * and `scale` (as in pc_param_make). */
typedef struct pc_squeeze {
    const pc_edge_rows *rows;
    const double *scale;
    double *asked; /* per vertex: room, on the mean over about a period around it */
    double rings;  /* edges in half a period */
} pc_squeeze;

pc_status pc_squeeze_make(pc_squeeze *squeeze, pc_context *ctx, const pc_param *param, const pc_mesh *mesh,
                          const pc_edge_rows *rows, const double *scale);
void pc_squeeze_free(pc_squeeze *squeeze, pc_context *ctx);

/* Marks (adds 1 to) vertices whose cells are more than 1/`least` times as large as asked, on the mean over
 * about a period around them, and those about a period around such. `*count`: vertices that were not marked
 * before. */
pc_status pc_squeeze_mark(uint8_t *mark, pc_index *count, pc_context *ctx, const pc_squeeze *squeeze,
                          const pc_param *param, const pc_mesh *mesh, double least);

#endif
