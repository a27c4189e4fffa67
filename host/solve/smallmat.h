/* Dense matrices: 4x4 blocks, and the coarsest system. Row-major doubles. */
#ifndef PC_SMALLMAT_H
#define PC_SMALLMAT_H

#include "context.h"

/* The orthogonal matrix next to `m` (polar factor); singular directions are filled up so that the result is
 * always orthogonal. False where m is zero: q is then the identity. Newton-Schulz iteration, Higham,
 * Functions of Matrices, ch. 8. */
bool pc_smallmat_polar4(double *q, const double *m);
/* The inverse of a symmetric positive 4x4 matrix. Eigenvalues below `least` times the mean diagonal are taken
 * as that; always finite and positive where the mean diagonal is. */
void pc_smallmat_inverse4(double *inverse, const double *m, double least);
/* Inverse of a symmetric positive (semi-)definite n x n matrix by Cholesky, in place; vanishing pivots are
 * raised. */
pc_status pc_smallmat_invert(double *m, pc_context *ctx, size_t n);

#endif
