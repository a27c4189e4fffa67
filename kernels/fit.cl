/* The linear system of a spline fit; the plain-C reference is host/spline/energy.c. First the sums over the samples of
 * each element, then the rows of the control points, which gather from the elements under their functions in a fixed
 * order: no atomics, the same bytes whatever the number of compute units. A work-item does `chunk` elements or rows. */
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

/* As in energy.h. */
#define MOMENT 0
#define PULL 49
#define BENDING 97
#define LOCAL_SIZE 100
#define SLOT_DIAGONAL 0xfffe
#define SLOT_FIXED 0xffff
/* Doubles of a sample: u, v, target, weight. */
#define SAMPLE 6
#define IRREGULAR 0x80000000u

/* b[i] = u^i (1-u)^(n-i) */
inline void powers(double *b, int n, double u) {
    double up = 1, down = 1;
    for (int i = 0; i <= n; i++) {
        b[i] = up;
        up *= u;
    }
    for (int i = n; i >= 0; i--) {
        b[i] *= down;
        down *= 1 - u;
    }
}

/* y += the bending's matrix times the 16 numbers c. */
inline void add_bending(double *y, const double *factor, global const double *plate, const double *c) {
    for (int d = 0; d < 3; d++) {
        global const double *along = plate + 16 * (2 - d), *across = plate + 16 * d;
        for (int l = 0; l < 4; l++) {
            double z[4];
            for (int i = 0; i < 4; i++)
                z[i] = factor[d] * (along[i] * c[4 * l] + along[i + 4] * c[1 + 4 * l] + along[i + 8] * c[2 + 4 * l] +
                                    along[i + 12] * c[3 + 4 * l]);
            for (int j = 0; j < 4; j++)
                for (int i = 0; i < 4; i++)
                    y[i + 4 * j] += across[j + 4 * l] * z[i];
        }
    }
}

kernel void fit_local(global double *restrict local_sums, global double *restrict tally,
                      global const uint *restrict first, global const double *restrict sample,
                      global const double *restrict bezier, global const double *restrict bending,
                      global const double *restrict plate, const uint count, const uint chunk) {
    const uint from = get_global_id(0) * chunk, to = min(from + chunk, count);
    for (uint e = from; e < to; e++) {
        double moment[49], pull[48], total = 0, weight = 0, stiff = 0;
        const double factor[3] = {bending[3 * e], bending[3 * e + 1], bending[3 * e + 2]};
        global const double *x = bezier + 48 * (size_t)e;
        for (int i = 0; i < 49; i++)
            moment[i] = 0;
        for (int k = 0; k < 3; k++) {
            double c[16], y[16];
            for (int i = 0; i < 16; i++) {
                c[i] = x[3 * i + k];
                y[i] = 0;
            }
            add_bending(y, factor, plate, c);
            for (int i = 0; i < 16; i++) {
                pull[3 * i + k] = -y[i];
                stiff += c[i] * y[i];
            }
        }
        for (uint i = first[e]; i < first[e + 1]; i++) {
            global const double *p = sample + SAMPLE * (size_t)i;
            double s[7], t[7], r[3] = {p[2], p[3], p[4]};
            const double w = p[5];
            powers(s, 3, p[0]);
            powers(t, 3, p[1]);
            s[1] *= 3, s[2] *= 3, t[1] *= 3, t[2] *= 3;
            for (int k = 0; k < 16; k++)
                for (int d = 0; d < 3; d++)
                    r[d] -= s[k % 4] * t[k / 4] * x[3 * k + d];
            for (int k = 0; k < 16; k++)
                for (int d = 0; d < 3; d++)
                    pull[3 * k + d] += w * (s[k % 4] * t[k / 4]) * r[d];
            total += w * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
            weight += w;
            powers(s, 6, p[0]);
            powers(t, 6, p[1]);
            for (int j = 0; j < 7; j++)
                for (int k = 0; k < 7; k++)
                    moment[k + 7 * j] += w * t[j] * s[k];
        }
        global double *out = local_sums + LOCAL_SIZE * (size_t)e;
        for (int i = 0; i < 49; i++)
            out[MOMENT + i] = moment[i];
        for (int i = 0; i < 48; i++)
            out[PULL + i] = pull[i];
        for (int i = 0; i < 3; i++)
            out[BENDING + i] = factor[i];
        tally[3 * (size_t)e] = total;
        tally[3 * (size_t)e + 1] = weight;
        tally[3 * (size_t)e + 2] = stiff;
    }
}

