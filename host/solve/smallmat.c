#include "smallmat.h"
#include "memory.h"
#include <math.h>
#include <string.h>

/* y += a x */
static void add_multiple(double *y, double a, const double *x, size_t n) {
    for (size_t k = 0; k < n; k++)
        y[k] += a * x[k];
}

/* The lower half of m becomes L, m = L L^T; `beside` holds n numbers. */
static void factor(double *m, double *beside, size_t n) {
    for (size_t j = 0; j < n; j++) {
        /* beside[j] still is the diagonal as given. */
        double least = 1e-12 * fabs(beside[j]);
        double pivot = m[j * n + j];
        double root = sqrt(pivot > least ? pivot : least > 0 ? 1e6 * least : 1);
        m[j * n + j] = root;
        for (size_t i = j + 1; i < n; i++) {
            double keep = m[i * n + j] / root;
            m[i * n + j] = keep;
            m[j * n + i] = keep;
        }
        for (size_t i = j + 1; i < n; i++)
            add_multiple(m + i * n + j + 1, -m[i * n + j], m + j * n + j + 1, i - j);
    }
}

pc_status pc_smallmat_invert(double *m, pc_context *ctx, size_t n) {
    double *x = NULL;
    double *diagonal = NULL;
    pc_status status = PC_OK;
    PC_TRY(pc_new(&x, ctx, n * n));
    PC_TRY(pc_new(&diagonal, ctx, n));
    for (size_t j = 0; j < n; j++) {
        diagonal[j] = m[j * n + j];
        for (size_t i = j + 1; i < n; i++)
            m[i * n + j] = 0.5 * (m[i * n + j] + m[j * n + i]);
    }
    factor(m, diagonal, n);
    /* x = L^-1 */
    for (size_t i = 0; i < n; i++) {
        double *row = x + i * n;
        for (size_t k = 0; k < i; k++)
            add_multiple(row, -m[i * n + k], x + k * n, k + 1);
        for (size_t k = 0; k < i; k++)
            row[k] /= m[i * n + i];
        row[i] = 1 / m[i * n + i];
    }
    /* m = x^T x */
#pragma omp parallel for schedule(static, 8)
    for (size_t i = 0; i < n; i++) {
        memset(m + i * n, 0, n * sizeof *m);
        for (size_t k = i; k < n; k++)
            add_multiple(m + i * n, x[k * n + i], x + k * n, i + 1);
    }
    for (size_t i = 0; i < n; i++)
        for (size_t j = i + 1; j < n; j++)
            m[i * n + j] = m[j * n + i];
done:
    pc_free(ctx, x);
    pc_free(ctx, diagonal);
    return status;
}
