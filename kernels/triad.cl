/* a = b + s c over `count` vectors of 8 doubles, `per_item` of them per work-item: the bandwidth of the moment. */
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

kernel void triad(global double *restrict a, const global double *restrict b, const global double *restrict c,
                  const uint count, const uint per_item, const double s) {
    const uint from = get_global_id(0) * per_item;
    const uint to = min(from + per_item, count);
    for (uint i = from; i < to; i++)
        vstore8(vload8(i, b) + s * vload8(i, c), i, a);
}
