#include "overlay.h"
#include "memory.h"
#include "transition.h"
#include "vec3.h"
#include <string.h>

enum { GRAIN = 4096, MOST_CORNERS = 16 };

/* Where iso-lines meet an edge i -> j, in i's frame: at most one s-line and one t-line. */
typedef struct edge_points {
    pc_index first_vertex; /* of the overlay; the second follows */
    uint8_t count;
    uint8_t family[2]; /* 0: an s-line, 1: a t-line; ordered from i to j */
} edge_points;

typedef struct drawing {
    const pc_mesh *mesh;
    pc_index first_cone;
    const pc_adjacency *adjacency;
    const pc_param *param;
    pc_overlay *overlay;
    edge_points *points;  /* per edge of the scan */
    pc_index *first_face; /* per scan face: its first triangle of the overlay; one more at the end */
    pc_index *crossing;   /* per scan face: the vertex where its chords cross, PC_NONE */
} drawing;

/* Where the families of lines keep apart: everywhere but in field singularities without a cone. */
static bool is_drawable(const pc_param *param, pc_index f) {
    return param->singular[f] != PC_FIELD_SINGULARITY;
}

static bool is_cone(const drawing *d, pc_index v) {
    return v >= d->first_cone;
}

/* The half-edge in whose tail's frame the points of an edge are told: never a cone's, whose frame is
 * ambiguous. */
static pc_index base_half(const drawing *d, pc_index e) {
    pc_index h = d->adjacency->edge_half[e];
    return is_cone(d, pc_tail(d->mesh, h)) ? d->adjacency->twin[h] : h;
}

/* The period boundary strictly between two odd numbers less than a period apart; false if there is none. */
static bool crossed_line(int64_t *line, int64_t from, int64_t to) {
    int64_t low = from < to ? from : to, high = from < to ? to : from;
    int64_t period = high >= 0 ? high / PC_PERIOD : -((PC_PERIOD - 1 - high) / PC_PERIOD);
    *line = period * PC_PERIOD;
    return *line > low && *line < high;
}

static void find_edge_points(const drawing *d, pc_index e, double abscissa[2]) {
    edge_points *points = &d->points[e];
    pc_index h = base_half(d, e), twin = d->adjacency->twin[h];
    *points = (edge_points){.first_vertex = PC_NONE};
    if (!is_drawable(d->param, h / 3) && (twin == PC_NONE || !is_drawable(d->param, twin / 3))) return;
    const int32_t *c = d->param->coordinate;
    size_t i = pc_tail(d->mesh, h), j = pc_head(d->mesh, h);
    pc_point2 p = {c[2 * i], c[2 * i + 1]};
    pc_point2 q = pc_transition_apply(pc_transition_of(d->param, h), (pc_point2){c[2 * j], c[2 * j + 1]});
    int64_t line[2], over[2], span[2] = {q.s - p.s, q.t - p.t};
    bool met[2] = {crossed_line(&line[0], p.s, q.s), crossed_line(&line[1], p.t, q.t)};
    over[0] = line[0] - p.s, over[1] = line[1] - p.t;
    for (int k = 0; k < 2; k++) {
        if (span[k] < 0) span[k] = -span[k], over[k] = -over[k];
        if (met[k]) points->family[points->count++] = (uint8_t)k;
    }
    /* over/span < 2^25: the products are exact. A tie (a crossing on the edge itself) puts the s-line first.
     */
    if (points->count == 2 && over[1] * span[0] < over[0] * span[1])
        points->family[0] = 1, points->family[1] = 0;
    for (int k = 0; k < points->count; k++)
        abscissa[k] = (double)over[points->family[k]] / (double)span[points->family[k]];
}

/* ---- one triangle: corners and edge points around it, chords between them ---- */

typedef struct ring {
    int count;
    pc_index vertex[MOST_CORNERS];
    uint8_t lines[MOST_CORNERS]; /* the straight lines a vertex is on: bits 0-2 the sides of the face, 3 and 4
                                    chords */
} ring;

enum { CHORD_LINES = 3 };

