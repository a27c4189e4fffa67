/* Conjugate gradients with D^-1 for three right-hand sides at once, in double; the plain-C reference is
 * host/solve/threefold.c. A row's three numbers and a 0 are one double4. Matrices lie as in cycle.cl; sums as in
 * conjugate.cl do not depend on the number of compute units: fixed chunks (or groups) leave pairs of partial sums, one
 * work-item (or group) adds them.
 *
 * scalars[]: 0 p.q, 1 r.r, 2 and 3 r.D^-1 r of the present and last iteration in turn, 4 squares of the goals. A column
 * whose r.r has reached its goal stays as it is. */
#ifndef PC_CHUNK
#define PC_CHUNK 1
#endif
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

/* Slices and rows of a chunk, and items of a group; all also in threefold_device.c. */
#define CHUNK_SLICES 64
#define CHUNK_ROWS 512
#define GROUP 128

/* a / b for columns on their way, 0 for the others. */
inline double4 ratio(double4 a, double4 b, double4 square, double4 goal) {
    return select((double4)(0), a / b, (square > goal) & (b > 0));
}

#if PC_CHUNK

kernel void threefold_product(const global uint *restrict start, const global uint *restrict column,
                              const global double *restrict value, const global double *restrict diagonal,
                              const global double4 *restrict p, global double4 *restrict q,
                              global double4 *restrict partial, const uint first, const uint slices) {
    const uint from = get_global_id(0) * CHUNK_SLICES;
    const uint to = min(from + CHUNK_SLICES, slices);
    double4 dot_sum = 0;
    for (uint s = from; s < to; s++) {
        const uint row = 8 * (first + s);
        double4 a0 = 0, a1 = 0, a2 = 0, a3 = 0, a4 = 0, a5 = 0, a6 = 0, a7 = 0;
        for (uint k = start[s]; k < start[s + 1]; k++) {
            const uint8 c = vload8(k, column);
            const double8 v = vload8(k, value);
            a0 += v.s0 * p[c.s0], a1 += v.s1 * p[c.s1], a2 += v.s2 * p[c.s2], a3 += v.s3 * p[c.s3];
            a4 += v.s4 * p[c.s4], a5 += v.s5 * p[c.s5], a6 += v.s6 * p[c.s6], a7 += v.s7 * p[c.s7];
        }
        const double4 sum[8] = {a0, a1, a2, a3, a4, a5, a6, a7};
        for (uint i = 0; i < 8; i++) {
            const double4 own = p[row + i];
            const double4 all = sum[i] + diagonal[row + i] * own;
            q[row + i] = all;
            dot_sum += all * own;
        }
    }
    partial[2 * (first / CHUNK_SLICES + get_global_id(0))] = dot_sum;
}

#define EACH_ROW                                                                                             \
    const uint from = get_global_id(0) * CHUNK_ROWS;                                                         \
    const uint to = min(from + CHUNK_ROWS, rows);                                                            \
    double4 square = 0;                                                                                      \
    double4 angle = 0;                                                                                       \
    for (uint i = from; i < to; i++)
#define LEAVE_SUMS                                                                                           \
    do {                                                                                                     \
        partial[2 * get_global_id(0)] = square;                                                              \
        partial[2 * get_global_id(0) + 1] = angle;                                                           \
    } while (0)
#define LEAVE_NONE (void)square, (void)angle

kernel void threefold_finish(const global double4 *restrict partial, global double4 *restrict scalars, const uint count,
                             const uint slot, const uint second) {
    double4 a = 0;
    double4 b = 0;
    for (uint i = 0; i < count; i++) {
        a += partial[2 * i];
        b += partial[2 * i + 1];
    }
    if (second != slot) scalars[second] = b;
    scalars[slot] = a;
}

#else

/* As in cycle.cl. */
#define SLICE 32

/* The sum over a work-group, by a tree; on its first item. */
inline double4 group_sum(double4 mine, local double4 *tree) {
    const uint lane = get_local_id(0);
    barrier(CLK_LOCAL_MEM_FENCE);
    tree[lane] = mine;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint width = GROUP / 2; width > 0; width /= 2) {
        if (lane < width) tree[lane] += tree[lane + width];
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    return tree[0];
}

