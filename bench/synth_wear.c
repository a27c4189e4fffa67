#include "synth_wear.h"
#include "adjacency.h"
#include "memory.h"
#include "random.h"
#include <string.h>

double pc_synth_mean_edge(const pc_mesh *mesh) {
    double sum = 0;
    pc_index half_count = 3 * mesh->face_count;
    for (pc_index h = 0; h < half_count; h++)
        sum += pc_distance(pc_vec3_at(mesh->position, pc_tail(mesh, h)),
                           pc_vec3_at(mesh->position, pc_head(mesh, h)));
    return half_count ? sum / half_count : 0;
}

/* Unit vertex normals, weighted by area. */
static pc_status vertex_normals(double **normal, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = pc_new(normal, ctx, 3 * (size_t)mesh->vertex_count);
    if (status != PC_OK) return status;
    for (size_t f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * f;
        pc_vec3 a = pc_vec3_at(mesh->position, t[0]), b = pc_vec3_at(mesh->position, t[1]);
        pc_vec3 n = pc_cross(pc_sub(b, a), pc_sub(pc_vec3_at(mesh->position, t[2]), a));
        for (int k = 0; k < 3; k++)
            pc_vec3_put(*normal, t[k], pc_add(pc_vec3_at(*normal, t[k]), n));
    }
    for (size_t v = 0; v < mesh->vertex_count; v++)
        pc_vec3_put(*normal, v, pc_unit(pc_vec3_at(*normal, v)));
    return PC_OK;
}

static double signed_unit(uint64_t x) {
    return (double)(x >> 11) * 0x1p-52 - 1;
}

/* Nearly Gaussian, deviation 1: a sum of uniform numbers needs no library function that differs among
 * machines. */
static double gaussian(pc_random *random) {
    double sum = -6;
    for (int i = 0; i < 12; i++)
        sum += pc_random_uniform(random);
    return sum;
}

pc_status pc_synth_noise(pc_mesh *mesh, pc_context *ctx, double amount, uint64_t seed) {
    double *normal = NULL;
    pc_status status = vertex_normals(&normal, ctx, mesh);
    if (status != PC_OK) return status;
    double size = amount * pc_synth_mean_edge(mesh);
#pragma omp parallel for schedule(static)
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        pc_random random = {pc_hash64(seed ^ pc_hash64(v))};
        pc_vec3 moved =
            pc_madd(pc_vec3_at(mesh->position, v), size * gaussian(&random), pc_vec3_at(normal, v));
        pc_vec3_put(mesh->position, v, moved);
    }
    pc_free(ctx, normal);
    return PC_OK;
}

/* Random values at the points of an integer lattice, blended smoothly between them. */
static double lattice_noise(pc_vec3 p, uint64_t seed) {
    const double x[3] = {p.x, p.y, p.z};
    double smooth[3], sum = 0;
    int64_t cell[3];
    for (int k = 0; k < 3; k++) {
        double t = x[k] - floor(x[k]);
        cell[k] = (int64_t)floor(x[k]);
        smooth[k] = t * t * (3 - 2 * t);
    }
    for (int corner = 0; corner < 8; corner++) {
        uint64_t key = seed;
        double weight = 1;
        for (int k = 0; k < 3; k++) {
            int up = corner >> k & 1;
            key = pc_hash64(key ^ (uint64_t)(cell[k] + up));
            weight *= up ? smooth[k] : 1 - smooth[k];
        }
        sum += weight * signed_unit(key);
    }
    return sum;
}

pc_status pc_synth_ripple(pc_mesh *mesh, pc_context *ctx, double amount, double wavelength, uint64_t seed) {
    double *normal = NULL;
    pc_status status = vertex_normals(&normal, ctx, mesh);
    if (status != PC_OK) return status;
    double edge = pc_synth_mean_edge(mesh);
    double size = amount * edge * 3.3; /* the blend's deviation is about 0.3 */
    double pitch = edge > 0 && wavelength > 0 ? 1 / (wavelength * edge) : 0;
#pragma omp parallel for schedule(static)
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        pc_vec3 p = pc_vec3_at(mesh->position, v);
        double wave = lattice_noise(pc_scale(pitch, p), seed);
        pc_vec3_put(mesh->position, v, pc_madd(p, size * wave, pc_vec3_at(normal, v)));
    }
    pc_free(ctx, normal);
    return PC_OK;
}

