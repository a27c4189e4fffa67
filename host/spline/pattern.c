#include "pattern.h"
#include "memory.h"
#include "oddpair.h"
#include "polygraph.h"
#include "spare.h"
#include "vec3.h"
#include <string.h>

/* Odd polygons so many edges apart are joined: longer strips come out askew, and take more control points in
 * the end than what the centres of odd polygons cost. */
static const int farthest = 2;

typedef enum kind { WHOLE, EVEN, ODD } kind;

/* A part of a polygon: `count` corners from `start` on. */
typedef struct piece {
    pc_index start, count, source;
    kind kind;
} piece;

typedef struct carving {
    pc_polymesh tidy; /* the polygons without spare vertices, odd ones joined in pairs */
    pc_index *source; /* per polygon of it: the one given */
    pc_index pairs;
    uint8_t *border;  /* per vertex */
    uint8_t *closed;  /* per vertex: a T-junction that stays, and takes no more edges */
    pc_index *degree; /* per vertex: edges, those that have been added too */
    pc_index *head;   /* per vertex: its first entry in the lists of neighbours, */
    pc_index *next;   /* per entry: the one after it, */
    pc_index *to;     /* and the neighbour */
    pc_index entries;
    piece *part;
    size_t part_count, part_room;
    pc_index *corner;
    uint8_t *flat;
    size_t corner_count, corner_room;
    pc_polygraph graph; /* of the parts */
    pc_index *middle;   /* per corner of the parts: the vertex in the middle of its edge, or PC_NONE */
} carving;

/* How far the vertex is from regular with `more` edges. */
static int irregularity(const carving *c, pc_index v, int more) {
    int edges = (int)c->degree[v] + more;
    if (c->border[v]) return edges > 3 ? edges - 3 : 0;
    if (edges < 3) return 9; /* no vertex between two faces only */
    return edges > 4 ? edges - 4 : 4 - edges;
}

static int gain_of_edge(const carving *c, pc_index v) {
    return (c->closed[v] ? 8 : 0) + irregularity(c, v, 1) - irregularity(c, v, 0);
}

/* Of four corners, with or without T-junctions, and not to go apart. */
static bool stays(const carving *c, const uint8_t *apart, pc_index f) {
    pc_index corners = 0;
    for (pc_index k = c->tidy.start[f]; k < c->tidy.start[f + 1]; k++)
        corners += !c->tidy.corner_flat[k];
    return corners == 4 && !apart[c->source[f]];
}

static pc_status pair_up(carving *c, pc_context *ctx, const uint8_t *apart, const uint8_t *alone) {
    pc_status status = PC_OK;
    uint8_t *kept = NULL;
    pc_index *part = NULL;
    PC_TRY(pc_new(&kept, ctx, c->tidy.face_count));
    for (pc_index f = 0; f < c->tidy.face_count; f++)
        kept[f] = alone[c->source[f]] || (c->tidy.start[f + 1] - c->tidy.start[f] > 4 && stays(c, apart, f));
    PC_TRY(pc_oddpair_join(&c->tidy, &part, &c->pairs, ctx, kept, farthest));
    for (pc_index f = 0; f < c->tidy.face_count; f++)
        c->source[f] = c->source[part[f]]; /* parts are in order */
done:
    pc_free(ctx, kept);
    pc_free(ctx, part);
    return status;
}

static void list_neighbour(carving *c, pc_index v, pc_index w) {
    c->to[c->entries] = w;
    c->next[c->entries] = c->head[v];
    c->head[v] = c->entries++;
    c->degree[v]++;
}

static bool are_neighbours(const carving *c, pc_index v, pc_index w) {
    for (pc_index e = c->head[v]; e != PC_NONE; e = c->next[e])
        if (c->to[e] == w) return true;
    return false;
}

