#include "polygraph.h"
#include "memory.h"

typedef struct shape {
    pc_index vertex_count, face_count;
    const pc_index *start; /* NULL: triangles */
    const pc_index *corner;
} shape;

static pc_index face_start(const shape *s, pc_index f) {
    return s->start ? s->start[f] : 3 * f;
}

static pc_index next_corner(const shape *s, const pc_polygraph *g, pc_index c) {
    pc_index f = g->face[c];
    return c + 1 == face_start(s, f + 1) ? face_start(s, f) : c + 1;
}

static pc_index prev_corner(const shape *s, const pc_polygraph *g, pc_index c) {
    pc_index f = g->face[c];
    return c == face_start(s, f) ? face_start(s, f + 1) - 1 : c - 1;
}

static pc_status check_shape(pc_context *ctx, const shape *s) {
    for (pc_index f = 0; f < s->face_count; f++)
        if (face_start(s, f + 1) < face_start(s, f) || face_start(s, 0) != 0)
            return pc_fail(ctx, PC_E_BUG, "the corners of face %u end before they start", f);
    for (pc_index c = 0; c < face_start(s, s->face_count); c++)
        if (s->corner[c] >= s->vertex_count)
            return pc_fail(ctx, PC_E_BUG, "corner %u uses vertex %u of %u", c, s->corner[c], s->vertex_count);
    return PC_OK;
}

static void name_faces(pc_polygraph *g, const shape *s) {
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < s->face_count; f++) {
        for (pc_index c = face_start(s, f); c < face_start(s, f + 1); c++) {
            g->face[c] = f;
            g->twin[c] = PC_NONE;
        }
    }
}

static void count_faces(pc_polygraph *g, const shape *s) {
    for (pc_index f = 0; f < s->face_count; f++) {
        pc_index first = face_start(s, f), end = face_start(s, f + 1);
        bool broken = end - first < 3;
        for (pc_index c = first; c < end; c++)
            for (pc_index d = c + 1; d < end; d++)
                broken = broken || s->corner[c] == s->corner[d];
        g->count.broken_faces += broken;
    }
    g->count.faces = s->face_count;
}

/* Half-edges by their smaller end vertex. */
static pc_status bucket_halves(pc_index **start, pc_index **bucket, pc_context *ctx, const pc_polygraph *g,
                               const shape *s) {
    pc_status status = PC_OK;
    PC_TRY(pc_new(start, ctx, (size_t)s->vertex_count + 2));
    PC_TRY(pc_new(bucket, ctx, g->corner_count));
    for (int fill = 0; fill < 2; fill++) {
        for (pc_index c = 0; c < g->corner_count; c++) {
            pc_index a = s->corner[c], b = s->corner[next_corner(s, g, c)], least = a < b ? a : b;
            if (fill)
                (*bucket)[(*start)[least + 1]++] = c;
            else
                (*start)[least + 2]++;
        }
        for (size_t v = 2; v < (size_t)s->vertex_count + 2 && !fill; v++)
            (*start)[v] += (*start)[v - 1];
    }
done:
    return status;
}

static pc_index find_root(pc_index *parent, pc_index f) {
    while (parent[f] != f)
        f = parent[f] = parent[parent[f]];
    return f;
}

