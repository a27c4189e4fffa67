#include "scan_systems.h"
#include "assembly.h"
#include "connection.h"
#include "coupling.h"
#include "edge_rows.h"
#include "geometry.h"
#include "memory.h"
#include "order.h"
#include "pgp.h"
#include "refine.h"
#include "relief.h"
#include "repair.h"
#include "ring.h"
#include "scan.h"
#include "synth_wear.h"
#include <math.h>
#include <string.h>

static pc_status read_clean(pc_mesh *mesh, pc_context *ctx, const char *path,
                            const pc_scan_options *options) {
    const pc_repair_options repair = PC_REPAIR_DEFAULTS;
    pc_status status = PC_OK;
    pc_repair_report report = {0};
    pc_scan_info info;
    pc_mesh raw = {0};
    PC_TRY(pc_scan_read(&raw, &info, ctx, path));
    PC_TRY(pc_repair(mesh, &report, ctx, &raw, &repair));
    for (int k = 0; k < options->subdivisions; k++)
        PC_TRY(pc_synth_subdivide(mesh, ctx, true));
    if (options->subdivisions > 0) PC_TRY(pc_synth_noise(mesh, ctx, options->noise, 1));
done:
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&raw, ctx);
    return status;
}

/* In the order of computation. */
static pc_status put_in_order(pc_mesh *out, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    pc_adjacency adjacency = {0};
    pc_graph graph = {0};
    pc_order order = {0};
    PC_TRY(pc_adjacency_make(&adjacency, ctx, mesh));
    PC_TRY(pc_graph_make(&graph, ctx, mesh, &adjacency));
    PC_TRY(pc_order_make(&order, ctx, mesh, &graph));
    PC_TRY(pc_order_apply(out, ctx, &order, mesh));
done:
    pc_order_free(&order, ctx);
    pc_graph_free(&graph, ctx);
    pc_adjacency_free(&adjacency, ctx);
    return status;
}

pc_status pc_scan_case_make(pc_scan_case *scan, pc_context *ctx, const char *path,
                            const pc_scan_options *options) {
    const double longest = 0.32; /* of a period, as the pipeline's */
    pc_status status = PC_OK;
    pc_mesh clean = {0};
    pc_adjacency adjacency = {0};
    pc_refined refined = {0};
    pc_refine_options refine = PC_REFINE_DEFAULTS;
    *scan = (pc_scan_case){0};
    PC_TRY(read_clean(&clean, ctx, path, options));
    PC_TRY(pc_adjacency_make(&adjacency, ctx, &clean));
    scan->mean_edge = pc_geometry_mean_edge(&clean, &adjacency);
    scan->area = pc_geometry_area(&clean);
    scan->period = options->period_edges * scan->mean_edge;
    refine.max_edge = longest * scan->period;
    pc_adjacency_free(&adjacency, ctx);
    PC_TRY(pc_refine(&refined, ctx, &clean, &refine));
    pc_mesh_free(&clean, ctx);
    PC_TRY(put_in_order(&scan->mesh, ctx, &refined.mesh));
    PC_TRY(pc_adjacency_make(&scan->adjacency, ctx, &scan->mesh));
done:
    pc_refined_free(&refined, ctx);
    pc_mesh_free(&clean, ctx);
    if (status != PC_OK) pc_scan_case_free(scan, ctx);
    return status;
}

void pc_scan_case_free(pc_scan_case *scan, pc_context *ctx) {
    pc_mesh_free(&scan->mesh, ctx);
    pc_adjacency_free(&scan->adjacency, ctx);
    *scan = (pc_scan_case){0};
}

/* A third of each triangle's area to its corners, nothing below a trifle. */
static void vertex_areas(double *area, const pc_scan_case *scan) {
    const pc_mesh *m = &scan->mesh;
    memset(area, 0, m->vertex_count * sizeof *area);
    for (size_t f = 0; f < m->face_count; f++) {
        const pc_index *t = m->triangle + 3 * f;
        double third = pc_triangle_area(pc_vec3_at(m->position, t[0]), pc_vec3_at(m->position, t[1]),
                                        pc_vec3_at(m->position, t[2])) /
                       3;
        for (int k = 0; k < 3; k++)
            area[t[k]] += third;
    }
    double least = 1e-6 * scan->area / m->vertex_count;
    for (pc_index v = 0; v < m->vertex_count; v++)
        area[v] = fmax(area[v], least);
}

