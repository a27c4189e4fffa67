/* Three doubles and what one does with them. */
#ifndef PC_VEC3_H
#define PC_VEC3_H

#include <math.h>
#include <stddef.h>

#define PC_PI 3.14159265358979323846

typedef struct pc_vec3 {
    double x, y, z;
} pc_vec3;

static inline pc_vec3 pc_vec3_at(const double *array, size_t i) {
    return (pc_vec3){array[3 * i], array[3 * i + 1], array[3 * i + 2]};
}
static inline void pc_vec3_put(double *array, size_t i, pc_vec3 v) {
    array[3 * i] = v.x, array[3 * i + 1] = v.y, array[3 * i + 2] = v.z;
}
static inline pc_vec3 pc_add(pc_vec3 a, pc_vec3 b) {
    return (pc_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline pc_vec3 pc_sub(pc_vec3 a, pc_vec3 b) {
    return (pc_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline pc_vec3 pc_scale(double s, pc_vec3 a) {
    return (pc_vec3){s * a.x, s * a.y, s * a.z};
}
/* a + s*b */
static inline pc_vec3 pc_madd(pc_vec3 a, double s, pc_vec3 b) {
    return (pc_vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
static inline double pc_dot(pc_vec3 a, pc_vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline pc_vec3 pc_cross(pc_vec3 a, pc_vec3 b) {
    return (pc_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline double pc_norm(pc_vec3 a) {
    return sqrt(pc_dot(a, a));
}
static inline double pc_distance(pc_vec3 a, pc_vec3 b) {
    return pc_norm(pc_sub(a, b));
}
/* The zero vector stays zero. */
static inline pc_vec3 pc_unit(pc_vec3 a) {
    double n = pc_norm(a);
    return n > 0 ? pc_scale(1 / n, a) : a;
}

#endif
