/* The linear system of a spline fit; the plain-C reference is host/spline/energy.c. First the sums over the samples of
 * each element, then the rows of the control points, which gather from the elements under their functions in a fixed
 * order: no atomics, the same bytes whatever the number of compute units. A work-item does `chunk` elements or rows. */
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

/* What is known of one element, as in energy.c but for the bending: sums over its samples. */
#define MOMENT 0
#define PULL 49
#define LOCAL_SIZE 97
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
        tally[3 * (size_t)e] = total;
        tally[3 * (size_t)e + 1] = weight;
        tally[3 * (size_t)e + 2] = stiff;
    }
}

/* Coefficients of an element's functions: 16, or 8 whose products are meant. */
typedef struct functions {
    uint count, stride;
    global const double *from;
} functions;

inline functions functions_of(uint e, global const uint *count, global const uint *start, global const double *all) {
    functions f;
    f.count = count[e] & ~IRREGULAR;
    f.stride = count[e] & IRREGULAR ? 16 : 8;
    f.from = all + start[e];
    return f;
}

/* Lines of 4 coefficients of function k. */
inline void coefficients(double4 *c, const functions *f, uint k) {
    global const double *from = f->from + f->stride * k;
    for (int j = 0; j < 4; j++)
        c[j] = f->stride == 16 ? vload4(j, from) : vload4(0, from) * from[4 + j];
}

/* y . (function k) */
inline double product(const double4 *y, const functions *f, uint k) {
    global const double *from = f->from + f->stride * k;
    double4 sum;
    if (f->stride == 16)
        sum = y[0] * vload4(0, from) + y[1] * vload4(1, from) + y[2] * vload4(2, from) + y[3] * vload4(3, from);
    else
        sum = vload4(0, from) * (y[0] * from[4] + y[1] * from[5] + y[2] * from[6] + y[3] * from[7]);
    return (sum.x + sum.y) + (sum.z + sum.w);
}

/* The products of y with all functions, into the slots of a row. */
inline double add_products(global double *entry, global const ushort *slot, const double4 *y, const functions *f) {
    double diagonal = 0;
    for (uint k = 0; k < f->count; k++) {
        if (slot[k] == SLOT_FIXED) continue;
        const double sum = product(y, f, k);
        if (slot[k] == SLOT_DIAGONAL)
            diagonal += sum;
        else
            entry[slot[k]] += sum;
    }
    return diagonal;
}

/* What bending puts into the rows: the same for all samples. */
kernel void fit_bending(global double *restrict value, global double *restrict diagonal,
                        global const uint *restrict start, global const uint *restrict use_start,
                        global const uint *restrict use, global const uint *restrict use_element,
                        global const uint *restrict slot_start, global const ushort *restrict slot,
                        global const uint *restrict function_count, global const uint *restrict coefficient_start,
                        global const double *restrict coefficient, global const double *restrict bending,
                        global const double *restrict plate, const uint count, const uint chunk) {
    const uint from = get_global_id(0) * chunk, to = min(from + chunk, count);
    for (uint row = from; row < to; row++) {
        global const ushort *own = slot + slot_start[row];
        double own_diagonal = 0;
        for (uint k = start[row]; k < start[row + 1]; k++)
            value[k] = 0;
        for (uint u = use_start[row]; u < use_start[row + 1]; u++) {
            const uint e = use_element[u];
            const functions f = functions_of(e, function_count, coefficient_start, coefficient);
            const double factor[3] = {bending[3 * e], bending[3 * e + 1], bending[3 * e + 2]};
            double4 line[4];
            double c[16], y[16];
            coefficients(line, &f, use[u]);
            for (int j = 0; j < 4; j++)
                vstore4(line[j], j, c);
            for (int i = 0; i < 16; i++)
                y[i] = 0;
            add_bending(y, factor, plate, c);
            for (int j = 0; j < 4; j++)
                line[j] = vload4(j, y);
            own_diagonal += add_products(value + start[row], own, line, &f);
            own += f.count;
        }
        diagonal[row] = own_diagonal;
    }
}

