#include "distortion.h"
#include "deviation.h"
#include "memory.h"
#include "vec3.h"

/* Of every face; weight 0 where it has no say. */
typedef struct figures {
    double *area, *param_area;
    double *stretch2; /* square of the L2 stretch, at any scale */
    double *shear;
    double *log_sum, *log_square; /* over both singular values, base 2 */
} figures;

/* S^r with S(s,t) = (t,-s). */
static void turn(double st[2], int r) {
    for (; r > 0; r--) {
        double s = st[0];
        st[0] = st[1], st[1] = -s;
    }
}

/* The corners of face f in the frame of its first one, in periods. */
static void face_corners(double st[3][2], const pc_param *param, const pc_mesh *mesh, pc_index f) {
    pc_index out = 3 * f, in = 3 * f + 2; /* from corner 0 to corner 1, and from corner 2 to corner 0 */
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 2; i++)
            st[k][i] =
                (double)param->coordinate[2 * (size_t)mesh->triangle[3 * (size_t)f + k] + i] / PC_PERIOD;
    turn(st[1], param->turn[out] % 4);
    for (int i = 0; i < 2; i++) {
        st[1][i] += param->shift[2 * (size_t)out + i];
        st[2][i] -= param->shift[2 * (size_t)in + i];
    }
    turn(st[2], (4 - param->turn[in] % 4) % 4);
}

/* Sander, Snyder, Gortler and Hoppe, Texture mapping progressive meshes, 2001: the two partial derivatives.
 */
static void measure_face(const figures *out, const pc_mesh *mesh, const pc_param *param, pc_index f) {
    double st[3][2];
    pc_vec3 p[3];
    face_corners(st, param, mesh, f);
    for (int k = 0; k < 3; k++)
        p[k] = pc_vec3_at(mesh->position, mesh->triangle[3 * (size_t)f + k]);
    double s1 = st[1][0] - st[0][0], t1 = st[1][1] - st[0][1];
    double s2 = st[2][0] - st[0][0], t2 = st[2][1] - st[0][1], twice = s1 * t2 - s2 * t1;
    pc_vec3 e1 = pc_sub(p[1], p[0]), e2 = pc_sub(p[2], p[0]);
    double area = pc_norm(pc_cross(e1, e2)) / 2;
    if (!(twice > 0) || !(area > 0)) return;
    pc_vec3 along_s = pc_scale(1 / twice, pc_sub(pc_scale(t2, e1), pc_scale(t1, e2)));
    pc_vec3 along_t = pc_scale(1 / twice, pc_sub(pc_scale(s1, e2), pc_scale(s2, e1)));
    double a = pc_dot(along_s, along_s), b = pc_dot(along_s, along_t), c = pc_dot(along_t, along_t);
    double root = sqrt((a - c) * (a - c) + 4 * b * b), large = (a + c + root) / 2;
    double small =
        area / (twice / 2) * (area / (twice / 2)) / large; /* their product is the ratio of areas */
    out->area[f] = area;
    out->param_area[f] = twice / 2;
    out->stretch2[f] = (a + c) / 2;
    out->shear[f] = fabs(b) / sqrt(a * c);
    out->log_sum[f] = (log2(large) + log2(small)) / 2;
    out->log_square[f] = (log2(large) * log2(large) + log2(small) * log2(small)) / 4;
}

/* The normalised stretch of the faces that are stretched by no more than the limit. */
static double stretch_up_to(const figures *v, pc_index count, double limit) {
    double area = 0, param_area = 0, sum = 0;
    for (pc_index f = 0; f < count; f++) {
        if (v->stretch2[f] > limit) continue;
        area += v->area[f], param_area += v->param_area[f];
        sum += v->area[f] * v->stretch2[f];
    }
    return area > 0 ? sqrt(sum / area * (param_area / area)) : 0;
}

static void sum_up(pc_distortion *d, const figures *v, const pc_mesh *mesh, const pc_param *param) {
    pc_index kind[4] = {0}, count = mesh->face_count;
    double area = 0, shear = 0, log_sum = 0, log_square = 0;
    for (pc_index f = 0; f < count; f++) {
        kind[param->singular[f] & 3]++;
        area += v->area[f];
        shear += v->area[f] * v->shear[f];
        log_sum += v->area[f] * v->log_sum[f];
        log_square += v->area[f] * v->log_square[f];
    }
    *d = (pc_distortion){.regular_faces = kind[PC_REGULAR],
                         .dislocations = kind[PC_DISLOCATION],
                         .field_singularities = kind[PC_FIELD_SINGULARITY],
                         .flipped = kind[PC_FLIPPED]};
    if (count) d->singular_percent = 100.0 * (count - d->regular_faces) / count;
    if (!(area > 0)) return;
    d->stretch = stretch_up_to(v, count, INFINITY);
    d->stretch_core = stretch_up_to(v, count, pc_weighted_quantile(v->stretch2, v->area, count, 0.99));
    d->shear = shear / area;
    double mean = log_sum / (2 * area);
    d->length_error = sqrt(fmax(log_square / (2 * area) - mean * mean, 0));
}

pc_status pc_distortion_measure(pc_distortion *distortion, pc_context *ctx, const pc_mesh *mesh,
                                const pc_param *param) {
    pc_status status = PC_OK;
    size_t count = mesh->face_count;
    double *all = NULL;
    *distortion = (pc_distortion){0};
    if (param->face_count != mesh->face_count || param->vertex_count != mesh->vertex_count)
        return pc_fail(ctx, PC_E_BUG, "the parameterization has %u faces, the mesh %u", param->face_count,
                       mesh->face_count);
    PC_TRY(pc_new(&all, ctx, 6 * count));
    const figures v = {all, all + count, all + 2 * count, all + 3 * count, all + 4 * count, all + 5 * count};
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < mesh->face_count; f++)
        if (param->singular[f] == PC_REGULAR) measure_face(&v, mesh, param, f);
    sum_up(distortion, &v, mesh, param);
done:
    pc_free(ctx, all);
    return status;
}