static void join(pc_index *parent, pc_index a, pc_index b) {
    a = find_root(parent, a), b = find_root(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

/* All half-edges of one edge: counts it, pairs them where they are two of opposite directions. `same` is how
 * many run like the first, `other` how many run against it. */
static void settle_edge(pc_polygraph *g, pc_index first, pc_index partner, pc_index same, pc_index other) {
    g->count.edges++;
    if (same + other == 1) {
        g->boundary[first] = 1;
        g->count.boundary_edges++;
    } else if (same + other > 2) {
        g->count.overfull_edges++;
    } else if (same == 2) {
        g->count.clashing_edges++;
    } else {
        g->twin[first] = partner;
        g->twin[partner] = first;
    }
}

static void pair_bucket(pc_polygraph *g, const shape *s, pc_index *bucket, pc_index count) {
    for (pc_index i = 0; i < count; i++) {
        pc_index h = bucket[i], partner = PC_NONE, same = 1, other = 0;
        if (h == PC_NONE) continue;
        pc_index tail = s->corner[h], head = s->corner[next_corner(s, g, h)];
        for (pc_index j = i + 1; j < count; j++) {
            if (bucket[j] == PC_NONE) continue;
            pc_index t = s->corner[bucket[j]], e = s->corner[next_corner(s, g, bucket[j])];
            bool along = t == tail && e == head, against = t == head && e == tail && t != e;
            if (!along && !against) continue;
            same += along, other += against;
            partner = bucket[j];
            join(g->face_component, g->face[h], g->face[partner]);
            bucket[j] = PC_NONE;
        }
        settle_edge(g, h, partner, same, other);
    }
}

static pc_status pair_twins(pc_polygraph *g, pc_context *ctx, const shape *s) {
    pc_status status = PC_OK;
    pc_index *start = NULL, *bucket = NULL;
    PC_TRY(bucket_halves(&start, &bucket, ctx, g, s));
    for (pc_index f = 0; f < s->face_count; f++)
        g->face_component[f] = f;
    for (pc_index v = 0; v < s->vertex_count; v++) {
        if (start[v] == start[v + 1]) continue;
        pair_bucket(g, s, bucket + start[v], start[v + 1] - start[v]);
    }
    for (pc_index f = 0; f < s->face_count; f++) { /* a root comes before all others of its component */
        pc_index root = find_root(g->face_component, f);
        if (root == f) g->count.components++;
    }
done:
    pc_free(ctx, start);
    pc_free(ctx, bucket);
    return status;
}

static pc_status number_components(pc_polygraph *g, pc_context *ctx, pc_index face_count) {
    pc_status status = PC_OK;
    pc_index *number = NULL, count = 0;
    PC_TRY(pc_new(&number, ctx, face_count));
    for (pc_index f = 0; f < face_count; f++) {
        pc_index root = find_root(g->face_component, f);
        number[f] = root == f ? count++ : number[root];
    }
    for (pc_index f = 0; f < face_count; f++)
        g->face_component[f] = number[f];
done:
    pc_free(ctx, number);
    return status;
}

/* Walks the fan of corner c counter-clockwise and marks it. */
static void walk_fan(uint8_t *seen, const pc_polygraph *g, const shape *s, pc_index c) {
    while (c != PC_NONE && !seen[c]) {
        seen[c] = 1;
        c = g->twin[prev_corner(s, g, c)];
    }
}

static pc_status count_fans(pc_polygraph *g, pc_context *ctx, const shape *s) {
    pc_status status = PC_OK;
    uint8_t *seen = NULL, *fans = NULL;
    PC_TRY(pc_new(&seen, ctx, g->corner_count));
    PC_TRY(pc_new(&fans, ctx, s->vertex_count));
    for (int closed = 0; closed < 2; closed++) /* open fans first, from their clockwise ends */
        for (pc_index c = 0; c < g->corner_count; c++) {
            if (seen[c] || (!closed && g->twin[c] != PC_NONE)) continue;
            if (fans[s->corner[c]] < 2) fans[s->corner[c]]++;
            walk_fan(seen, g, s, c);
        }
    for (pc_index v = 0; v < s->vertex_count; v++) {
        g->count.split_vertices += fans[v] > 1;
        g->count.unused_vertices += fans[v] == 0;
        g->count.vertices += fans[v] > 0;
    }
done:
    pc_free(ctx, seen);
    pc_free(ctx, fans);
    return status;
}

static pc_status count_loops(pc_polygraph *g, pc_context *ctx, const shape *s) {
    pc_status status = PC_OK;
    uint8_t *seen = NULL;
    PC_TRY(pc_new(&seen, ctx, g->corner_count));
    for (pc_index first = 0; first < g->corner_count; first++) {
        if (!g->boundary[first] || seen[first]) continue;
        g->count.loops++;
        for (pc_index c = first;
             !seen[c];) { /* the walk around the head ends at a half-edge without a twin */
            seen[c] = 1;
            c = next_corner(s, g, c);
            while (g->twin[c] != PC_NONE)
                c = next_corner(s, g, g->twin[c]);
        }
    }
done:
    pc_free(ctx, seen);
    return status;
}

pc_status pc_polygraph_make(pc_polygraph *graph, pc_context *ctx, pc_index vertex_count, pc_index face_count,
                            const pc_index *start, const pc_index *corner) {
    pc_status status = PC_OK;
    const shape s = {vertex_count, face_count, start, corner};
    *graph = (pc_polygraph){0};
    PC_TRY(check_shape(ctx, &s));
    graph->corner_count = face_start(&s, face_count);
    PC_TRY(pc_new(&graph->face, ctx, graph->corner_count));
    PC_TRY(pc_new(&graph->twin, ctx, graph->corner_count));
    PC_TRY(pc_new(&graph->boundary, ctx, graph->corner_count));
    PC_TRY(pc_new(&graph->face_component, ctx, face_count));
    name_faces(graph, &s);
    count_faces(graph, &s);
    PC_TRY(pair_twins(graph, ctx, &s));
    PC_TRY(number_components(graph, ctx, face_count));
    PC_TRY(count_fans(graph, ctx, &s));
    PC_TRY(count_loops(graph, ctx, &s));
    graph->count.chi = (int64_t)graph->count.vertices - graph->count.edges + graph->count.faces;
done:
    if (status != PC_OK) pc_polygraph_free(graph, ctx);
    return status;
}

pc_status pc_polygraph_of_mesh(pc_polygraph *graph, pc_context *ctx, const pc_mesh *mesh) {
    return pc_polygraph_make(graph, ctx, mesh->vertex_count, mesh->face_count, NULL, mesh->triangle);
}

pc_status pc_polygraph_of_polymesh(pc_polygraph *graph, pc_context *ctx, const pc_polymesh *mesh) {
    return pc_polygraph_make(graph, ctx, mesh->vertex_count, mesh->face_count, mesh->start, mesh->corner);
}

void pc_polygraph_free(pc_polygraph *graph, pc_context *ctx) {
    if (!graph) return;
    pc_free(ctx, graph->face);
    pc_free(ctx, graph->twin);
    pc_free(ctx, graph->boundary);
    pc_free(ctx, graph->face_component);
    *graph = (pc_polygraph){0};
}
