#include "ringmesh.h"
#include "memory.h"
#include "tmesh.h"
#include "vec3.h"
#include <string.h>

pc_status pc_ringmesh_make(pc_ringmesh *ring, pc_context *ctx, size_t faces, size_t vertices, size_t width) {
    pc_status status = PC_OK;
    *ring = (pc_ringmesh){.width = (pc_index)width};
    PC_TRY(pc_new(&ring->face, ctx, faces));
    PC_TRY(pc_new(&ring->vertex, ctx, vertices));
    PC_TRY(pc_new(&ring->row, ctx, vertices * width));
done:
    if (status != PC_OK) pc_ringmesh_free(ring, ctx);
    return status;
}

void pc_ringmesh_free(pc_ringmesh *ring, pc_context *ctx) {
    pc_free(ctx, ring->face);
    pc_free(ctx, ring->vertex);
    pc_free(ctx, ring->row);
    *ring = (pc_ringmesh){0};
}

static inline double *row_of(const pc_ringmesh *ring, pc_index v) {
    return ring->row + (size_t)v * ring->width;
}

static void add_row(double *to, double weight, const double *row, pc_index width) {
    for (pc_index i = 0; i < width; i++)
        to[i] += weight * row[i];
}

/* At corner c of a face: the intervals of the side that leaves it in the given direction (0: along side c,
 * 1: along the side before, backwards), of the one behind, and of the one ahead. */
typedef struct reach {
    double behind, own, ahead;
} reach;

static reach reach_from(const pc_ringface *face, int c, int direction) {
    int p = (c + 3) & 3;
    if (direction == 0) return (reach){face->behind[c], face->interval[c], face->ahead[c]};
    return (reach){face->ahead[p], face->interval[p], face->behind[p]};
}

/* Halfway along a side of knots: the share of its near end. */
static double halfway_share(reach r) {
    return (r.own + 2 * r.ahead) / (2 * (r.behind + r.own + r.ahead));
}

static void add_face_point(double *to, double weight, const pc_ringmesh *ring, pc_index f) {
    const pc_ringface *face = ring->face + f;
    for (int c = 0; c < 4; c++)
        add_row(to, weight * halfway_share(reach_from(face, c, 0)) * halfway_share(reach_from(face, c, 1)),
                row_of(ring, face->vertex[c]), ring->width);
}

static void add_middle(double *to, double weight, const pc_ringmesh *ring, pc_ringcorner at) {
    const pc_ringface *face = ring->face + at.face;
    double share = halfway_share(reach_from(face, at.corner, 0));
    add_row(to, weight * share, row_of(ring, face->vertex[at.corner]), ring->width);
    add_row(to, weight * (1 - share), row_of(ring, face->vertex[(at.corner + 1) & 3]), ring->width);
}

static void set_edge_point(double *to, const pc_ringmesh *ring, pc_ringcorner at) {
    const pc_ringface *face = ring->face + at.face;
    pc_index other = face->near[at.corner];
    double up = face->interval[(at.corner + 1) & 3];
    double down = ring->face[other].interval[(face->near_side[at.corner] + 1) & 3];
    add_middle(to, 0.5, ring, at);
    add_face_point(to, 0.5 * down / (up + down), ring, at.face);
    add_face_point(to, 0.5 * up / (up + down), ring, other);
}

/* Faces around the vertex at a corner, counter-clockwise from that one. */
enum { MOST_AROUND = PC_TMESH_VALENCE };

static int faces_around(pc_ringcorner around[MOST_AROUND], const pc_ringmesh *ring, pc_ringcorner at) {
    int n = 0;
    pc_ringcorner now = at;
    do {
        around[n++] = now;
        now = pc_ringmesh_ccw(ring, now);
    } while (n < MOST_AROUND && now.face != PC_NONE && (now.face != at.face || now.corner != at.corner));
    return n;
}

static void set_vertex_point(double *to, const pc_ringmesh *ring, pc_ringcorner at) {
    pc_ringcorner around[MOST_AROUND];
    double d[MOST_AROUND], sum = 0;
    int n = faces_around(around, ring, at);
    for (int i = 0; i < n; i++)
        d[i] = ring->face[around[i].face].interval[around[i].corner];
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < n; i++) {
            double before = d[(i + n - 1) % n], after = d[(i + 1) % n], last = d[(i + n - 2) % n];
            double later = d[(i + 2) % n];
            double middle = 0.5 * (before + after) * (last + later), face = before * later;
            if (pass == 0) {
                sum += middle + face;
            } else {
                add_middle(to, 3.0 / n * middle / sum, ring, around[i]);
                add_face_point(to, 3.0 / n * face / sum, ring, around[i].face);
            }
        }
    add_row(to, (n - 3.0) / n, row_of(ring, ring->face[at.face].vertex[at.corner]), ring->width);
}

