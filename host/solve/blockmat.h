/* Matrices of small float blocks in compressed rows: the levels of the multigrid hierarchy and the transfers
 * between them, with their host kernels. */
#ifndef PC_BLOCKMAT_H
#define PC_BLOCKMAT_H

#include "system.h"

/* As in pc_block_kind. Sums of TURNED blocks of different turns, as they come up around singularities, are
 * kept apart: a row may hold a column up to four times, once for each turn, and its own column for the turns
 * 1 to 3. Every real 4x4 block is such a sum; nearly all have one term. */
typedef enum pc_block_form { PC_FORM_SCALAR, PC_FORM_COMPLEX, PC_FORM_TURNED } pc_block_form;

typedef struct pc_blockmat {
    pc_block_form form;
    pc_index row_count;
    pc_index column_count;
    pc_index *start;
    pc_index *column; /* ascending in a row, but for prolongators */
    float *value;     /* 1, 2 or 4 per entry */
    uint8_t *turn;    /* TURNED only */
    float *diagonal;  /* square matrices: apart from the entries, 1 per row, for TURNED one for U and one for
                         V; NULL for transfers */
    float *inverse;   /* of the diagonal, same shape; NULL where devices have the matrix */
    bool borrowed;    /* start, column and turn are someone else's */
    /* The finest level while its system is there: the entries in double, not owned; else NULL. */
    const double *exact;
    const double *exact_diagonal;
    double exact_scale; /* what both are to be multiplied by */
} pc_blockmat;

/* Reals of a row, of an entry, and of a diagonal. */
static inline int pc_form_width(pc_block_form form) {
    return form == PC_FORM_SCALAR ? 1 : form == PC_FORM_COMPLEX ? 2 : 4;
}
static inline int pc_form_size(pc_block_form form) {
    return pc_form_width(form);
}
static inline int pc_form_diagonal(pc_block_form form) {
    return form == PC_FORM_TURNED ? 2 : 1;
}

/* Arrays for the given counts; `square` adds the diagonals. */
pc_status pc_blockmat_make(pc_blockmat *matrix, pc_context *ctx, pc_block_form form, pc_index rows,
                           pc_index columns, size_t entries, bool square);
/* A square matrix with the graph of a system, which is to stay as long as the couplings. */
pc_status pc_blockmat_borrow(pc_blockmat *matrix, pc_context *ctx, const pc_system *system);
/* Frees all but the diagonals of a square matrix. */
void pc_blockmat_free_couplings(pc_blockmat *matrix, pc_context *ctx);
void pc_blockmat_free(pc_blockmat *matrix, pc_context *ctx);

/* Of the diagonal of row i. */
static inline double pc_blockmat_mean_diagonal(const pc_blockmat *matrix, pc_index i) {
    const float *d = matrix->diagonal;
    return matrix->form == PC_FORM_TURNED ? 0.5 * ((double)d[2 * (size_t)i] + (double)d[2 * (size_t)i + 1])
                                          : (double)d[i];
}

/* All of it, row by row: width*row_count x width*column_count numbers. */
void pc_blockmat_dense(double *out, const pc_blockmat *matrix);
/* y = A x (square: with its diagonal). */
void pc_blockmat_apply(float *y, const pc_blockmat *matrix, const float *x);
/* y += P x */
void pc_blockmat_add(float *y, const pc_blockmat *transfer, const float *x);
/* r = b - A x */
void pc_blockmat_residual(float *r, const pc_blockmat *matrix, const float *b, const float *x);
/* One Chebyshev step: d = alpha d + beta D^-1 (b - A x), x_new = x + d. alpha 0 does not read d. */
void pc_blockmat_smooth(float *x_new, float *d, const pc_blockmat *matrix, const float *b, const float *x,
                        float alpha, float beta);
/* The first step from x = 0: d = x = beta D^-1 b. */
void pc_blockmat_smooth_first(float *x, float *d, const pc_blockmat *matrix, const float *b, float beta);

#endif
