#include "topology.h"
#include "geometry.h"
#include "memory.h"

/* Flood fill from the smallest face left; `stack` holds one entry per face. */
static pc_index flood_faces(pc_index *face_component, pc_index *stack, const pc_mesh *mesh,
                            const pc_adjacency *adjacency) {
    pc_index count = 0;
    for (pc_index f = 0; f < mesh->face_count; f++)
        face_component[f] = PC_NONE;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_index top = 0;
        if (face_component[f] != PC_NONE) continue;
        face_component[f] = count;
        stack[top++] = f;
        while (top) {
            pc_index g = stack[--top];
            for (pc_index k = 0; k < 3; k++) {
                pc_index twin = adjacency->twin[3 * g + k];
                if (twin == PC_NONE || face_component[twin / 3] != PC_NONE) continue;
                face_component[twin / 3] = count;
                stack[top++] = twin / 3;
            }
        }
        count++;
    }
    return count;
}

static void count_elements(pc_topology *topology, const pc_mesh *mesh, const pc_adjacency *adjacency) {
    for (pc_index c = 0; c < topology->component_count; c++)
        topology->component[c].first_face = PC_NONE;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_component *component = &topology->component[topology->face_component[f]];
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        if (component->first_face == PC_NONE) component->first_face = f;
        component->face_count++;
        component->area +=
            pc_triangle_area(pc_vec3_at(mesh->position, t[0]), pc_vec3_at(mesh->position, t[1]),
                             pc_vec3_at(mesh->position, t[2]));
    }
    for (pc_index e = 0; e < adjacency->edge_count; e++)
        topology->component[topology->face_component[adjacency->edge_half[e] / 3]].edge_count++;
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        if (adjacency->vertex_half[v] != PC_NONE)
            topology->component[topology->face_component[adjacency->vertex_half[v] / 3]].vertex_count++;
}

/* Walks the loops in order of their smallest half-edge; `seen` is per half-edge. */
static void walk_loops(pc_topology *topology, uint8_t *seen, const pc_mesh *mesh,
                       const pc_adjacency *adjacency) {
    pc_index used = 0;
    for (pc_index first = 0; first < 3 * mesh->face_count; first++) {
        pc_index c = topology->face_component[first / 3];
        if (adjacency->twin[first] != PC_NONE || seen[first]) continue;
        topology->loop_start[topology->loop_count] = used;
        topology->loop_component[topology->loop_count++] = c;
        topology->component[c].loop_count++;
        for (pc_index h = first; !seen[h]; h = adjacency->vertex_half[pc_head(mesh, h)]) {
            seen[h] = 1;
            topology->loop_half[used++] = h;
        }
    }
    topology->loop_start[topology->loop_count] = used;
}

static void sum_up(pc_topology *topology) {
    for (pc_index c = 0; c < topology->component_count; c++) {
        pc_component *component = &topology->component[c];
        component->chi = (int64_t)component->vertex_count - component->edge_count + component->face_count;
        component->genus = (pc_index)((2 - component->chi - component->loop_count) / 2);
        topology->chi += component->chi;
        topology->genus += component->genus;
    }
}

pc_status pc_topology_make(pc_topology *topology, pc_context *ctx, const pc_mesh *mesh,
                           const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    pc_index *stack = NULL;
    uint8_t *seen = NULL;
    *topology = (pc_topology){0};
    PC_TRY(pc_new(&topology->face_component, ctx, mesh->face_count));
    PC_TRY(pc_new(&stack, ctx, mesh->face_count));
    topology->component_count = flood_faces(topology->face_component, stack, mesh, adjacency);
    PC_TRY(pc_new(&topology->component, ctx, topology->component_count));
    count_elements(topology, mesh, adjacency);
    /* A loop has at least two half-edges. */
    PC_TRY(pc_new(&topology->loop_start, ctx, (size_t)adjacency->boundary_edge_count / 2 + 1));
    PC_TRY(pc_new(&topology->loop_component, ctx, (size_t)adjacency->boundary_edge_count / 2));
    PC_TRY(pc_new(&topology->loop_half, ctx, adjacency->boundary_edge_count));
    PC_TRY(pc_new(&seen, ctx, 3 * (size_t)mesh->face_count));
    walk_loops(topology, seen, mesh, adjacency);
    sum_up(topology);
done:
    pc_free(ctx, stack);
    pc_free(ctx, seen);
    if (status != PC_OK) pc_topology_free(topology, ctx);
    return status;
}

void pc_topology_free(pc_topology *topology, pc_context *ctx) {
    if (!topology) return;
    pc_free(ctx, topology->component);
    pc_free(ctx, topology->face_component);
    pc_free(ctx, topology->loop_start);
    pc_free(ctx, topology->loop_half);
    pc_free(ctx, topology->loop_component);
    *topology = (pc_topology){0};
}

static pc_status check_counts(const pc_topology *topology, pc_context *ctx, const pc_mesh *mesh,
                              const pc_adjacency *adjacency) {
    uint64_t faces = 0, edges = 0, loops = 0;
    for (pc_index c = 0; c < topology->component_count; c++) {
        const pc_component *component = &topology->component[c];
        faces += component->face_count, edges += component->edge_count, loops += component->loop_count;
        if (2 - component->chi - component->loop_count != 2 * (int64_t)component->genus)
            return pc_fail(ctx, PC_E_BUG, "component %u: chi %lld and %u loops give no whole genus", c,
                           (long long)component->chi, component->loop_count);
    }
    if (faces != mesh->face_count || edges != adjacency->edge_count || loops != topology->loop_count)
        return pc_fail(ctx, PC_E_BUG, "the components do not add up to the mesh");
    return PC_OK;
}

pc_status pc_topology_check(const pc_topology *topology, pc_context *ctx, const pc_mesh *mesh,
                            const pc_adjacency *adjacency) {
    pc_index least = 0;
    pc_status status = check_counts(topology, ctx, mesh, adjacency);
    if (status != PC_OK) return status;
    if (topology->loop_start[topology->loop_count] != adjacency->boundary_edge_count)
        return pc_fail(ctx, PC_E_BUG, "the loops hold %u of %u boundary edges",
                       topology->loop_start[topology->loop_count], adjacency->boundary_edge_count);
    for (pc_index l = 0; l < topology->loop_count; l++) {
        pc_index begin = topology->loop_start[l], end = topology->loop_start[l + 1];
        for (pc_index i = begin; i < end; i++) {
            pc_index h = topology->loop_half[i], next = topology->loop_half[i + 1 < end ? i + 1 : begin];
            bool least_first = i == begin ? l == 0 || h > least : h > topology->loop_half[begin];
            if (adjacency->twin[h] != PC_NONE || pc_head(mesh, h) != pc_tail(mesh, next) || !least_first)
                return pc_fail(ctx, PC_E_BUG, "loop %u is broken at half-edge %u", l, h);
        }
        least = topology->loop_half[begin];
    }
    return PC_OK;
}