static pc_status list_neighbours(carving *c, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_polygraph graph = {0};
    const pc_polymesh *t = &c->tidy;
    PC_TRY(pc_polygraph_of_polymesh(&graph, ctx, t));
    PC_TRY(pc_new(&c->degree, ctx, t->vertex_count));
    PC_TRY(pc_new(&c->head, ctx, t->vertex_count));
    PC_TRY(pc_new(&c->next, ctx, 4 * (size_t)graph.corner_count)); /* fewer cuts than corners */
    PC_TRY(pc_new(&c->to, ctx, 4 * (size_t)graph.corner_count));
    memset(c->head, 0xff, t->vertex_count * sizeof *c->head);
    for (pc_index k = 0; k < graph.corner_count; k++) {
        pc_index f = graph.face[k], v = t->corner[k];
        pc_index w = t->corner[pc_polymesh_next(t, f, k)];
        if (graph.twin[k] != PC_NONE && graph.twin[k] < k) continue;
        list_neighbour(c, v, w);
        list_neighbour(c, w, v);
    }
done:
    pc_polygraph_free(&graph, ctx);
    return status;
}

/* Room for a part of so many corners more; where they go. */
static pc_status add_part(pc_index **corner, carving *c, pc_context *ctx, pc_index count, pc_index source) {
    pc_status status = PC_OK;
    if (c->part_count == c->part_room) {
        c->part_room = 2 * c->part_room + 64;
        PC_TRY(pc_resize(&c->part, ctx, c->part_room));
    }
    if (c->corner_count + count > c->corner_room) {
        c->corner_room = 2 * (c->corner_room + count);
        PC_TRY(pc_resize(&c->corner, ctx, c->corner_room));
        PC_TRY(pc_resize(&c->flat, ctx, c->corner_room));
    }
    c->part[c->part_count++] =
        (piece){.start = (pc_index)c->corner_count, .count = count, .source = source, .kind = WHOLE};
    *corner = c->corner + c->corner_count;
    memset(c->flat + c->corner_count, 0, count);
    c->corner_count += count;
done:
    return status;
}

static double mean_side(const carving *c, const piece *p) {
    const pc_index *v = c->corner + p->start;
    double sum = 0;
    for (pc_index i = 0; i < p->count; i++)
        sum += pc_distance(pc_vec3_at(c->tidy.position, v[i]),
                           pc_vec3_at(c->tidy.position, v[(i + 1) % p->count]));
    return sum / p->count;
}

/* A cut from corner to corner and what it costs: valences, and its length. */
typedef struct chord {
    pc_index from, to;
    double cost;
} chord;

/* Parts of four corners and more, an odd polygon's odd part of five and more. */
static chord best_chord(const carving *c, const piece *p) {
    const double length_weight = 0.5;
    const pc_index *v = c->corner + p->start;
    chord best = {.cost = INFINITY};
    double side = fmax(mean_side(c, p), 1e-300);
    for (pc_index i = 0; i < p->count; i++)
        for (pc_index j = i + 3; j < p->count && p->count - (j - i) >= 3; j++) {
            bool even = (j - i) % 2 == 1;
            if ((p->count % 2 == 0 && !even) || v[i] == v[j] || are_neighbours(c, v[i], v[j])) continue;
            double length =
                pc_distance(pc_vec3_at(c->tidy.position, v[i]), pc_vec3_at(c->tidy.position, v[j]));
            double cost = gain_of_edge(c, v[i]) + gain_of_edge(c, v[j]) + length_weight * length / side;
            if (cost < best.cost) best = (chord){i, j, cost};
        }
    return best;
}

/* Spokes to the corners of this parity, and one more vertex. */
static double cost_of_star(const carving *c, const piece *p, pc_index parity) {
    const pc_index spokes = p->count / 2;
    double cost = 1 + (spokes > 4 ? spokes - 4.0 : 4.0 - spokes);
    for (pc_index i = parity; i < p->count; i += 2)
        cost += gain_of_edge(c, c->corner[p->start + i]);
    return cost;
}

static void rotate(pc_index *v, pc_index count, pc_index by) {
    for (; by > 0; by--) {
        pc_index first = v[0];
        memmove(v, v + 1, (count - 1) * sizeof *v);
        v[count - 1] = first;
    }
}

