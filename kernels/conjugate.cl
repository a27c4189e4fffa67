/* Conjugate gradients in double: products with the layout of cycle.cl, vector passes, and sums that do not depend on
 * the number of compute units: fixed chunks (or groups) leave one partial sum each, one work-item (or group) adds them.
 *
 * Numbers of the matrix are what the cycle reads, plus `rest` in units of 2^-42 and `last` in units of 2^-58 where that
 * is halves, else `rest` in units of 2^-55. Residuals are pairs of floats, `high` and `low`, in a unit of the caller's;
 * the cycle reads `high`. Directions are floats: they are what they are, the steps along them are in double.
 *
 * scalars[]: 0 p.q, 1 r.r, 2 and 3 r.z of the present and last iteration in turn. */
#ifndef PC_CHUNK
#define PC_CHUNK 1
#endif
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

#define HALF 1
#define NARROW 2
#define TURN_SHIFT 30
#define COLUMN(c) ((c) & 0x3fffffffu)
/* Slices of a chunk, and numbers of a chunk; both also in conjugate.c. */
#define CHUNK_SLICES 512
#define CHUNK 4096
#define GROUP 128

/* x is in doubles where `wide`, else in floats. */
#define MATRIX                                                                                               \
    const global uint *restrict start, const global uint *restrict column, const global float *restrict value, \
        const global int *restrict rest, const global ushort *restrict last, const global uchar *restrict exponent, \
        const global double *restrict diagonal, const global float *x, global double *restrict y,            \
        global double *restrict partial, const uint first, const uint slices, const uint storage, const uint wide

/* The least column of a slice; 0 where they are wide. */
#define LEAST(s) ((storage & NARROW) ? start[slices + 1 + (s)] : 0)

inline double4 turned(double4 u, uint t) {
    double4 s = (t & 1) ? u.zwxy : u;
    s.y = t >= 2 ? -s.y : s.y;
    s.w = t == 1 || t == 2 ? -s.w : s.w;
    return s;
}

inline double total4(double4 v) { return (v.x + v.y) + (v.z + v.w); }
inline double total8(double8 v) { return total4(v.lo + v.hi); }
inline double total16(double16 v) { return total8(v.lo + v.hi); }

#if PC_CHUNK

#define EACH_SLICE                                                                                           \
    const uint from = get_global_id(0) * CHUNK_SLICES;                                                       \
    const uint to = min(from + CHUNK_SLICES, slices);                                                        \
    double dot_sum = 0;                                                                                      \
    for (uint s = from; s < to; s++)

#define LEAVE_PARTIAL partial[first / CHUNK_SLICES + get_global_id(0)] = dot_sum

inline uint8 columns(const global uint *column, uint k, uint least, uint storage) {
    return (storage & NARROW) ? least + convert_uint8(vload8(k, (const global ushort *)column)) : vload8(k, column);
}

/* Four columns with turns in the top bits. */
inline uint4 turned_columns(const global uint *column, uint k, uint least, uint storage) {
    if (!(storage & NARROW)) return vload4(k, column);
    const uint4 word = convert_uint4(vload4(k, (const global ushort *)column));
    return (least + (word & 0x3fffu)) | (word >> 14) << TURN_SHIFT;
}

inline double8 values(const global float *value, const global int *rest, const global ushort *last, uint k,
                      uint storage) {
    const double8 more = convert_double8(vload8(k, rest));
    if (!(storage & HALF)) return convert_double8(vload8(k, value)) + 0x1p-55 * more;
    return convert_double8(vload_half8(k, (const global half *)value)) +
           (0x1p-42 * more + 0x1p-58 * convert_double8(vload8(k, last)));
}

inline double8 units(const global uchar *exponent, uint s) {
    return convert_double8(as_float8(convert_uint8(vload8(s, exponent)) << 23));
}

/* Eight numbers of a vector. */
inline double8 own_numbers(const global float *x, uint at, uint wide) {
    return wide ? vload8(at, (const global double *)x) : convert_double8(vload8(at, x));
}

