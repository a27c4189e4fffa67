#include "geometry.h"
#include <stddef.h>

/* Sums are taken over this many fixed blocks, so that they do not depend on the number of threads. */
enum { BLOCKS = 256 };

static size_t block_begin(size_t count, int block) {
    return count / BLOCKS * (size_t)block + (count % BLOCKS * (size_t)block) / BLOCKS;
}

static double sum_blocks(const double *partial) {
    double sum = 0;
    for (int b = 0; b < BLOCKS; b++)
        sum += partial[b];
    return sum;
}

static double largest_part(pc_vec3 a) {
    return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
}

/* Exact scaling by a power of two where squares could overflow or underflow. */
static pc_vec3 near_one(pc_vec3 a) {
    double size = largest_part(a);
    int exponent = 0;
    if (!(size > 0) || (size > 0x1p-200 && size < 0x1p200)) return a;
    (void)frexp(size, &exponent);
    return (pc_vec3){ldexp(a.x, -exponent), ldexp(a.y, -exponent), ldexp(a.z, -exponent)};
}

double pc_angle(pc_vec3 u, pc_vec3 v) {
    u = near_one(u), v = near_one(v);
    if (!(largest_part(u) > 0) || !(largest_part(v) > 0)) return PC_PI / 2;
    return atan2(pc_norm(pc_cross(u, v)), pc_dot(u, v));
}

double pc_corner_angle(const pc_mesh *mesh, pc_index h) {
    const pc_vec3 at = pc_vec3_at(mesh->position, pc_tail(mesh, h));
    return pc_angle(pc_sub(pc_vec3_at(mesh->position, pc_head(mesh, h)), at),
                    pc_sub(pc_vec3_at(mesh->position, pc_tail(mesh, pc_prev(h))), at));
}

double pc_cotangent(pc_vec3 u, pc_vec3 v) {
    u = near_one(u), v = near_one(v);
    double along = pc_dot(u, v), across = pc_norm(pc_cross(u, v));
    if (fabs(along) < PC_COTANGENT_LIMIT * across) return along / across;
    return along > 0 ? PC_COTANGENT_LIMIT : along < 0 ? -PC_COTANGENT_LIMIT : 0;
}

pc_vec3 pc_triangle_normal(pc_vec3 a, pc_vec3 b, pc_vec3 c) {
    pc_vec3 normal = pc_cross(near_one(pc_sub(b, a)), near_one(pc_sub(c, a)));
    return pc_unit(near_one(normal));
}

double pc_triangle_area(pc_vec3 a, pc_vec3 b, pc_vec3 c) {
    pc_vec3 u = pc_sub(b, a), v = pc_sub(c, a);
    double size = fmax(largest_part(u), largest_part(v));
    if (!(size > 0)) return 0;
    double scaled = pc_norm(pc_cross(pc_scale(1 / size, u), pc_scale(1 / size, v)));
    return 0.5 * scaled * size * size;
}

void pc_triangle_angles(double angle[3], pc_vec3 a, pc_vec3 b, pc_vec3 c) {
    const pc_vec3 edge[3] = {pc_sub(b, a), pc_sub(c, b), pc_sub(a, c)}; /* edge k leaves corner k */
    int zero_edges = 0, zero_edge = 0;
    for (int k = 0; k < 3; k++)
        if (!(largest_part(edge[k]) > 0)) zero_edges++, zero_edge = k;
    for (int k = 0; k < 3; k++)
        angle[k] = zero_edges == 3 ? PC_PI / 3 : pc_angle(edge[k], pc_scale(-1, edge[(k + 2) % 3]));
    if (zero_edges == 1) angle[(zero_edge + 2) % 3] = 0;
}

pc_box pc_box_of(const double *position, size_t count) {
    pc_box box = {{0, 0, 0}, {0, 0, 0}};
    for (size_t i = 0; i < count; i++) {
        pc_vec3 p = pc_vec3_at(position, i);
        if (!i) box.low = box.high = p;
        box.low = (pc_vec3){p.x < box.low.x ? p.x : box.low.x, p.y < box.low.y ? p.y : box.low.y,
                            p.z < box.low.z ? p.z : box.low.z};
        box.high = (pc_vec3){p.x > box.high.x ? p.x : box.high.x, p.y > box.high.y ? p.y : box.high.y,
                             p.z > box.high.z ? p.z : box.high.z};
    }
    return box;
}

