/* Block matrices on a device, in the layout of kernels/cycle.cl: slices of eight rows, longest rows first
 * within windows; dense blocks one row to a slice. Split into parts below the device's allocation cap. */
#ifndef PC_DEVMAT_H
#define PC_DEVMAT_H

#include "blockmat.h"
#include "launch.h"

/* The order of a level's rows on the device. */
typedef struct pc_row_order {
    pc_index count;
    pc_index padded; /* a multiple of 8 */
    pc_index *row;   /* per place: the row there */
    pc_index *place; /* per row */
} pc_row_order;

/* Rows of `matrix` sorted by length in windows of 256; as they are for dense matrices. */
pc_status pc_row_order_make(pc_row_order *order, pc_context *ctx, const pc_blockmat *matrix);
void pc_row_order_free(pc_row_order *order, pc_context *ctx);

typedef struct pc_devmat_part {
    pc_index first;  /* slice */
    pc_index slices; /* a multiple of 512 but in the last part */
    size_t entries;  /* of slices */
    pc_buffer *start;
    pc_buffer *column;
    pc_buffer *value;
    pc_buffer *exact; /* values in double, or NULL */
} pc_devmat_part;

typedef struct pc_devmat {
    pc_block_form form;
    pc_index row_count;
    pc_index slice_count;
    int part_count;
    pc_devmat_part *part;
    pc_buffer *diagonal; /* float; NULL for transfers */
    pc_buffer *inverse;
} pc_devmat;

/* Copies `matrix` with its rows and columns in the given orders. `exact`: the values in double too (those of
 * `system`). */
pc_status pc_devmat_make(pc_devmat *out, pc_context *ctx, pc_device *device, const pc_blockmat *matrix,
                         const pc_row_order *rows, const pc_row_order *columns, const pc_system *exact);
/* The diagonals of `matrix` anew, in the order of its making. */
pc_status pc_devmat_set_diagonals(pc_devmat *out, pc_context *ctx, const pc_blockmat *matrix,
                                  const pc_row_order *rows);
void pc_devmat_free(pc_devmat *matrix, pc_context *ctx);
/* Rows on the device: whole slices. */
static inline size_t pc_devmat_padded(const pc_devmat *matrix) {
    return matrix->form == PC_FORM_DENSE ? matrix->row_count : 8 * (size_t)matrix->slice_count;
}

#endif
