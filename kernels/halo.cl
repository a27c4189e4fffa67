/* Rows of a vector that other devices have copies of, gathered and laid out again; a row has `words` words of 4 bytes,
 * a work-item takes one. */

/* to[i] = from[place[i]] for `count` rows */
kernel void halo_gather(const global uint *restrict from, const global uint *restrict place, global uint *restrict to,
                        const uint count, const uint words) {
    const uint i = get_global_id(0);
    if (i / words < count) to[i] = from[place[i / words] * words + i % words];
}

/* to[place[i]] = from[i] for `count` rows */
kernel void halo_scatter(const global uint *restrict from, const global uint *restrict place, global uint *restrict to,
                         const uint count, const uint words) {
    const uint i = get_global_id(0);
    if (i / words < count) to[place[i / words] * words + i % words] = from[i];
}