static void append(ring *around, pc_index vertex, int lines) {
    around->vertex[around->count] = vertex;
    around->lines[around->count++] = (uint8_t)lines;
}

typedef struct chord {
    int end[2]; /* positions on the ring; end[0] < end[1] */
    bool present;
} chord;

/* Quarter turns, modulo 2, between the frame of the face's first corner and that of corner k. */
static int frame_parity(const pc_param *param, pc_index f, int k) {
    size_t h = 3 * (size_t)f;
    return k == 0 ? 0 : k == 1 ? param->turn[h] & 1 : param->turn[h + 2] & 1;
}

/* Joins the ends of one family. Two make a chord; a single one in a face with a cone ends there; of the three
 * that a dislocation may leave, the two that are closest go on and the third ends. */
static void join_ends(chord *line, const int end[3], int count, int cone_position, const ring *around,
                      const double *position) {
    line->present = count >= 2 || (count == 1 && cone_position >= 0);
    if (!line->present) return;
    int a = end[0], b = count == 1 ? cone_position : end[1];
    double best = INFINITY;
    for (int skip = 0; count == 3 && skip < 3; skip++) {
        int p = end[skip == 0 ? 1 : 0], q = end[skip == 2 ? 1 : 2];
        double length =
            pc_distance(pc_vec3_at(position, around->vertex[p]), pc_vec3_at(position, around->vertex[q]));
        if (length < best) best = length, a = p, b = q;
    }
    line->end[0] = a < b ? a : b, line->end[1] = a < b ? b : a;
}

static void walk_ring(ring *around, chord chords[2], const drawing *d, pc_index f) {
    around->count = 0;
    chords[0] = chords[1] = (chord){.present = false};
    int ends[2] = {0, 0}, end[2][3], cone_position = -1;
    for (int k = 0; k < 3; k++) {
        pc_index h = 3 * f + (pc_index)k, e = d->adjacency->edge[h];
        const edge_points *points = &d->points[e];
        bool forward = base_half(d, e) == h;
        int parity = frame_parity(d->param, f, forward ? k : (k + 1) % 3);
        if (is_cone(d, d->mesh->triangle[h])) cone_position = around->count;
        append(around, d->mesh->triangle[h], 1 << k | 1 << (k + 2) % 3);
        for (int a = 0; a < points->count; a++) {
            int b = forward ? a : points->count - 1 - a, family = points->family[b] ^ parity;
            end[family][ends[family]++] = around->count;
            append(around, points->first_vertex + (pc_index)b, 1 << k);
        }
    }
    for (int family = 0; family < 2 && is_drawable(d->param, f); family++)
        join_ends(&chords[family], end[family], ends[family], cone_position, around,
                  d->overlay->mesh.position);
    for (int i = 0; i < 4; i++)
        if (chords[i / 2].present)
            around->lines[chords[i / 2].end[i % 2]] |= (uint8_t)(1 << (CHORD_LINES + i / 2));
}

static bool chords_cross(const chord chords[2]) {
    if (!chords[0].present || !chords[1].present) return false;
    int a = chords[0].end[0], b = chords[0].end[1], c = chords[1].end[0], e = chords[1].end[1];
    return (a < c && c < b && b < e) || (c < a && a < e && e < b);
}

typedef struct drawn_pairs {
    int count;
    pc_index pair[4][2];
} drawn_pairs;

static void add_pair(drawn_pairs *pairs, pc_index a, pc_index b) {
    pairs->pair[pairs->count][0] = a, pairs->pair[pairs->count++][1] = b;
}

static bool is_pair(const drawn_pairs *pairs, pc_index a, pc_index b) {
    for (int i = 0; i < pairs->count; i++)
        if ((pairs->pair[i][0] == a && pairs->pair[i][1] == b) ||
            (pairs->pair[i][0] == b && pairs->pair[i][1] == a))
            return true;
    return false;
}

