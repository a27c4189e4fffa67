/* Conjugate gradients in double: products with the layout of cycle.cl, vector passes, and sums that do not depend on
 * the number of compute units: fixed chunks (or groups) leave one partial sum each, one work-item (or group) adds them.
 *
 * scalars[]: 0 p.q, 1 r.r, 2 and 3 r.z of the present and last iteration in turn. */
#ifndef PC_CHUNK
#define PC_CHUNK 1
#endif
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

#define TURN_SHIFT 30
#define COLUMN(c) ((c) & 0x3fffffffu)
/* Slices of a chunk, and numbers of a chunk; both also in conjugate.c. */
#define CHUNK_SLICES 512
#define CHUNK 4096
#define GROUP 128

#define MATRIX                                                                                               \
    const global uint *restrict start, const global uint *restrict column, const global double *restrict value, \
        const global double *restrict diagonal, const global double *restrict x, global double *restrict y,  \
        global double *restrict partial, const uint first, const uint slices

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

/* y = A x, and the partial sums of x.y */
kernel void conjugate_scalar(MATRIX) {
    EACH_SLICE {
        const uint at = first + s;
        const double8 own = vload8(at, x);
        double8 sum = vload8(at, diagonal) * own;
        for (uint k = start[s]; k < start[s + 1]; k++) {
            const uint8 c = vload8(k, column);
            sum += vload8(k, value) *
                   (double8)(x[c.s0], x[c.s1], x[c.s2], x[c.s3], x[c.s4], x[c.s5], x[c.s6], x[c.s7]);
        }
        vstore8(sum, at, y);
        dot_sum += total8(sum * own);
    }
    LEAVE_PARTIAL;
}

kernel void conjugate_complex(MATRIX) {
    const global double2 *z = (const global double2 *)x;
    const double8 sign = (double8)(-1, 1, -1, 1, -1, 1, -1, 1);
    EACH_SLICE {
        const uint at = 2 * (first + s);
        const double8 g = vload8(first + s, diagonal);
        double8 low = 0;
        double8 high = 0;
        double8 low_crossed = 0;
        double8 high_crossed = 0;
        for (uint k = start[s]; k < start[s + 1]; k++) {
            const uint8 c = vload8(k, column);
            const double8 a = vload8(2 * k, value);
            const double8 b = vload8(2 * k + 1, value);
            const double8 u = (double8)(z[c.s0], z[c.s1], z[c.s2], z[c.s3]);
            const double8 v = (double8)(z[c.s4], z[c.s5], z[c.s6], z[c.s7]);
            low += a.s00224466 * u;
            low_crossed += a.s11335577 * u.s10325476;
            high += b.s00224466 * v;
            high_crossed += b.s11335577 * v.s10325476;
        }
        const double8 own_low = vload8(at, x);
        const double8 own_high = vload8(at + 1, x);
        low += sign * low_crossed + g.s00112233 * own_low;
        high += sign * high_crossed + g.s44556677 * own_high;
        vstore8(low, at, y);
        vstore8(high, at + 1, y);
        dot_sum += total8(low * own_low + high * own_high);
    }
    LEAVE_PARTIAL;
}

