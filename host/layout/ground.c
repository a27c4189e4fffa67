#include "ground.h"
#include "geometry.h"
#include "memory.h"

static pc_status make_rim(pc_ground *ground, pc_context *ctx, const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    const pc_mesh *scan = ground->scan;
    pc_index *at_vertex = NULL, count = 0, edges = adjacency->boundary_edge_count;
    PC_TRY(pc_new(&at_vertex, ctx, edges ? scan->vertex_count : 0));
    PC_TRY(pc_mesh_make(&ground->rim, ctx, edges, edges));
    PC_TRY(pc_new(&ground->rim_before, ctx, edges));
    for (pc_index h = 0; edges && h < 3 * scan->face_count; h++) {
        if (adjacency->twin[h] != PC_NONE) continue;
        at_vertex[pc_tail(scan, h)] = count;
        ground->rim.triangle[3 * (size_t)count] = pc_head(scan, h);
        pc_vec3_put(ground->rim.position, count++, pc_vec3_at(scan->position, pc_tail(scan, h)));
    }
    for (pc_index i = 0; i < edges; i++) {
        pc_index *t = ground->rim.triangle + 3 * (size_t)i, next = at_vertex[t[0]];
        t[0] = i, t[1] = t[2] = next;
        ground->rim_before[next] = i;
    }
    PC_TRY(pc_bvh_make(&ground->rim_tree, ctx, &ground->rim));
done:
    pc_free(ctx, at_vertex);
    return status;
}

pc_status pc_ground_make(pc_ground *ground, pc_context *ctx, const pc_mesh *scan,
                         const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    *ground = (pc_ground){.scan = scan, .adjacency = adjacency};
    PC_TRY(pc_bvh_make(&ground->tree, ctx, scan));
    PC_TRY(pc_new(&ground->normal, ctx, 3 * (size_t)scan->vertex_count));
    pc_geometry_vertex_normals(ground->normal, scan, adjacency, PC_NORMAL_AREA);
    PC_TRY(make_rim(ground, ctx, adjacency));
done:
    if (status != PC_OK) pc_ground_free(ground, ctx);
    return status;
}

void pc_ground_free(pc_ground *ground, pc_context *ctx) {
    pc_bvh_free(&ground->tree, ctx);
    pc_free(ctx, ground->normal);
    pc_bvh_free(&ground->rim_tree, ctx);
    pc_mesh_free(&ground->rim, ctx);
    pc_free(ctx, ground->rim_before);
    *ground = (pc_ground){0};
}

pc_vec3 pc_ground_normal(const pc_ground *ground, const pc_bvh_hit *hit) {
    pc_vec3 normal = {0, 0, 0};
    if (hit->face == PC_NONE) return normal;
    const pc_index *t = ground->scan->triangle + 3 * (size_t)hit->face;
    for (int k = 0; k < 3; k++)
        normal = pc_madd(normal, hit->weight[k], pc_vec3_at(ground->normal, t[k]));
    return normal;
}

static double face_cosine(const pc_ground *ground, pc_index face, pc_vec3 direction) {
    const pc_index *t = ground->scan->triangle + 3 * (size_t)face;
    pc_vec3 a = pc_vec3_at(ground->scan->position, t[0]);
    pc_vec3 normal = pc_cross(pc_sub(pc_vec3_at(ground->scan->position, t[1]), a),
                              pc_sub(pc_vec3_at(ground->scan->position, t[2]), a));
    double length = pc_norm(normal);
    return length > 0 ? pc_dot(normal, direction) / length : 1;
}

double pc_ground_flat_cosine(const pc_ground *ground, const pc_bvh_hit *hit, pc_vec3 direction) {
    if (hit->face == PC_NONE) return 0;
    double least = face_cosine(ground, hit->face, direction);
    for (pc_index k = 0; k < 3; k++) { /* half-edge k is opposite to the third corner from its tail */
        pc_index twin = ground->adjacency->twin[3 * hit->face + k];
        if (hit->weight[(k + 2) % 3] < 1e-9 && twin != PC_NONE)
            least = fmin(least, face_cosine(ground, twin / 3, direction));
    }
    return least;
}

pc_rim_place pc_ground_rim_closest(const pc_ground *ground, pc_vec3 point) {
    pc_bvh_hit hit = pc_bvh_closest(&ground->rim_tree, point, PC_NONE);
    return (pc_rim_place){hit.face, hit.face == PC_NONE ? 0 : 1 - hit.weight[0]};
}

static pc_vec3 rim_start(const pc_ground *ground, pc_index edge) {
    return pc_vec3_at(ground->rim.position, edge);
}

static pc_vec3 rim_end(const pc_ground *ground, pc_index edge) {
    return pc_vec3_at(ground->rim.position, ground->rim.triangle[3 * (size_t)edge + 1]);
}

pc_vec3 pc_ground_rim_point(const pc_ground *ground, pc_rim_place place) {
    pc_vec3 from = rim_start(ground, place.edge);
    return pc_madd(from, place.along, pc_sub(rim_end(ground, place.edge), from));
}

pc_rim_place pc_ground_rim_walk(const pc_ground *ground, pc_rim_place from, double distance,
                                pc_rim_place stop) {
    const pc_rim_place nowhere = {PC_NONE, 0};
    const bool forward = distance > 0;
    pc_rim_place at = from;
    if (at.edge == PC_NONE) return nowhere;
    for (pc_index steps = 0; steps <= ground->rim.face_count; steps++) {
        double length = pc_distance(rim_start(ground, at.edge), rim_end(ground, at.edge));
        double room = length * (forward ? 1 - at.along : at.along), left = fabs(distance);
        bool last = left <= room && length > 0;
        double to = forward ? 1 : 0;
        if (last) to = at.along + distance / length;
        if (stop.edge == at.edge && (forward ? at.along <= stop.along && stop.along <= to
                                             : to <= stop.along && stop.along <= at.along))
            return nowhere;
        if (last) return (pc_rim_place){at.edge, to};
        distance -= forward ? room : -room;
        at.edge = forward ? ground->rim.triangle[3 * (size_t)at.edge + 1] : ground->rim_before[at.edge];
        at.along = forward ? 0 : 1;
    }
    return nowhere;
}
