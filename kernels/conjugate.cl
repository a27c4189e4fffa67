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

#if PC_CHUNK

#define EACH_SLICE                                                                                           \
    const uint from = get_global_id(0) * CHUNK_SLICES;                                                       \
    const uint to = min(from + CHUNK_SLICES, slices);                                                        \
    double dot_sum = 0;                                                                                      \
    for (uint s = from; s < to; s++)

#define LEAVE_PARTIAL partial[first / CHUNK_SLICES + get_global_id(0)] = dot_sum

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

/* The loops over entries are made for the usual storages each, so that nothing is asked inside. Columns are read one by
 * one: taking them out of vectors costs more. */
#define ENTRIES                                                                                              \
    const global uint *restrict column, const global float *restrict value, const global int *restrict rest, \
        const global ushort *restrict last, const global float *x, const uint from, const uint to,           \
        const uint storage, const uint wide
#define EACH_ENTRY(COLUMN)                                                                                   \
    const global COLUMN *c = (const global COLUMN *)column + 8 * (size_t)from;                               \
    for (uint k = from; k < to; k++, c += 8)
/* x from the least column of a slice of `width` numbers per row. */
#define OF_ENTRIES(width, storage, wide)                                                                     \
    column, value, rest, last, x + ((wide) ? 2 : 1) * (width) * (size_t)LEAST(s), start[s], start[s + 1],    \
        storage, wide
