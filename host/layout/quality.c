#include "quality.h"
#include "memory.h"
#include "polysurface.h"

static const double degrees = 180 / PC_PI;

/* What several figures share. */
typedef struct survey {
    const pc_mesh *scan;
    const pc_polymesh *quads;
    const pc_bvh *tree;
    pc_polygraph scan_graph, quad_graph;
    double *scan_normal;  /* per scan vertex, area-weighted unit normals */
    double *quad_normal;  /* per quad vertex, the scan's smooth normal at the closest point */
    pc_index *near_face;  /* per quad vertex, the closest scan face */
    uint8_t *flat_in;     /* per quad vertex: faces in which it is flat (up to 255) */
    uint8_t *on_boundary; /* per quad vertex */
} survey;

static void count_sides(pc_quality *q, const pc_polymesh *mesh) {
    pc_index quad_polygons = 0, quad_cells = 0;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_index sides = mesh->start[f + 1] - mesh->start[f], corners = pc_cell_corners(NULL, 0, mesh, f);
        q->polygons[sides < PC_QUALITY_SIDES ? sides : PC_QUALITY_SIDES - 1]++;
        q->cells[corners < PC_QUALITY_SIDES ? corners : PC_QUALITY_SIDES - 1]++;
        quad_polygons += sides == 4;
        quad_cells += corners == 4;
    }
    if (mesh->face_count == 0) return;
    q->quad_polygon_percent = 100.0 * quad_polygons / mesh->face_count;
    q->quad_cell_percent = 100.0 * quad_cells / mesh->face_count;
}

/* A straight side through a T-junction takes the place of the edge that a regular vertex would have there. */
static pc_status count_vertices(pc_quality *q, pc_context *ctx, survey *s) {
    pc_status status = PC_OK;
    const pc_polymesh *mesh = s->quads;
    pc_index *corners = NULL;
    PC_TRY(pc_new(&corners, ctx, mesh->vertex_count));
    for (pc_index c = 0; c < s->quad_graph.corner_count; c++) {
        pc_index v = mesh->corner[c], f = s->quad_graph.face[c];
        corners[v]++;
        if (mesh->corner_flat && mesh->corner_flat[c] && s->flat_in[v] < 255) s->flat_in[v]++;
        if (!s->quad_graph.boundary[c]) continue;
        s->on_boundary[v] = 1;
        s->on_boundary[mesh->corner[pc_polymesh_next(mesh, f, c)]] = 1;
    }
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        if (corners[v] == 0) continue;
        pc_index quarters = corners[v] + s->flat_in[v]; /* of a full turn, were all angles right */
        q->t_junctions += s->flat_in[v] > 0;
        q->boundary_vertices += s->on_boundary[v];
        q->interior_vertices += !s->on_boundary[v];
        q->irregular_interior += !s->on_boundary[v] && quarters != 4;
        q->irregular_boundary += s->on_boundary[v] && quarters != 1 && quarters != 2;
    }
done:
    pc_free(ctx, corners);
    return status;
}

static pc_status make_scan_normals(pc_context *ctx, survey *s) {
    pc_status status = pc_new(&s->scan_normal, ctx, 3 * (size_t)s->scan->vertex_count);
    if (status != PC_OK) return status;
    for (size_t f = 0; f < s->scan->face_count; f++) {
        const pc_index *t = s->scan->triangle + 3 * f;
        pc_vec3 a = pc_vec3_at(s->scan->position, t[0]);
        pc_vec3 ab = pc_sub(pc_vec3_at(s->scan->position, t[1]), a);
        pc_vec3 n = pc_cross(ab, pc_sub(pc_vec3_at(s->scan->position, t[2]), a));
        for (int k = 0; k < 3; k++)
            pc_vec3_put(s->scan_normal, t[k], pc_add(pc_vec3_at(s->scan_normal, t[k]), n));
    }
#pragma omp parallel for schedule(static)
    for (size_t v = 0; v < s->scan->vertex_count; v++)
        pc_vec3_put(s->scan_normal, v, pc_unit(pc_vec3_at(s->scan_normal, v)));
    return PC_OK;
}

static pc_vec3 normal_at(const survey *s, const pc_bvh_hit *hit) {
    pc_vec3 n = {0, 0, 0};
    for (int k = 0; k < 3 && hit->face != PC_NONE; k++)
        n = pc_madd(n, hit->weight[k],
                    pc_vec3_at(s->scan_normal, s->scan->triangle[3 * (size_t)hit->face + k]));
    return pc_unit(n);
}

static bool vertex_is_wild(const pc_polymesh *mesh, pc_index v) {
    pc_vec3 p = pc_vec3_at(mesh->position, v);
    return !isfinite(p.x) || !isfinite(p.y) || !isfinite(p.z);
}

