/* The algebra of single blocks in double, for the set-up of the hierarchy. The three forms are closed under
 * products; sums of TURNED blocks are kept as one block for each turn. */
#ifndef PC_BLOCKALG_H
#define PC_BLOCKALG_H

#include "blockmat.h"
#include "eachrow.h"
#include <math.h>
#include <string.h>

/* A block as it is stored. */
typedef struct pc_blockval {
    double v[4];
    int turn;
} pc_blockval;

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
    return form == PC_FORM_TURNED ? 0.5 * sum : sum;
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
    out->turn = (4 - in->turn) & 3;
    if (form == PC_FORM_SCALAR) {
        out->v[0] = in->v[0];
    } else if (form == PC_FORM_COMPLEX) {
        out->v[0] = in->v[0];
        out->v[1] = -in->v[1];
    } else {
        double conjugate[4] = {in->v[0], -in->v[1], in->v[2], -in->v[3]};
        pc_turn_diagonal(out->v, out->turn, conjugate);
    }
}

/* c += a * b; the turn of a TURNED product is the sum of the turns. */
PC_ALWAYS_INLINE void pc_blockval_add_product(pc_block_form form, double *c, const pc_blockval *a,
                                              const double *b) {
    if (form == PC_FORM_SCALAR) {
        c[0] += a->v[0] * b[0];
    } else if (form == PC_FORM_COMPLEX) {
        c[0] += a->v[0] * b[0] - a->v[1] * b[1];
        c[1] += a->v[0] * b[1] + a->v[1] * b[0];
    } else {
        double moved[4] = {b[0], b[1], b[2], b[3]};
        if (a->turn != 0) pc_turn_diagonal(moved, a->turn, b);
        c[0] += a->v[0] * moved[0] - a->v[1] * moved[1];
        c[1] += a->v[0] * moved[1] + a->v[1] * moved[0];
        c[2] += a->v[2] * moved[2] - a->v[3] * moved[3];
        c[3] += a->v[2] * moved[3] + a->v[3] * moved[2];
    }
}

#endif