kernel void threefold_product(const global uint *restrict start, const global uint *restrict column,
                              const global double *restrict value, const global double *restrict diagonal,
                              const global double4 *restrict p, global double4 *restrict q,
                              global double4 *restrict partial, const uint first, const uint slices) {
    local double4 tree[GROUP];
    const uint s = get_global_id(0) / SLICE;
    const uint lane = get_global_id(0) % SLICE;
    const uint row = SLICE * first + get_global_id(0);
    double4 dot_sum = 0;
    if (s < slices) {
        const double4 own = p[row];
        double4 sum = diagonal[row] * own;
        for (uint k = start[s]; k < start[s + 1]; k++)
            sum += value[SLICE * k + lane] * p[column[SLICE * k + lane]];
        q[row] = sum;
        dot_sum = sum * own;
    }
    const double4 of_group = group_sum(dot_sum, tree);
    if (get_local_id(0) == 0) partial[2 * (SLICE * first / GROUP + get_group_id(0))] = of_group;
}

#define EACH_ROW                                                                                             \
    local double4 tree[GROUP];                                                                               \
    const uint i = get_global_id(0);                                                                         \
    double4 square = 0;                                                                                      \
    double4 angle = 0;                                                                                       \
    if (i < rows)
#define LEAVE_SUMS                                                                                           \
    do {                                                                                                     \
        const double4 squares = group_sum(square, tree);                                                     \
        if (get_local_id(0) == 0) partial[2 * get_group_id(0)] = squares;                                    \
        const double4 angles = group_sum(angle, tree);                                                       \
        if (get_local_id(0) == 0) partial[2 * get_group_id(0) + 1] = angles;                                 \
    } while (0)
#define LEAVE_NONE (void)square, (void)angle, (void)tree

kernel void threefold_finish(const global double4 *restrict partial, global double4 *restrict scalars, const uint count,
                             const uint slot, const uint second) {
    local double4 tree[GROUP];
    double4 a = 0;
    double4 b = 0;
    for (uint i = get_local_id(0); i < count; i += GROUP) {
        a += partial[2 * i];
        b += partial[2 * i + 1];
    }
    const double4 first_sum = group_sum(a, tree);
    if (get_local_id(0) == 0) scalars[slot] = first_sum;
    const double4 second_sum = group_sum(b, tree);
    if (get_local_id(0) == 0 && second != slot) scalars[second] = second_sum;
}

#endif

/* r = b - q; sums of r.r and r.D^-1 r */
kernel void threefold_begin(global double4 *restrict r, const global double4 *restrict b,
                            const global double4 *restrict q, const global double *restrict diagonal,
                            global double4 *restrict partial, const uint rows) {
    EACH_ROW {
        const double4 v = b[i] - q[i];
        r[i] = v;
        square += v * v;
        angle += v * v * (1 / diagonal[i]);
    }
    LEAVE_SUMS;
}

/* p = D^-1 r + (r.z new / r.z old) p; p = D^-1 r at the start. */
kernel void threefold_turn(global double4 *restrict p, const global double4 *restrict r,
                           const global double *restrict diagonal, const global double4 *restrict scalars,
                           const uint rows, const uint slot, const uint at_start) {
    const double4 beta =
        at_start ? (double4)(0) : ratio(scalars[slot], scalars[5 - slot], scalars[1], scalars[4]);
    EACH_ROW { p[i] = (1 / diagonal[i]) * r[i] + beta * p[i]; }
    LEAVE_NONE;
}

/* x += alpha p, r -= alpha q with alpha = r.z / p.q; sums of r.r and r.D^-1 r */
kernel void threefold_step(global double4 *restrict x, global double4 *restrict r, const global double4 *restrict p,
                           const global double4 *restrict q, const global double *restrict diagonal,
                           global double4 *restrict partial, const global double4 *restrict scalars, const uint rows,
                           const uint slot) {
    const double4 alpha = ratio(scalars[slot], scalars[0], scalars[1], scalars[4]);
    EACH_ROW {
        const double4 v = r[i] - alpha * q[i];
        x[i] += alpha * p[i];
        r[i] = v;
        square += v * v;
        angle += v * v * (1 / diagonal[i]);
    }
    LEAVE_SUMS;
}