/* The larger part stays where the whole was. */
static pc_status cut_part(carving *c, pc_context *ctx, size_t at, chord cut) {
    pc_status status = PC_OK;
    pc_index *part, count = c->part[at].count, near = cut.to - cut.from + 1, far = count - near + 2;
    pc_index a = c->corner[c->part[at].start + cut.from], b = c->corner[c->part[at].start + cut.to];
    PC_TRY(add_part(&part, c, ctx, near < far ? near : far, c->part[at].source));
    pc_index *v = c->corner + c->part[at].start;
    rotate(v, count, near < far ? cut.from : cut.to); /* the smaller part comes first */
    if (near >= far) near = far;
    memcpy(part, v, near * sizeof *v);
    memmove(v + 1, v + near - 1, (count - near + 1) * sizeof *v);
    c->part[at].count = count - near + 2;
    list_neighbour(c, a, b);
    list_neighbour(c, b, a);
done:
    return status;
}

/* Cut until no part has more than six corners, or a centre is better. */
static pc_status carve(carving *c, pc_context *ctx, size_t first) {
    pc_status status = PC_OK;
    for (size_t at = first; at < c->part_count; at++) {
        piece *p = c->part + at;
        while (p->count > 5) {
            chord cut = best_chord(c, p);
            double star = fmin(cost_of_star(c, p, 0), cost_of_star(c, p, 1));
            if (!(cut.cost < INFINITY) || (p->count % 2 == 0 && p->count <= 8 && star < cut.cost)) break;
            PC_TRY(cut_part(c, ctx, at, cut));
            p = c->part + at;
        }
        if (p->count == 4) continue;
        p->kind = p->count % 2 ? ODD : EVEN;
        if (p->kind == ODD) continue;
        pc_index *v = c->corner + p->start;
        if (cost_of_star(c, p, 1) < cost_of_star(c, p, 0)) rotate(v, p->count, 1);
        for (pc_index i = 0; i < p->count; i += 2)
            c->degree[v[i]]++;
    }
done:
    return status;
}

static pc_status carve_all(carving *c, pc_context *ctx, const uint8_t *apart) {
    pc_status status = PC_OK;
    const pc_polymesh *t = &c->tidy;
    PC_TRY(pc_new(&c->closed, ctx, t->vertex_count));
    for (pc_index f = 0; f < t->face_count; f++)
        for (pc_index k = t->start[f]; k < t->start[f + 1] && stays(c, apart, f); k++)
            if (t->corner_flat[k]) c->closed[t->corner[k]] = 1;
    for (pc_index f = 0; f < t->face_count; f++) {
        pc_index from = t->start[f], count = t->start[f + 1] - from, *v;
        size_t first = c->part_count;
        PC_TRY(add_part(&v, c, ctx, count, c->source[f]));
        memcpy(v, t->corner + from, count * sizeof *v);
        if (stays(c, apart, f))
            memcpy(c->flat + c->part[first].start, t->corner_flat + from, count);
        else
            PC_TRY(carve(c, ctx, first));
    }
done:
    return status;
}

/* Polygons whose T-junctions got an edge from the other side all the same go apart too; those whose joining
 * left a vertex between two faces only are not joined. */
static bool is_spoilt(uint8_t *apart, uint8_t *alone, const carving *c) {
    bool spoilt = false;
    for (size_t i = 0; i < c->part_count; i++) {
        const piece *p = c->part + i;
        for (pc_index k = p->start; k < p->start + p->count; k++) {
            const pc_index v = c->corner[k];
            if (c->flat[k] && c->degree[v] != 3) apart[p->source] = spoilt = true;
            if (!c->border[v] && c->degree[v] < 3 && !alone[p->source]) alone[p->source] = spoilt = true;
        }
    }
    return spoilt;
}

