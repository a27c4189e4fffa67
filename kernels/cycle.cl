/* The multigrid cycle: products with sliced block matrices and Chebyshev steps, in float.
 *
 * Eight rows make a slice in the chunk shape, 32 in the row shape; entry k of a slice holds the k-th entries of its
 * rows side by side: columns, and scalars, complex numbers, or (turned) complex numbers for U and then those for V,
 * with the quarter turn in the two top bits of the column. `start` counts entries of slices. Diagonals: a number per
 * row, for turned one for U and one for V.
 *
 * `storage`, a sum of: 1 numbers are halves, else floats; 2 columns have 16 bits and count from the least one of their
 * slice, which follows the starts, else 32 bits and from 0. Sums are in units of 2^(exponent - 127), a byte per row.
 *
 * Modes: 0 y = A x, 1 y += A x, 2 y = b - A x, 3 d = alpha d + beta D^-1 (b - A x), y = x + d; 2 and 3 with diagonal.
 * Chunk shape: a work-item takes `per_item` slices as wide vectors. Row shape: a work-item takes a row. */
#ifndef PC_CHUNK
#define PC_CHUNK 1
#endif

#define HALF 1
#define NARROW 2
#define TURN_SHIFT 30
#define COLUMN(c) ((c) & 0x3fffffffu)

#define MATRIX                                                                                               \
    const global uint *restrict start, const global uint *restrict column, const global float *restrict value, \
        const global uchar *restrict exponent, const global float *restrict diagonal,                        \
        const global float *restrict x, const global float *restrict b, global float *y, global float *d,    \
        const uint first, const uint slices, const uint per_item, const uint storage, const uint mode,       \
        const float alpha, const float beta

/* Number, pair or group of eight at place k. */
#define VALUES(V, N, k) ((storage & HALF) ? vload_half##N(k, (const global half *)value) : V(k, value))
/* The least column of a slice; 0 where they are wide. */
#define LEAST(s) ((storage & NARROW) ? start[slices + 1 + (s)] : 0)

/* M^t of (U,V): M (U,V) = (V, conj U). */
inline float4 turned(float4 u, uint t) {
    float4 s = (t & 1) ? u.zwxy : u;
    s.y = t >= 2 ? -s.y : s.y;
    s.w = t == 1 || t == 2 ? -s.w : s.w;
    return s;
}

/* What the modes do with a sum; V is the vector type, `g` its diagonal. */
#define FINISH(V, LOAD, STORE, sum, at, g)                                                                   \
    do {                                                                                                     \
        if (mode == 0) {                                                                                     \
            STORE(sum, at, y);                                                                               \
        } else if (mode == 1) {                                                                              \
            STORE(LOAD(at, y) + sum, at, y);                                                                 \
        } else {                                                                                             \
            const V own = LOAD(at, x);                                                                       \
            const V residual = LOAD(at, b) - sum - (g) * own;                                                \
            if (mode == 2) {                                                                                 \
                STORE(residual, at, y);                                                                      \
            } else {                                                                                         \
                V change = beta * residual / (g);                                                            \
                if (alpha != 0) change += alpha * LOAD(at, d);                                               \
                STORE(change, at, d);                                                                        \
                STORE(own + change, at, y);                                                                  \
            }                                                                                                \
        }                                                                                                    \
    } while (0)

#define LOAD1(at, p) ((p)[at])
#define STORE1(v, at, p) ((p)[at] = (v))

#if PC_CHUNK

inline uint8 columns(const global uint *column, uint k, uint least, uint storage) {
    return (storage & NARROW) ? least + convert_uint8(vload8(k, (const global ushort *)column)) : vload8(k, column);
}

/* With turns in the top bits. */
inline uint8 turned_columns(const global uint *column, uint k, uint least, uint storage) {
    if (!(storage & NARROW)) return vload8(k, column);
    const uint8 word = convert_uint8(vload8(k, (const global ushort *)column));
    return (least + (word & 0x3fffu)) | (word >> 14) << TURN_SHIFT;
}

/* Units of the rows of a slice. */
inline float8 units(const global uchar *exponent, uint s) {
    return as_float8(convert_uint8(vload8(s, exponent)) << 23);
}

#define EACH_SLICE                                                                                           \
    const uint from = get_global_id(0) * per_item;                                                           \
    const uint to = min(from + per_item, slices);                                                            \
    for (uint s = from; s < to; s++)

/* The loops over entries are made for the usual storages each, so that nothing is asked inside. */
#define ENTRIES                                                                                              \
    const global uint *restrict column, const global float *restrict value, const global float *restrict x,  \
        const uint from, const uint to, const uint least, const uint storage