/* The parts of the faces and where their new vertices are. */
typedef struct division {
    const pc_ringmesh *ring;
    pc_ringmesh *finer;
    pc_index *part;   /* 4 per face: the part at its corner c, or PC_NONE */
    pc_index *centre; /* per face */
    pc_index *middle; /* 4 per face: per side */
    pc_index *corner; /* per vertex */
} division;

static pc_index middle_of(division *d, pc_ringcorner at) {
    pc_index *slot = d->middle + 4 * (size_t)at.face + at.corner;
    const pc_ringface *face = d->ring->face + at.face;
    if (*slot == PC_NONE) {
        *slot = d->finer->vertex_count++;
        if (face->near[at.corner] != PC_NONE)
            d->middle[4 * (size_t)face->near[at.corner] + face->near_side[at.corner]] = *slot;
        set_edge_point(row_of(d->finer, *slot), d->ring, at);
    }
    return *slot;
}

static pc_index centre_of(division *d, pc_index f) {
    if (d->centre[f] == PC_NONE) {
        d->centre[f] = d->finer->vertex_count++;
        add_face_point(row_of(d->finer, d->centre[f]), 1, d->ring, f);
    }
    return d->centre[f];
}

static pc_index corner_of(division *d, pc_ringcorner at) {
    pc_index v = d->ring->face[at.face].vertex[at.corner];
    if (d->corner[v] == PC_NONE) {
        d->corner[v] = d->finer->vertex_count++;
        d->finer->vertex[d->corner[v]] = d->ring->vertex[v];
        set_vertex_point(row_of(d->finer, d->corner[v]), d->ring, at);
    }
    return d->corner[v];
}

/* The part of a face at corner c, turned so that its sides run as the face's. Its own side 0 leaves the
 * corner along side c. */
static void fill_part(division *d, pc_ringcorner at) {
    const pc_ringface *face = d->ring->face + at.face;
    int c = at.corner, before = (c + 3) & 3, after = (c + 1) & 3, across = (c + 2) & 3;
    pc_ringface own;
    own.vertex[0] = corner_of(d, at);
    own.vertex[1] = middle_of(d, at);
    own.vertex[2] = centre_of(d, at.face);
    own.vertex[3] = middle_of(d, (pc_ringcorner){at.face, before});
    double along = face->interval[c] / 2, up = face->interval[after] / 2;
    /* Beyond the sides: the neighbours' halves. */
    double below = (face->behind[after] + face->ahead[before]) / 4;
    double left = (face->behind[c] + face->ahead[across]) / 4;
    const double interval[4] = {along, up, along, up};
    const double ahead[4] = {along, up, left, face->ahead[before] / 2};
    const double behind[4] = {face->behind[c] / 2, below, along, up};
    const pc_index *part = d->part + 4 * (size_t)at.face;
    pc_index below_face = face->near[c], left_face = face->near[before];
    pc_index near[4] = {PC_NONE, part[after], part[before], PC_NONE};
    uint8_t near_side[4] = {0, 2, 1, 0}, near_corner[4] = {0, (uint8_t)after, (uint8_t)before, 0};
    if (below_face != PC_NONE) {
        near_corner[0] = (face->near_side[c] + 1) & 3;
        near[0] = d->part[4 * (size_t)below_face + near_corner[0]];
        near_side[0] = 3;
    }
    if (left_face != PC_NONE) {
        near_corner[3] = face->near_side[before];
        near[3] = d->part[4 * (size_t)left_face + near_corner[3]];
        near_side[3] = 0;
    }
    pc_ringface *to = d->finer->face + part[c];
    for (int m = 0; m < 4; m++) {
        int k = (m + 4 - c) & 3;
        to->vertex[m] = own.vertex[k];
        to->interval[m] = interval[k];
        to->ahead[m] = ahead[k];
        to->behind[m] = behind[k];
        to->near[m] = near[k];
        to->near_side[m] = (uint8_t)((near_side[k] + near_corner[k]) & 3);
    }
}

