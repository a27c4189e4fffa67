/* Curvature tensors by averaged normal cycles; the plain-C reference is host/field/normalcycle.c.
 * Positions come as two floats each, high and low part, so that edge vectors are as good as those of doubles: on a scan
 * of a million vertices single floats would drown the dihedral angles. A work-item does `chunk` rows. */

enum { AREA = 6, ROUGH = 7, NORMAL = 8, REACH = 11, LUMP = 12, RESULT = 16 };

static float3 edge_between(__global const float *high, __global const float *low, uint i, uint j) {
    return (vload3(j, high) - vload3(i, high)) + (vload3(j, low) - vload3(i, low));
}

static uint next_half(uint h) { return h % 3 == 2 ? h - 2 : h + 1; }
static uint prev_half(uint h) { return h % 3 == 0 ? h + 2 : h - 1; }

/* Twice the area times the normal of the face of h. */
static float3 face_normal(__global const uint *triangle, __global const float *high, __global const float *low, uint h) {
    uint i = triangle[h], j = triangle[next_half(h)], k = triangle[prev_half(h)];
    return cross(edge_between(high, low, i, j), edge_between(high, low, i, k));
}

static float3 unit(float3 v) {
    float n = sqrt(dot(v, v));
    return n > 0 ? v / n : v;
}

/* bend[e] = dihedral angle times length, 0 on a boundary. Scale makes the mean edge 1, against underflow. */
__kernel void curvature_bend(__global float *bend, __global const uint *edge_half, __global const uint *twin,
                             __global const uint *triangle, __global const float *high, __global const float *low,
                             uint chunk, uint count) {
    uint begin = (uint)get_global_id(0) * chunk, end = min(begin + chunk, count);
    for (uint e = begin; e < end; e++) {
        uint h = edge_half[e], t = twin[h];
        float value = 0;
        if (t != UINT_MAX) {
            float3 along = edge_between(high, low, triangle[h], triangle[next_half(h)]);
            float3 n = unit(face_normal(triangle, high, low, h)), m = unit(face_normal(triangle, high, low, t));
            float length2 = dot(along, along), size = sqrt(length2);
            if (size > 0) value = atan2(dot(cross(n, m), along) / size, dot(n, m)) * size;
        }
        bend[e] = value;
    }
}

static float walk_weight(float3 e, float step2) {
    float d2 = dot(e, e);
    return d2 > step2 ? step2 / d2 : 1;
}

/* Half of each edge's term, a third of each triangle: 12 numbers per vertex,
 * the last is 1 + the sum of the weights of its edges. */
__kernel void curvature_gather(__global float *lump, __global const float *bend, __global const uint *edge,
                               __global const uint *triangle, __global const float *high, __global const float *low,
                               __global const uint *start, __global const uint *vertex, __global const uint *half_edge,
                               float step2, uint chunk, uint count) {
    uint begin = (uint)get_global_id(0) * chunk, end = min(begin + chunk, count);
    for (uint v = begin; v < end; v++) {
        float3 row0 = 0, row1 = 0, normal = 0; /* xx xy xz | yy yz zz */
        float area = 0, rough = 0, reach = 1;
        for (uint k = start[v]; k < start[v + 1]; k++) {
            uint h = half_edge[k];
            float3 e = edge_between(high, low, v, vertex[k]), u = unit(e);
            float b = 0.5f * bend[edge[h]];
            row0 += b * u.x * u;
            row1 += b * (float3)(u.y * u.y, u.y * u.z, u.z * u.z);
            rough += fabs(b);
            reach += walk_weight(e, step2);
            if (triangle[h] == v) {
                float3 n = face_normal(triangle, high, low, h) / 6;
                normal += n;
                area += sqrt(dot(n, n));
            }
        }
        vstore4((float4)(row0, row1.x), 0, lump + LUMP * (size_t)v);
        vstore4((float4)(row1.yz, area, rough), 1, lump + LUMP * (size_t)v);
        vstore4((float4)(normal, reach), 2, lump + LUMP * (size_t)v);
    }
}

