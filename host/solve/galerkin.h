/* Products of block matrices for the set-up of the hierarchy: rows in parallel, sums in double, results in
 * float, the same for any number of threads. */
#ifndef PC_GALERKIN_H
#define PC_GALERKIN_H

#include "blockmat.h"

/* P = (I - omega D^-1 A) T, rows without tentative block staying empty. */
pc_status pc_galerkin_smooth(pc_blockmat *prolongator, pc_context *ctx, const pc_blockmat *matrix,
                             const pc_blockmat *tentative, double omega);
/* R = P^T (conjugate for complex). */
pc_status pc_galerkin_transpose(pc_blockmat *restriction, pc_context *ctx, const pc_blockmat *prolongator);
/* The coarse matrix R A P, R the transpose of P, with its diagonals and their inverses; diagonals below
 * rounding are raised. Symmetric to the bit: one half is computed, the other mirrored. */
pc_status pc_galerkin_coarse(pc_blockmat *coarse, pc_context *ctx, const pc_blockmat *restriction,
                             const pc_blockmat *matrix, const pc_blockmat *prolongator);
/* Inverse diagonals of a square matrix, where it has some. */
void pc_galerkin_invert_diagonal(pc_blockmat *matrix);

#endif
