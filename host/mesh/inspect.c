#include "inspect.h"
#include "memory.h"
#include <stdio.h>

static void count_valences(pc_inspection *inspection, const pc_adjacency *adjacency) {
    const pc_mesh *mesh = &inspection->mesh;
    inspection->valence_least = mesh->vertex_count ? PC_NONE : 0;
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_index first = adjacency->vertex_half[v], h = first, count = adjacency->vertex_boundary[v];
        do
            count++, h = pc_turn_ccw(adjacency, h);
        while (h != PC_NONE && h != first);
        if (count < inspection->valence_least) inspection->valence_least = count;
        if (count > inspection->valence_most) inspection->valence_most = count;
    }
}

static pc_status measure_edges(pc_inspection *inspection, pc_context *ctx, const pc_adjacency *adjacency) {
    double *length = NULL;
    pc_status status = pc_new(&length, ctx, adjacency->edge_count);
    if (status != PC_OK) return status;
    pc_geometry_edge_lengths(length, &inspection->mesh, adjacency);
    inspection->edge_length = pc_spread_of(length, adjacency->edge_count);
    pc_free(ctx, length);
    return PC_OK;
}

static pc_status measure_angles(pc_inspection *inspection, pc_context *ctx) {
    pc_status status = PC_OK;
    size_t face_count = inspection->mesh.face_count;
    double *angle = NULL, *least = NULL;
    PC_TRY(pc_new(&angle, ctx, 3 * face_count));
    PC_TRY(pc_new(&least, ctx, face_count));
    pc_geometry_corner_angles(angle, &inspection->mesh);
    for (size_t h = 0; h < 3 * face_count; h++)
        angle[h] *= 180 / PC_PI;
    for (size_t f = 0; f < face_count; f++)
        least[f] = fmin(angle[3 * f], fmin(angle[3 * f + 1], angle[3 * f + 2]));
    inspection->angle = pc_spread_of(angle, 3 * face_count);
    inspection->least_angle = pc_spread_of(least, face_count);
done:
    pc_free(ctx, angle);
    pc_free(ctx, least);
    return status;
}

static pc_status measure_loops(pc_inspection *inspection, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_topology *t = &inspection->topology;
    const pc_mesh *mesh = &inspection->mesh;
    double *length = NULL, *faces = NULL;
    PC_TRY(pc_new(&length, ctx, t->loop_count));
    PC_TRY(pc_new(&faces, ctx, t->component_count));
    for (pc_index l = 0; l < t->loop_count; l++)
        for (pc_index i = t->loop_start[l]; i < t->loop_start[l + 1]; i++) {
            pc_index h = t->loop_half[i];
            length[l] += pc_distance(pc_vec3_at(mesh->position, pc_tail(mesh, h)),
                                     pc_vec3_at(mesh->position, pc_head(mesh, h)));
        }
    for (pc_index c = 0; c < t->component_count; c++)
        faces[c] = t->component[c].face_count;
    inspection->boundary_length = pc_spread_of(length, t->loop_count);
    inspection->component_faces = pc_spread_of(faces, t->component_count);
done:
    pc_free(ctx, length);
    pc_free(ctx, faces);
    return status;
}

static pc_status measure(pc_inspection *inspection, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_adjacency adjacency = {0};
    const pc_mesh *mesh = &inspection->mesh;
    PC_TRY(pc_adjacency_make(&adjacency, ctx, mesh));
    PC_TRY(pc_topology_make(&inspection->topology, ctx, mesh, &adjacency));
    inspection->edge_count = adjacency.edge_count;
    inspection->boundary_edge_count = adjacency.boundary_edge_count;
    inspection->box = pc_geometry_box(mesh);
    inspection->diagonal = pc_box_diagonal(inspection->box);
    inspection->area = pc_geometry_area(mesh);
    inspection->volume = pc_geometry_volume(mesh);
    count_valences(inspection, &adjacency);
    PC_TRY(measure_edges(inspection, ctx, &adjacency));
    PC_TRY(measure_angles(inspection, ctx));
    PC_TRY(measure_loops(inspection, ctx));
done:
    pc_adjacency_free(&adjacency, ctx);
    return status;
}

/* Repairs as asked; where that is refused, once more in the most lenient way, to have something to measure.
 */
static pc_status repair_somehow(pc_inspection *inspection, pc_context *ctx, const pc_mesh *mesh,
                                const pc_repair_options *options) {
    pc_repair_options lenient = {.tear_nonorientable = true, .crowded_share = 1, .shred_share = 1};
    pc_status status = pc_repair(&inspection->mesh, &inspection->repair, ctx, mesh, options);
    inspection->convertible = status == PC_OK;
    if (status != PC_E_MESH) return status;
    (void)snprintf(inspection->refusal, sizeof inspection->refusal, "%s", pc_context_message(ctx));
    pc_context_clear_message(ctx);
    pc_repair_report_free(&inspection->repair, ctx);
    status = pc_repair(&inspection->mesh, &inspection->repair, ctx, mesh, &lenient);
    if (status == PC_E_MESH && !inspection->mesh.face_count) { /* nothing left: that is an answer too */
        pc_context_clear_message(ctx);
        return PC_OK;
    }
    return status;
}

pc_status pc_inspect(pc_inspection *inspection, pc_context *ctx, const pc_mesh *mesh,
                     const pc_repair_options *options) {
    pc_status status = PC_OK;
    *inspection =
        (pc_inspection){.given_vertex_count = mesh->vertex_count, .given_face_count = mesh->face_count};
    PC_TRY(pc_repair_check_input(ctx, mesh));
    PC_TRY(repair_somehow(inspection, ctx, mesh, options));
    PC_TRY(measure(inspection, ctx));
done:
    if (status != PC_OK) pc_inspection_free(inspection, ctx);
    return status;
}

void pc_inspection_free(pc_inspection *inspection, pc_context *ctx) {
    if (!inspection) return;
    pc_repair_report_free(&inspection->repair, ctx);
    pc_topology_free(&inspection->topology, ctx);
    pc_mesh_free(&inspection->mesh, ctx);
}