/* The loops over entries are made for the usual storages each, so that nothing is asked inside. */
#define ENTRIES                                                                                              \
    const global uint *restrict column, const global float *restrict value, const global int *restrict rest, \
        const global ushort *restrict last, const global float *x, const uint from, const uint to,           \
        const uint least, const uint storage, const uint wide
#define OF_ENTRIES(storage, wide)                                                                            \
    column, value, rest, last, x, start[s], start[s + 1], LEAST(s), storage, wide

/* y = A x, and the partial sums of x.y */
kernel void conjugate_scalar(MATRIX) {
    const global double *z = (const global double *)x;
    EACH_SLICE {
        const uint at = first + s;
        const uint least = LEAST(s);
        double8 sum = 0;
        for (uint k = start[s]; k < start[s + 1]; k++) {
            const uint8 c = columns(column, k, least, storage);
            const double8 v =
                wide ? (double8)(z[c.s0], z[c.s1], z[c.s2], z[c.s3], z[c.s4], z[c.s5], z[c.s6], z[c.s7])
                     : convert_double8((float8)(x[c.s0], x[c.s1], x[c.s2], x[c.s3], x[c.s4], x[c.s5], x[c.s6],
                                                x[c.s7]));
            sum += values(value, rest, last, k, storage) * v;
        }
        const double8 own = own_numbers(x, at, wide);
        sum = sum * units(exponent, s) + vload8(at, diagonal) * own;
        vstore8(sum, at, y);
        dot_sum += total8(sum * own);
    }
    LEAVE_PARTIAL;
}

inline double8 four_complex(const global float *x, uint4 c, uint wide) {
    const global double2 *z = (const global double2 *)x;
    const global float2 *w = (const global float2 *)x;
    return wide ? (double8)(z[c.s0], z[c.s1], z[c.s2], z[c.s3])
                : convert_double8((float8)(w[c.s0], w[c.s1], w[c.s2], w[c.s3]));
}

/* Two halves of what eight rows have, four rows each. */
typedef struct halves {
    double8 low, high;
} halves;

inline halves complex_sum(ENTRIES) {
    const double8 sign = (double8)(-1, 1, -1, 1, -1, 1, -1, 1);
    double8 low = 0;
    double8 high = 0;
    double8 low_crossed = 0;
    double8 high_crossed = 0;
    for (uint k = from; k < to; k++) {
        const uint8 c = columns(column, k, least, storage);
        const double8 a = values(value, rest, last, 2 * k, storage);
        const double8 b = values(value, rest, last, 2 * k + 1, storage);
        const double8 u = four_complex(x, c.lo, wide);
        const double8 v = four_complex(x, c.hi, wide);
        low += a.s00224466 * u;
        low_crossed += a.s11335577 * u.s10325476;
        high += b.s00224466 * v;
        high_crossed += b.s11335577 * v.s10325476;
    }
    halves sum;
    sum.low = low + sign * low_crossed;
    sum.high = high + sign * high_crossed;
    return sum;
}

kernel void conjugate_complex(MATRIX) {
    EACH_SLICE {
        const uint at = 2 * (first + s);
        halves sum;
        if (storage == (HALF | NARROW) && !wide)
            sum = complex_sum(OF_ENTRIES(HALF | NARROW, 0));
        else if (storage == NARROW && !wide)
            sum = complex_sum(OF_ENTRIES(NARROW, 0));
        else
            sum = complex_sum(OF_ENTRIES(storage, wide));
        const double8 g = vload8(first + s, diagonal);
        const double8 unit = units(exponent, s);
        const double8 own_low = own_numbers(x, at, wide);
        const double8 own_high = own_numbers(x, at + 1, wide);
        const double8 low = unit.s00112233 * sum.low + g.s00112233 * own_low;
        const double8 high = unit.s44556677 * sum.high + g.s44556677 * own_high;
        vstore8(low, at, y);
        vstore8(high, at + 1, y);
        dot_sum += total8(low * own_low + high * own_high);
    }
    LEAVE_PARTIAL;
}

inline double4 row_of(const global float *x, uint c, uint wide) {
    return wide ? ((const global double4 *)x)[c] : convert_double4(((const global float4 *)x)[c]);
}