#define OF_ENTRIES(storage) column, value, x, start[s], start[s + 1], LEAST(s), storage
#define PICK(SUM)                                                                                            \
    (storage == (HALF | NARROW) ? SUM(OF_ENTRIES(HALF | NARROW))                                             \
                                : storage == NARROW ? SUM(OF_ENTRIES(NARROW)) : SUM(OF_ENTRIES(storage)))

inline float8 scalar_sum(ENTRIES) {
    float8 sum = 0;
    for (uint k = from; k < to; k++) {
        const uint8 c = columns(column, k, least, storage);
        sum += VALUES(vload8, 8, k) *
               (float8)(x[c.s0], x[c.s1], x[c.s2], x[c.s3], x[c.s4], x[c.s5], x[c.s6], x[c.s7]);
    }
    return sum;
}

kernel void cycle_scalar(MATRIX) {
    EACH_SLICE {
        const uint at = first + s;
        const float8 sum = PICK(scalar_sum) * units(exponent, s);
        FINISH(float8, vload8, vstore8, sum, at, vload8(at, diagonal));
    }
}

#define TWICE(v) ((v).s0011223344556677)

inline float16 complex_sum(ENTRIES) {
    const global float2 *z = (const global float2 *)x;
    const float16 sign = (float16)(-1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1);
    float16 straight = 0;
    float16 crossed = 0;
    for (uint k = from; k < to; k++) {
        const uint8 c = columns(column, k, least, storage);
        const float16 a = VALUES(vload16, 16, k);
        const float16 u = (float16)(z[c.s0], z[c.s1], z[c.s2], z[c.s3], z[c.s4], z[c.s5], z[c.s6], z[c.s7]);
        straight += a.s0022446688aaccee * u;
        crossed += a.s1133557799bbddff * u.s1032547698badcfe;
    }
    return straight + sign * crossed;
}

kernel void cycle_complex(MATRIX) {
    EACH_SLICE {
        const uint at = first + s;
        const float16 sum = TWICE(units(exponent, s)) * PICK(complex_sum);
        FINISH(float16, vload16, vstore16, sum, at, TWICE(vload8(at, diagonal)));
    }
}

/* (U, V) per row to the four reals of a row. */
#define PAIRS(v) ((v).s0011223344556677)

/* U and V of eight rows. */
typedef struct pair {
    float16 u, v;
} pair;

inline pair turned_sum(ENTRIES) {
    const global float4 *z = (const global float4 *)x;
    const float16 sign = (float16)(-1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1);
    float16 straight_u = 0;
    float16 crossed_u = 0;
    float16 straight_v = 0;
    float16 crossed_v = 0;
    for (uint k = from; k < to; k++) {
        const uint8 word = turned_columns(column, k, least, storage);
        const uint8 c = COLUMN(word);
        float4 r0 = z[c.s0], r1 = z[c.s1], r2 = z[c.s2], r3 = z[c.s3];
        float4 r4 = z[c.s4], r5 = z[c.s5], r6 = z[c.s6], r7 = z[c.s7];
        const uint4 two = word.lo | word.hi;
        if (((two.x | two.y | two.z | two.w) >> TURN_SHIFT) != 0) {
            const uint8 t = word >> TURN_SHIFT;
            r0 = turned(r0, t.s0), r1 = turned(r1, t.s1), r2 = turned(r2, t.s2), r3 = turned(r3, t.s3);
            r4 = turned(r4, t.s4), r5 = turned(r5, t.s5), r6 = turned(r6, t.s6), r7 = turned(r7, t.s7);
        }
        const float16 u = (float16)(r0.lo, r1.lo, r2.lo, r3.lo, r4.lo, r5.lo, r6.lo, r7.lo);
        const float16 v = (float16)(r0.hi, r1.hi, r2.hi, r3.hi, r4.hi, r5.hi, r6.hi, r7.hi);
        const float16 a = VALUES(vload16, 16, 2 * k);
        const float16 q = VALUES(vload16, 16, 2 * k + 1);
        straight_u += a.s0022446688aaccee * u;
        crossed_u += a.s1133557799bbddff * u.s1032547698badcfe;
        straight_v += q.s0022446688aaccee * v;
        crossed_v += q.s1133557799bbddff * v.s1032547698badcfe;
    }
    pair sum;
    sum.u = straight_u + sign * crossed_u;
    sum.v = straight_v + sign * crossed_v;
    return sum;
}

