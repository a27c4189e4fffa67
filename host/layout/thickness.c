#include "thickness.h"
#include "vec3.h"

/* Across the side that unit vector `n` points to. */
static double chord(const pc_ground *ground, pc_index v, pc_vec3 n, double most) {
    enum { MOST_STEPS = 12 };
    const double opposite = -0.5, empty = 0.99;
    const pc_vec3 p = pc_vec3_at(ground->scan->position, v), normal = pc_vec3_at(ground->normal, v);
    double radius = 0.5 * most, length = INFINITY;
    for (int step = 0; step < MOST_STEPS; step++) {
        const pc_vec3 centre = pc_madd(p, radius, n);
        const pc_bvh_hit hit = pc_bvh_closest(&ground->tree, centre, PC_NONE);
        if (hit.face == PC_NONE || hit.distance >= empty * radius) break;
        const pc_vec3 to = pc_sub(hit.point, p);
        const double along = pc_dot(to, n), square = pc_dot(to, to);
        if (!(along > 0) || !(square > 0)) return INFINITY;
        const bool faces_away = pc_dot(pc_unit(pc_ground_normal(ground, &hit)), normal) < opposite;
        length = faces_away ? sqrt(square) : INFINITY;
        radius = square / (2 * along);
    }
    return length;
}

double pc_thickness_at(const pc_ground *ground, pc_index v, double most) {
    const pc_vec3 n = pc_vec3_at(ground->normal, v);
    return fmin(chord(ground, v, n, most), chord(ground, v, pc_scale(-1, n), most));
}
