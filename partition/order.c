#include "order.h"
#include "memory.h"
#include <stdlib.h>
#include <string.h>

/* Searches from a far end seldom get deeper after a few. */
enum { MOST_SEARCHES = 5, SMALL_ROW = 64 };

typedef struct search {
    const pc_graph *graph;
    pc_index *queue;
    pc_index *stamp; /* per vertex: the search that met it last */
    pc_index now;
} search;

/* Levels from `root`: how many there are, and in *far the vertex of the last one with the fewest neighbours.
 */
static pc_index search_levels(search *s, pc_index root, pc_index *far) {
    pc_index begin = 0, end = 1, levels = 0;
    s->queue[0] = root;
    s->stamp[root] = ++s->now;
    for (;;) {
        pc_index filled = end;
        levels++;
        for (pc_index i = begin; i < end; i++) {
            pc_index v = s->queue[i];
            for (pc_index j = s->graph->start[v]; j < s->graph->start[v + 1]; j++) {
                pc_index w = s->graph->neighbour[j];
                if (s->stamp[w] == s->now) continue;
                s->stamp[w] = s->now;
                s->queue[filled++] = w;
            }
        }
        if (filled == end) break;
        begin = end, end = filled;
    }
    *far = s->queue[begin];
    for (pc_index i = begin; i < end; i++) {
        pc_index v = s->queue[i], degree = pc_graph_degree(s->graph, v),
                 least = pc_graph_degree(s->graph, *far);
        if (degree < least || (degree == least && v < *far)) *far = v;
    }
    return levels;
}

static pc_index far_vertex(search *s, pc_index start) {
    pc_index root = start, next, levels = search_levels(s, root, &next);
    for (int i = 1; i < MOST_SEARCHES; i++) {
        pc_index beyond, deeper = search_levels(s, next, &beyond);
        root = next;
        if (deeper <= levels) break;
        levels = deeper, next = beyond;
    }
    return root;
}

typedef struct degree_key {
    pc_index degree, vertex;
} degree_key;

static int compare_degree(const void *a, const void *b) {
    const degree_key *x = a, *y = b;
    if (x->degree != y->degree) return x->degree < y->degree ? -1 : 1;
    return x->vertex < y->vertex ? -1 : x->vertex > y->vertex;
}

static void sort_by_degree(degree_key *key, pc_index count) {
    if (count > SMALL_ROW) {
        qsort(key, count, sizeof *key, compare_degree);
        return;
    }
    for (pc_index i = 1; i < count; i++) {
        degree_key item = key[i];
        pc_index j = i;
        for (; j > 0 && compare_degree(&key[j - 1], &item) > 0; j--)
            key[j] = key[j - 1];
        key[j] = item;
    }
}

/* Cuthill-McKee from `root` into list[0 .. returned), marked in `seen`; `key` holds the longest row. */
static pc_index list_component(pc_index *list, uint8_t *seen, degree_key *key, const pc_graph *graph,
                               pc_index root) {
    pc_index filled = 1;
    list[0] = root;
    seen[root] = 1;
    for (pc_index i = 0; i < filled; i++) {
        pc_index v = list[i], count = 0;
        for (pc_index j = graph->start[v]; j < graph->start[v + 1]; j++) {
            pc_index w = graph->neighbour[j];
            if (seen[w]) continue;
            seen[w] = 1;
            key[count++] = (degree_key){pc_graph_degree(graph, w), w};
        }
        sort_by_degree(key, count);
        for (pc_index j = 0; j < count; j++)
            list[filled++] = key[j].vertex;
    }
    return filled;
}

static pc_status order_vertices(pc_order *order, pc_context *ctx, const pc_graph *graph) {
    pc_status status = PC_OK;
    search s = {.graph = graph};
    degree_key *key = NULL;
    uint8_t *seen = NULL;
    pc_index longest = 0, done_count = 0;
    PC_TRY(pc_new(&s.queue, ctx, graph->vertex_count));
    PC_TRY(pc_new(&s.stamp, ctx, graph->vertex_count));
    PC_TRY(pc_new(&seen, ctx, graph->vertex_count));
    for (pc_index v = 0; v < graph->vertex_count; v++)
        if (pc_graph_degree(graph, v) > longest) longest = pc_graph_degree(graph, v);
    PC_TRY(pc_new(&key, ctx, longest));
    for (pc_index v = 0; v < graph->vertex_count; v++) {
        if (seen[v]) continue;
        pc_index *list = order->vertex_old + done_count;
        pc_index count = list_component(list, seen, key, graph, far_vertex(&s, v));
        for (pc_index i = 0; i < count / 2; i++) {
            pc_index swap = list[i];
            list[i] = list[count - 1 - i], list[count - 1 - i] = swap;
        }
        done_count += count;
        PC_TRY(pc_check_interrupt(ctx));
    }
    for (pc_index v = 0; v < graph->vertex_count; v++)
        order->vertex_new[order->vertex_old[v]] = v;
done:
    pc_free(ctx, s.queue);
    pc_free(ctx, s.stamp);
    pc_free(ctx, seen);
    pc_free(ctx, key);
    return status;
}

