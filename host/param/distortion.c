#include "distortion.h"
#include "memory.h"
#include "vec3.h"

enum { BLOCK = 4096 };

/* Sums over a block of faces. */
typedef struct sums {
    double area, param_area, stretch, shear, log, log2, weight;
    pc_index kind[4];
} sums;

/* S^r with S(s,t) = (t,-s). */
static void turn(double st[2], int r) {
    for (; r > 0; r--) {
        double s = st[0];
        st[0] = st[1], st[1] = -s;
    }
}

void pc_param_corners(double st[3][2], const pc_param *param, const pc_mesh *mesh, pc_index f) {
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
static void add_face(sums *sum, const pc_mesh *mesh, const pc_param *param, pc_index f) {
    double st[3][2];
    pc_vec3 p[3];
    pc_param_corners(st, param, mesh, f);
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
    double small = large > 0 ? fmax(a * c - b * b, 0) / large : 0;
    sum->area += area;
    sum->param_area += twice / 2;
    sum->stretch += area * (a + c) / 2;
    if (a > 0 && c > 0) sum->shear += area * fabs(b) / sqrt(a * c);
    if (small > 0) {
        const double logs[2] = {log2(large) / 2, log2(small) / 2};
        for (int i = 0; i < 2; i++)
            sum->log += area * logs[i], sum->log2 += area * logs[i] * logs[i], sum->weight += area;
    }
}

static void sum_block(sums *sum, const pc_mesh *mesh, const pc_param *param, size_t block) {
    pc_index first = (pc_index)(block * BLOCK);
    pc_index end = mesh->face_count - first < BLOCK ? mesh->face_count : first + BLOCK;
    for (pc_index f = first; f < end; f++) {
        int kind = param->singular[f] & 3;
        sum->kind[kind]++;
        if (kind == PC_REGULAR) add_face(sum, mesh, param, f);
    }
}

static void finish(pc_distortion *d, const sums *s, pc_index face_count) {
    *d = (pc_distortion){.regular_faces = s->kind[PC_REGULAR],
                         .dislocations = s->kind[PC_DISLOCATION],
                         .field_singularities = s->kind[PC_FIELD_SINGULARITY],
                         .flipped = s->kind[PC_FLIPPED]};
    if (face_count) d->singular_percent = 100.0 * (face_count - d->regular_faces) / face_count;
    if (!(s->area > 0)) return;
    d->stretch = sqrt(s->stretch / s->area * (s->param_area / s->area));
    d->shear = s->shear / s->area;
    double mean = s->weight > 0 ? s->log / s->weight : 0;
    d->length_error = s->weight > 0 ? sqrt(fmax(s->log2 / s->weight - mean * mean, 0)) : 0;
}

pc_status pc_distortion_measure(pc_distortion *distortion, pc_context *ctx, const pc_mesh *mesh,
                                const pc_param *param) {
    pc_status status = PC_OK;
    size_t blocks = (mesh->face_count + (size_t)BLOCK - 1) / BLOCK;
    sums *part = NULL, sum = {0};
    *distortion = (pc_distortion){0};
    if (param->face_count != mesh->face_count || param->vertex_count != mesh->vertex_count)
        return pc_fail(ctx, PC_E_BUG, "the parameterization has %u faces, the mesh %u", param->face_count,
                       mesh->face_count);
    PC_TRY(pc_new(&part, ctx, blocks));
#pragma omp parallel for schedule(static)
    for (size_t b = 0; b < blocks; b++)
        sum_block(part + b, mesh, param, b);
    for (size_t b = 0; b < blocks; b++) {
        sum.area += part[b].area, sum.param_area += part[b].param_area;
        sum.stretch += part[b].stretch, sum.shear += part[b].shear;
        sum.log += part[b].log, sum.log2 += part[b].log2, sum.weight += part[b].weight;
        for (int k = 0; k < 4; k++)
            sum.kind[k] += part[b].kind[k];
    }
    finish(distortion, &sum, mesh->face_count);
done:
    pc_free(ctx, part);
    return status;
}