pc_status pc_ringmesh_subdivide(pc_ringmesh *finer, pc_index middle[4], pc_context *ctx,
                                const pc_ringmesh *ring) {
    pc_status status = PC_OK;
    division d = {.ring = ring, .finer = finer};
    size_t faces = ring->face_count;
    PC_TRY(pc_ringmesh_make(finer, ctx, 4 * faces, 5 * faces + ring->vertex_count, ring->width));
    PC_TRY(pc_new(&d.part, ctx, 4 * faces));
    PC_TRY(pc_new(&d.centre, ctx, faces));
    PC_TRY(pc_new(&d.middle, ctx, 4 * faces));
    PC_TRY(pc_new(&d.corner, ctx, ring->vertex_count));
    memset(d.centre, 0xff, faces * sizeof *d.centre);
    memset(d.middle, 0xff, 4 * faces * sizeof *d.middle);
    memset(d.corner, 0xff, ring->vertex_count * sizeof *d.corner);
    for (size_t i = 0; i < 4 * faces; i++) { /* the middle face comes first, and its parts */
        bool wanted = false;
        for (int k = 0; k < 4; k++)
            wanted = wanted || ring->face[0].vertex[k] == ring->face[i / 4].vertex[i % 4];
        d.part[i] = wanted ? finer->face_count++ : PC_NONE;
    }
    for (pc_index i = 0; i < 4 * faces; i++)
        if (d.part[i] != PC_NONE) fill_part(&d, (pc_ringcorner){i / 4, (int)(i % 4)});
    memcpy(middle, d.part, 4 * sizeof *middle);
done:
    pc_free(ctx, d.part);
    pc_free(ctx, d.centre);
    pc_free(ctx, d.middle);
    pc_free(ctx, d.corner);
    if (status != PC_OK) pc_ringmesh_free(finer, ctx);
    return status;
}

pc_status pc_ringmesh_around(pc_ringmesh *part, pc_context *ctx, const pc_ringmesh *ring, pc_index f) {
    pc_status status = PC_OK;
    pc_index *face = NULL, *vertex = NULL, count = 0;
    PC_TRY(pc_ringmesh_make(part, ctx, ring->face_count, ring->vertex_count, ring->width));
    PC_TRY(pc_new(&face, ctx, ring->face_count));
    PC_TRY(pc_new(&vertex, ctx, ring->vertex_count));
    memset(face, 0xff, ring->face_count * sizeof *face);
    memset(vertex, 0xff, ring->vertex_count * sizeof *vertex);
    face[f] = count++;
    for (pc_index g = 0; g < ring->face_count; g++)
        for (int k = 0; k < 16 && face[g] == PC_NONE; k++)
            if (ring->face[g].vertex[k / 4] == ring->face[f].vertex[k % 4]) face[g] = count++;
    part->face_count = count;
    for (pc_index g = 0; g < ring->face_count; g++) {
        if (face[g] == PC_NONE) continue;
        pc_ringface *to = part->face + face[g];
        *to = ring->face[g];
        for (int k = 0; k < 4; k++) {
            pc_index *v = vertex + to->vertex[k];
            if (*v == PC_NONE) {
                *v = part->vertex_count++;
                part->vertex[*v] = ring->vertex[to->vertex[k]];
                memcpy(row_of(part, *v), row_of(ring, to->vertex[k]), ring->width * sizeof(double));
            }
            to->vertex[k] = *v;
            if (to->near[k] != PC_NONE) to->near[k] = face[to->near[k]];
        }
    }
done:
    pc_free(ctx, face);
    pc_free(ctx, vertex);
    if (status != PC_OK) pc_ringmesh_free(part, ctx);
    return status;
}

/* The inner Bezier point of a face at one of its corners. */
static void add_inner(double *to, double weight, const pc_ringmesh *ring, pc_ringcorner at) {
    const pc_ringface *face = ring->face + at.face;
    double far[2];
    for (int k = 0; k < 2; k++) {
        reach r = reach_from(face, at.corner, k);
        far[k] = r.behind / (r.behind + r.own + r.ahead);
    }
    double share[4] = {(1 - far[0]) * (1 - far[1]), far[0] * (1 - far[1]), far[0] * far[1],
                       (1 - far[0]) * far[1]};
    if (ring->vertex[face->vertex[at.corner]].extraordinary) {
        pc_ringcorner around[MOST_AROUND];
        double n = faces_around(around, ring, at);
        share[0] = n / (n + 5), share[1] = share[3] = 2 / (n + 5), share[2] = 1 / (n + 5);
    }
    for (int k = 0; k < 4; k++)
        add_row(to, weight * share[k], row_of(ring, face->vertex[(at.corner + k) & 3]), ring->width);
}