static pc_index least_corner(const pc_order *order, const pc_mesh *mesh, pc_index f) {
    const pc_index *t = mesh->triangle + 3 * (size_t)f;
    pc_index least = order->vertex_new[t[0]];
    for (int k = 1; k < 3; k++)
        if (order->vertex_new[t[k]] < least) least = order->vertex_new[t[k]];
    return least;
}

static pc_status order_faces(pc_order *order, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    pc_index *start = NULL;
    PC_TRY(pc_new(&start, ctx, (size_t)mesh->vertex_count + 1));
    for (pc_index f = 0; f < mesh->face_count; f++)
        start[least_corner(order, mesh, f) + 1]++;
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        start[v + 1] += start[v];
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_index place = start[least_corner(order, mesh, f)]++;
        order->face_new[f] = place;
        order->face_old[place] = f;
    }
done:
    pc_free(ctx, start);
    return status;
}

pc_status pc_order_make(pc_order *order, pc_context *ctx, const pc_mesh *mesh, const pc_graph *graph) {
    pc_status status = PC_OK;
    *order = (pc_order){.vertex_count = mesh->vertex_count, .face_count = mesh->face_count};
    PC_TRY(pc_new(&order->vertex_new, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&order->vertex_old, ctx, mesh->vertex_count));
    PC_TRY(pc_new(&order->face_new, ctx, mesh->face_count));
    PC_TRY(pc_new(&order->face_old, ctx, mesh->face_count));
    PC_TRY(order_vertices(order, ctx, graph));
    PC_TRY(order_faces(order, ctx, mesh));
done:
    if (status != PC_OK) pc_order_free(order, ctx);
    return status;
}

void pc_order_free(pc_order *order, pc_context *ctx) {
    if (!order) return;
    pc_free(ctx, order->vertex_new);
    pc_free(ctx, order->vertex_old);
    pc_free(ctx, order->face_new);
    pc_free(ctx, order->face_old);
    *order = (pc_order){0};
}

static pc_status check_pair(pc_context *ctx, const pc_index *a, const pc_index *b, pc_index count,
                            const char *what) {
    for (pc_index i = 0; i < count; i++)
        if (a[i] >= count || b[a[i]] != i)
            return pc_fail(ctx, PC_E_BUG, "the order of the %s is no permutation at %u", what, i);
    return PC_OK;
}

pc_status pc_order_check(const pc_order *order, pc_context *ctx) {
    pc_status status = check_pair(ctx, order->vertex_new, order->vertex_old, order->vertex_count, "vertices");
    if (status != PC_OK) return status;
    return check_pair(ctx, order->face_new, order->face_old, order->face_count, "faces");
}

pc_status pc_order_apply(pc_mesh *out, pc_context *ctx, const pc_order *order, const pc_mesh *mesh) {
    pc_status status = pc_mesh_make(out, ctx, mesh->vertex_count, mesh->face_count);
    if (status != PC_OK) return status;
    pc_order_permute(out->position, mesh->position, order->vertex_old, mesh->vertex_count,
                     3 * sizeof(double));
#pragma omp parallel for schedule(static)
    for (size_t f = 0; f < mesh->face_count; f++)
        for (size_t k = 0; k < 3; k++)
            out->triangle[3 * f + k] = order->vertex_new[mesh->triangle[3 * (size_t)order->face_old[f] + k]];
    return PC_OK;
}

void pc_order_permute(void *out, const void *in, const pc_index *from, size_t count, size_t bytes) {
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < count; i++)
        memcpy((char *)out + i * bytes, (const char *)in + from[i] * bytes, bytes);
}

pc_bandwidth pc_order_bandwidth(const pc_graph *graph) {
    pc_bandwidth width = {0, 0};
    uint64_t sum = 0;
    for (pc_index v = 0; v < graph->vertex_count; v++)
        for (pc_index i = graph->start[v]; i < graph->start[v + 1]; i++) {
            pc_index w = graph->neighbour[i], gap = v > w ? v - w : w - v;
            if (gap > width.largest) width.largest = gap;
            sum += gap;
        }
    if (graph->vertex_count && graph->start[graph->vertex_count])
        width.mean = (double)sum / graph->start[graph->vertex_count];
    return width;
}
