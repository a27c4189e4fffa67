#include "differential.h"

pc_vec3 pc_surface_normal(const pc_surface_point *at) {
    return pc_unit(pc_cross(at->s, at->t));
}

bool pc_surface_curvatures(double k[2], const pc_surface_point *at) {
    pc_vec3 n = pc_surface_normal(at), x = pc_unit(at->s), y = pc_cross(n, x);
    double along = pc_norm(at->s), shear = pc_dot(at->t, x), height = pc_dot(at->t, y);
    k[0] = k[1] = 0;
    if (!(along > 0 && height > 0)) return false;
    /* With x = s/along and y = (t - shear x)/height: the form (ss, st, tt).n in these. */
    double ss = pc_dot(at->ss, n), st = pc_dot(at->st, n), tt = pc_dot(at->tt, n);
    double slope = shear / along;
    double a = ss / (along * along), b = (st - slope * ss) / (along * height);
    double c = (tt - 2 * slope * st + slope * slope * ss) / (height * height);
    double mean = -(a + c) / 2, radius = hypot((a - c) / 2, b);
    k[0] = mean + radius, k[1] = mean - radius;
    return true;
}