/* Cuts a ring along the line from position a to position b, by way of `through` unless that is PC_NONE. */
static void cut_ring(ring *left, ring *right, const ring *whole, int a, int b, pc_index through) {
    const int both = 3 << CHORD_LINES;
    left->count = right->count = 0;
    for (int i = 0; i < whole->count; i++) {
        if (i <= a || i >= b) append(left, whole->vertex[i], whole->lines[i]);
        if (i == a && through != PC_NONE) append(left, through, both);
        if (i >= a && i <= b) append(right, whole->vertex[i], whole->lines[i]);
    }
    if (through != PC_NONE) append(right, through, both);
}

static int position_of(const ring *around, pc_index vertex) {
    for (int i = 0; i < around->count; i++)
        if (around->vertex[i] == vertex) return i;
    return -1;
}

static double ear_quality(const double *position, pc_index a, pc_index b, pc_index c) {
    pc_vec3 p = pc_vec3_at(position, a), q = pc_vec3_at(position, b), r = pc_vec3_at(position, c);
    pc_vec3 u = pc_sub(q, p), v = pc_sub(r, p), w = pc_sub(r, q);
    double longest = fmax(pc_dot(u, u), fmax(pc_dot(v, v), pc_dot(w, w)));
    return longest > 0 ? pc_norm(pc_cross(u, v)) / longest : 0;
}

/* Triangulates a convex ring, best ear first; writes triangles and their drawn half-edges from face *at on.
 * No cut joins two vertices of a line: it would lie on the line, and could be there already on its other
 * side. A ring of three lines or more always has an ear left. */
static void emit_ring(const drawing *d, ring around, const drawn_pairs *pairs, pc_index source,
                      pc_index *at) {
    pc_overlay *o = d->overlay;
    while (around.count >= 3) {
        int best = 0;
        double best_quality = -1;
        for (int i = 0; i < around.count; i++) {
            const pc_index *v = around.vertex;
            int before = (i + around.count - 1) % around.count, after = (i + 1) % around.count;
            if (around.count > 3 && (around.lines[before] & around.lines[after])) continue;
            double quality = ear_quality(o->mesh.position, v[before], v[i], v[after]);
            if (quality > best_quality) best = i, best_quality = quality;
        }
        pc_index *t = o->mesh.triangle + 3 * (size_t)*at;
        for (int k = 0; k < 3; k++)
            t[k] = around.vertex[(best + around.count - 1 + k) % around.count];
        for (int k = 0; k < 3; k++)
            o->drawn[3 * (size_t)*at + (size_t)k] = is_pair(pairs, t[k], t[(k + 1) % 3]);
        o->source_face[(*at)++] = source;
        around.count--;
        memmove(around.vertex + best, around.vertex + best + 1,
                sizeof(pc_index) * (size_t)(around.count - best));
        memmove(around.lines + best, around.lines + best + 1, (size_t)(around.count - best));
    }
}

/* The point of both lines, computed along the s-chord; kept off its ends where rounding would reach them. */
static void place_crossing(const drawing *d, pc_index f, const ring *around, const chord *s_chord) {
    pc_point2 corner[3];
    pc_param_corners(corner, d->param, d->mesh->triangle, f);
    pc_vec3 p0 = pc_vec3_at(d->mesh->position, d->mesh->triangle[3 * (size_t)f]);
    pc_vec3 e1 = pc_sub(pc_vec3_at(d->mesh->position, d->mesh->triangle[3 * (size_t)f + 1]), p0);
    pc_vec3 e2 = pc_sub(pc_vec3_at(d->mesh->position, d->mesh->triangle[3 * (size_t)f + 2]), p0);
    double s1 = (double)(corner[1].s - corner[0].s), t1 = (double)(corner[1].t - corner[0].t);
    double s2 = (double)(corner[2].s - corner[0].s), t2 = (double)(corner[2].t - corner[0].t);
    double det = s1 * t2 - s2 * t1;
    pc_vec3 a = pc_vec3_at(d->overlay->mesh.position, around->vertex[s_chord->end[0]]);
    pc_vec3 b = pc_vec3_at(d->overlay->mesh.position, around->vertex[s_chord->end[1]]);
    double fraction = 0.5;
    int64_t line_s, line_t;
    int64_t low_s = corner[0].s, high_s = low_s, low_t = corner[0].t, high_t = low_t;
    for (int k = 1; k < 3; k++) {
        low_s = corner[k].s < low_s ? corner[k].s : low_s,
        high_s = corner[k].s > high_s ? corner[k].s : high_s;
        low_t = corner[k].t < low_t ? corner[k].t : low_t,
        high_t = corner[k].t > high_t ? corner[k].t : high_t;
    }
    pc_vec3 ab = pc_sub(b, a);
    if (det != 0 && pc_dot(ab, ab) > 0 && crossed_line(&line_s, low_s, high_s) &&
        crossed_line(&line_t, low_t, high_t)) {
        double ds = (double)(line_s - corner[0].s), dt = (double)(line_t - corner[0].t);
        pc_vec3 x = pc_madd(pc_madd(p0, (ds * t2 - dt * s2) / det, e1), (s1 * dt - t1 * ds) / det, e2);
        fraction = pc_dot(pc_sub(x, a), ab) / pc_dot(ab, ab);
    }
    fraction = fmin(fmax(fraction, 1e-3), 1 - 1e-3);
    pc_vec3_put(d->overlay->mesh.position, d->crossing[f], pc_madd(a, fraction, ab));
}