kernel void cycle_turned(MATRIX) {
    EACH_SLICE {
        pair sum;
        if (storage == (HALF | NARROW))
            sum = turned_sum(OF_ENTRIES(HALF | NARROW));
        else if (storage == HALF)
            sum = turned_sum(OF_ENTRIES(HALF));
        else
            sum = turned_sum(OF_ENTRIES(storage));
        const float8 unit = units(exponent, s);
        const float16 u = TWICE(unit) * sum.u;
        const float16 v = TWICE(unit) * sum.v;
        const float16 low = (float16)(u.s01, v.s01, u.s23, v.s23, u.s45, v.s45, u.s67, v.s67);
        const float16 high = (float16)(u.s89, v.s89, u.sab, v.sab, u.scd, v.scd, u.sef, v.sef);
        const uint at = 2 * (first + s);
        const uint next = at + 1;
        FINISH(float16, vload16, vstore16, low, at, PAIRS(vload8(at, diagonal)));
        FINISH(float16, vload16, vstore16, high, next, PAIRS(vload8(next, diagonal)));
    }
}

#else

#define SLICE 32

inline uint column_at(const global uint *column, uint at, uint least, uint storage) {
    return (storage & NARROW) ? least + ((const global ushort *)column)[at] : column[at];
}

/* With the turn in the top bits. */
inline uint turned_column(const global uint *column, uint at, uint least, uint storage) {
    if (!(storage & NARROW)) return column[at];
    const uint word = ((const global ushort *)column)[at];
    return (least + (word & 0x3fffu)) | (word >> 14) << TURN_SHIFT;
}

#define UNIT as_float((uint)exponent[local_row] << 23)

#define ROW_OF_SLICE                                                                                         \
    const uint local_row = get_global_id(0);                                                                 \
    const uint s = local_row / SLICE;                                                                            \
    const uint lane = local_row % SLICE;                                                                         \
    const uint row = SLICE * first + local_row;                                                                  \
    (void)per_item;                                                                                          \
    if (s < slices)

kernel void cycle_scalar(MATRIX) {
    ROW_OF_SLICE {
        const uint least = LEAST(s);
        float sum = 0;
        for (uint k = start[s]; k < start[s + 1]; k++)
            sum += ((storage & HALF) ? vload_half(SLICE * k + lane, (const global half *)value)
                                     : value[SLICE * k + lane]) *
                   x[column_at(column, SLICE * k + lane, least, storage)];
        sum *= UNIT;
        FINISH(float, LOAD1, STORE1, sum, row, diagonal[row]);
    }
}

inline float2 times(float2 a, float2 b) { return (float2)(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }

kernel void cycle_complex(MATRIX) {
    const global float2 *z = (const global float2 *)x;
    ROW_OF_SLICE {
        const uint least = LEAST(s);
        float2 sum = 0;
        for (uint k = start[s]; k < start[s + 1]; k++)
            sum += times(VALUES(vload2, 2, SLICE * k + lane),
                         z[column_at(column, SLICE * k + lane, least, storage)]);
        sum *= UNIT;
        FINISH(float2, vload2, vstore2, sum, row, diagonal[row]);
    }
}

kernel void cycle_turned(MATRIX) {
    const global float4 *z = (const global float4 *)x;
    ROW_OF_SLICE {
        const uint least = LEAST(s);
        float4 sum = 0;
        for (uint k = start[s]; k < start[s + 1]; k++) {
            const uint c = turned_column(column, SLICE * k + lane, least, storage);
            const float4 u = turned(z[COLUMN(c)], c >> TURN_SHIFT);
            sum.lo += times(VALUES(vload2, 2, 2 * SLICE * k + lane), u.lo);
            sum.hi += times(VALUES(vload2, 2, 2 * SLICE * k + SLICE + lane), u.hi);
        }
        sum *= UNIT;
        FINISH(float4, vload4, vstore4, sum, row, vload2(row, diagonal).xxyy);
    }
}

#endif

/* The first step from x = 0: d = x = beta D^-1 b; `width` numbers per row. Items take `per_item` rows. */
kernel void cycle_first(const global float *restrict diagonal, const global float *restrict b, global float *restrict x,
                        global float *restrict d, const uint rows, const uint width, const uint per_item,
                        const float beta) {
    const uint from = get_global_id(0) * per_item;
    const uint to = min(from + per_item, rows);
    for (uint row = from; row < to; row++) {
        if (width == 4) {
            const float4 change = beta * vload4(row, b) / vload2(row, diagonal).xxyy;
            vstore4(change, row, d);
            vstore4(change, row, x);
        } else if (width == 2) {
            const float2 change = beta / diagonal[row] * vload2(row, b);
            vstore2(change, row, d);
            vstore2(change, row, x);
        } else {
            d[row] = x[row] = beta / diagonal[row] * b[row];
        }
    }
}

/* x = A b with a dense symmetric n x n matrix; an item takes a row. */
kernel void cycle_direct(const global float *restrict matrix, const global float *restrict b,
                         global float *restrict x, const uint n) {
    const uint row = get_global_id(0);
    if (row >= n) return;
    float sum = 0;
    for (uint k = 0; k < n; k++)
        sum += matrix[k * n + row] * b[k];
    x[row] = sum;
}
