#include "hostvec.h"

/* A block's sum is one number; groups of blocks bound the partial sums that are kept. */
enum { BLOCK = 2048, GROUP = 512 };

/* Sums `term`, which may use i, over i in [0,n), blocks in parallel, in an order that only n decides. */
#define BLOCKED_SUM(result, n, term)                                                                         \
    do {                                                                                                     \
        (result) = 0;                                                                                        \
        for (size_t group = 0; group < (n); group += (size_t)BLOCK * GROUP) {                                \
            double partial[GROUP];                                                                           \
            size_t in_group = ((n)-group + BLOCK - 1) / BLOCK;                                               \
            if (in_group > GROUP) in_group = GROUP;                                                          \
            _Pragma("omp parallel for schedule(static)") for (size_t block = 0; block < in_group; block++) { \
                size_t from = group + block * BLOCK;                                                         \
                size_t to = from + BLOCK < (n) ? from + BLOCK : (n);                                         \
                double sum = 0;                                                                              \
                for (size_t i = from; i < to; i++)                                                           \
                    sum += (term);                                                                           \
                partial[block] = sum;                                                                        \
            }                                                                                                \
            for (size_t block = 0; block < in_group; block++)                                                \
                (result) += partial[block];                                                                  \
        }                                                                                                    \
    } while (0)

double pc_hostvec_dot(const double *x, const double *y, size_t n) {
    double result;
    BLOCKED_SUM(result, n, x[i] * y[i]);
    return result;
}

static inline double step(double *x, double *r, double p, double q, double alpha) {
    *x += alpha * p;
    *r -= alpha * q;
    return *r * *r;
}

double pc_hostvec_step(double *x, double *r, const double *p, const double *q, double alpha, size_t n) {
    double result;
    BLOCKED_SUM(result, n, step(&x[i], &r[i], p[i], q[i], alpha));
    return result;
}

void pc_hostvec_direction(double *p, const double *z, double beta, size_t n) {
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < n; i++)
        p[i] = z[i] + beta * p[i];
}

static inline double residual(double *r, double b) {
    *r = b - *r;
    return *r * *r;
}

double pc_hostvec_residual(double *r, const double *b, size_t n) {
    double result;
    BLOCKED_SUM(result, n, residual(&r[i], b[i]));
    return result;
}

static inline double divide(double *z, double r, double d) {
    *z = r / d;
    return *z * r;
}

double pc_hostvec_jacobi(double *z, const double *r, const double *diagonal, pc_index rows, int width) {
    double result;
    size_t n = (size_t)rows * (size_t)width;
    int shift = width == 1 ? 0 : width == 2 ? 1 : 2;
    BLOCKED_SUM(result, n, divide(&z[i], r[i], diagonal[i >> shift]));
    return result;
}

void pc_hostvec_narrow(float *y, const double *x, double scale, size_t n) {
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < n; i++)
        y[i] = (float)(scale * x[i]);
}

void pc_hostvec_widen(double *y, const float *x, double scale, size_t n) {
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < n; i++)
        y[i] = scale * (double)x[i];
}