static void draw_face(const drawing *d, pc_index f) {
    ring around, half[2], quarter[2];
    chord chords[2];
    drawn_pairs pairs = {0};
    pc_index at = d->first_face[f], x = d->crossing[f];
    walk_ring(&around, chords, d, f);
    if (!chords[0].present && !chords[1].present) {
        emit_ring(d, around, &pairs, f, &at);
        return;
    }
    if (x != PC_NONE) place_crossing(d, f, &around, &chords[0]);
    int first = chords[0].present ? 0 : 1;
    pc_index a = around.vertex[chords[first].end[0]], b = around.vertex[chords[first].end[1]];
    cut_ring(&half[0], &half[1], &around, chords[first].end[0], chords[first].end[1], x);
    if (x == PC_NONE)
        add_pair(&pairs, a, b);
    else
        add_pair(&pairs, a, x), add_pair(&pairs, x, b);
    bool second = first == 0 && chords[1].present;
    pc_index c = second ? around.vertex[chords[1].end[0]] : PC_NONE;
    pc_index e = second ? around.vertex[chords[1].end[1]] : PC_NONE;
    if (second && x == PC_NONE) add_pair(&pairs, c, e);
    if (second && x != PC_NONE) add_pair(&pairs, c, x), add_pair(&pairs, x, e);
    for (int k = 0; k < 2; k++) {
        /* In each half: the second chord as a whole, its piece up to the crossing, or nothing of it. */
        int from = second ? position_of(&half[k], c) : -1, to = second ? position_of(&half[k], e) : -1;
        if (x != PC_NONE && from < 0) from = position_of(&half[k], x);
        if (x != PC_NONE && to < 0) to = position_of(&half[k], x);
        if (from < 0 || to < 0) {
            emit_ring(d, half[k], &pairs, f, &at);
            continue;
        }
        cut_ring(&quarter[0], &quarter[1], &half[k], from < to ? from : to, from < to ? to : from, PC_NONE);
        emit_ring(d, quarter[0], &pairs, f, &at);
        emit_ring(d, quarter[1], &pairs, f, &at);
    }
}

/* ---- the whole scan ---- */

static pc_status number_edge_points(drawing *d, pc_context *ctx, double **abscissa, pc_index *vertex_count) {
    pc_status status = PC_OK;
    pc_index edges = d->adjacency->edge_count;
    PC_TRY(pc_new(&d->points, ctx, edges));
    PC_TRY(pc_new(abscissa, ctx, 2 * (size_t)edges));
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index e = 0; e < edges; e++)
        find_edge_points(d, e, *abscissa + 2 * (size_t)e);
    for (pc_index e = 0; e < edges; e++) {
        d->points[e].first_vertex = *vertex_count;
        *vertex_count += d->points[e].count;
    }
