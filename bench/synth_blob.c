#include "synth_blob.h"
#include "memory.h"
#include "vec3.h"

/* Ring r lies around (2r, 0, 0) in the plane z = 0: neighbours touch along their tubes and melt there. */
#define RING_RADIUS 1.0
#define TUBE_RADIUS 0.4
#define MELT        0.25
#define MARGIN      0.3

static double ring(pc_vec3 p, double centre) {
    double x = p.x - centre, flat = sqrt(x * x + p.y * p.y) - RING_RADIUS;
    return sqrt(flat * flat + p.z * p.z) - TUBE_RADIUS * (1 + 0.15 * sin(2 * p.x + 3 * p.y));
}

/* The smaller of two, rounded off where they are close. */
static double melt(double a, double b) {
    double h = (MELT - fabs(a - b)) / MELT, least = a < b ? a : b;
    return h > 0 ? least - h * h * MELT / 4 : least;
}

static double blob(pc_vec3 p, pc_index genus) {
    if (genus == 0)
        return pc_norm(p) - 1 - 0.12 * sin(3 * p.x + 1) * cos(2.5 * p.y) - 0.08 * sin(4 * p.z + 2 * p.x);
    double nearest = floor(p.x / (2 * RING_RADIUS) + 0.5), value = INFINITY;
    for (int side = -1; side <= 1; side++) {
        double i = nearest + side;
        if (i < 0 || i >= genus) continue;
        double d = ring(p, 2 * RING_RADIUS * i);
        value = isinf(value) ? d : melt(value, d);
    }
    return isinf(value) ? ring(p, nearest < 0 ? 0 : 2 * (genus - 1.0)) : value;
}

static pc_vec3 blob_gradient(pc_vec3 p, pc_index genus) {
    const double h = 1e-5;
    double x = blob((pc_vec3){p.x + h, p.y, p.z}, genus) - blob((pc_vec3){p.x - h, p.y, p.z}, genus);
    double y = blob((pc_vec3){p.x, p.y + h, p.z}, genus) - blob((pc_vec3){p.x, p.y - h, p.z}, genus);
    double z = blob((pc_vec3){p.x, p.y, p.z + h}, genus) - blob((pc_vec3){p.x, p.y, p.z - h}, genus);
    return pc_scale(1 / (2 * h), (pc_vec3){x, y, z});
}

/* Two layers of the lattice, and the mesh that grows between them. */
typedef struct march {
    pc_mesh *mesh;
    pc_context *ctx;
    size_t vertex_room, face_room;
    pc_index size[3]; /* lattice points */
    pc_vec3 origin;
    double step;
    pc_index genus;
    double *value[2];    /* per point of the layer */
    pc_index *vertex[2]; /* per point of the layer and direction 1..7: the vertex on that lattice edge */
} march;

static pc_vec3 lattice_point(const march *m, pc_index i, pc_index j, pc_index k) {
    return pc_madd(m->origin, m->step, (pc_vec3){i, j, k});
}

static void fill_layer(march *m, int which, pc_index k) {
    size_t points = (size_t)m->size[0] * m->size[1];
    for (size_t e = 0; e < 8 * points; e++)
        m->vertex[which][e] = PC_NONE;
#pragma omp parallel for schedule(static)
    for (pc_index j = 0; j < m->size[1]; j++)
        for (pc_index i = 0; i < m->size[0]; i++) {
            double value = blob(lattice_point(m, i, j, k), m->genus);
            m->value[which][i + (size_t)j * m->size[0]] = value == 0 ? 1e-300 : value;
        }
}

/* The corner of a cell after the first `n` steps of a path that walks the axes in one of six orders. */
static int path_corner(int path, int n) {
    static const int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    int corner = 0;
    for (int i = 0; i < n; i++)
        corner |= 1 << order[path][i];
    return corner;
}

