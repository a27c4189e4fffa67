/* Vector passes of conjugate gradients on the host. Sums run in fixed blocks, so that they do not depend on
 * the number of threads. */
#ifndef PC_HOSTVEC_H
#define PC_HOSTVEC_H

#include "context.h"

/* sum x_i y_i */
double pc_hostvec_dot(const double *x, const double *y, size_t n);
/* x += alpha p, r -= alpha q; the new r.r */
double pc_hostvec_step(double *x, double *r, const double *p, const double *q, double alpha, size_t n);
/* p = z + beta p */
void pc_hostvec_direction(double *p, const double *z, double beta, size_t n);
/* r = b - r; r.r */
double pc_hostvec_residual(double *r, const double *b, size_t n);
/* z = r / diagonal, `width` numbers per row; r.z */
double pc_hostvec_jacobi(double *z, const double *r, const double *diagonal, pc_index rows, int width);
/* y = (float)(scale x) and back. */
void pc_hostvec_narrow(float *y, const double *x, double scale, size_t n);
void pc_hostvec_widen(double *y, const float *x, double scale, size_t n);

#endif