/* Drops the marked faces, then the vertices that no face uses. */
static pc_status drop_faces(pc_mesh *mesh, pc_context *ctx, const uint8_t *gone) {
    pc_status status = PC_OK;
    pc_index *number = NULL, kept = 0, used = 0;
    PC_TRY(pc_new(&number, ctx, mesh->vertex_count));
    for (size_t f = 0; f < mesh->face_count; f++) {
        if (gone[f]) continue;
        for (int k = 0; k < 3; k++) {
            pc_index v = mesh->triangle[3 * f + k];
            mesh->triangle[3 * (size_t)kept + k] = v;
            number[v] = 1;
        }
        kept++;
    }
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        if (!number[v]) continue;
        pc_vec3_put(mesh->position, used, pc_vec3_at(mesh->position, v));
        number[v] = used++;
    }
    for (size_t c = 0; c < 3 * (size_t)kept; c++)
        mesh->triangle[c] = number[mesh->triangle[c]];
    mesh->vertex_count = used, mesh->face_count = kept;
done:
    pc_free(ctx, number);
    return status;
}

typedef struct digger {
    const pc_mesh *mesh;
    const pc_adjacency *adjacency;
    uint8_t *gone;      /* per face */
    pc_index *owner;    /* per vertex: 1 + the hole that touches it, 0 untouched */
    pc_index *frontier; /* half-edges of kept faces beside the hole */
    size_t frontier_count;
    size_t capacity;
} digger;

static bool face_is_free(const digger *d, pc_index f) {
    for (int k = 0; k < 3; k++) {
        pc_index v = d->mesh->triangle[3 * (size_t)f + k];
        if (d->owner[v] || d->adjacency->vertex_boundary[v]) return false;
    }
    return !d->gone[f];
}

static pc_status remove_face(digger *d, pc_context *ctx, pc_index f, pc_index hole) {
    d->gone[f] = 1;
    if (d->frontier_count + 3 > d->capacity) {
        d->capacity = 2 * d->capacity + 64;
        pc_status status = pc_resize(&d->frontier, ctx, d->capacity);
        if (status != PC_OK) return status;
    }
    for (pc_index h = 3 * f; h < 3 * f + 3; h++) {
        pc_index twin = d->adjacency->twin[h];
        d->owner[pc_tail(d->mesh, h)] = hole + 1;
        if (twin != PC_NONE && !d->gone[twin / 3]) d->frontier[d->frontier_count++] = twin;
    }
    return PC_OK;
}

/* Whether the hole stays a disk when the face of h, beside it, goes too. */
static bool may_remove(const digger *d, pc_index h, pc_index hole) {
    pc_index f = h / 3, sides = 0;
    if (d->gone[f]) return false;
    for (pc_index g = 3 * f; g < 3 * f + 3; g++) {
        pc_index v = pc_tail(d->mesh, g), twin = d->adjacency->twin[g];
        if (d->adjacency->vertex_boundary[v] || (d->owner[v] && d->owner[v] != hole + 1)) return false;
        sides += twin != PC_NONE && d->gone[twin / 3];
    }
    pc_index apex = pc_tail(d->mesh, pc_prev(h));
    return sides == 2 || (sides == 1 && d->owner[apex] == 0);
}

static pc_status dig_hole(digger *d, pc_context *ctx, pc_index hole, pc_index faces, pc_random *random) {
    pc_status status = PC_OK;
    pc_index first = PC_NONE, removed = 1;
    for (int attempt = 0; attempt < 1000 && first == PC_NONE; attempt++) {
        pc_index f = (pc_index)(pc_random_next(random) % d->mesh->face_count);
        if (face_is_free(d, f)) first = f;
    }
    if (first == PC_NONE) return pc_fail(ctx, PC_E_MESH, "there is no room for hole %u", hole);
    d->frontier_count = 0;
    PC_TRY(remove_face(d, ctx, first, hole));
    while (removed < faces && d->frontier_count) {
        size_t pick = pc_random_next(random) % d->frontier_count;
        pc_index h = d->frontier[pick];
        d->frontier[pick] = d->frontier[--d->frontier_count];
        if (!may_remove(d, h, hole)) continue;
        PC_TRY(remove_face(d, ctx, h / 3, hole));
        removed++;
    }
done:
    return status;
}

pc_status pc_synth_holes(pc_mesh *mesh, pc_context *ctx, pc_index count, pc_index faces_each, uint64_t seed) {
    pc_status status = PC_OK;
    pc_random random = {pc_hash64(seed)};
    pc_adjacency adjacency = {0};
    digger d = {.mesh = mesh, .adjacency = &adjacency};
    PC_TRY(pc_adjacency_make(&adjacency, ctx, mesh));
    PC_TRY(pc_new(&d.gone, ctx, mesh->face_count));
    PC_TRY(pc_new(&d.owner, ctx, mesh->vertex_count));
    for (pc_index hole = 0; hole < count; hole++)
        PC_TRY(dig_hole(&d, ctx, hole, faces_each, &random));
    PC_TRY(drop_faces(mesh, ctx, d.gone));
done:
    pc_adjacency_free(&adjacency, ctx);
    pc_free(ctx, d.gone);
    pc_free(ctx, d.owner);
    pc_free(ctx, d.frontier);
    return status;
}