static pc_status find_vertices(pc_context *ctx, survey *s) {
    pc_status status = PC_OK;
    PC_TRY(pc_new(&s->quad_normal, ctx, 3 * (size_t)s->quads->vertex_count));
    PC_TRY(pc_new(&s->near_face, ctx, s->quads->vertex_count));
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < s->quads->vertex_count; v++) {
        pc_bvh_hit hit = pc_bvh_closest(s->tree, pc_vec3_at(s->quads->position, v), PC_NONE);
        pc_vec3_put(s->quad_normal, v, normal_at(s, &hit));
        s->near_face[v] = hit.face;
    }
done:
    return status;
}

/* The sum of the scan's normals at the corners and the centre of a face. */
static pc_vec3 scan_normal_of_face(const survey *s, pc_index f, pc_index *near) {
    const pc_polymesh *mesh = s->quads;
    pc_vec3 sum = {0, 0, 0}, centre = {0, 0, 0};
    pc_index first = mesh->start[f], end = mesh->start[f + 1];
    for (pc_index c = first; c < end; c++) {
        sum = pc_add(sum, pc_vec3_at(s->quad_normal, mesh->corner[c]));
        centre = pc_madd(centre, 1.0 / (end - first), pc_vec3_at(mesh->position, mesh->corner[c]));
    }
    pc_bvh_hit hit = pc_bvh_closest(s->tree, centre, s->near_face[mesh->corner[first]]);
    *near = hit.face;
    return pc_add(sum, normal_at(s, &hit));
}

/* Per face its area, and the sign of its normal against the scan's. */
static void judge_faces(double *area, int8_t *sign, pc_index *near, const survey *s) {
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < s->quads->face_count; f++) {
        pc_vec3 normal = pc_face_normal(s->quads, f);
        area[f] = pc_norm(normal);
        near[f] = PC_NONE;
        if (s->quads->start[f] == s->quads->start[f + 1]) continue;
        double dot = pc_dot(normal, scan_normal_of_face(s, f, near + f));
        sign[f] = (int8_t)(dot > 0 ? 1 : dot < 0 ? -1 : 0);
    }
}

static pc_status find_broken_cells(pc_quality *q, pc_context *ctx, const survey *s) {
    pc_status status = PC_OK;
    pc_index faces = s->quads->face_count, *near = NULL;
    double *area = NULL, sum = 0;
    int8_t *sign = NULL;
    uint8_t *served = NULL;
    PC_TRY(pc_new(&area, ctx, faces));
    PC_TRY(pc_new(&sign, ctx, faces));
    PC_TRY(pc_new(&near, ctx, faces));
    PC_TRY(pc_new(&served, ctx, q->scan.components));
    judge_faces(area, sign, near, s);
    for (pc_index f = 0; f < faces; f++)
        sum += area[f];
    q->quads_area = sum;
    for (pc_index f = 0; f < faces; f++) {
        if (near[f] != PC_NONE) served[s->scan_graph.face_component[near[f]]] = 1;
        if (!(area[f] > 1e-12 * sum / faces)) {
            if (q->zero_area++ == 0) q->first_zero_area = f;
        } else if (sign[f] < 0) {
            if (q->inverted++ == 0) q->first_inverted = f;
        }
    }
    for (pc_index i = 0; i < q->scan.components; i++)
        q->missed_components += !served[i];
done:
    pc_free(ctx, area);
    pc_free(ctx, sign);
    pc_free(ctx, near);
    pc_free(ctx, served);
    return status;
}

/* The angle from an edge to the nearest of the four directions of the field at its middle, in degrees. The
 * field is blended over the face there as a fourth power, so that it does not matter which directions its
 * vertices name. */
static double angle_to_field(const survey *s, const pc_field *field, pc_index a, pc_index b) {
    pc_vec3 p = pc_vec3_at(s->quads->position, a), d = pc_sub(pc_vec3_at(s->quads->position, b), p);
    pc_bvh_hit hit = pc_bvh_closest(s->tree, pc_madd(p, 0.5, d), s->near_face[a]);
    double cosine = 0, sine = 0;
    for (int k = 0; k < 3 && hit.face != PC_NONE; k++) {
        pc_index v = s->scan->triangle[3 * (size_t)hit.face + k];
        pc_vec3 n = pc_vec3_at(field->normal, v), direction = pc_vec3_at(field->direction, v);
        double four = 4 * atan2(pc_dot(d, pc_cross(n, direction)), pc_dot(d, direction));
        cosine += hit.weight[k] * cos(four);
        sine += hit.weight[k] * sin(four);
    }
    return fabs(atan2(sine, cosine)) / 4 * degrees;
}

static pc_status compare_with_field(pc_quality *q, pc_context *ctx, const survey *s, const pc_field *field) {
    pc_status status = PC_OK;
    const pc_polymesh *mesh = s->quads;
    double *angle = NULL;
    size_t count = 0;
    if (!field) return PC_OK;
    if (field->vertex_count != s->scan->vertex_count)
        return pc_fail(ctx, PC_E_BUG, "the field has %u vertices, the scan %u", field->vertex_count,
                       s->scan->vertex_count);
    PC_TRY(pc_new(&angle, ctx, s->quad_graph.corner_count));
#pragma omp parallel for schedule(static)
    for (pc_index c = 0; c < s->quad_graph.corner_count; c++) {
        pc_index f = s->quad_graph.face[c], twin = s->quad_graph.twin[c];
        pc_index next = pc_polymesh_next(mesh, f, c);
        angle[c] =
            twin != PC_NONE && twin < c ? -1 : angle_to_field(s, field, mesh->corner[c], mesh->corner[next]);
    }
    for (pc_index c = 0; c < s->quad_graph.corner_count; c++)
        if (angle[c] >= 0) angle[count++] = angle[c];
    q->field_angle = pc_spread_of(angle, count);
done:
    pc_free(ctx, angle);
    return status;
}