kernel void conjugate_turned(MATRIX) {
    const global double4 *z = (const global double4 *)x;
    EACH_SLICE {
        for (uint side = 0; side < 2; side++) {
            /* Four rows at a time: more would not fit the registers. */
            double8 u_sum = 0;
            double8 u_crossed = 0;
            double8 v_sum = 0;
            double8 v_crossed = 0;
            for (uint k = start[s]; k < start[s + 1]; k++) {
                const uint4 word = vload4(2 * k + side, column);
                const uint4 c = COLUMN(word);
                double4 r0 = z[c.s0], r1 = z[c.s1], r2 = z[c.s2], r3 = z[c.s3];
                if (((word.x | word.y | word.z | word.w) >> TURN_SHIFT) != 0) {
                    const uint4 t = word >> TURN_SHIFT;
                    r0 = turned(r0, t.s0), r1 = turned(r1, t.s1), r2 = turned(r2, t.s2), r3 = turned(r3, t.s3);
                }
                const double8 a = vload8(4 * k + side, value);
                const double8 b = vload8(4 * k + 2 + side, value);
                const double8 u = (double8)(r0.lo, r1.lo, r2.lo, r3.lo);
                const double8 v = (double8)(r0.hi, r1.hi, r2.hi, r3.hi);
                u_sum += a.s00224466 * u;
                u_crossed += a.s11335577 * u.s10325476;
                v_sum += b.s00224466 * v;
                v_crossed += b.s11335577 * v.s10325476;
            }
            const double8 sign = (double8)(-1, 1, -1, 1, -1, 1, -1, 1);
            u_sum += sign * u_crossed;
            v_sum += sign * v_crossed;
            const uint at = 2 * (first + s) + side;
            const double4 g = vload4(at, diagonal);
            const double16 own = vload16(at, x);
            const double16 sum = (double16)(u_sum.s01, v_sum.s01, u_sum.s23, v_sum.s23, u_sum.s45, v_sum.s45,
                                            u_sum.s67, v_sum.s67) +
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

kernel void conjugate_scalar(MATRIX) {
    ROW_OF_SLICE {
        double sum = diagonal[row] * x[row];
        for (uint k = start[s]; k < start[s + 1]; k++)
            sum += value[SLICE * k + lane] * x[column[SLICE * k + lane]];
        y[row] = sum;
        dot_sum = sum * x[row];
    }
    LEAVE_PARTIAL;
}

inline double2 times(double2 a, double2 b) { return (double2)(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }

kernel void conjugate_complex(MATRIX) {
    const global double2 *z = (const global double2 *)x;
    ROW_OF_SLICE {
        double2 sum = diagonal[row] * z[row];
        for (uint k = start[s]; k < start[s + 1]; k++)
            sum += times(vload2(SLICE * k + lane, value), z[column[SLICE * k + lane]]);
        vstore2(sum, row, y);
        dot_sum = sum.x * z[row].x + sum.y * z[row].y;
    }
    LEAVE_PARTIAL;
}

kernel void conjugate_turned(MATRIX) {
    const global double4 *z = (const global double4 *)x;
    ROW_OF_SLICE {
        double4 sum = diagonal[row] * z[row];
        for (uint k = start[s]; k < start[s + 1]; k++) {
            const uint c = column[SLICE * k + lane];
            const double4 u = turned(z[COLUMN(c)], c >> TURN_SHIFT);
            sum.lo += times(vload2(2 * SLICE * k + lane, value), u.lo);
            sum.hi += times(vload2(2 * SLICE * k + SLICE + lane, value), u.hi);
        }
        vstore4(sum, row, y);
        dot_sum = total4(sum * z[row]);
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

/* r = b - q; the cycle's right-hand side = scale r; sums of r.r */
kernel void conjugate_begin(global double *restrict r, global float *restrict narrow, const global double *restrict b,
                            const global double *restrict q, global double *restrict partial, const uint n,
                            const double scale) {
    EACH_PART {
        const part v = LOAD(i, b) - LOAD(i, q);
        STORE(v, i, r);
        STORE(FLOAT(scale * v), i, narrow);
        sum += v * v;
    }
    LEAVE_SUM;
}

/* x += a p, r -= a q with a = r.z / p.q; the cycle's right-hand side = scale r; sums of r.r */
kernel void conjugate_step(global double *restrict x, global double *restrict r, global float *restrict narrow,
                           const global double *restrict p, const global double *restrict q,
                           global double *restrict partial, const global double *restrict scalars, const uint n,
                           const uint slot, const double scale) {
    const double a = scalars[slot] / scalars[0];
    EACH_PART {
        const part v = LOAD(i, r) - a * LOAD(i, q);
        STORE(LOAD(i, x) + a * LOAD(i, p), i, x);
        STORE(v, i, r);
        STORE(FLOAT(scale * v), i, narrow);
        sum += v * v;
    }
    LEAVE_SUM;
}

/* Sums of r.z, z = scale * (what the cycle found). */
kernel void conjugate_angle(const global double *restrict r, const global float *restrict z,
                            global double *restrict partial, const uint n, const double scale) {
    EACH_PART { sum += LOAD(i, r) * (scale * DOUBLE(LOAD(i, z))); }
    LEAVE_SUM;
}

/* p = z + (r.z new / r.z old) p; p = z at the start. */
kernel void conjugate_direction(global double *restrict p, const global float *restrict z,
                                const global double *restrict scalars, const uint n, const uint slot,
                                const uint at_start, const double scale) {
    const double b = at_start ? 0 : scalars[slot] / scalars[5 - slot];
    EACH_PART {
        const part v = scale * DOUBLE(LOAD(i, z));
        STORE(at_start ? v : v + b * LOAD(i, p), i, p);
    }
    LEAVE_NONE;
}
