#include "smallmat.h"
#include "memory.h"
#include <math.h>
#include <string.h>

pc_status pc_smallmat_invert(double *m, pc_context *ctx, size_t n) {
    double *l = NULL;
    pc_status status = pc_new(&l, ctx, n * n);
    if (status != PC_OK) return status;
    /* m = L L^T, then L := L^-1, then m := L^T L. */
    for (size_t j = 0; j < n; j++) {
        double pivot = m[j * n + j];
        double least = 1e-12 * fabs(pivot);
        for (size_t k = 0; k < j; k++)
            pivot -= l[j * n + k] * l[j * n + k];
        l[j * n + j] = sqrt(pivot > least ? pivot : least > 0 ? 1e6 * least : 1);
#pragma omp parallel for schedule(static) if (n - j > 64)
        for (size_t i = j + 1; i < n; i++) {
            double sum = 0.5 * (m[i * n + j] + m[j * n + i]);
            for (size_t k = 0; k < j; k++)
                sum -= l[i * n + k] * l[j * n + k];
            l[i * n + j] = sum / l[j * n + j];
        }
    }
    memset(m, 0, n * n * sizeof *m);
    /* Column c of L^-1 goes to row c of m: contiguous for the products below. */
#pragma omp parallel for schedule(static)
    for (size_t c = 0; c < n; c++) {
        double *x = m + c * n;
        x[c] = 1 / l[c * n + c];
        for (size_t i = c + 1; i < n; i++) {
            double sum = 0;
            for (size_t k = c; k < i; k++)
                sum -= l[i * n + k] * x[k];
            x[i] = sum / l[i * n + i];
        }
    }
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < n; j++) {
            double sum = 0;
            for (size_t k = i > j ? i : j; k < n; k++)
                sum += m[i * n + k] * m[j * n + k];
            l[i * n + j] = sum;
        }
    }
    memcpy(m, l, n * n * sizeof *m);
    pc_free(ctx, l);
    return PC_OK;
}