#define PICK(SUM, width)                                                                                     \
    (storage == (HALF | NARROW) && !wide ? SUM##_narrow(OF_ENTRIES(width, HALF, 0))                          \
     : storage == NARROW && !wide        ? SUM##_narrow(OF_ENTRIES(width, 0, 0))                             \
     : (storage & NARROW) != 0           ? SUM##_narrow(OF_ENTRIES(width, storage & HALF, wide))             \
                                         : SUM##_wide(OF_ENTRIES(width, storage, wide)))

#define EIGHT(V, z) (V)(z[c[0]], z[c[1]], z[c[2]], z[c[3]], z[c[4]], z[c[5]], z[c[6]], z[c[7]])
#define FOUR(V, z, n) (V)(z[c[n]], z[c[n + 1]], z[c[n + 2]], z[c[n + 3]])

#define SCALAR_SUM(COLUMN)                                                                                   \
    const global double *z = (const global double *)x;                                                       \
    double8 sum = 0;                                                                                         \
    EACH_ENTRY(COLUMN) {                                                                                     \
        const double8 v = wide ? EIGHT(double8, z) : convert_double8(EIGHT(float8, x));                      \
        sum += values(value, rest, last, k, storage) * v;                                                    \
    }                                                                                                        \
    return sum

inline double8 scalar_sum_narrow(ENTRIES) { SCALAR_SUM(ushort); }
inline double8 scalar_sum_wide(ENTRIES) { SCALAR_SUM(uint); }

/* y = A x, and the partial sums of x.y */
kernel void conjugate_scalar(MATRIX) {
    EACH_SLICE {
        const uint at = first + s;
        const double8 own = own_numbers(x, at, wide);
        const double8 sum = PICK(scalar_sum, 1) * units(exponent, s) + vload8(at, diagonal) * own;
        vstore8(sum, at, y);
        dot_sum += total8(sum * own);
    }
    LEAVE_PARTIAL;
}

/* Two halves of what eight rows have, four rows each. */
typedef struct halves {
    double8 low, high;
} halves;

/* Complex products from those of their parts: re re and im im side by side, re im and im re. */
inline double8 complex_products(double8 s, double8 c) {
    const double8 sign = (double8)(-1, 1, -1, 1, -1, 1, -1, 1);
    return (double8)(s.s0, c.s0, s.s2, c.s2, s.s4, c.s4, s.s6, c.s6) +
           sign * (double8)(s.s1, c.s1, s.s3, c.s3, s.s5, c.s5, s.s7, c.s7);
}

#define COMPLEX_SUM(COLUMN)                                                                                  \
    const global double2 *z = (const global double2 *)x;                                                     \
    const global float2 *w = (const global float2 *)x;                                                       \
    double8 low = 0;                                                                                         \
    double8 high = 0;                                                                                        \
    double8 low_crossed = 0;                                                                                 \
    double8 high_crossed = 0;                                                                                \
    EACH_ENTRY(COLUMN) {                                                                                     \
        const double8 a = values(value, rest, last, 2 * k, storage);                                         \
        const double8 b = values(value, rest, last, 2 * k + 1, storage);                                     \
        const double8 u = wide ? FOUR(double8, z, 0) : convert_double8(FOUR(float8, w, 0));                  \
        const double8 v = wide ? FOUR(double8, z, 4) : convert_double8(FOUR(float8, w, 4));                  \
        low += a * u;                                                                                        \
        low_crossed += a * u.s10325476;                                                                      \
        high += b * v;                                                                                       \
        high_crossed += b * v.s10325476;                                                                     \
    }                                                                                                        \
    halves sum;                                                                                              \
    sum.low = complex_products(low, low_crossed);                                                            \
    sum.high = complex_products(high, high_crossed);                                                         \
    return sum

inline halves complex_sum_narrow(ENTRIES) { COMPLEX_SUM(ushort); }
inline halves complex_sum_wide(ENTRIES) { COMPLEX_SUM(uint); }

kernel void conjugate_complex(MATRIX) {
    EACH_SLICE {
        const uint at = 2 * (first + s);
        const halves sum = PICK(complex_sum, 2);
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

/* Quarters of what eight rows have, two rows each. */
typedef struct quarters {
    double8 s0, s1, s2, s3;
} quarters;

inline double4 row_of(const global float *x, uint c, uint wide) {
    return wide ? ((const global double4 *)x)[c] : convert_double4(((const global float4 *)x)[c]);
}

/* Is any of the columns of an entry of a slice turned? */
inline int some_turned_narrow(const global ushort *c) {
    const ulong2 w = as_ulong2(vload8(0, c));
    return ((w.x | w.y) & 0xc000c000c000c000ul) != 0;
}
inline int some_turned_wide(const global uint *c) {
    const ulong4 w = as_ulong4(vload8(0, c));
    return ((w.x | w.y | w.z | w.w) & 0xc0000000c0000000ul) != 0;
}

#define ROW(n) turned(row_of(x, c[n] & mask, wide), c[n] >> bits)
#define TWO(n)                                                                                               \
    (some  ? (double8)(ROW(2 * n), ROW(2 * n + 1))                                                           \
     : wide ? (double8)(z[c[2 * n]], z[c[2 * n + 1]])                                                        \
            : convert_double8((float8)(w[c[2 * n]], w[c[2 * n + 1]])))
#define ADD_TWO(n)                                                                                           \
    do {                                                                                                     \
        const double8 a = values(value, rest, last, 4 * k + n, storage);                                     \
        const double8 u = TWO(n);                                                                            \
        straight##n += a * u;                                                                                \
        crossed##n += a * u.s10325476;                                                                       \
    } while (0)

#define TURNED_SUM(COLUMN, BITS, SOME)                                                                       \
    const global double4 *z = (const global double4 *)x;                                                     \
    const global float4 *w = (const global float4 *)x;                                                       \
    const uint bits = BITS;                                                                                  \
    const uint mask = (1u << bits) - 1;                                                                      \
    double8 straight0 = 0, straight1 = 0, straight2 = 0, straight3 = 0;                                      \
    double8 crossed0 = 0, crossed1 = 0, crossed2 = 0, crossed3 = 0;                                          \
    EACH_ENTRY(COLUMN) {                                                                                     \
        const int some = SOME(c);                                                                            \
        ADD_TWO(0);                                                                                          \
        ADD_TWO(1);                                                                                          \
        ADD_TWO(2);                                                                                          \
        ADD_TWO(3);                                                                                          \
    }                                                                                                        \
    quarters sum;                                                                                            \
    sum.s0 = complex_products(straight0, crossed0);                                                          \
    sum.s1 = complex_products(straight1, crossed1);                                                          \
    sum.s2 = complex_products(straight2, crossed2);                                                          \
    sum.s3 = complex_products(straight3, crossed3);                                                          \
    return sum

inline quarters turned_sum_narrow(ENTRIES) { TURNED_SUM(ushort, 14, some_turned_narrow); }
inline quarters turned_sum_wide(ENTRIES) { TURNED_SUM(uint, 30, some_turned_wide); }

/* y and x.y of the n-th two rows of a slice. */
#define LEAVE_TWO(n, unit2, g2)                                                                              \
    do {                                                                                                     \
        const uint at = 4 * (first + s) + n;                                                                 \
        const double8 own = own_numbers(x, at, wide);                                                        \
        const double8 whole = (unit2).s00001111 * sum.s##n + (g2).s00001111 * own;                           \
        vstore8(whole, at, y);                                                                               \
        dot_sum += total8(whole * own);                                                                      \
    } while (0)

kernel void conjugate_turned(MATRIX) {
    EACH_SLICE {
        const quarters sum = PICK(turned_sum, 4);
        const double8 unit = units(exponent, s);
        const double8 g = vload8(first + s, diagonal);
        LEAVE_TWO(0, unit.s01, g.s01);
        LEAVE_TWO(1, unit.s23, g.s23);
        LEAVE_TWO(2, unit.s45, g.s45);
        LEAVE_TWO(3, unit.s67, g.s67);
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
    const uint s = get_global_id(0) / SLICE;                                                                 \
    const uint lane = get_global_id(0) % SLICE;                                                              \
    const uint row = SLICE * first + get_global_id(0);                                                       \
    double dot_sum = 0;                                                                                      \
    if (s < slices)

#define LEAVE_PARTIAL                                                                                        \
    do {                                                                                                     \
        const double of_group = group_sum(dot_sum, tree);                                                    \
        if (get_local_id(0) == 0) partial[SLICE * first / GROUP + get_group_id(0)] = of_group;               \
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
            const uint at = 2 * (SLICE * k + lane);
            sum.lo += times(pair_at(value, rest, last, at, storage), u.lo);
            sum.hi += times(pair_at(value, rest, last, at + 1, storage), u.hi);
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
