#include "continuity.h"
#include <string.h>

/* An element at an extraordinary corner of its face. */
static bool is_closing(const pc_tspline *spline, pc_index e, bool corner[4]) {
    const pc_element *element = spline->basis.element + e;
    bool any = false;
    memset(corner, 0, 4 * sizeof *corner);
    if (!element->irregular) return false;
    pc_index h = spline->mesh.face[element->face].first;
    for (int k = 0; k < 4; k++, h = spline->mesh.half[h].next) {
        double at[2];
        pc_thalf_place(at, &spline->mesh, h);
        double s = k == 1 || k == 2 ? element->high[0] : element->low[0];
        double t = k >= 2 ? element->high[1] : element->low[1];
        corner[k] = spline->mesh.vertex[spline->mesh.half[h].tail].extraordinary && at[0] == s && at[1] == t;
        any = any || corner[k];
    }
    return any;
}

static pc_joint class_of(const pc_tspline *spline, pc_index e, pc_index other, int side) {
    bool own[4], others[4];
    bool closing = is_closing(spline, e, own) || is_closing(spline, other, others);
    (void)is_closing(spline, e, own);
    if (own[side] || own[(side + 1) & 3]) return PC_JOINT_SPOKE;
    if (closing) return PC_JOINT_CLOSING;
    return spline->basis.element[e].irregular || spline->basis.element[other].irregular ? PC_JOINT_MIXED
                                                                                        : PC_JOINT_REGULAR;
}

/* Normal curvature in the direction d of the tangent plane. */
static double curvature_along(const pc_surface_point *p, pc_vec3 d) {
    pc_vec3 n = pc_unit(pc_cross(p->s, p->t));
    double e = pc_dot(p->s, p->s), f = pc_dot(p->s, p->t), g = pc_dot(p->t, p->t);
    double det = e * g - f * f, ds = pc_dot(d, p->s), dt = pc_dot(d, p->t);
    double a = (g * ds - f * dt) / det, b = (e * dt - f * ds) / det; /* d = a S_s + b S_t */
    double second = a * a * pc_dot(p->ss, n) + 2 * a * b * pc_dot(p->st, n) + b * b * pc_dot(p->tt, n);
    double first = a * a * e + 2 * a * b * f + b * b * g;
    return first > 0 ? second / first : 0;
}

static void add_sample(pc_jump *jump, const pc_surface_point *a, const pc_surface_point *b, pc_vec3 along,
                       double size) {
    pc_vec3 n = pc_unit(pc_cross(a->s, a->t)), m = pc_unit(pc_cross(b->s, b->t));
    double angle = atan2(pc_norm(pc_cross(n, m)), pc_dot(n, m));
    pc_vec3 out = pc_cross(along, pc_unit(pc_add(n, m)));
    double bend = fabs(curvature_along(a, out) - curvature_along(b, out)) * size;
    jump->sample_count++;
    jump->gap = fmax(jump->gap, pc_distance(a->p, b->p));
    jump->normal_mean += angle;
    jump->normal_max = fmax(jump->normal_max, angle);
    jump->curvature_mean += bend;
    jump->curvature_max = fmax(jump->curvature_max, bend);
}

/* The four sides of an element. */
static void measure_element(pc_jump jump[PC_JOINT_COUNT], const pc_tspline *spline, pc_index element,
                            int samples) {
    const pc_element *e = spline->basis.element + element;
    for (int i = 0; i < 4 * samples; i++) {
        const int side = i / samples, across = side % 2 == 0;
        double at[2], u = (i % samples + 0.5) / samples;
        at[1 - across] = e->low[1 - across] + u * (e->high[1 - across] - e->low[1 - across]);
        at[across] = side == 1 || side == 2 ? e->high[across] : e->low[across];
        pc_surface_place here = {element, at[0], at[1]}, beyond;
        if (!pc_tspline_cross(&beyond, spline, here, side)) continue;
        pc_surface_point a = pc_tspline_evaluate(spline, here), b = pc_tspline_evaluate(spline, beyond);
        double size = (e->high[across] - e->low[across]) * pc_norm(across ? a.t : a.s);
        add_sample(jump + class_of(spline, element, beyond.element, side), &a, &b,
                   pc_unit(across ? a.s : a.t), size);
    }
}

static void add_jump(pc_jump *to, const pc_jump *part) {
    to->sample_count += part->sample_count;
    to->gap = fmax(to->gap, part->gap);
    to->normal_mean += part->normal_mean;
    to->normal_max = fmax(to->normal_max, part->normal_max);
    to->curvature_mean += part->curvature_mean;
    to->curvature_max = fmax(to->curvature_max, part->curvature_max);
}

void pc_continuity_measure(pc_jump jump[PC_JOINT_COUNT], const pc_tspline *spline, int samples) {
    enum { PARTS = 64 }; /* summed up in order, whatever the number of threads */
    const uint64_t count = spline->basis.element_count;
    pc_jump part[PARTS][PC_JOINT_COUNT];
    memset(part, 0, sizeof part);
    memset(jump, 0, PC_JOINT_COUNT * sizeof *jump);
#pragma omp parallel for schedule(dynamic, 1)
    for (int p = 0; p < PARTS; p++)
        for (uint64_t e = count * (uint64_t)p / PARTS; e < count * (uint64_t)(p + 1) / PARTS; e++)
            measure_element(part[p], spline, (pc_index)e, samples);
    for (int p = 0; p < PARTS; p++)
        for (int c = 0; c < PC_JOINT_COUNT; c++)
            add_jump(jump + c, part[p] + c);
    for (int c = 0; c < PC_JOINT_COUNT; c++) {
        if (!jump[c].sample_count) continue;
        jump[c].normal_mean /= jump[c].sample_count;
        jump[c].curvature_mean /= jump[c].sample_count;
    }
}

const char *pc_joint_name(pc_joint joint) {
    static const char *const name[PC_JOINT_COUNT] = {"regular", "mixed", "closing", "spoke"};
    return name[joint];
}