/* Parts in a row, and who touches whom. */
static pc_status join_parts(carving *c, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index *corner = NULL, *start = NULL, at = 0;
    uint8_t *flat = NULL;
    PC_TRY(pc_new(&corner, ctx, c->corner_count));
    PC_TRY(pc_new(&flat, ctx, c->corner_count));
    PC_TRY(pc_new(&start, ctx, c->part_count + 1));
    for (size_t i = 0; i < c->part_count; i++) {
        piece *p = c->part + i;
        memcpy(corner + at, c->corner + p->start, p->count * sizeof *corner);
        memcpy(flat + at, c->flat + p->start, p->count);
        start[i] = p->start = at;
        at += p->count;
    }
    start[c->part_count] = at;
    pc_free(ctx, c->corner);
    pc_free(ctx, c->flat);
    c->corner = corner, c->flat = flat, corner = NULL, flat = NULL;
    c->corner_count = at;
    PC_TRY(
        pc_polygraph_make(&c->graph, ctx, c->tidy.vertex_count, (pc_index)c->part_count, start, c->corner));
done:
    pc_free(ctx, corner);
    pc_free(ctx, flat);
    pc_free(ctx, start);
    return status;
}

static pc_vec3 corner_at(const carving *c, pc_index k) {
    return pc_vec3_at(c->tidy.position, c->corner[k]);
}

static pc_index after(const piece *p, pc_index k) {
    return k + 1 < p->start + p->count ? k + 1 : p->start;
}

/* Vertices of the polygons, then centres and middles, part by part. */
static pc_status place_vertices(pc_index *centre, carving *c, pc_context *ctx, pc_polymesh *faces) {
    pc_status status = PC_OK;
    size_t most = c->tidy.vertex_count + c->part_count + c->corner_count;
    pc_index count = c->tidy.vertex_count;
    PC_TRY(pc_new(&c->middle, ctx, c->corner_count));
    memset(c->middle, 0xff, c->corner_count * sizeof *c->middle);
    PC_TRY(pc_polymesh_make(faces, ctx, most, c->corner_count, 8 * c->corner_count));
    memcpy(faces->position, c->tidy.position, 3 * sizeof(double) * count);
    for (size_t i = 0; i < c->part_count; i++) {
        const piece *p = c->part + i;
        pc_vec3 sum = {0, 0, 0};
        if (p->kind == WHOLE) continue;
        for (pc_index k = p->start; k < p->start + p->count; k++) {
            sum = pc_add(sum, corner_at(c, k));
            if (p->kind == EVEN || c->middle[k] != PC_NONE) continue;
            c->middle[k] = count;
            if (c->graph.twin[k] != PC_NONE) c->middle[c->graph.twin[k]] = count;
            pc_vec3_put(faces->position, count++,
                        pc_scale(0.5, pc_add(corner_at(c, k), corner_at(c, after(p, k)))));
        }
        centre[i] = count;
        pc_vec3_put(faces->position, count++, pc_scale(1.0 / p->count, sum));
    }
    faces->vertex_count = count;
done:
    return status;
}

/* The face that is being written. */
typedef struct pen {
    pc_pattern *out;
    const carving *c;
    pc_index corners;
} pen;

static void put_corner(pen *w, pc_index vertex, bool flat, double interval) {
    w->out->faces.corner[w->corners] = vertex;
    w->out->faces.corner_flat[w->corners] = flat;
    w->out->interval[w->corners++] = interval;
}

/* Corner k and the edge that leaves it, with the T-junction that a neighbour put in. */
static void put_side(pen *w, pc_index k) {
    pc_index middle = w->c->middle[k];
    put_corner(w, w->c->corner[k], w->c->flat[k], middle == PC_NONE ? 1 : 0.5);
    if (middle != PC_NONE) put_corner(w, middle, true, 0.5);
}

static void end_face(pen *w, const piece *p, bool whole) {
    pc_polymesh *faces = &w->out->faces;
    w->out->source[faces->face_count] = p->source;
    w->out->whole[faces->face_count] = whole;
    faces->start[++faces->face_count] = w->corners;
}

static void put_even(pen *w, const piece *p, pc_index centre) {
    for (pc_index i = 0; i < p->count; i += 2) {
        pc_index k = p->start + i, last = i + 2 < p->count ? k + 2 : p->start;
        put_side(w, k);
        put_side(w, k + 1);
        put_corner(w, w->c->corner[last], false, 1);
        put_corner(w, centre, false, 1);
        end_face(w, p, false);
    }
}