/* Four neighbours of a line of 7 moments, moved along it and weighted. */
inline double4 slide(global const double *line, double4 weight) {
    return weight.x * vload4(0, line) + weight.y * vload4(0, line + 1) + weight.z * vload4(0, line + 2) +
           weight.w * vload4(0, line + 3);
}

/* y = the matrix of an element's samples times c[4j+i]. */
inline void apply_moments(double4 *y, global const double *moment, const double4 *c) {
    const double4 binomial = (double4)(1, 3, 3, 1);
    for (int j = 0; j < 4; j++)
        y[j] = 0;
    for (int l = 0; l < 4; l++) {
        const double4 scale = binomial * c[l] * (l == 1 || l == 2 ? 3.0 : 1.0);
        for (int j = 0; j < 4; j++)
            y[j] += slide(moment + 7 * (j + l), scale);
    }
    for (int j = 0; j < 4; j++)
        y[j] *= binomial * (j == 1 || j == 2 ? 3.0 : 1.0);
}

/* The same for c = a b. */
inline void apply_product(double4 *y, global const double *moment, double4 a, double4 b) {
    const double4 binomial = (double4)(1, 3, 3, 1);
    double4 along[7];
    a *= binomial, b *= binomial;
    for (int j = 0; j < 7; j++)
        along[j] = slide(moment + 7 * j, a);
    for (int j = 0; j < 4; j++)
        y[j] = (b.x * along[j] + b.y * along[j + 1] + b.z * along[j + 2] + b.w * along[j + 3]) * binomial *
               (j == 1 || j == 2 ? 3.0 : 1.0);
}

/* Rows and right-hand sides; `stiff` and `stiff_diagonal` are those of fit_bending. */
kernel void fit_rows(global double *restrict value, global double *restrict diagonal, global double *restrict right,
                     global const double *restrict stiff, global const double *restrict stiff_diagonal,
                     global const uint *restrict start, global const uint *restrict use_start,
                     global const uint *restrict use, global const uint *restrict use_element,
                     global const uint *restrict slot_start, global const ushort *restrict slot,
                     global const uint *restrict function_count, global const uint *restrict coefficient_start,
                     global const double *restrict coefficient, global const uint *restrict first,
                     global const double *restrict local_sums, const uint count, const uint chunk) {
    const uint from = get_global_id(0) * chunk, to = min(from + chunk, count);
    for (uint row = from; row < to; row++) {
        global const ushort *own = slot + slot_start[row];
        double own_diagonal = stiff_diagonal[row], sum_x = 0, sum_y = 0, sum_z = 0;
        for (uint k = start[row]; k < start[row + 1]; k++)
            value[k] = stiff[k];
        for (uint u = use_start[row]; u < use_start[row + 1]; u++) {
            const uint e = use_element[u];
            const functions f = functions_of(e, function_count, coefficient_start, coefficient);
            global const double *sums = local_sums + LOCAL_SIZE * (size_t)e, *pull = sums + PULL;
            double4 c[4], y[4];
            coefficients(c, &f, use[u]);
            for (int j = 0; j < 4; j++, pull += 12) {
                sum_x += c[j].x * pull[0] + c[j].y * pull[3] + c[j].z * pull[6] + c[j].w * pull[9];
                sum_y += c[j].x * pull[1] + c[j].y * pull[4] + c[j].z * pull[7] + c[j].w * pull[10];
                sum_z += c[j].x * pull[2] + c[j].y * pull[5] + c[j].z * pull[8] + c[j].w * pull[11];
            }
            if (first[e] < first[e + 1]) {
                global const double *from_a = f.from + f.stride * use[u];
                if (f.stride == 16)
                    apply_moments(y, sums + MOMENT, c);
                else
                    apply_product(y, sums + MOMENT, vload4(0, from_a), vload4(1, from_a));
                own_diagonal += add_products(value + start[row], own, y, &f);
            }
            own += f.count;
        }
        diagonal[row] = own_diagonal > 0 ? own_diagonal : 1;
        right[3 * (size_t)row] = sum_x;
        right[3 * (size_t)row + 1] = sum_y;
        right[3 * (size_t)row + 2] = sum_z;
    }
}
