/* A symmetric positive (semi-)definite matrix of small blocks over a graph. Knows no meshes.
 *
 * Row i of A x is   diagonal_i * x_i + sum over entries e of row i of  B_e x_column(e).
 * What B_e does depends on the kind:
 *   PC_BLOCK_SCALAR   width 1 unknown per row:     B_e = value[e]
 *   PC_BLOCK_COMPLEX  width 2 (re, im):            B_e x = (value[2e] + i value[2e+1]) * (x_0 + i x_1)
 *   PC_BLOCK_TURNED   width 4, two complex numbers U, V as X = (Re U, Im U, Re V, Im V):
 *                     B_e X = diag(value[4e..4e+1], value[4e+2..4e+3]) M^turn[e] X, values complex, and M the
 *                     quarter turn of PGP, (s,t) -> (t,-s): M (U,V) = (V, conj U), M^4 = 1.
 * Symmetry: the entry (j,i) is the transpose of the entry (i,j). */
#ifndef PC_SYSTEM_H
#define PC_SYSTEM_H

#include "context.h"

typedef enum pc_block_kind { PC_BLOCK_SCALAR, PC_BLOCK_COMPLEX, PC_BLOCK_TURNED } pc_block_kind;

typedef struct pc_system {
    pc_block_kind kind;
    pc_index row_count;
    pc_index *start;  /* row_count+1 offsets into the entries */
    pc_index *column; /* per entry, ascending within a row, the diagonal left out */
    double *diagonal; /* per row, times the identity */
    double *value;    /* 1, 2 or 4 per entry */
    uint8_t *turn;    /* per entry, 0..3; NULL unless PC_BLOCK_TURNED */
} pc_system;

/* Unknowns per row: 1, 2 or 4. */
static inline int pc_block_width(pc_block_kind kind) {
    return kind == PC_BLOCK_SCALAR ? 1 : kind == PC_BLOCK_COMPLEX ? 2 : 4;
}

pc_status pc_system_make(pc_system *system, pc_context *ctx, pc_block_kind kind, pc_index row_count,
                         size_t entry_count);
/* Frees all but the diagonal. */
void pc_system_free_couplings(pc_system *system, pc_context *ctx);
void pc_system_free(pc_system *system, pc_context *ctx);
/* Columns ascending and in range, values finite, diagonal positive, symmetric up to rounding. PC_E_BUG else.
 */
pc_status pc_system_check(const pc_system *system, pc_context *ctx);
/* Entry e as a dense matrix of width x width numbers, row after row. */
void pc_system_block(double out[16], const pc_system *system, size_t e);
/* y = A x in plain C, double: the reference of every kernel. x and y hold width*row_count numbers. */
void pc_system_apply(double *y, const pc_system *system, const double *x);

#endif