done:
    return status;
}

static void place_edge_points(const drawing *d, const double *abscissa) {
    const pc_mesh *mesh = d->mesh;
    double *position = d->overlay->mesh.position;
    memcpy(position, mesh->position, 3 * sizeof(double) * (size_t)mesh->vertex_count);
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index e = 0; e < d->adjacency->edge_count; e++) {
        pc_index h = base_half(d, e);
        pc_vec3 p = pc_vec3_at(mesh->position, pc_tail(mesh, h)),
                q = pc_vec3_at(mesh->position, pc_head(mesh, h));
        for (int k = 0; k < d->points[e].count; k++)
            pc_vec3_put(position, d->points[e].first_vertex + (pc_index)k,
                        pc_madd(p, abscissa[2 * (size_t)e + (size_t)k], pc_sub(q, p)));
    }
}

static pc_status number_faces(drawing *d, pc_context *ctx, pc_index *vertex_count) {
    pc_status status = PC_OK;
    pc_index faces = d->mesh->face_count;
    PC_TRY(pc_new(&d->first_face, ctx, (size_t)faces + 1));
    PC_TRY(pc_new(&d->crossing, ctx, faces));
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index f = 0; f < faces; f++) {
        ring around;
        chord chords[2];
        walk_ring(&around, chords, d, f);
        d->crossing[f] = chords_cross(chords) ? 1 : PC_NONE;
        /* A disk with B vertices on its rim and I inside has B + 2I - 2 triangles. */
        d->first_face[f + 1] = (pc_index)around.count - 2 + (d->crossing[f] == PC_NONE ? 0 : 2);
    }
    for (pc_index f = 0; f < faces; f++) {
        d->first_face[f + 1] += d->first_face[f];
        if (d->crossing[f] != PC_NONE) d->crossing[f] = (*vertex_count)++;
    }
done:
    return status;
}

pc_status pc_overlay_make(pc_overlay *overlay, pc_context *ctx, const pc_coned *coned,
                          const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    const pc_mesh *mesh = &coned->mesh;
    const pc_param *param = &coned->param;
    drawing d = {.mesh = mesh,
                 .first_cone = coned->first_cone,
                 .adjacency = adjacency,
                 .param = param,
                 .overlay = overlay};
    double *abscissa = NULL;
    pc_index vertices = mesh->vertex_count;
    *overlay = (pc_overlay){0};
    PC_TRY(number_edge_points(&d, ctx, &abscissa, &vertices));
    /* Positions first: where a dislocation leaves a choice, lengths decide. */
    PC_TRY(pc_new(&overlay->mesh.position, ctx, 3 * ((size_t)vertices + mesh->face_count)));
    place_edge_points(&d, abscissa);
    PC_TRY(number_faces(&d, ctx, &vertices));
    pc_index faces = d.first_face[mesh->face_count];
    overlay->mesh.vertex_count = vertices, overlay->mesh.face_count = faces;
    PC_TRY(pc_resize(&overlay->mesh.position, ctx, 3 * (size_t)vertices));
    PC_TRY(pc_new(&overlay->mesh.triangle, ctx, 3 * (size_t)faces));
    PC_TRY(pc_new(&overlay->source_face, ctx, faces));
    PC_TRY(pc_new(&overlay->drawn, ctx, 3 * (size_t)faces));
#pragma omp parallel for schedule(static, GRAIN)
    for (pc_index f = 0; f < mesh->face_count; f++)
        draw_face(&d, f);
done:
    pc_free(ctx, abscissa);
    pc_free(ctx, d.points);
    pc_free(ctx, d.first_face);
    pc_free(ctx, d.crossing);
    if (status != PC_OK) pc_overlay_free(overlay, ctx);
    return status;
}

void pc_overlay_free(pc_overlay *overlay, pc_context *ctx) {
    if (!overlay) return;
    pc_mesh_free(&overlay->mesh, ctx);
    pc_free(ctx, overlay->source_face);
    pc_free(ctx, overlay->drawn);
    *overlay = (pc_overlay){0};
}
