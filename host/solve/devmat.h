/* Block matrices on a device, in the layout of kernels/cycle.cl: slices of 8 rows on devices of chunk shape,
 * of 32 on those of row shape, longest rows first within windows. Split into parts below the device's
 * allocation cap.
 *
 * Numbers are kept in units of a power of two for each row, so that none is above 1 and halves never run out
 * of range. The finest matrix has what halves or floats leave of its doubles apart, as whole numbers: the
 * cycle reads the one, conjugate gradients both, and nothing is stored twice. */
#ifndef PC_DEVMAT_H
#define PC_DEVMAT_H

#include "blockmat.h"
#include "launch.h"

/* The order of a level's rows on the device. */
typedef struct pc_row_order {
    pc_index count;
    pc_index *row;   /* per place: the row there */
    pc_index *place; /* per row */
    pc_index copies; /* of other devices' rows, which have the places after the last slice (share.h) */
} pc_row_order;

/* Rows of `matrix` sorted by length in windows of 256. */
pc_status pc_row_order_make(pc_row_order *order, pc_context *ctx, const pc_blockmat *matrix);
void pc_row_order_free(pc_row_order *order, pc_context *ctx);

typedef struct pc_devmat_part {
    pc_index first;  /* slice */
    pc_index slices; /* of 4096 rows and multiples, but in the last part */
    size_t entries;  /* of slices */
    bool late;       /* reads copies of other devices' rows, so that it must wait for them */
    bool narrow;     /* columns in 16 bits */
    pc_buffer
        *start; /* per slice, and one more; then the least column of each slice, where they are narrow */
    pc_buffer *column;
    pc_buffer *value;    /* in the storage of the matrix */
    pc_buffer *rest;     /* what they leave, in units of 2^-42 or 2^-55; NULL where there are no doubles */
    pc_buffer *last;     /* what that leaves in units of 2^-58; NULL for floats */
    pc_buffer *exponent; /* per row, a byte: that of its unit as floats have it */
} pc_devmat_part;

typedef enum pc_storage {
    PC_STORE_FLOAT,
    PC_STORE_HALF,
    PC_STORE_DOUBLE /* as they are, with wide columns, for other kernels than those of the solver */
} pc_storage;

typedef struct pc_devmat {
    pc_block_form form;
    pc_storage storage;
    pc_index row_count;
    pc_index slice_rows;
    pc_index slice_count;
    int part_count;
    pc_devmat_part *part;
    pc_buffer *diagonal; /* float, 1 where there is no row; NULL for transfers */
} pc_devmat;

/* Copies the rows of `matrix` that `rows` has, in its order and with columns in that of `columns`; parts that
 * read copies are apart from the others. Where matrix->exact is there, all its digits are kept;
 * doubles need it, and are not scaled. */
pc_status pc_devmat_make(pc_devmat *out, pc_context *ctx, pc_device *device, const pc_blockmat *matrix,
                         const pc_row_order *rows, const pc_row_order *columns, pc_storage storage);
/* The diagonals of `matrix` anew, in the order of its making. */
pc_status pc_devmat_set_diagonals(pc_devmat *out, pc_context *ctx, const pc_blockmat *matrix,
                                  const pc_row_order *rows);
void pc_devmat_free(pc_devmat *matrix, pc_context *ctx);
/* How kernels are to read a part: their argument `storage`. */
static inline uint32_t pc_devmat_storage(const pc_devmat *matrix, const pc_devmat_part *part) {
    return (matrix->storage == PC_STORE_HALF ? 1U : 0U) | (part->narrow ? 2U : 0U);
}
/* Rows of a slice on a device. */
static inline pc_index pc_devmat_slice_rows(const pc_device *device) {
    return pc_device_shape(device) == PC_SHAPE_CHUNK ? 8 : 32;
}
/* Rows on the device: whole slices. */
static inline size_t pc_devmat_padded(const pc_devmat *matrix) {
    return (size_t)matrix->slice_rows * matrix->slice_count;
}

#endif