static void sum_rows(pc_system *s, const double *area, double shift) {
    for (pc_index v = 0; v < s->row_count; v++) {
        double sum = shift * area[v];
        for (pc_index e = s->start[v]; e < s->start[v + 1]; e++)
            sum += hypot(s->value[2 * (size_t)e], s->value[2 * (size_t)e + 1]);
        s->diagonal[v] = sum;
    }
}

pc_status pc_scan_field_system(pc_system *system, pc_context *ctx, pc_device *device,
                               const pc_scan_case *scan) {
    const pc_field_options field = PC_FIELD_DEFAULTS;
    const double rho = field.smoothness;
    pc_status status = PC_OK;
    pc_connection connection = {0};
    pc_ring ring = {0};
    double *transport = NULL, *area = NULL;
    size_t n = scan->mesh.vertex_count;
    *system = (pc_system){0};
    PC_TRY(pc_connection_make(&connection, ctx, &scan->mesh, &scan->adjacency));
    PC_TRY(pc_new(&transport, ctx, 3 * (size_t)scan->mesh.face_count));
    PC_TRY(pc_new(&area, ctx, n));
    PC_TRY(pc_relief_smooth(transport, ctx, device, &scan->mesh, &scan->adjacency, &connection,
                            field.relief_edges * scan->mean_edge, &field.solver));
    PC_TRY(pc_ring_make(&ring, ctx, &scan->mesh, &scan->adjacency));
    PC_TRY(pc_system_make(system, ctx, PC_BLOCK_COMPLEX, (pc_index)n, ring.start[n]));
    memcpy(system->start, ring.start, (n + 1) * sizeof *system->start);
    memcpy(system->column, ring.vertex, ring.start[n] * sizeof *system->column);
    const pc_assembly work = {&scan->mesh, &scan->adjacency, &ring, connection.weight, transport, 4, rho};
    pc_assembly_ref(system->value, &work);
    vertex_areas(area, scan);
    sum_rows(system, area, (rho + 1e-3) * 1e-2 / scan->area);
done:
    pc_connection_free(&connection, ctx);
    pc_ring_free(&ring, ctx);
    pc_free(ctx, transport);
    pc_free(ctx, area);
    if (status != PC_OK) pc_system_free(system, ctx);
    return status;
}

pc_status pc_scan_pgp_system(pc_system *system, pc_context *ctx, pc_device *device,
                             const pc_scan_case *scan) {
    const pc_curvature_options how = PC_CURVATURE_DEFAULTS;
    const pc_field_options options = PC_FIELD_DEFAULTS;
    const double reach = 8 * scan->period;
    pc_status status = PC_OK;
    pc_curvature curvature = {0};
    pc_field field = {0};
    pc_coupling coupling = {0};
    pc_edge_rows rows = {0};
    double *area = NULL;
    *system = (pc_system){0};
    PC_TRY(pc_curvature_make(&curvature, ctx, device, &scan->mesh, &scan->adjacency, &how));
    PC_TRY(pc_field_make(&field, ctx, device, &scan->mesh, &scan->adjacency, &curvature, &options));
    PC_TRY(
        pc_coupling_make(&coupling, ctx, device, &scan->mesh, &scan->adjacency, &field, NULL, scan->period));
    PC_TRY(pc_edge_rows_make(&rows, ctx, &scan->mesh, &scan->adjacency));
    PC_TRY(pc_pgp_assemble(system, ctx, device, &scan->mesh, &scan->adjacency, &rows, &coupling));
    PC_TRY(pc_new(&area, ctx, scan->mesh.vertex_count));
    vertex_areas(area, scan);
    for (pc_index v = 0; v < system->row_count; v++)
        system->diagonal[v] += area[v] / (reach * reach);
done:
    pc_curvature_free(&curvature, ctx);
    pc_field_free(&field, ctx);
    pc_coupling_free(&coupling, ctx);
    pc_edge_rows_free(&rows, ctx);
    pc_free(ctx, area);
    if (status != PC_OK) pc_system_free(system, ctx);
    return status;
}
