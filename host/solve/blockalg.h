/* The algebra of single blocks in double, for the set-up of the hierarchy. TURNED blocks multiply as they are
 * and become dense in products. */
#ifndef PC_BLOCKALG_H
#define PC_BLOCKALG_H

#include "blockmat.h"
#include "eachrow.h"
#include <math.h>
#include <string.h>

/* A block as it is stored. */
typedef struct pc_blockval {
    double v[16];
    int turn;
} pc_blockval;

/* The form of products. */
PC_ALWAYS_INLINE pc_block_form pc_form_coarse(pc_block_form form) {
    return form == PC_FORM_TURNED ? PC_FORM_DENSE : form;
}

PC_ALWAYS_INLINE void pc_blockval_load(pc_block_form form, pc_blockval *b, const pc_blockmat *a, size_t e) {
    const int n = pc_form_size(form);
    if (a->exact) {
        for (int k = 0; k < n; k++)
            b->v[k] = a->exact[(size_t)n * e + (size_t)k] * a->exact_scale;
    } else {
        for (int k = 0; k < n; k++)
            b->v[k] = (double)a->value[(size_t)n * e + (size_t)k];
    }
    b->turn = form == PC_FORM_TURNED ? a->turn[e] : 0;
}

/* |B|^2 as of a multiple of an orthogonal matrix. */
PC_ALWAYS_INLINE double pc_blockval_square(pc_block_form form, const pc_blockval *b) {
    double sum = 0;
    for (int k = 0; k < pc_form_size(form); k++)
        sum += b->v[k] * b->v[k];
    return form == PC_FORM_DENSE ? 0.25 * sum : form == PC_FORM_TURNED ? 0.5 * sum : sum;
}

/* (p,q) of diag(p,q) moved from the right of M^turn to its left. */
PC_ALWAYS_INLINE void pc_turn_diagonal(double *out, int turn, const double *in) {
    int first = (turn & 1) ? 2 : 0;
    out[0] = in[first];
    out[1] = turn >= 2 ? -in[first + 1] : in[first + 1];
    out[2] = in[2 - first];
    out[3] = turn == 1 || turn == 2 ? -in[3 - first] : in[3 - first];
}

/* The transpose of diag(p,q) M^t is M^-t diag(conj p, conj q). */
PC_ALWAYS_INLINE void pc_blockval_transpose(pc_block_form form, pc_blockval *out, const pc_blockval *in) {
    double conjugate[4] = {in->v[0], -in->v[1], in->v[2], -in->v[3]};
    out->turn = (4 - in->turn) & 3;
    if (form == PC_FORM_DENSE) {
        for (int k = 0; k < 16; k++)
            out->v[k] = in->v[k % 4 * 4 + k / 4];
    } else if (form == PC_FORM_TURNED) {
        pc_turn_diagonal(out->v, out->turn, conjugate);
    } else {
        memcpy(out->v, conjugate, sizeof conjugate);
    }
}

/* c += s * a * b; a TURNED: b and c dense. Else all of one form. */
PC_ALWAYS_INLINE void pc_blockval_add_product(pc_block_form form, double *c, const pc_blockval *a,
                                              const float *b, double s) {
    if (form == PC_FORM_SCALAR) {
        c[0] += s * a->v[0] * (double)b[0];
    } else if (form == PC_FORM_COMPLEX) {
        double re = s * a->v[0];
        double im = s * a->v[1];
        c[0] += re * (double)b[0] - im * (double)b[1];
        c[1] += re * (double)b[1] + im * (double)b[0];
    } else if (form == PC_FORM_TURNED) {
        int t = a->turn;
        const float *first = b + ((t & 1) ? 8 : 0);
        const float *second = b + ((t & 1) ? 0 : 8);
        double sign1 = t >= 2 ? -s : s;
        double sign2 = t == 1 || t == 2 ? -s : s;
        for (int k = 0; k < 4; k++) {
            double p = s * (double)first[k];
            double p_im = sign1 * (double)first[4 + k];
            double q = s * (double)second[k];
            double q_im = sign2 * (double)second[4 + k];
            c[k] += a->v[0] * p - a->v[1] * p_im;
            c[4 + k] += a->v[0] * p_im + a->v[1] * p;
            c[8 + k] += a->v[2] * q - a->v[3] * q_im;
            c[12 + k] += a->v[2] * q_im + a->v[3] * q;
        }
    } else {
        for (int r = 0; r < 4; r++) {
            for (int m = 0; m < 4; m++) {
                double f = s * a->v[4 * r + m];
                for (int k = 0; k < 4; k++)
                    c[4 * r + k] += f * (double)b[4 * m + k];
            }
        }
    }
}

/* diag(p,q) M^turn as a dense row-major block. */
PC_ALWAYS_INLINE void pc_turned_dense(float *out, const float *v, int turn) {
    /* Row pair `half` of M^turn takes U or V, conjugated or not. */
    memset(out, 0, 16 * sizeof *out);
    for (int half = 0; half < 2; half++) {
        int source = (turn & 1) ? 1 - half : half;
        bool conjugate = half == 0 ? turn >= 2 : turn == 1 || turn == 2;
        float sign = conjugate ? -1.0F : 1.0F;
        float *rows = out + (ptrdiff_t)8 * half + (ptrdiff_t)2 * source;
        rows[0] = v[2 * half];
        rows[1] = -sign * v[2 * half + 1];
        rows[4] = v[2 * half + 1];
        rows[5] = sign * v[2 * half];
    }
}

#endif