/* U and V of four rows, one side of a slice: more would not fit the registers. */
inline halves turned_sum(ENTRIES, const uint side) {
    const double8 sign = (double8)(-1, 1, -1, 1, -1, 1, -1, 1);
    double8 u_sum = 0;
    double8 u_crossed = 0;
    double8 v_sum = 0;
    double8 v_crossed = 0;
    for (uint k = from; k < to; k++) {
        const uint4 word = turned_columns(column, 2 * k + side, least, storage);
        const uint4 c = COLUMN(word);
        double4 r0 = row_of(x, c.s0, wide), r1 = row_of(x, c.s1, wide);
        double4 r2 = row_of(x, c.s2, wide), r3 = row_of(x, c.s3, wide);
        if (((word.x | word.y | word.z | word.w) >> TURN_SHIFT) != 0) {
            const uint4 t = word >> TURN_SHIFT;
            r0 = turned(r0, t.s0), r1 = turned(r1, t.s1), r2 = turned(r2, t.s2), r3 = turned(r3, t.s3);
        }
        const double8 a = values(value, rest, last, 4 * k + side, storage);
        const double8 b = values(value, rest, last, 4 * k + 2 + side, storage);
        const double8 u = (double8)(r0.lo, r1.lo, r2.lo, r3.lo);
        const double8 v = (double8)(r0.hi, r1.hi, r2.hi, r3.hi);
        u_sum += a.s00224466 * u;
        u_crossed += a.s11335577 * u.s10325476;
        v_sum += b.s00224466 * v;
        v_crossed += b.s11335577 * v.s10325476;
    }
    halves sum;
    sum.low = u_sum + sign * u_crossed;
    sum.high = v_sum + sign * v_crossed;
    return sum;
}

kernel void conjugate_turned(MATRIX) {
    EACH_SLICE {
        const double8 unit = units(exponent, s);
        for (uint side = 0; side < 2; side++) {
            halves sums;
            if (storage == (HALF | NARROW) && !wide)
                sums = turned_sum(OF_ENTRIES(HALF | NARROW, 0), side);
            else if (storage == NARROW && !wide)
                sums = turned_sum(OF_ENTRIES(NARROW, 0), side);
            else
                sums = turned_sum(OF_ENTRIES(storage, wide), side);
            const double8 u_sum = sums.low;
            const double8 v_sum = sums.high;
            const uint at = 2 * (first + s) + side;
            const double4 g = vload4(at, diagonal);
            const double4 f = side ? unit.hi : unit.lo;
            const double16 own = (double16)(own_numbers(x, 2 * at, wide), own_numbers(x, 2 * at + 1, wide));
            const double16 sum = f.s0000111122223333 *
                                     (double16)(u_sum.s01, v_sum.s01, u_sum.s23, v_sum.s23, u_sum.s45,
                                                v_sum.s45, u_sum.s67, v_sum.s67) +
                                 g.s0000111122223333 * own;
            vstore16(sum, at, y);
            dot_sum += total16(sum * own);
        }
    }
    LEAVE_PARTIAL;
}

/* Vector passes: an item takes CHUNK numbers; n is a multiple of 8. */
#define EACH_PART                                                                                            \
    const uint from = get_global_id(0) * (CHUNK / 8);                                                        \
    const uint to = min(from + CHUNK / 8, n / 8);                                                            \
    double8 sum = 0;                                                                                         \
    for (uint i = from; i < to; i++)
#define LEAVE_SUM partial[get_global_id(0)] = total8(sum)
#define LEAVE_NONE (void)sum
typedef double8 part;
#define LOAD(i, p)        vload8(i, p)
#define STORE(v, i, p)    vstore8(v, i, p)
#define FLOAT(v)          convert_float8(v)
#define DOUBLE(v)         convert_double8(v)

/* scalars[slot] = the sum of the partial sums, by one item. */
kernel void conjugate_finish(const global double *restrict partial, global double *restrict scalars, const uint count,
                             const uint slot) {
    double sum = 0;
    for (uint i = 0; i < count; i++)
        sum += partial[i];
    scalars[slot] = sum;
}

#else

/* As in cycle.cl. */
#define SLICE 32

