#include "tessellation.h"
#include "memory.h"

enum { MOST_CELLS = 64, MOST_VERTICES = 5000000 };

/* The largest length of the control polygons along each direction: no curve of the element is longer. */
static void element_lengths(double length[2], const double *bezier) {
    length[0] = length[1] = 0;
    for (size_t line = 0; line < 4; line++) {
        double sum[2] = {0, 0};
        for (size_t k = 0; k < 3; k++) {
            sum[0] += pc_distance(pc_vec3_at(bezier, 4 * line + k), pc_vec3_at(bezier, 4 * line + k + 1));
            sum[1] += pc_distance(pc_vec3_at(bezier, line + 4 * k), pc_vec3_at(bezier, line + 4 * k + 4));
        }
        for (int d = 0; d < 2; d++)
            length[d] = fmax(length[d], sum[d]);
    }
}

static uint8_t cell_count(double length, double spacing) {
    double cells = ceil(length / spacing);
    return cells >= MOST_CELLS ? MOST_CELLS : cells > 1 ? (uint8_t)cells : 1;
}

/* Fills start and cells; returns how many vertices there will be. */
static size_t plan(pc_tessellation *t, const pc_tspline *spline, double spacing) {
    size_t vertices = 0, faces = 0;
    for (pc_index e = 0; e < spline->basis.element_count; e++) {
        double length[2];
        element_lengths(length, spline->bezier + 48 * (size_t)e);
        for (int d = 0; d < 2; d++)
            t->cells[e][d] = cell_count(length[d], spacing);
        t->start[e] = (pc_index)vertices;
        vertices += (size_t)(t->cells[e][0] + 1) * (size_t)(t->cells[e][1] + 1);
        faces += 2 * (size_t)t->cells[e][0] * t->cells[e][1];
    }
    t->start[spline->basis.element_count] = (pc_index)vertices;
    t->vertex_count = (pc_index)vertices, t->face_count = (pc_index)faces;
    return vertices;
}

/* The parameter of line i of n over 0..1, the outer ones `rim` beyond. */
static double grid_line(int i, int n, double rim) {
    return i == 0 ? -rim : i == n ? 1 + rim : (double)i / n;
}

static void put_vertices(pc_tessellation *t, const pc_tspline *spline, pc_index e, double spacing) {
    const pc_element *element = spline->basis.element + e;
    const uint8_t *cells = t->cells[e];
    double length[2], rim[2], size[2];
    size_t at = t->start[e];
    element_lengths(length, spline->bezier + 48 * (size_t)e);
    for (int d = 0; d < 2; d++) {
        size[d] = element->high[d] - element->low[d];
        rim[d] = length[d] > 0 ? fmin(0.05, 0.1 * spacing / length[d]) : 0;
    }
    for (int j = 0; j <= cells[1]; j++)
        for (int i = 0; i <= cells[0]; i++, at++) {
            double u = grid_line(i, cells[0], rim[0]), v = grid_line(j, cells[1], rim[1]);
            pc_surface_place place = {e, element->low[0] + u * size[0], element->low[1] + v * size[1]};
            pc_surface_point x = pc_tspline_evaluate(spline, place);
            pc_vec3 n = pc_unit(pc_cross(x.s, x.t));
            pc_vec3_put(t->position, at, x.p);
            float *normal = t->normal + 3 * at;
            normal[0] = (float)n.x, normal[1] = (float)n.y, normal[2] = (float)n.z;
        }
}

static pc_index *put_triangles(pc_index *corner, const pc_tessellation *t, pc_index e) {
    const pc_index row = (pc_index)t->cells[e][0] + 1;
    for (pc_index j = 0; j < t->cells[e][1]; j++)
        for (pc_index i = 0; i + 1 < row; i++) {
            pc_index at = t->start[e] + j * row + i;
            const pc_index square[6] = {at, at + 1, at + row, at + row + 1, at + row, at + 1};
            for (int k = 0; k < 6; k++)
                *corner++ = square[k];
        }
    return corner;
}

pc_status pc_tessellation_make(pc_tessellation *t, pc_context *ctx, const pc_tspline *spline,
                               double spacing) {
    pc_status status = PC_OK;
    const pc_index elements = spline->basis.element_count;
    *t = (pc_tessellation){0};
    PC_TRY(pc_new(&t->start, ctx, (size_t)elements + 1));
    PC_TRY(pc_new(&t->cells, ctx, elements));
    if (!(spacing > 0)) spacing = INFINITY;
    for (size_t n = plan(t, spline, spacing); n > MOST_VERTICES && n > 4 * (size_t)elements;
         n = plan(t, spline, spacing))
        spacing *= 1.25;
    PC_TRY(pc_new(&t->position, ctx, 3 * (size_t)t->vertex_count));
    PC_TRY(pc_new(&t->normal, ctx, 3 * (size_t)t->vertex_count));
    PC_TRY(pc_new(&t->triangle, ctx, 3 * (size_t)t->face_count));
#pragma omp parallel for schedule(dynamic, 64)
    for (pc_index e = 0; e < elements; e++)
        put_vertices(t, spline, e, spacing);
    pc_index *corner = t->triangle;
    for (pc_index e = 0; e < elements; e++)
        corner = put_triangles(corner, t, e);
done:
    if (status != PC_OK) pc_tessellation_free(t, ctx);
    return status;
}

void pc_tessellation_free(pc_tessellation *t, pc_context *ctx) {
    pc_free(ctx, t->position);
    pc_free(ctx, t->normal);
    pc_free(ctx, t->triangle);
    pc_free(ctx, t->start);
    pc_free(ctx, t->cells);
    *t = (pc_tessellation){0};
}