static pc_status random_order(pc_index **order, pc_context *ctx, pc_index count, pc_random *random) {
    pc_status status = pc_new(order, ctx, count);
    if (status != PC_OK) return status;
    for (pc_index i = 0; i < count; i++) {
        pc_index j = (pc_index)(pc_random_next(random) % (i + 1));
        (*order)[i] = (*order)[j];
        (*order)[j] = i;
    }
    return PC_OK;
}

pc_status pc_synth_shuffle(pc_mesh *mesh, pc_context *ctx, uint64_t seed) {
    pc_status status = PC_OK;
    pc_random random = {pc_hash64(seed)};
    pc_index *vertex = NULL, *face = NULL;
    pc_mesh old = {0};
    PC_TRY(pc_mesh_copy(&old, ctx, mesh));
    PC_TRY(random_order(&vertex, ctx, mesh->vertex_count, &random));
    PC_TRY(random_order(&face, ctx, mesh->face_count, &random));
    for (size_t v = 0; v < mesh->vertex_count; v++)
        pc_vec3_put(mesh->position, vertex[v], pc_vec3_at(old.position, v));
    for (size_t f = 0; f < mesh->face_count; f++) {
        size_t turn = pc_random_next(&random) % 3;
        for (size_t k = 0; k < 3; k++)
            mesh->triangle[3 * (size_t)face[f] + (k + turn) % 3] = vertex[old.triangle[3 * f + k]];
    }
done:
    pc_free(ctx, vertex);
    pc_free(ctx, face);
    pc_mesh_free(&old, ctx);
    return status;
}

/* The middle of an edge, or of the cubic that leaves both ends in their tangent planes. */
static pc_vec3 edge_middle(const pc_mesh *mesh, const double *normal, pc_index i, pc_index j) {
    pc_vec3 a = pc_vec3_at(mesh->position, i), b = pc_vec3_at(mesh->position, j);
    pc_vec3 middle = pc_scale(0.5, pc_add(a, b)), ab = pc_sub(b, a);
    if (!normal) return middle;
    pc_vec3 na = pc_vec3_at(normal, i), nb = pc_vec3_at(normal, j);
    middle = pc_madd(middle, -pc_dot(ab, na) / 8, na);
    return pc_madd(middle, pc_dot(ab, nb) / 8, nb);
}

pc_status pc_synth_subdivide(pc_mesh *mesh, pc_context *ctx, bool curved) {
    pc_status status = PC_OK;
    pc_adjacency adjacency = {0};
    pc_mesh fine = {0};
    double *normal = NULL;
    size_t old_count = mesh->vertex_count;
    PC_TRY(pc_adjacency_make(&adjacency, ctx, mesh));
    if (curved) PC_TRY(vertex_normals(&normal, ctx, mesh));
    PC_TRY(pc_mesh_make(&fine, ctx, old_count + adjacency.edge_count, 4 * (size_t)mesh->face_count));
    memcpy(fine.position, mesh->position, 3 * sizeof(double) * old_count);
#pragma omp parallel for schedule(static)
    for (pc_index e = 0; e < adjacency.edge_count; e++) {
        pc_index h = adjacency.edge_half[e];
        pc_vec3_put(fine.position, old_count + e,
                    edge_middle(mesh, normal, pc_tail(mesh, h), pc_head(mesh, h)));
    }
#pragma omp parallel for schedule(static)
    for (size_t f = 0; f < mesh->face_count; f++) {
        const pc_index *v = mesh->triangle + 3 * f, *e = adjacency.edge + 3 * f;
        pc_index n = (pc_index)old_count, m[3] = {n + e[0], n + e[1], n + e[2]};
        const pc_index four[12] = {v[0], m[0], m[2], m[0], v[1], m[1], m[2], m[1], v[2], m[0], m[1], m[2]};
        memcpy(fine.triangle + 12 * f, four, sizeof four);
    }
    pc_mesh_free(mesh, ctx);
    *mesh = fine;
    fine = (pc_mesh){0};
done:
    pc_free(ctx, normal);
    pc_adjacency_free(&adjacency, ctx);
    pc_mesh_free(&fine, ctx);
    return status;
}

/* Interior edges, no two of them sides of one face. Lists one half-edge of each. */
static pc_status pick_edges(pc_index **picked, pc_index *count, pc_context *ctx, const pc_mesh *mesh,
                            const pc_adjacency *adjacency, double fraction, pc_random *random) {
    pc_status status = PC_OK;
    uint8_t *taken = NULL;
    PC_TRY(pc_new(&taken, ctx, mesh->face_count));
    PC_TRY(pc_new(picked, ctx, adjacency->edge_count));
    *count = 0;
    for (pc_index e = 0; e < adjacency->edge_count; e++) {
        pc_index h = adjacency->edge_half[e], twin = adjacency->twin[h];
        bool wanted = pc_random_uniform(random) < fraction;
        if (!wanted || twin == PC_NONE || taken[h / 3] || taken[twin / 3]) continue;
        taken[h / 3] = taken[twin / 3] = 1;
        (*picked)[(*count)++] = h;
    }
done:
    pc_free(ctx, taken);
    return status;
}

