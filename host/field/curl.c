#include "curl.h"
#include "connection.h"
#include "geometry.h"
#include "memory.h"
#include "ring.h"
#include "topology.h"
#include "vec3.h"
#include <stdlib.h>
#include <string.h>

typedef struct correction {
    pc_context *ctx;
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    const pc_field *field;
    pc_connection connection;
    pc_ring ring;
    pc_system system;
    double *right;
} correction;

/* The turn of the field along half-edge h as seen in its triangle, flattened. */
static double turn_in_face(const correction *c, pc_index h) {
    pc_index i = pc_tail(c->mesh, h), j = pc_head(c->mesh, h), first = h - h % 3;
    double quarter = 2 * PC_PI / c->field->symmetry, excess = -PC_PI;
    for (pc_index k = first; k < first + 3; k++)
        excess += pc_connection_corner(&c->connection, c->mesh, c->adjacency, k);
    double x = c->field->angle[j] - c->field->angle[i] - c->connection.transport[h];
    return x - quarter * nearbyint(x / quarter) + excess / 3;
}

static double face_part(const correction *c, pc_index h) {
    return c->field->index[h / 3] == 0 ? 1 : 0.1;
}

/* Both faces of an edge give it half its cotangent weight, less where singular. */
static double edge_weight(const correction *c, pc_index h) {
    pc_index twin = c->adjacency->twin[h];
    double part = face_part(c, h);
    if (twin != PC_NONE) part = 0.5 * (part + face_part(c, twin));
    return part * c->connection.weight[c->adjacency->edge[h]];
}

static void fill_row(correction *c, pc_index v, double shift) {
    double sum = 0, right = 0;
    for (pc_index k = c->ring.start[v]; k < c->ring.start[v + 1]; k++) {
        pc_index h = c->ring.half[k];
        double w = edge_weight(c, h);
        c->system.value[k] = -w;
        sum += w;
        if (pc_tail(c->mesh, h) == v && c->field->index[h / 3] == 0)
            right += 0.5 * turn_in_face(c, pc_next(h));
    }
    c->system.diagonal[v] = sum > 0 ? sum * (1 + shift) : 1;
    c->right[v] = right;
}

static pc_status assemble(correction *c) {
    pc_status status = PC_OK;
    size_t n = c->mesh->vertex_count;
    PC_TRY(pc_connection_make(&c->connection, c->ctx, c->mesh, c->adjacency));
    PC_TRY(pc_ring_make(&c->ring, c->ctx, c->mesh, c->adjacency));
    PC_TRY(pc_system_make(&c->system, c->ctx, PC_BLOCK_SCALAR, c->mesh->vertex_count, c->ring.start[n]));
    PC_TRY(pc_new(&c->right, c->ctx, n));
    memcpy(c->system.start, c->ring.start, (n + 1) * sizeof *c->ring.start);
    memcpy(c->system.column, c->ring.vertex, c->ring.start[n] * sizeof *c->ring.vertex);
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < c->mesh->vertex_count; v++)
        fill_row(c, v, 1e-3 / (double)n); /* only the constant, the kernel, feels it */
done:
    return status;
}

/* Vertices listed by component, isolated ones last: offsets in start (components+2). */
static pc_status list_components(pc_index **start, pc_index **list, pc_context *ctx, const pc_mesh *mesh,
                                 const pc_adjacency *a, const pc_topology *topology) {
    pc_status status = PC_OK;
    pc_index parts = topology->component_count + 1;
    PC_TRY(pc_new(start, ctx, (size_t)parts + 2));
    PC_TRY(pc_new(list, ctx, mesh->vertex_count));
    for (int fill = 0; fill < 2; fill++) {
        for (pc_index v = 0; v < mesh->vertex_count; v++) {
            pc_index h = a->vertex_half[v], part = h == PC_NONE ? parts - 1 : topology->face_component[h / 3];
            if (fill)
                (*list)[(*start)[part + 1]++] = v;
            else
                (*start)[part + 2]++;
        }
        for (pc_index p = 1; !fill && p < parts + 2; p++)
            (*start)[p] += (*start)[p - 1];
    }
done:
    return status;
}

static int by_value(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double quantile(double *sorted, pc_index count, double q) {
    qsort(sorted, count, sizeof *sorted, by_value);
    return sorted[(size_t)(q * (count - 1))];
}

static pc_status scale_parts(double *scale, pc_context *ctx, const pc_mesh *mesh,
                             const pc_adjacency *adjacency, const pc_curl_options *options) {
    pc_status status = PC_OK;
    pc_topology topology = {0};
    pc_index *start = NULL, *list = NULL;
    double *sorted = NULL;
    PC_TRY(pc_topology_make(&topology, ctx, mesh, adjacency));
    PC_TRY(list_components(&start, &list, ctx, mesh, adjacency, &topology));
    PC_TRY(pc_new(&sorted, ctx, mesh->vertex_count));
    for (pc_index part = 0; part <= topology.component_count; part++) {
        pc_index count = start[part + 1] - start[part];
        if (count == 0) continue;
        for (pc_index k = 0; k < count; k++)
            sorted[k] = scale[list[start[part] + k]];
        double top = quantile(sorted, count, options->quantile);
        for (pc_index k = 0; k < count; k++) {
            double *nu = scale + list[start[part] + k];
            *nu = fmin(1, fmax(options->least, exp(*nu - top)));
        }
    }
done:
    pc_topology_free(&topology, ctx);
    pc_free(ctx, start);
    pc_free(ctx, list);
    pc_free(ctx, sorted);
    return status;
}

pc_status pc_curl_correct(double *scale, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                          const pc_adjacency *adjacency, const pc_field *field,
                          const pc_curl_options *options) {
    pc_status status = PC_OK;
    correction c = {.ctx = ctx, .mesh = mesh, .adjacency = adjacency, .field = field};
    pc_solver *solver = NULL;
    pc_solver_stats stats = {0};
    if (!(options->least > 0 && options->least <= 1))
        return pc_fail(ctx, PC_E_USAGE, "the least scale of a field must be in (0,1], not %g",
                       options->least);
    PC_TRY(assemble(&c));
    memset(scale, 0, mesh->vertex_count * sizeof *scale);
    PC_TRY(pc_solver_make(&solver, ctx, device, &c.system, &options->solver));
    PC_TRY(pc_solver_solve(solver, ctx, scale, c.right, options->tolerance, &stats));
    PC_TRY(scale_parts(scale, ctx, mesh, adjacency, options));
done:
    pc_solver_free(solver, ctx);
    pc_connection_free(&c.connection, ctx);
    pc_ring_free(&c.ring, ctx);
    pc_system_free(&c.system, ctx);
    pc_free(ctx, c.right);
    return status;
}