/* The sum over a work-group, by a tree; on its first item. */
inline double group_sum(double mine, local double *tree) {
    const uint lane = get_local_id(0);
    tree[lane] = mine;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint width = GROUP / 2; width > 0; width /= 2) {
        if (lane < width) tree[lane] += tree[lane + width];
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    return tree[0];
}

#define ROW_OF_SLICE                                                                                         \
    local double tree[GROUP];                                                                                \
    const uint s = get_global_id(0) / SLICE;                                                                     \
    const uint lane = get_global_id(0) % SLICE;                                                                  \
    const uint row = SLICE * first + get_global_id(0);                                                           \
    double dot_sum = 0;                                                                                      \
    if (s < slices)

#define LEAVE_PARTIAL                                                                                        \
    do {                                                                                                     \
        const double of_group = group_sum(dot_sum, tree);                                                    \
        if (get_local_id(0) == 0) partial[SLICE * first / GROUP + get_group_id(0)] = of_group;                   \
    } while (0)

inline uint column_at(const global uint *column, uint at, uint least, uint storage) {
    return (storage & NARROW) ? least + ((const global ushort *)column)[at] : column[at];
}

/* With the turn in the top bits. */
inline uint turned_column(const global uint *column, uint at, uint least, uint storage) {
    if (!(storage & NARROW)) return column[at];
    const uint word = ((const global ushort *)column)[at];
    return (least + (word & 0x3fffu)) | (word >> 14) << TURN_SHIFT;
}

inline double number_at(const global float *value, const global int *rest, const global ushort *last, uint at,
                        uint storage) {
    if (!(storage & HALF)) return value[at] + 0x1p-55 * rest[at];
    return vload_half(at, (const global half *)value) + (0x1p-42 * rest[at] + 0x1p-58 * last[at]);
}

inline double2 pair_at(const global float *value, const global int *rest, const global ushort *last, uint at,
                       uint storage) {
    return (double2)(number_at(value, rest, last, 2 * at, storage), number_at(value, rest, last, 2 * at + 1, storage));
}

#define UNIT ((double)as_float((uint)exponent[get_global_id(0)] << 23))

kernel void conjugate_scalar(MATRIX) {
    const global double *z = (const global double *)x;
    ROW_OF_SLICE {
        const uint least = LEAST(s);
        double sum = 0;
        for (uint k = start[s]; k < start[s + 1]; k++) {
            const uint c = column_at(column, SLICE * k + lane, least, storage);
            sum += number_at(value, rest, last, SLICE * k + lane, storage) * (wide ? z[c] : (double)x[c]);
        }
        const double own = wide ? z[row] : (double)x[row];
        sum = UNIT * sum + diagonal[row] * own;
        y[row] = sum;
        dot_sum = sum * own;
    }
    LEAVE_PARTIAL;
}