/* The vertex on the lattice edge from corner a to corner b (a is below b in every axis) of cell (i,j,k). */
static pc_status edge_vertex(pc_index *out, march *m, const pc_index cell[3], int a, int b) {
    size_t pa = cell[0] + (a & 1) + (size_t)(cell[1] + (a >> 1 & 1)) * m->size[0];
    size_t pb = cell[0] + (b & 1) + (size_t)(cell[1] + (b >> 1 & 1)) * m->size[0];
    pc_index *slot = m->vertex[a >> 2] + 8 * pa + (a ^ b);
    pc_status status = PC_OK;
    if (*slot == PC_NONE) {
        double va = m->value[a >> 2][pa], vb = m->value[b >> 2][pb], t = va / (va - vb);
        t = t < 0.1 ? 0.1 : t > 0.9 ? 0.9 : t;
        pc_vec3 p = lattice_point(m, cell[0] + (a & 1), cell[1] + (a >> 1 & 1), cell[2] + (a >> 2));
        pc_vec3 q = lattice_point(m, cell[0] + (b & 1), cell[1] + (b >> 1 & 1), cell[2] + (b >> 2));
        if (m->mesh->vertex_count == m->vertex_room) {
            m->vertex_room = 2 * m->vertex_room + 1024;
            PC_TRY(pc_resize(&m->mesh->position, m->ctx, 3 * m->vertex_room));
        }
        *slot = m->mesh->vertex_count++;
        pc_vec3_put(m->mesh->position, *slot, pc_madd(p, t, pc_sub(q, p)));
    }
    *out = *slot;
done:
    return status;
}

static pc_status add_face(march *m, pc_index a, pc_index b, pc_index c) {
    pc_status status = PC_OK;
    if (m->mesh->face_count == m->face_room) {
        m->face_room = 2 * m->face_room + 1024;
        PC_TRY(pc_resize(&m->mesh->triangle, m->ctx, 3 * m->face_room));
    }
    pc_index *t = m->mesh->triangle + 3 * (size_t)m->mesh->face_count++;
    t[0] = a, t[1] = b, t[2] = c;
done:
    return status;
}

/* Cuts one tetrahedron: `odd` tells whether its path walks the axes in an odd order. With the inside corners
 * named first, an even order sees the cut (ac, ad, bd, bc) or (ad, bd, cd) counter-clockwise from outside. */
static pc_status cut_tetrahedron(march *m, const pc_index cell[3], const int corner[4], int inside,
                                 bool odd) {
    pc_status status = PC_OK;
    int in[4], out[4], ins = 0, outs = 0;
    bool flip = odd;
    for (int i = 0; i < 4; i++) {
        if (inside >> i & 1) {
            flip = flip != (outs % 2 == 1);
            in[ins++] = i;
        } else {
            out[outs++] = i;
        }
    }
    pc_index v[4] = {0};
    int count = 0;
    for (int i = 0; i < ins; i++)
        for (int n = 0; n < outs; n++) {
            int j = i % 2 ? outs - 1 - n : n; /* ac ad bd bc */
            bool up = in[i] < out[j];
            int a = corner[up ? in[i] : out[j]], b = corner[up ? out[j] : in[i]];
            PC_TRY(edge_vertex(&v[count++], m, cell, a, b));
        }
    for (int i = 2; i < count; i++)
        PC_TRY(add_face(m, v[0], v[flip ? i : i - 1], v[flip ? i - 1 : i]));
done:
    return status;
}

static pc_status march_layer(march *m, pc_index k) {
    pc_status status = PC_OK;
    for (pc_index j = 0; j + 1 < m->size[1]; j++)
        for (pc_index i = 0; i + 1 < m->size[0]; i++) {
            const pc_index cell[3] = {i, j, k};
            int inside = 0;
            for (int c = 0; c < 8; c++) {
                size_t at = i + (c & 1) + (size_t)(j + (c >> 1 & 1)) * m->size[0];
                inside |= (m->value[c >> 2][at] < 0) << c;
            }
            if (inside == 0 || inside == 255) continue;
            for (int path = 0; path < 6; path++) {
                int corner[4], mask = 0;
                for (int n = 0; n < 4; n++) {
                    corner[n] = path_corner(path, n);
                    mask |= (inside >> corner[n] & 1) << n;
                }
                if (mask != 0 && mask != 15) PC_TRY(cut_tetrahedron(m, cell, corner, mask, path >= 3));
            }
        }
done:
    return status;
}

