/* The multigrid cycle: products with sliced block matrices and Chebyshev steps, in float.
 *
 * Eight rows make a slice in the chunk shape, 32 in the row shape; entry k of a slice holds the k-th entries of its
 * rows side by side: columns, and scalars, complex numbers, or (turned) complex numbers for U and V, with the quarter
 * turn in the two top bits of the column. `start` counts entries of slices. Diagonals: a number per
 * row, for turned one for U and one for V.
 *
 * `storage`, a sum of: 1 numbers are halves, else floats; 2 columns have 16 bits and count from the least one of their
 * slice, which follows the starts, else 32 bits and from 0. Sums are in units of 2^(exponent - 127), a byte per row.
 *
 * Modes: 0 y = A x, 1 y += A x, 2 y = b - A x, 3 y = x + alpha (x - y) + beta D^-1 (b - A x), where y is the x of the step
 * before, 4 the same where that was 0; 2 to 4 with diagonal.
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
        const global float *restrict x, const global float *restrict b, global float *y,                     \
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
                if (mode == 4)                                                                               \
                    change += alpha * own;                                                                   \
                else if (alpha != 0)                                                                         \
                    change += alpha * (own - LOAD(at, y));                                                   \
                STORE(own + change, at, y);                                                                  \
            }                                                                                                \
        }                                                                                                    \
    } while (0)

#define LOAD1(at, p) ((p)[at])
#define STORE1(v, at, p) ((p)[at] = (v))

#if PC_CHUNK

/* Units of the rows of a slice. */
inline float8 units(const global uchar *exponent, uint s) {
    return as_float8(convert_uint8(vload8(s, exponent)) << 23);
}

#define EACH_SLICE                                                                                           \
    const uint from = get_global_id(0) * per_item;                                                           \
    const uint to = min(from + per_item, slices);                                                            \
    for (uint s = from; s < to; s++)

/* The loops over entries are made for each storage, so that nothing is asked inside. Columns are read one by one:
 * taking them out of vectors costs more. */
#define ENTRIES                                                                                              \
    const global uint *restrict column, const global float *restrict value, const global float *restrict x,  \
        const uint from, const uint to, const uint storage
#define EIGHT(V) (V)(z[c[0]], z[c[1]], z[c[2]], z[c[3]], z[c[4]], z[c[5]], z[c[6]], z[c[7]])
#define EACH_ENTRY(COLUMN)                                                                                   \
    const global COLUMN *c = (const global COLUMN *)column + 8 * (size_t)from;                               \
    for (uint k = from; k < to; k++, c += 8)
/* x from the least column of a slice of `width` numbers per row. */
#define OF_ENTRIES(width, storage)                                                                           \
    column, value, x + (width) * (size_t)LEAST(s), start[s], start[s + 1], storage
