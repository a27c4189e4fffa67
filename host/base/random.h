/* A small seeded generator (splitmix64) for tests, synthetic scans and tie breaking; the same on every
 * machine. */
#ifndef PC_RANDOM_H
#define PC_RANDOM_H

#include <stdint.h>

typedef struct pc_random {
    uint64_t state;
} pc_random;

static inline uint64_t pc_hash64(uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

static inline uint64_t pc_random_next(pc_random *random) {
    uint64_t value = pc_hash64(random->state);
    random->state += 0x9e3779b97f4a7c15u;
    return value;
}

/* Uniform in [0,1). */
static inline double pc_random_uniform(pc_random *random) {
    return (double)(pc_random_next(random) >> 11) * 0x1p-53;
}

#endif