/* Each vertex goes to the mean of its neighbours, then back along the gradient: slivers of the lattice even
 * out. */
static pc_status even_out(pc_mesh *mesh, pc_context *ctx, pc_index genus) {
    pc_status status = PC_OK;
    double *sum = NULL;
    pc_index *count = NULL;
    PC_TRY(pc_new(&sum, ctx, 3 * (size_t)mesh->vertex_count));
    PC_TRY(pc_new(&count, ctx, mesh->vertex_count));
    for (pc_index h = 0; h < 3 * mesh->face_count; h++) {
        pc_index a = pc_tail(mesh, h), b = pc_head(mesh, h);
        pc_vec3_put(sum, a, pc_add(pc_vec3_at(sum, a), pc_vec3_at(mesh->position, b)));
        count[a]++;
    }
#pragma omp parallel for schedule(static)
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        pc_vec3 p = pc_scale(1.0 / count[v], pc_vec3_at(sum, v));
        for (int i = 0; i < 3; i++) {
            pc_vec3 g = blob_gradient(p, genus);
            double g2 = pc_dot(g, g);
            if (g2 > 1e-6) p = pc_madd(p, -blob(p, genus) / g2, g);
        }
        pc_vec3_put(mesh->position, v, p);
    }
done:
    pc_free(ctx, sum);
    pc_free(ctx, count);
    return status;
}

pc_status pc_synth_blob(pc_mesh *mesh, pc_context *ctx, pc_index genus, pc_index steps) {
    pc_status status = PC_OK;
    *mesh = (pc_mesh){0};
    if (steps < 6) return pc_fail(ctx, PC_E_USAGE, "a blob needs 6 steps per unit or more, not %u", steps);
    double reach = genus ? RING_RADIUS + 1.2 * TUBE_RADIUS + MARGIN : 1.5 + MARGIN;
    double high = genus ? 1.2 * TUBE_RADIUS + MARGIN : reach,
           last = genus ? 2 * RING_RADIUS * (genus - 1.0) : 0;
    march m = {
        .mesh = mesh, .ctx = ctx, .step = 1.0 / steps, .genus = genus, .origin = {-reach, -reach, -high}};
    m.size[0] = (pc_index)((2 * reach + last) * steps) + 2;
    m.size[1] = (pc_index)(2 * reach * steps) + 2;
    m.size[2] = (pc_index)(2 * high * steps) + 2;
    size_t points = (size_t)m.size[0] * m.size[1];
    for (int i = 0; i < 2; i++) {
        PC_TRY(pc_new(&m.value[i], ctx, points));
        PC_TRY(pc_new(&m.vertex[i], ctx, 8 * points));
    }
    fill_layer(&m, 0, 0);
    for (pc_index k = 0; k + 1 < m.size[2]; k++) {
        fill_layer(&m, 1, k + 1);
        PC_TRY(march_layer(&m, k));
        double *value = m.value[0];
        pc_index *vertex = m.vertex[0];
        m.value[0] = m.value[1], m.value[1] = value;
        m.vertex[0] = m.vertex[1], m.vertex[1] = vertex;
    }
    for (int round = 0; round < 3; round++)
        PC_TRY(even_out(mesh, ctx, genus));
done:
    for (int i = 0; i < 2; i++) {
        pc_free(ctx, m.value[i]);
        pc_free(ctx, m.vertex[i]);
    }
    if (status != PC_OK) pc_mesh_free(mesh, ctx);
    return status;
}