pc_box pc_geometry_box(const pc_mesh *mesh) {
    return pc_box_of(mesh->position, mesh->vertex_count);
}

double pc_box_diagonal(pc_box box) {
    pc_vec3 size = pc_sub(box.high, box.low);
    return hypot(hypot(size.x, size.y), size.z);
}

static void corners(pc_vec3 p[3], const pc_mesh *mesh, size_t face) {
    for (int k = 0; k < 3; k++)
        p[k] = pc_vec3_at(mesh->position, mesh->triangle[3 * face + (size_t)k]);
}

double pc_geometry_area(const pc_mesh *mesh) {
    double partial[BLOCKS];
#pragma omp parallel for schedule(static)
    for (int b = 0; b < BLOCKS; b++) {
        partial[b] = 0;
        for (size_t f = block_begin(mesh->face_count, b); f < block_begin(mesh->face_count, b + 1); f++) {
            pc_vec3 p[3];
            corners(p, mesh, f);
            partial[b] += pc_triangle_area(p[0], p[1], p[2]);
        }
    }
    return sum_blocks(partial);
}

double pc_geometry_volume(const pc_mesh *mesh) {
    double partial[BLOCKS];
    pc_vec3 origin = pc_geometry_box(mesh).low; /* near the mesh, against cancellation */
#pragma omp parallel for schedule(static)
    for (int b = 0; b < BLOCKS; b++) {
        partial[b] = 0;
        for (size_t f = block_begin(mesh->face_count, b); f < block_begin(mesh->face_count, b + 1); f++) {
            pc_vec3 p[3];
            corners(p, mesh, f);
            partial[b] += pc_dot(pc_sub(p[0], origin), pc_cross(pc_sub(p[1], origin), pc_sub(p[2], origin)));
        }
    }
    return sum_blocks(partial) / 6;
}

static double edge_length(const pc_mesh *mesh, const pc_adjacency *adjacency, size_t edge) {
    pc_index h = adjacency->edge_half[edge];
    return pc_distance(pc_vec3_at(mesh->position, pc_tail(mesh, h)),
                       pc_vec3_at(mesh->position, pc_head(mesh, h)));
}

double pc_geometry_mean_edge(const pc_mesh *mesh, const pc_adjacency *adjacency) {
    double partial[BLOCKS];
    if (!adjacency->edge_count) return 0;
#pragma omp parallel for schedule(static)
    for (int b = 0; b < BLOCKS; b++) {
        partial[b] = 0;
        for (size_t e = block_begin(adjacency->edge_count, b); e < block_begin(adjacency->edge_count, b + 1);
             e++)
            partial[b] += edge_length(mesh, adjacency, e);
    }
    return sum_blocks(partial) / adjacency->edge_count;
}

void pc_geometry_vertex_areas(double *area, const pc_mesh *mesh, double least_share) {
    double sum = 0;
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        area[v] = 0;
    for (size_t h = 0; h < 3 * (size_t)mesh->face_count; h += 3) {
        const pc_index *t = mesh->triangle + h;
        pc_vec3 p = pc_vec3_at(mesh->position, t[0]), e = pc_sub(pc_vec3_at(mesh->position, t[1]), p);
        double third = pc_norm(pc_cross(e, pc_sub(pc_vec3_at(mesh->position, t[2]), p))) / 6;
        for (int k = 0; k < 3; k++)
            area[t[k]] += third;
        sum += 3 * third;
    }
    double least = mesh->vertex_count ? least_share * sum / mesh->vertex_count : 0;
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        if (!(area[v] > least)) area[v] = least > 0 ? least : 1;
}

void pc_geometry_edge_lengths(double *length, const pc_mesh *mesh, const pc_adjacency *adjacency) {
#pragma omp parallel for schedule(static)
    for (size_t e = 0; e < adjacency->edge_count; e++)
        length[e] = edge_length(mesh, adjacency, e);
}