pc_status pc_synth_needles(pc_mesh *mesh, pc_context *ctx, double fraction, uint64_t seed) {
    pc_status status = PC_OK;
    pc_random random = {pc_hash64(seed)};
    pc_adjacency adjacency = {0};
    pc_index *picked = NULL, count = 0;
    PC_TRY(pc_adjacency_make(&adjacency, ctx, mesh));
    PC_TRY(pick_edges(&picked, &count, ctx, mesh, &adjacency, fraction, &random));
    PC_TRY(pc_resize(&mesh->position, ctx, 3 * ((size_t)mesh->vertex_count + count)));
    PC_TRY(pc_resize(&mesh->triangle, ctx, 3 * ((size_t)mesh->face_count + 2 * (size_t)count)));
    for (pc_index i = 0; i < count; i++) {
        pc_index half[2] = {picked[i], adjacency.twin[picked[i]]}, v = mesh->vertex_count++;
        pc_vec3 a = pc_vec3_at(mesh->position, pc_tail(mesh, half[0]));
        pc_vec3 b = pc_vec3_at(mesh->position, pc_head(mesh, half[0]));
        double t = 1e-3 + 0.02 * pc_random_uniform(&random);
        pc_vec3_put(mesh->position, v, pc_madd(a, t, pc_sub(b, a)));
        for (int side = 0; side < 2; side++) { /* face (x, y, z) becomes (v, y, z) and (x, v, z) */
            pc_index h = half[side], *added = mesh->triangle + 3 * (size_t)mesh->face_count++;
            added[0] = pc_tail(mesh, h), added[1] = v, added[2] = pc_tail(mesh, pc_prev(h));
            mesh->triangle[h] = v;
        }
    }
done:
    pc_free(ctx, picked);
    pc_adjacency_free(&adjacency, ctx);
    return status;
}

pc_status pc_synth_append(pc_mesh *mesh, pc_context *ctx, const pc_mesh *other, pc_vec3 move) {
    pc_status status = PC_OK;
    size_t vertices = mesh->vertex_count, faces = mesh->face_count;
    PC_TRY(pc_resize(&mesh->position, ctx, 3 * (vertices + other->vertex_count)));
    PC_TRY(pc_resize(&mesh->triangle, ctx, 3 * (faces + other->face_count)));
    for (size_t v = 0; v < other->vertex_count; v++)
        pc_vec3_put(mesh->position, vertices + v, pc_add(pc_vec3_at(other->position, v), move));
    for (size_t c = 0; c < 3 * (size_t)other->face_count; c++)
        mesh->triangle[3 * faces + c] = other->triangle[c] + (pc_index)vertices;
    mesh->vertex_count += other->vertex_count;
    mesh->face_count += other->face_count;
done:
    return status;
}

pc_status pc_synth_unweld(pc_mesh *mesh, pc_context *ctx) {
    pc_mesh loose;
    size_t corners = 3 * (size_t)mesh->face_count;
    pc_status status = pc_mesh_make(&loose, ctx, corners, mesh->face_count);
    if (status != PC_OK) return status;
    for (size_t c = 0; c < corners; c++) {
        pc_vec3_put(loose.position, c, pc_vec3_at(mesh->position, mesh->triangle[c]));
        loose.triangle[c] = (pc_index)c;
    }
    pc_mesh_free(mesh, ctx);
    *mesh = loose;
    return PC_OK;
}

pc_status pc_synth_soup(pc_mesh *mesh, pc_context *ctx, pc_index vertices, pc_index faces, uint64_t seed) {
    pc_random random = {pc_hash64(seed)};
    if (vertices < 3) return pc_fail(ctx, PC_E_USAGE, "a triangle needs 3 vertices, not %u", vertices);
    pc_status status = pc_mesh_make(mesh, ctx, vertices, faces);
    if (status != PC_OK) return status;
    for (size_t i = 0; i < 3 * (size_t)vertices; i++)
        mesh->position[i] = pc_random_uniform(&random);
    for (size_t f = 0; f < faces; f++) {
        pc_index *t = mesh->triangle + 3 * f;
        t[0] = (pc_index)(pc_random_next(&random) % vertices);
        do
            t[1] = (pc_index)(pc_random_next(&random) % vertices);
        while (t[1] == t[0]);
        do
            t[2] = (pc_index)(pc_random_next(&random) % vertices);
        while (t[2] == t[0] || t[2] == t[1]);
    }
    return PC_OK;
}