/* The quads have their smallest pieces at the scan's resolution, the scan at half that of the quads. */
static pc_status measure_distances(pc_quality *q, pc_context *ctx, const survey *s) {
    pc_status status = PC_OK;
    pc_mesh surface = {0};
    pc_bvh tree = {0};
    double *component = NULL, edges = s->scan_graph.count.edges, scan_edge;
    PC_TRY(pc_polysurface_make(&surface, NULL, ctx, s->quads));
    PC_TRY(pc_bvh_make(&tree, ctx, &surface));
    PC_TRY(pc_new(&component, ctx, q->scan.components));
    scan_edge = edges > 0 ? sqrt(q->scan_area * 4 / (sqrt(3) * s->scan->face_count)) : 0;
    pc_deviation_options there = {.spacing = q->shape.edge_length.mean / 2,
                                  .label = s->scan_graph.face_component,
                                  .label_count = q->scan.components};
    pc_deviation_options back = {.spacing = scan_edge, .least = 3};
    PC_TRY(pc_check_interrupt(ctx));
    PC_TRY(pc_deviation_measure(&q->scan_to_quads, component, ctx, s->scan, &tree, &there));
    PC_TRY(pc_check_interrupt(ctx));
    PC_TRY(pc_deviation_measure(&q->quads_to_scan, NULL, ctx, &surface, s->tree, &back));
    for (pc_index i = 0; i < q->scan.components; i++)
        if (component[i] > q->worst_component) q->worst_component = component[i], q->worst_component_id = i;
done:
    pc_free(ctx, component);
    pc_bvh_free(&tree, ctx);
    pc_mesh_free(&surface, ctx);
    return status;
}

static pc_status measure_counts(pc_quality *q, pc_context *ctx, survey *s) {
    pc_status status = PC_OK;
    PC_TRY(pc_polygraph_of_mesh(&s->scan_graph, ctx, s->scan));
    PC_TRY(pc_polygraph_of_polymesh(&s->quad_graph, ctx, s->quads));
    q->scan = s->scan_graph.count;
    q->quads = s->quad_graph.count;
    PC_TRY(pc_new(&s->flat_in, ctx, s->quads->vertex_count));
    PC_TRY(pc_new(&s->on_boundary, ctx, s->quads->vertex_count));
    count_sides(q, s->quads);
    PC_TRY(count_vertices(q, ctx, s));
    for (pc_index v = 0; v < s->quads->vertex_count; v++)
        q->wild_vertices += vertex_is_wild(s->quads, v);
done:
    return status;
}

/* Everything that needs positions. */
static pc_status measure_surface(pc_quality *q, pc_context *ctx, survey *s, const pc_field *field) {
    pc_status status = PC_OK;
    q->diagonal = pc_box_diagonal(pc_geometry_box(s->scan));
    q->scan_area = pc_geometry_area(s->scan);
    PC_TRY(pc_cellshape_measure(&q->shape, ctx, s->quads, &s->quad_graph));
    PC_TRY(make_scan_normals(ctx, s));
    PC_TRY(find_vertices(ctx, s));
    PC_TRY(find_broken_cells(q, ctx, s));
    PC_TRY(compare_with_field(q, ctx, s, field));
    PC_TRY(measure_distances(q, ctx, s));
done:
    return status;
}

pc_status pc_quality_measure(pc_quality *quality, pc_context *ctx, const pc_quality_input *input) {
    pc_status status = PC_OK;
    pc_bvh own_tree = {0};
    survey s = {.scan = input->scan, .quads = input->quads, .tree = input->scan_tree};
    *quality = (pc_quality){0};
    PC_TRY(measure_counts(quality, ctx, &s));
    if (quality->wild_vertices) goto done; /* positions mean nothing then */
    if (!s.tree) {
        PC_TRY(pc_bvh_make(&own_tree, ctx, s.scan));
        s.tree = &own_tree;
    }
    PC_TRY(measure_surface(quality, ctx, &s, input->field));
done:
    pc_bvh_free(&own_tree, ctx);
    pc_polygraph_free(&s.scan_graph, ctx);
    pc_polygraph_free(&s.quad_graph, ctx);
    pc_free(ctx, s.scan_normal);
    pc_free(ctx, s.quad_normal);
    pc_free(ctx, s.near_face);
    pc_free(ctx, s.flat_in);
    pc_free(ctx, s.on_boundary);
    return status;
}
