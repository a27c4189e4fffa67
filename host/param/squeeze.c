#include "squeeze.h"
#include "memory.h"
#include "transition.h"
#include "vec3.h"

enum { GRAIN = 4096, MOST_PASSES = 64 };

/* Per vertex a third of what its closed faces have in the parameter plane (signed: folds count against), and
 * of what they should have there. */
static void gather_areas(double *given, double *asked, double *mean_edge, const pc_param *param,
                         const pc_mesh *mesh, const double *scale) {
    double length = 0;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        if (param->singular[f] == PC_FIELD_SINGULARITY) continue;
        pc_point2 p[3];
        pc_param_corners(p, param, mesh->triangle, f);
        pc_vec3 a = pc_vec3_at(mesh->position, t[0]), u = pc_sub(pc_vec3_at(mesh->position, t[1]), a);
        double area = pc_norm(pc_cross(u, pc_sub(pc_vec3_at(mesh->position, t[2]), a)));
        double in_plane = (double)pc_point2_area(p[0], p[1], p[2]) / ((double)PC_PERIOD * PC_PERIOD);
        length += pc_norm(u);
        for (int k = 0; k < 3; k++) {
            double cells = (scale ? scale[t[k]] : 1) / param->period_length;
            given[t[k]] += in_plane;
            asked[t[k]] += area * cells * cells;
        }
    }
    *mean_edge = length / (mesh->face_count ? mesh->face_count : 1);
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

static void grow(uint8_t *out, const uint8_t *in, const pc_edge_rows *rows) {
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index i = 0; i < rows->row_count; i++) {
        out[i] = in[i];
        for (pc_index e = rows->start[i]; e < rows->start[i + 1] && !out[i]; e++)
            out[i] = in[rows->column[e]];
    }
}

pc_status pc_squeeze_mark(uint8_t *mark, pc_index *count, pc_context *ctx, const pc_param *param,
                          const pc_mesh *mesh, const pc_edge_rows *rows, const double *scale, double least) {
    pc_status status = PC_OK;
    double *given = NULL, *asked = NULL, *other = NULL, mean_edge;
    uint8_t *fresh = NULL, *grown = NULL;
    pc_index n = mesh->vertex_count;
    PC_TRY(pc_new(&given, ctx, n));
    PC_TRY(pc_new(&asked, ctx, n));
    PC_TRY(pc_new(&other, ctx, n));
    PC_TRY(pc_new(&fresh, ctx, n));
    PC_TRY(pc_new(&grown, ctx, n));
    gather_areas(given, asked, &mean_edge, param, mesh, scale);
    /* k steps spread over about sqrt(k/2) edges: half a period either way. */
    double rings = 0.5 * param->period_length / (mean_edge > 0 ? mean_edge : 1);
    int passes = (int)fmin(fmax(2 * rings * rings, 2), MOST_PASSES);
    for (int i = 0; i < 2 * passes; i++) {
        double **values = i % 2 ? &asked : &given, *swap = *values;
        spread(other, *values, rows);
        *values = other, other = swap;
    }
    for (pc_index i = 0; i < n; i++)
        fresh[i] = given[i] < least * (scale ? fmin(fmax(scale[i], 1), 2) : 1) * asked[i];
    for (int i = 0; i < (int)fmin(rings, 8); i++) {
        uint8_t *swap = fresh;
        grow(grown, fresh, rows);
        fresh = grown, grown = swap;
    }
    *count = 0;
    for (pc_index i = 0; i < n; i++)
        if (fresh[i] && !mark[i]) mark[i] = 1, ++*count;
done:
    pc_free(ctx, given);
    pc_free(ctx, asked);
    pc_free(ctx, other);
    pc_free(ctx, fresh);
    pc_free(ctx, grown);
    return status;
}