/* y = the element's matrix times c, both in Bezier coefficients. */
inline void apply_local(double *y, global const double *sums, global const double *plate, const double *c) {
    const double binomial[4] = {1, 3, 3, 1};
    const double factor[3] = {sums[BENDING], sums[BENDING + 1], sums[BENDING + 2]};
    for (int i = 0; i < 16; i++)
        y[i] = 0;
    for (int l = 0; l < 4; l++)
        for (int k = 0; k < 4; k++) {
            const double scale = binomial[k] * binomial[l] * c[k + 4 * l];
            for (int j = 0; j < 4; j++)
                for (int i = 0; i < 4; i++)
                    y[i + 4 * j] += scale * sums[MOMENT + i + k + 7 * (j + l)];
        }
    for (int i = 0; i < 16; i++)
        y[i] *= binomial[i % 4] * binomial[i / 4];
    add_bending(y, factor, plate, c);
}

/* Coefficients of an element's functions: 8 each, whose products are meant, or all 16. */
inline void coefficients(double *c, global const double *from, bool irregular) {
    for (int i = 0; i < 16; i++)
        c[i] = irregular ? from[i] : from[i % 4] * from[4 + i / 4];
}

kernel void fit_rows(global double *restrict value, global double *restrict diagonal, global double *restrict right,
                     global const uint *restrict start, global const uint *restrict use_start,
                     global const uint *restrict use, global const uint *restrict use_element,
                     global const uint *restrict slot_start, global const ushort *restrict slot,
                     global const uint *restrict functions, global const uint *restrict coefficient_start,
                     global const double *restrict coefficient, global const double *restrict local_sums,
                     global const double *restrict plate, const uint count, const uint chunk) {
    const uint from = get_global_id(0) * chunk, to = min(from + chunk, count);
    for (uint row = from; row < to; row++) {
        global const ushort *own = slot + slot_start[row];
        global double *entry = value + start[row];
        double own_diagonal = 0, sum_x = 0, sum_y = 0, sum_z = 0;
        for (uint k = start[row]; k < start[row + 1]; k++)
            value[k] = 0;
        for (uint u = use_start[row]; u < use_start[row + 1]; u++) {
            const uint e = use_element[u];
            const bool irregular = (functions[e] & IRREGULAR) != 0;
            const uint number = functions[e] & ~IRREGULAR, stride = irregular ? 16 : 8;
            global const double *sums = local_sums + LOCAL_SIZE * (size_t)e;
            global const double *all = coefficient + coefficient_start[e];
            double c[16], y[16];
            coefficients(c, all + stride * use[u], irregular);
            for (int k = 0; k < 16; k++) {
                sum_x += c[k] * sums[PULL + 3 * k];
                sum_y += c[k] * sums[PULL + 3 * k + 1];
                sum_z += c[k] * sums[PULL + 3 * k + 2];
            }
            apply_local(y, sums, plate, c);
            for (uint k = 0; k < number; k++) {
                if (own[k] == SLOT_FIXED) continue;
                double other[16], sum = 0;
                coefficients(other, all + stride * k, irregular);
                for (int i = 0; i < 16; i++)
                    sum += y[i] * other[i];
                if (own[k] == SLOT_DIAGONAL)
                    own_diagonal += sum;
                else
                    entry[own[k]] += sum;
            }
            own += number;
        }
        diagonal[row] = own_diagonal > 0 ? own_diagonal : 1;
        right[3 * (size_t)row] = sum_x;
        right[3 * (size_t)row + 1] = sum_y;
        right[3 * (size_t)row + 2] = sum_z;
    }
}