inline double2 times(double2 a, double2 b) { return (double2)(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }

inline double2 complex_at(const global float *x, uint c, uint wide) {
    return wide ? ((const global double2 *)x)[c] : convert_double2(((const global float2 *)x)[c]);
}

kernel void conjugate_complex(MATRIX) {
    ROW_OF_SLICE {
        const uint least = LEAST(s);
        double2 sum = 0;
        for (uint k = start[s]; k < start[s + 1]; k++) {
            const uint c = column_at(column, SLICE * k + lane, least, storage);
            sum += times(pair_at(value, rest, last, SLICE * k + lane, storage), complex_at(x, c, wide));
        }
        const double2 own = complex_at(x, row, wide);
        sum = UNIT * sum + diagonal[row] * own;
        vstore2(sum, row, y);
        dot_sum = sum.x * own.x + sum.y * own.y;
    }
    LEAVE_PARTIAL;
}

inline double4 row_of(const global float *x, uint c, uint wide) {
    return wide ? ((const global double4 *)x)[c] : convert_double4(((const global float4 *)x)[c]);
}

kernel void conjugate_turned(MATRIX) {
    ROW_OF_SLICE {
        const uint least = LEAST(s);
        double4 sum = 0;
        for (uint k = start[s]; k < start[s + 1]; k++) {
            const uint c = turned_column(column, SLICE * k + lane, least, storage);
            const double4 u = turned(row_of(x, COLUMN(c), wide), c >> TURN_SHIFT);
            sum.lo += times(pair_at(value, rest, last, 2 * SLICE * k + lane, storage), u.lo);
            sum.hi += times(pair_at(value, rest, last, 2 * SLICE * k + SLICE + lane, storage), u.hi);
        }
        const double4 own = row_of(x, row, wide);
        sum = UNIT * sum + diagonal[row] * own;
        vstore4(sum, row, y);
        dot_sum = total4(sum * own);
    }
    LEAVE_PARTIAL;
}

#define EACH_PART                                                                                            \
    local double tree[GROUP];                                                                                \
    const uint i = get_global_id(0);                                                                         \
    double sum = 0;                                                                                          \
    if (i < n)
#define LEAVE_SUM                                                                                            \
    do {                                                                                                     \
        const double of_group = group_sum(sum, tree);                                                        \
        if (get_local_id(0) == 0) partial[get_group_id(0)] = of_group;                                       \
    } while (0)
#define LEAVE_NONE (void)(sum), (void)tree
typedef double part;
#define LOAD(i, p)        ((p)[i])
#define STORE(v, i, p)    ((p)[i] = (v))
#define FLOAT(v)          ((float)(v))
#define DOUBLE(v)         ((double)(v))

kernel void conjugate_finish(const global double *restrict partial, global double *restrict scalars, const uint count,
                             const uint slot) {
    local double tree[GROUP];
    double sum = 0;
    for (uint i = get_local_id(0); i < count; i += GROUP)
        sum += partial[i];
    const double all = group_sum(sum, tree);
    if (get_local_id(0) == 0) scalars[slot] = all;
}

#endif

/* A residual from a double, and back. */
#define SPLIT(v, i)                                                                                          \
    STORE(FLOAT(v), i, high);                                                                                \
    STORE(FLOAT((v) - DOUBLE(FLOAT(v))), i, low)
#define JOINED(i) (DOUBLE(LOAD(i, high)) + DOUBLE(LOAD(i, low)))

/* r = scale b, where at_start, else r -= scale q; sums of r.r */
kernel void conjugate_begin(global float *restrict high, global float *restrict low, const global double *restrict q,
                            global double *restrict partial, const uint n, const uint at_start, const double scale) {
    EACH_PART {
        const part v = at_start ? scale * LOAD(i, q) : JOINED(i) - scale * LOAD(i, q);
        SPLIT(v, i);
        sum += v * v;
    }
    LEAVE_SUM;
}

/* r -= a q and x += scale a p with a = r.z / p.q; sums of r.r */
kernel void conjugate_step(global double *restrict x, global float *restrict high, global float *restrict low,
                           const global float *restrict p, const global double *restrict q,
                           global double *restrict partial, const global double *restrict scalars, const uint n,
                           const uint slot, const double scale) {
    const double a = scalars[slot] / scalars[0];
    const double along = scale * a;
    EACH_PART {
        const part v = JOINED(i) - a * LOAD(i, q);
        STORE(LOAD(i, x) + along * DOUBLE(LOAD(i, p)), i, x);
        SPLIT(v, i);
        sum += v * v;
    }
    LEAVE_SUM;
}

/* Sums of r.z, z what the cycle found. */
kernel void conjugate_angle(const global float *restrict high, const global float *restrict z,
                            global double *restrict partial, const uint n) {
    EACH_PART { sum += DOUBLE(LOAD(i, high)) * DOUBLE(LOAD(i, z)); }
    LEAVE_SUM;
}

/* p = z + (r.z new / r.z old) p; p = z at the start. */
kernel void conjugate_direction(global float *restrict p, const global float *restrict z,
                                const global double *restrict scalars, const uint n, const uint slot,
                                const uint at_start) {
    const float b = at_start ? 0 : (float)(scalars[slot] / scalars[5 - slot]);
    EACH_PART { STORE(at_start ? LOAD(i, z) : LOAD(i, z) + b * LOAD(i, p), i, p); }
    LEAVE_NONE;
}