static void put_odd(pen *w, const piece *p, pc_index centre) {
    for (pc_index i = 0; i < p->count; i++) {
        pc_index k = p->start + i, before = i ? k - 1 : p->start + p->count - 1;
        put_corner(w, w->c->corner[k], false, 0.5);
        put_corner(w, w->c->middle[k], false, 0.5);
        put_corner(w, centre, false, 0.5);
        put_corner(w, w->c->middle[before], false, 0.5);
        end_face(w, p, false);
    }
}

static void put_whole(pen *w, const piece *p) {
    bool flat = false;
    for (pc_index k = p->start; k < p->start + p->count; k++) {
        flat = flat || w->c->flat[k];
        put_side(w, k);
    }
    end_face(w, p, flat);
}

static pc_status write_faces(pc_pattern *out, carving *c, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index *centre = NULL;
    pen w = {.out = out, .c = c};
    PC_TRY(pc_new(&centre, ctx, c->part_count));
    PC_TRY(place_vertices(centre, c, ctx, &out->faces));
    PC_TRY(pc_new(&out->source, ctx, c->corner_count));
    PC_TRY(pc_new(&out->whole, ctx, c->corner_count));
    PC_TRY(pc_new(&out->interval, ctx, 8 * c->corner_count));
    out->faces.face_count = 0;
    for (size_t i = 0; i < c->part_count; i++) {
        const piece *p = c->part + i;
        out->even += p->kind == EVEN;
        out->odd += p->kind == ODD;
        out->cuts += i > 0 && p->source == c->part[i - 1].source;
        if (p->kind == WHOLE) put_whole(&w, p);
        if (p->kind == EVEN) put_even(&w, p, centre[i]);
        if (p->kind == ODD) put_odd(&w, p, centre[i]);
    }
done:
    pc_free(ctx, centre);
    return status;
}

static void drop_carving(carving *c, pc_context *ctx) {
    pc_polymesh_free(&c->tidy, ctx);
    pc_polygraph_free(&c->graph, ctx);
    pc_free(ctx, c->source);
    pc_free(ctx, c->border);
    pc_free(ctx, c->closed);
    pc_free(ctx, c->degree);
    pc_free(ctx, c->head);
    pc_free(ctx, c->next);
    pc_free(ctx, c->to);
    pc_free(ctx, c->part);
    pc_free(ctx, c->corner);
    pc_free(ctx, c->flat);
    pc_free(ctx, c->middle);
    *c = (carving){0};
}

pc_status pc_pattern_make(pc_pattern *pattern, pc_context *ctx, const pc_polymesh *polygons,
                          const uint8_t *apart) {
    pc_status status = PC_OK;
    carving c = {0};
    uint8_t *own = NULL, *alone = NULL;
    *pattern = (pc_pattern){0};
    PC_TRY(pc_new(&own, ctx, polygons->face_count));
    PC_TRY(pc_new(&alone, ctx, polygons->face_count));
    if (apart) memcpy(own, apart, polygons->face_count);
    do {
        drop_carving(&c, ctx);
        PC_TRY(pc_polymesh_copy(&c.tidy, ctx, polygons));
        PC_TRY(pc_spare_drop(&c.tidy, &c.source, &c.border, ctx));
        PC_TRY(pair_up(&c, ctx, own, alone));
        PC_TRY(list_neighbours(&c, ctx));
        PC_TRY(carve_all(&c, ctx, own));
    } while (is_spoilt(own, alone, &c));
    PC_TRY(join_parts(&c, ctx));
    PC_TRY(write_faces(pattern, &c, ctx));
    pattern->pairs = c.pairs;
done:
    drop_carving(&c, ctx);
    pc_free(ctx, own);
    pc_free(ctx, alone);
    if (status != PC_OK) pc_pattern_free(pattern, ctx);
    return status;
}

void pc_pattern_free(pc_pattern *pattern, pc_context *ctx) {
    pc_polymesh_free(&pattern->faces, ctx);
    pc_free(ctx, pattern->source);
    pc_free(ctx, pattern->whole);
    pc_free(ctx, pattern->interval);
    *pattern = (pc_pattern){0};
}