void pc_geometry_corner_angles(double *angle, const pc_mesh *mesh) {
#pragma omp parallel for schedule(static)
    for (size_t f = 0; f < mesh->face_count; f++) {
        pc_vec3 p[3];
        corners(p, mesh, f);
        pc_triangle_angles(angle + 3 * f, p[0], p[1], p[2]);
    }
}

void pc_geometry_cotangents(double *cotangent, const pc_mesh *mesh) {
#pragma omp parallel for schedule(static)
    for (size_t f = 0; f < mesh->face_count; f++) {
        pc_vec3 p[3];
        corners(p, mesh, f);
        for (size_t k = 0; k < 3; k++) {
            pc_vec3 tip = p[(k + 2) % 3];
            cotangent[3 * f + k] = pc_cotangent(pc_sub(p[k], tip), pc_sub(p[(k + 1) % 3], tip));
        }
    }
}

static pc_vec3 vertex_normal(const pc_mesh *mesh, const pc_adjacency *adjacency, size_t v,
                             pc_normal_weight weight) {
    pc_vec3 sum = {0, 0, 0}, fallback = {0, 0, 1};
    double largest = 0, total = 0;
    pc_index first = adjacency->vertex_half[v], h = first;
    while (h != PC_NONE) {
        pc_vec3 p[3], normal;
        double angle[3], area;
        corners(p, mesh, h / 3);
        normal = pc_triangle_normal(p[0], p[1], p[2]);
        area = pc_triangle_area(p[0], p[1], p[2]);
        if (weight != PC_NORMAL_AREA) pc_triangle_angles(angle, p[0], p[1], p[2]);
        double share = weight == PC_NORMAL_AREA ? area : angle[h % 3];
        if (area > largest) largest = area, fallback = normal;
        sum = pc_madd(sum, share, normal);
        total += share;
        h = pc_turn_ccw(adjacency, h);
        if (h == first) break;
    }
    return pc_norm(sum) > 1e-9 * total ? pc_unit(sum) : fallback;
}

void pc_geometry_vertex_normals(double *normal, const pc_mesh *mesh, const pc_adjacency *adjacency,
                                pc_normal_weight weight) {
#pragma omp parallel for schedule(static)
    for (size_t v = 0; v < mesh->vertex_count; v++)
        pc_vec3_put(normal, v, vertex_normal(mesh, adjacency, v, weight));
}

/* Wirth's selection: afterwards value[rank] is in its sorted place among value[low .. high]. */
static double select_rank(double *value, ptrdiff_t low, ptrdiff_t high, ptrdiff_t rank) {
    while (low < high) {
        double pivot = value[rank];
        ptrdiff_t i = low, j = high;
        do {
            while (value[i] < pivot)
                i++;
            while (value[j] > pivot)
                j--;
            if (i <= j) {
                double swap = value[i];
                value[i++] = value[j], value[j--] = swap;
            }
        } while (i <= j);
        if (j < rank) low = i;
        if (rank < i) high = j;
    }
    return value[rank];
}

pc_spread pc_spread_of(double *value, size_t count) {
    static const double share[7] = {0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99};
    pc_spread spread = {.count = count};
    double *const out[7] = {&spread.q01, &spread.q05, &spread.q25, &spread.median,
                            &spread.q75, &spread.q95, &spread.q99};
    double partial[BLOCKS];
    if (!count) return spread;
    for (int b = 0; b < BLOCKS; b++) {
        partial[b] = 0;
        for (size_t i = block_begin(count, b); i < block_begin(count, b + 1); i++)
            partial[b] += value[i];
    }
    spread.mean = sum_blocks(partial) / (double)count;
    spread.min = spread.max = value[0];
    for (size_t i = 1; i < count; i++)
        spread.min = fmin(spread.min, value[i]), spread.max = fmax(spread.max, value[i]);
    for (ptrdiff_t q = 0, low = 0; q < 7; q++) {
        ptrdiff_t rank = (ptrdiff_t)ceil(share[q] * (double)count) - 1;
        *out[q] = select_rank(value, low, (ptrdiff_t)count - 1, rank < 0 ? 0 : rank);
        low = rank < 0 ? 0 : rank; /* what is left of it is smaller */
    }
    return spread;
}