/* The point on side `at.corner` next to its first or its last end, from the inner points of both faces. */
static void set_side_point(double *to, const pc_ringmesh *ring, pc_ringcorner at, bool last) {
    const pc_ringface *face = ring->face + at.face;
    pc_index other = face->near[at.corner];
    int side = face->near_side[at.corner];
    double up = face->interval[(at.corner + 1) & 3], down = ring->face[other].interval[(side + 1) & 3];
    add_inner(to, down / (up + down), ring, (pc_ringcorner){at.face, (at.corner + last) & 3});
    add_inner(to, up / (up + down), ring, (pc_ringcorner){other, (side + !last) & 3});
}

static void set_corner_point(double *to, const pc_ringmesh *ring, pc_ringcorner at) {
    pc_ringcorner around[MOST_AROUND] = {{0, 0}};
    double d[4];
    faces_around(around, ring, at); /* four: the vertex is regular */
    for (int i = 0; i < 4; i++)
        d[i] = ring->face[around[i].face].interval[around[i].corner];
    for (int i = 0; i < 4; i++)
        add_inner(to, d[(i + 2) & 3] * d[(i + 3) & 3] / ((d[0] + d[2]) * (d[1] + d[3])), ring, around[i]);
}

/* Limit position and, along spoke k from the vertex, a third of the derivative (k = -1: none). The face at
 * `around[i]` is between spokes i and i+1. */
static void set_limit(double *to, const pc_ringmesh *ring, const pc_ringcorner *around, int n, int spoke) {
    double turn = 2 * PC_PI / n, c1 = cos(turn), c2 = cos(turn / 2);
    double root = sqrt(2 * (9 + c1)), edge = 1 + c1 + c2 * root;
    double scale = (5 + c1 + c2 * root) / 16 / sqrt(4 + c2 * c2) / (3 * n * c2);
    for (int i = 0; i < n; i++) {
        const pc_ringface *face = ring->face + around[i].face;
        double near = 4.0 / (n * (n + 5.0)), far = 1.0 / (n * (n + 5.0));
        if (spoke >= 0) {
            near += scale * edge * cos(turn * (i - spoke));
            far += scale * (cos(turn * (i - spoke)) + cos(turn * (i + 1 - spoke)));
        }
        add_row(to, near, row_of(ring, face->vertex[(around[i].corner + 1) & 3]), ring->width);
        add_row(to, far, row_of(ring, face->vertex[(around[i].corner + 2) & 3]), ring->width);
    }
    add_row(to, n / (n + 5.0), row_of(ring, ring->face[around[0].face].vertex[around[0].corner]),
            ring->width);
}

void pc_ringmesh_bezier(double *weight, const pc_ringmesh *ring) {
    static const int corner[4] = {0, 3, 15, 12}, inner[4] = {5, 6, 10, 9};
    static const int leaving[4] = {1, 7, 14, 8}, arriving[4] = {2, 11, 13, 4}; /* on side c */
    size_t width = ring->width;
    memset(weight, 0, 16 * width * sizeof(double));
    for (int c = 0; c < 4; c++) {
        pc_ringcorner at = {0, c}, before = {0, (c + 3) & 3}, around[MOST_AROUND];
        double *leave = weight + width * (size_t)leaving[c];
        double *arrive = weight + width * (size_t)arriving[before.corner];
        add_inner(weight + width * (size_t)inner[c], 1, ring, at);
        if (ring->vertex[ring->face[0].vertex[c]].extraordinary) {
            int n = faces_around(around, ring, at);
            set_limit(weight + width * (size_t)corner[c], ring, around, n, -1);
            set_limit(leave, ring, around, n, 0);
            set_limit(arrive, ring, around, n, 1);
        } else {
            set_corner_point(weight + width * (size_t)corner[c], ring, at);
            set_side_point(leave, ring, at, false);
            set_side_point(arrive, ring, before, true);
        }
    }
}