/* One pass of a walk with symmetric weights, edges longer than the step counting less. */
__kernel void curvature_average(__global float *out, __global const float *in, __global const float *high,
                                __global const float *low, __global const uint *start, __global const uint *vertex,
                                float step2, uint chunk, uint count) {
    uint begin = (uint)get_global_id(0) * chunk, end = min(begin + chunk, count);
    for (uint v = begin; v < end; v++) {
        __global const float *own = in + LUMP * (size_t)v;
        float8 sum = 0;
        float4 normal = 0;
        float total = 0;
        for (uint k = start[v]; k < start[v + 1]; k++) {
            uint j = vertex[k];
            __global const float *other = in + LUMP * (size_t)j;
            float w = walk_weight(edge_between(high, low, v, j), step2) / max(own[REACH], other[REACH]);
            sum += w * vload8(0, other);
            normal += w * vload4(2, other);
            total += w;
        }
        normal += (1 - total) * vload4(2, own);
        normal.w = own[REACH];
        vstore8(sum + (1 - total) * vload8(0, own), 0, out + LUMP * (size_t)v);
        vstore4(normal, 2, out + LUMP * (size_t)v);
    }
}

static float bilinear(const float t[6], float3 u, float3 v) {
    float3 tv = (float3)(t[0] * v.x + t[1] * v.y + t[2] * v.z, t[1] * v.x + t[3] * v.y + t[4] * v.z,
                         t[2] * v.x + t[4] * v.y + t[5] * v.z);
    return dot(u, tv);
}

static float trust(float k1, float k2, float rough, float flat, float noise) {
    float sum = fabs(k1) + fabs(k2), apart = k1 - k2;
    if (!(apart > 0)) return 0;
    float ratio = rough > 0 ? apart / (rough * noise) : 0;
    return min(1.0f, apart / (sum + flat) * (ratio * ratio / (ratio * ratio + 4)));
}

/* 16 per vertex: tensor 6, normal 3, k1, k2, direction 3, weight, unused. Written where the new weight is more
 * than prefer times the old; prefer 0 writes all. */
__kernel void curvature_principal(__global float *result, __global const float *lump, float flat, float noise,
                                  float prefer, uint chunk, uint count) {
    uint begin = (uint)get_global_id(0) * chunk, end = min(begin + chunk, count);
    for (uint v = begin; v < end; v++) {
        __global const float *own = lump + LUMP * (size_t)v;
        __global float *to = result + RESULT * (size_t)v;
        float t[6], area = own[AREA] > 0 ? own[AREA] : 1;
        for (int k = 0; k < 6; k++)
            t[k] = own[k] / area;
        float3 n = unit((float3)(own[NORMAL], own[NORMAL + 1], own[NORMAL + 2]));
        if (!(dot(n, n) > 0.5f)) n = (float3)(0, 0, 1);
        float3 axis = fabs(n.x) < 0.6f ? (float3)(1, 0, 0) : (float3)(0, 1, 0);
        float3 b1 = unit(cross(axis, n)), b2 = cross(n, b1);
        float a = bilinear(t, b1, b1), b = bilinear(t, b1, b2), d = bilinear(t, b2, b2);
        float mean = 0.5f * (a + d), apart = hypot(0.5f * (a - d), b);
        float angle = 0.5f * atan2(2 * b, a - d) + M_PI_2_F; /* k1 lies across its eigenvector */
        float3 along = cos(angle) * b1 + sin(angle) * b2;
        float weight = trust(mean + apart, mean - apart, own[ROUGH] / area, flat, noise);
        if (prefer > 0 && !(weight > prefer * to[14])) continue;
        for (int k = 0; k < 6; k++)
            to[k] = t[k];
        vstore3(n, 2, to);
        to[9] = mean + apart;
        to[10] = mean - apart;
        to[11] = along.x;
        to[12] = along.y;
        to[13] = along.z;
        to[14] = weight;
        to[15] = 0;
    }
}
