/* Dense matrices: the coarsest system. Row-major doubles. */
#ifndef PC_SMALLMAT_H
#define PC_SMALLMAT_H

#include "context.h"

/* Inverse of a symmetric positive (semi-)definite n x n matrix by Cholesky, in place; vanishing pivots are
 * raised. */
pc_status pc_smallmat_invert(double *m, pc_context *ctx, size_t n);

#endif
