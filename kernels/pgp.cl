/* Periodic global parameterization; the plain-C references are coupling.c, pgp.c and reconstruct.c in host/param.
 * A work-item does `chunk` elements one after the other (CPUs), or one (GPUs). Phases and the system are in double; what
 * is known of an edge is in float, from positions in two floats; whole periods are found in integers. */
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

/* As in host/param/param.h and coupling.c. */
enum { PERIOD = 1 << 24, PERIOD_BITS = 24 };
#define WEIGHT_LEAST   0.05f
#define WEIGHT_MOST    20.0f
#define COTANGENT_MOST 1e12f

#define EACH(i)                                                                                              \
    const uint from = (uint)get_global_id(0) * chunk, to = min(from + chunk, count);                         \
    for (uint i = from; i < to; i++)

static float3 edge_between(const global float *high, const global float *low, uint i, uint j) {
    return (vload3(j, high) - vload3(i, high)) + (vload3(j, low) - vload3(i, low));
}

/* The cotangent of the angle between u and v. */
static float cotangent(float3 u, float3 v) {
    const float3 n = cross(u, v);
    const float area = sqrt(dot(n, n)), along = dot(u, v);
    if (area <= 1e-12f * fabs(along)) return along > 0 ? COTANGENT_MOST : -COTANGENT_MOST;
    return along / area;
}

/* Cosine and sine of the angle of e in the frame (k, n x k). */
static float2 heading(const global float *normal, const global float *direction, uint v, float3 e) {
    const float3 k = vload3(v, direction), n = vload3(v, normal);
    const float2 h = (float2)(dot(e, k), dot(e, cross(n, k)));
    const float size = sqrt(dot(h, h));
    return size > 0 ? h / size : (float2)(1, 0);
}

/* S^turn (s,t), S(s,t) = (t,-s). */
static float2 turned(float2 p, uint turn) {
    const float2 q = (turn & 1) ? (float2)(p.y, -p.x) : p;
    return (turn & 2) ? -q : q;
}

/* Advance and weight of the edges from `first` on. corner[4*e]: tail, head, and the vertices opposite on both sides
 * (UINT_MAX: none). Lengths are in periods. scale is read where scaled is 1. */
kernel void pgp_couple(global float *advance, global float *weight, const global uint *corner,
                       const global uchar *turn, const global float *high, const global float *low,
                       const global float *normal, const global float *direction, const global float *scale,
                       uint scaled, uint chunk, uint count) {
    EACH(e) {
        const uint4 c = vload4(e, corner);
        const float3 along = edge_between(high, low, c.x, c.y);
        float w = 0;
        if (c.z != UINT_MAX)
            w += cotangent(edge_between(high, low, c.z, c.x), edge_between(high, low, c.z, c.y));
        if (c.w != UINT_MAX)
            w += cotangent(edge_between(high, low, c.w, c.x), edge_between(high, low, c.w, c.y));
        weight[e] = clamp(0.5f * w, WEIGHT_LEAST, WEIGHT_MOST);
        const float2 seen = turned(heading(normal, direction, c.y, along), turn[e]);
        const float2 own = heading(normal, direction, c.x, along);
        const float half_way = 0.5f * sqrt(dot(along, along));
        const float at_tail = scaled ? half_way * scale[c.x] : half_way;
        const float at_head = scaled ? half_way * scale[c.y] : half_way;
        vstore2(at_tail * own + at_head * seen, e, advance);
    }
}

/* Rows of the system: the entries -weight exp(i 2 pi advance) with their quarter turns, and the sum of their weights.
 * origin[k] of entry k is 2*edge, +1 where the edge is seen from its head. start[] counts from the first row's first
 * entry; `origin`, `value`, `entry_turn` and `degree` begin there. */
kernel void pgp_assemble(global double *value, global uchar *entry_turn, global double *degree,
                         const global uint *start, const global uint *origin, const global float *advance,
                         const global float *weight, const global uchar *turn, uint chunk, uint count) {
    EACH(row) {
        double sum = 0;
        for (uint k = start[row]; k < start[row + 1]; k++) {
            const uint e = origin[k] >> 1, backwards = origin[k] & 1;
            const uint r = turn[e];
            const double w = weight[e];
            const float2 forth = vload2(e, advance);
            const float2 gain = backwards ? -turned(forth, 4 - r) : forth;
            const double a = 2 * M_PI * gain.x, b = 2 * M_PI * gain.y;
            vstore4((double4)(-w * cos(a), w * sin(a), -w * cos(b), w * sin(b)), k, value);
            entry_turn[k] = backwards ? (4 - r) & 3 : r;
            sum += w;
        }
        degree[row] = sum;
    }
}

/* U and V of each vertex back to norm 1. */
kernel void pgp_normalise(global double *phase, uint chunk, uint count) {
    EACH(i) {
        const double2 u = vload2(i, phase);
        const double norm = sqrt(u.x * u.x + u.y * u.y);
        vstore2(norm > 1e-30 ? u / norm : (double2)(1, 0), i, phase);
    }
}

/* Fixed-point coordinates of phases: odd, within one period. */
kernel void pgp_coordinate(global int *coordinate, const global double *phase, uint chunk, uint count) {
    EACH(i) {
        const double2 u = vload2(i, phase);
        const double periods = atan2(u.y, u.x) / (2 * M_PI);
        const double fraction = periods - floor(periods);
        coordinate[i] = ((int)(fraction * PERIOD) | 1) & (PERIOD - 1);
    }
}

/* The whole number nearest to advance - gap/PERIOD, halves away from zero. */
static int whole_periods(float advance, long gap) {
    const float scaled = ldexp(advance, PERIOD_BITS), whole = floor(scaled);
    const long steps = (long)whole - gap;
    if (steps >= 0) return (int)((steps + PERIOD / 2) >> PERIOD_BITS);
    return (int)((steps + (scaled > whole ? 1 : 0) + PERIOD / 2 - 1) >> PERIOD_BITS);
}

/* Whole periods along the edges ends[2*e] -> ends[2*e+1]. */
kernel void pgp_shift(global int *shift, const global uint *ends, const global uchar *turn,
                      const global float *advance, const global int *coordinate, uint chunk, uint count) {
    EACH(e) {
        const uint2 v = vload2(e, ends);
        const int2 p = vload2(v.x, coordinate), own = vload2(v.y, coordinate);
        const float2 gain = vload2(e, advance);
        long s = own.x, t = own.y;
        if (turn[e] & 1) {
            const long u = s;
            s = t;
            t = -u;
        }
        if (turn[e] & 2) {
            s = -s;
            t = -t;
        }
        vstore2((int2)(whole_periods(gain.x, s - p.x), whole_periods(gain.y, t - p.y)), e, shift);
    }
}
