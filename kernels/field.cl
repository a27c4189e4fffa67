/* The smoothing system of the direction field; the plain-C reference is host/field/assembly.c. */

/* Off-diagonal entries -w exp(-+ i turn): 2 per entry. turn is N times the transport of a half-edge, in [-pi, pi]; the
 * sign is the sense of the spoke, whose half-edge leaves the row's vertex or comes in. Opposite entries come out as exact
 * conjugates: both take the turn of half-edges that are exact negatives. A work-item does `chunk` rows. */
__kernel void field_assemble(__global float *value, __global const uint *start, __global const uint *half_edge,
                             __global const uint *tail, __global const uint *edge, __global const float *weight,
                             __global const float *turn, float smoothness, uint chunk, uint count) {
    uint begin = (uint)get_global_id(0) * chunk, end = min(begin + chunk, count);
    for (uint v = begin; v < end; v++)
        for (uint k = start[v]; k < start[v + 1]; k++) {
            uint h = half_edge[k];
            float w = smoothness * weight[edge[h]], re, im = sincos(fabs(turn[h]), &re);
            if ((turn[h] < 0) != (tail[h] != v)) im = -im;
            vstore2((float2)(-w * re, w * im), k, value);
        }
}
