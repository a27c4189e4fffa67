#include "smallmat.h"
#include "memory.h"
#include <math.h>
#include <string.h>

static void times4(double *c, const double *a, const double *b) {
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            c[4 * i + j] = a[4 * i] * b[j] + a[4 * i + 1] * b[4 + j] + a[4 * i + 2] * b[8 + j] +
                           a[4 * i + 3] * b[12 + j];
        }
    }
}

/* s = q^T q - 1; its largest entry */
static double defect4(double *s, const double *q) {
    double largest = 0;
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            double sum = i == j ? -1 : 0;
            for (int k = 0; k < 4; k++)
                sum += q[4 * k + i] * q[4 * k + j];
            s[4 * i + j] = sum;
            if (fabs(sum) > largest) largest = fabs(sum);
        }
    }
    return largest;
}

/* Takes the earlier columns out of column c and normalises it; false where little is left. */
static bool orthogonal_column(double *q, int c) {
    for (int pass = 0; pass < 2; pass++) {
        for (int e = 0; e < c; e++) {
            double along = 0;
            for (int k = 0; k < 4; k++)
                along += q[4 * k + e] * q[4 * k + c];
            for (int k = 0; k < 4; k++)
                q[4 * k + c] -= along * q[4 * k + e];
        }
    }
    double norm = 0;
    for (int k = 0; k < 4; k++)
        norm += q[4 * k + c] * q[4 * k + c];
    norm = sqrt(norm);
    if (norm < 0.1) return false;
    for (int k = 0; k < 4; k++)
        q[4 * k + c] /= norm;
    return true;
}

static void orthonormal4(double *q) {
    for (int c = 0; c < 4; c++) {
        if (orthogonal_column(q, c)) continue;
        /* One of the four axes has at least half its length outside the earlier columns. */
        for (int axis = 0; axis < 4; axis++) {
            for (int k = 0; k < 4; k++)
                q[4 * k + c] = k == axis;
            if (orthogonal_column(q, c)) break;
        }
    }
}

bool pc_smallmat_polar4(double *q, const double *m) {
    double norm = 0;
    double s[16];
    double t[16];
    double defect = 1;
    for (int i = 0; i < 16; i++)
        norm += m[i] * m[i];
    norm = sqrt(norm);
    if (!(norm > 1e-300)) {
        for (int i = 0; i < 16; i++)
            q[i] = i % 5 == 0;
        return false;
    }
    /* An orthogonal matrix has norm 2 and then stays; singular values never exceed 2 here, below sqrt(3) they
     * converge: hence a little less. */
    for (int i = 0; i < 16; i++)
        q[i] = m[i] * (1.7 / norm);
    for (int pass = 0; pass < 12 && defect > 1e-7; pass++) {
        defect = defect4(s, q);
        times4(t, q, s);
        for (int i = 0; i < 16; i++)
            q[i] -= 0.5 * t[i];
    }
    if (defect > 1e-3) orthonormal4(q);
    return true;
}

void pc_smallmat_inverse4(double *inverse, const double *m, double least) {
    double l[16] = {0};
    double mean = 0.25 * (m[0] + m[5] + m[10] + m[15]);
    double floor_of = least * mean;
    /* LDL^T with raised pivots, then the columns of the inverse. */
    double d[4];
    for (int j = 0; j < 4; j++) {
        double pivot = m[5 * j];
        for (int k = 0; k < j; k++)
            pivot -= l[4 * j + k] * l[4 * j + k] * d[k];
        d[j] = pivot > floor_of ? pivot : floor_of > 0 ? mean : 1;
        for (int i = j + 1; i < 4; i++) {
            double sum = 0.5 * (m[4 * i + j] + m[4 * j + i]);
            for (int k = 0; k < j; k++)
                sum -= l[4 * i + k] * l[4 * j + k] * d[k];
            l[4 * i + j] = pivot > floor_of ? sum / d[j] : 0;
        }
    }
    for (int c = 0; c < 4; c++) {
        double x[4];
        for (int i = 0; i < 4; i++) {
            x[i] = i == c;
            for (int k = 0; k < i; k++)
                x[i] -= l[4 * i + k] * x[k];
        }
        for (int i = 3; i >= 0; i--) {
            x[i] /= d[i];
            for (int k = i + 1; k < 4; k++)
                x[i] -= l[4 * k + i] * x[k];
            inverse[4 * i + c] = x[i];
        }
    }
}

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