#define PICK(SUM, width)                                                                                     \
    (storage == (HALF | NARROW) ? SUM##_narrow(OF_ENTRIES(width, HALF))                                      \
     : storage == NARROW        ? SUM##_narrow(OF_ENTRIES(width, 0))                                         \
     : storage == HALF          ? SUM##_wide(OF_ENTRIES(width, HALF))                                        \
                                : SUM##_wide(OF_ENTRIES(width, 0)))

#define SCALAR_SUM(COLUMN)                                                                                   \
    const global float *z = x;                                                                               \
    float8 sum = 0;                                                                                          \
    EACH_ENTRY(COLUMN) { sum += VALUES(vload8, 8, k) * EIGHT(float8); }                                      \
    return sum

inline float8 scalar_sum_narrow(ENTRIES) { SCALAR_SUM(ushort); }
inline float8 scalar_sum_wide(ENTRIES) { SCALAR_SUM(uint); }

kernel void cycle_scalar(MATRIX) {
    EACH_SLICE {
        const uint at = first + s;
        const float8 sum = PICK(scalar_sum, 1) * units(exponent, s);
        FINISH(float8, vload8, vstore8, sum, at, vload8(at, diagonal));
    }
}

#define TWICE(v) ((v).s0011223344556677)

/* Complex products from those of their parts: re re and im im side by side, re im and im re. */
inline float16 complex_products(float16 s, float16 c) {
    const float16 sign = (float16)(-1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1);
    return (float16)(s.s0, c.s0, s.s2, c.s2, s.s4, c.s4, s.s6, c.s6, s.s8, c.s8, s.sa, c.sa, s.sc, c.sc, s.se, c.se) +
           sign * (float16)(s.s1, c.s1, s.s3, c.s3, s.s5, c.s5, s.s7, c.s7, s.s9, c.s9, s.sb, c.sb, s.sd, c.sd, s.sf,
                            c.sf);
}

#define COMPLEX_SUM(COLUMN)                                                                                  \
    const global float2 *z = (const global float2 *)x;                                                       \
    float16 straight = 0;                                                                                    \
    float16 crossed = 0;                                                                                     \
    EACH_ENTRY(COLUMN) {                                                                                     \
        const float16 a = VALUES(vload16, 16, k);                                                            \
        const float16 u = EIGHT(float16);                                                                    \
        straight += a * u;                                                                                   \
        crossed += a * u.s1032547698badcfe;                                                                  \
    }                                                                                                        \
    return complex_products(straight, crossed)

inline float16 complex_sum_narrow(ENTRIES) { COMPLEX_SUM(ushort); }
inline float16 complex_sum_wide(ENTRIES) { COMPLEX_SUM(uint); }

kernel void cycle_complex(MATRIX) {
    EACH_SLICE {
        const uint at = first + s;
        const float16 sum = TWICE(units(exponent, s)) * PICK(complex_sum, 2);
        FINISH(float16, vload16, vstore16, sum, at, TWICE(vload8(at, diagonal)));
    }
}

/* (U, V) per row to the four reals of a row. */
#define PAIRS(v) ((v).s0011223344556677)

/* Four rows each. */
typedef struct halves {
    float16 low, high;
} halves;

/* Is any of the columns of an entry of a slice turned? */
inline int some_turned_narrow(const global ushort *c) {
    const ulong2 w = as_ulong2(vload8(0, c));
    return ((w.x | w.y) & 0xc000c000c000c000ul) != 0;
}
inline int some_turned_wide(const global uint *c) {
    const ulong4 w = as_ulong4(vload8(0, c));
    return ((w.x | w.y | w.z | w.w) & 0xc0000000c0000000ul) != 0;
}

#define ROW(n) turned(z[c[n] & mask], c[n] >> bits)

#define TURNED_SUM(COLUMN, BITS, SOME)                                                                       \
    const global float4 *z = (const global float4 *)x;                                                       \
    const uint bits = BITS;                                                                                  \
    const uint mask = (1u << bits) - 1;                                                                      \
    float16 straight_low = 0;                                                                                \
    float16 crossed_low = 0;                                                                                 \
    float16 straight_high = 0;                                                                               \
    float16 crossed_high = 0;                                                                                \
    EACH_ENTRY(COLUMN) {                                                                                     \
        float16 u, v;                                                                                        \
        if (SOME(c)) {                                                                                       \
            u = (float16)(ROW(0), ROW(1), ROW(2), ROW(3));                                                   \
            v = (float16)(ROW(4), ROW(5), ROW(6), ROW(7));                                                   \
        } else {                                                                                             \
            u = (float16)(z[c[0]], z[c[1]], z[c[2]], z[c[3]]);                                               \
            v = (float16)(z[c[4]], z[c[5]], z[c[6]], z[c[7]]);                                               \
        }                                                                                                    \
        const float16 a = VALUES(vload16, 16, 2 * k);                                                        \
        const float16 b = VALUES(vload16, 16, 2 * k + 1);                                                    \
        straight_low += a * u;                                                                               \
        crossed_low += a * u.s1032547698badcfe;                                                              \
        straight_high += b * v;                                                                              \
        crossed_high += b * v.s1032547698badcfe;                                                             \
    }                                                                                                        \
    halves sum;                                                                                              \
    sum.low = complex_products(straight_low, crossed_low);                                                   \
    sum.high = complex_products(straight_high, crossed_high);                                                \
    return sum

inline halves turned_sum_narrow(ENTRIES) { TURNED_SUM(ushort, 14, some_turned_narrow); }
inline halves turned_sum_wide(ENTRIES) { TURNED_SUM(uint, 30, some_turned_wide); }

kernel void cycle_turned(MATRIX) {
    EACH_SLICE {
        const halves sum = PICK(turned_sum, 4);
        const float8 unit = units(exponent, s);
        const float16 low = unit.s0000111122223333 * sum.low;
        const float16 high = unit.s4444555566667777 * sum.high;
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
    const uint s = local_row / SLICE;                                                                        \
    const uint lane = local_row % SLICE;                                                                     \
    const uint row = SLICE * first + local_row;                                                              \
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
            const float4 v = VALUES(vload4, 4, SLICE * k + lane);
            sum.lo += times(v.lo, u.lo);
            sum.hi += times(v.hi, u.hi);
        }
        sum *= UNIT;
        FINISH(float4, vload4, vstore4, sum, row, vload2(row, diagonal).xxyy);
    }
}

#endif

/* The first step from x = 0: x = beta D^-1 b; `width` numbers per row. Items take `per_item` rows. */
kernel void cycle_first(const global float *restrict diagonal, const global float *restrict b, global float *restrict x,
                        const uint rows, const uint width, const uint per_item, const float beta) {
    const uint from = get_global_id(0) * per_item;
    const uint to = min(from + per_item, rows);
    for (uint row = from; row < to; row++) {
        if (width == 4)
            vstore4(beta * vload4(row, b) / vload2(row, diagonal).xxyy, row, x);
        else if (width == 2)
            vstore2(beta / diagonal[row] * vload2(row, b), row, x);
        else
            x[row] = beta / diagonal[row] * b[row];
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
