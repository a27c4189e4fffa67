#include "measure.h"
#include "cubic.h"
#include "memory.h"

enum { POINTS = 8 };

/* Gauss and Legendre's rule on 0..1: cubic Bernstein polynomials and their derivatives at its points. */
typedef struct rule {
    double weight[POINTS];
    double value[POINTS][4], slope[POINTS][4];
} rule;

static void make_rule(rule *r) {
    static const double place[POINTS / 2] = {0.18343464249564980494, 0.52553240991632898582,
                                             0.79666647741362673959, 0.96028985649753623168};
    static const double weight[POINTS / 2] = {0.36268378337836198297, 0.31370664587788728734,
                                              0.22238103445337447054, 0.10122853629037625915};
    double curvature[4];
    for (int i = 0; i < POINTS; i++) {
        int k = i / 2;
        r->weight[i] = weight[k] / 2;
        pc_bernstein(r->value[i], r->slope[i], curvature, (1 + (i % 2 ? place[k] : -place[k])) / 2);
    }
}

static pc_vec3 combined(const double *bezier, const double s[4], const double t[4]) {
    pc_vec3 p = {0, 0, 0};
    for (size_t j = 0; j < 4; j++)
        for (size_t i = 0; i < 4; i++)
            p = pc_madd(p, s[i] * t[j], pc_vec3_at(bezier, i + 4 * j));
    return p;
}

/* Area of one element, and the volume of the cone from `centre` over it. The size of its parameters cancels.
 */
static void measure_element(double *area, double *volume, const double *bezier, pc_vec3 centre,
                            const rule *r) {
    *area = *volume = 0;
    for (int j = 0; j < POINTS; j++)
        for (int i = 0; i < POINTS; i++) {
            double w = r->weight[i] * r->weight[j];
            pc_vec3 p = combined(bezier, r->value[i], r->value[j]);
            pc_vec3 n = pc_cross(combined(bezier, r->slope[i], r->value[j]),
                                 combined(bezier, r->value[i], r->slope[j]));
            *area += w * pc_norm(n);
            *volume += w * pc_dot(pc_sub(p, centre), n) / 3;
        }
}

static bool is_closed(const pc_tmesh *mesh) {
    for (pc_index f = 0; f < mesh->face_count; f++)
        if (mesh->face[f].ghost) return false;
    return true;
}

pc_status pc_tspline_measure(pc_measure *measure, pc_context *ctx, const pc_tspline *spline) {
    pc_status status = PC_OK;
    pc_index count = spline->basis.element_count;
    double *part = NULL; /* area and volume per element */
    rule r;
    *measure = (pc_measure){.closed = is_closed(&spline->mesh)};
    make_rule(&r);
    PC_TRY(pc_new(&part, ctx, 2 * (size_t)count));
    /* Cones from far away would cancel. */
    pc_vec3 centre = count ? pc_vec3_at(spline->bezier, 0) : (pc_vec3){0, 0, 0};
#pragma omp parallel for schedule(static)
    for (pc_index e = 0; e < count; e++)
        measure_element(part + 2 * (size_t)e, part + 2 * (size_t)e + 1, spline->bezier + 48 * (size_t)e,
                        centre, &r);
    for (pc_index e = 0; e < count; e++) {
        measure->area += part[2 * (size_t)e];
        if (measure->closed) measure->volume += part[2 * (size_t)e + 1];
    }
done:
    pc_free(ctx, part);
    return status;
}
