#include "squeeze.h"
#include "memory.h"
#include "transition.h"
#include "vec3.h"

enum { GRAIN = 4096, MOST_PASSES = 64 };

/* Per vertex a third of what its closed faces should have in the parameter plane; returns the mean edge. */
static double gather_asked(double *asked, const pc_param *param, const pc_mesh *mesh, const double *scale) {
    double length = 0;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        if (param->singular[f] == PC_FIELD_SINGULARITY) continue;
        pc_vec3 a = pc_vec3_at(mesh->position, t[0]), u = pc_sub(pc_vec3_at(mesh->position, t[1]), a);
        double area = pc_norm(pc_cross(u, pc_sub(pc_vec3_at(mesh->position, t[2]), a)));
        length += pc_norm(u);
        for (int k = 0; k < 3; k++) {
            double cells = (scale ? scale[t[k]] : 1) / param->period_length;
            asked[t[k]] += area * cells * cells;
        }
    }
    return length / (mesh->face_count ? mesh->face_count : 1);
}

/* ... and of what they have there; signed: folds count against. */
static void gather_given(double *given, const pc_param *param, const pc_mesh *mesh) {
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_point2 p[3];
        if (param->singular[f] == PC_FIELD_SINGULARITY) continue;
        pc_param_corners(p, param, mesh->triangle, f);
        double in_plane = (double)pc_point2_area(p[0], p[1], p[2]) / ((double)PC_PERIOD * PC_PERIOD);
        for (int k = 0; k < 3; k++)
            given[mesh->triangle[3 * (size_t)f + (size_t)k]] += in_plane;
    }
}

/* One step of spreading to neighbours: sums stay as they are. */
static void spread(double *out, const double *in, const pc_edge_rows *rows) {
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index i = 0; i < rows->row_count; i++) {
        double sum = in[i];
        for (pc_index e = rows->start[i]; e < rows->start[i + 1]; e++)
            sum += in[rows->column[e]];
        out[i] = sum / (1 + rows->start[i + 1] - rows->start[i]);
    }
}

static void spread_widely(double **values, double **other, const pc_edge_rows *rows, double rings) {
    /* k steps spread over about sqrt(k/2) edges: half a period either way. */
    int passes = (int)fmin(fmax(2 * rings * rings, 2), MOST_PASSES);
    for (int i = 0; i < passes; i++) {
        double *swap = *values;
        spread(*other, swap, rows);
        *values = *other, *other = swap;
    }
}

static void grow(uint8_t *out, const uint8_t *in, const pc_edge_rows *rows) {
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index i = 0; i < rows->row_count; i++) {
        out[i] = in[i];
        for (pc_index e = rows->start[i]; e < rows->start[i + 1] && !out[i]; e++)
            out[i] = in[rows->column[e]];
    }
}

pc_status pc_squeeze_make(pc_squeeze *squeeze, pc_context *ctx, const pc_param *param, const pc_mesh *mesh,
                          const pc_edge_rows *rows, const double *scale) {
    pc_status status = PC_OK;
    double *other = NULL;
    *squeeze = (pc_squeeze){.rows = rows, .scale = scale};
    PC_TRY(pc_new(&squeeze->asked, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&other, ctx, mesh->vertex_count));
    double mean_edge = gather_asked(squeeze->asked, param, mesh, scale);
    squeeze->rings = 0.5 * param->period_length / (mean_edge > 0 ? mean_edge : 1);
    spread_widely(&squeeze->asked, &other, rows, squeeze->rings);
done:
    pc_free(ctx, other);
    if (status != PC_OK) pc_squeeze_free(squeeze, ctx);
    return status;
}

void pc_squeeze_free(pc_squeeze *squeeze, pc_context *ctx) {
    pc_free(ctx, squeeze->asked);
    *squeeze = (pc_squeeze){0};
}

pc_status pc_squeeze_mark(uint8_t *mark, pc_index *count, pc_context *ctx, const pc_squeeze *squeeze,
                          const pc_param *param, const pc_mesh *mesh, double least) {
    pc_status status = PC_OK;
    const double *scale = squeeze->scale;
    double *given = NULL, *other = NULL;
    uint8_t *fresh = NULL, *grown = NULL;
    pc_index n = mesh->vertex_count;
    PC_TRY(pc_new(&given, ctx, n));
    PC_TRY(pc_new(&other, ctx, n));
    PC_TRY(pc_new(&fresh, ctx, n));
    PC_TRY(pc_new(&grown, ctx, n));
    gather_given(given, param, mesh);
    spread_widely(&given, &other, squeeze->rows, squeeze->rings);
    for (pc_index i = 0; i < n; i++)
        fresh[i] = given[i] < least * (scale ? fmin(fmax(scale[i], 1), 2) : 1) * squeeze->asked[i];
    for (int i = 0; i < (int)fmin(squeeze->rings, 8); i++) {
        uint8_t *swap = fresh;
        grow(grown, fresh, squeeze->rows);
        fresh = grown, grown = swap;
    }
    *count = 0;
    for (pc_index i = 0; i < n; i++)
        if (fresh[i] && !mark[i]) mark[i] = 1, ++*count;
done:
    pc_free(ctx, given);
    pc_free(ctx, other);
    pc_free(ctx, fresh);
    pc_free(ctx, grown);
    return status;
}
