/* Random polygon meshes: faces of a mesh of quads, cut from corner to corner and joined at random, with
 * T-junctions wherever three faces meet and one wants it. */
#ifndef PC_RANDOM_POLYGONS_H
#define PC_RANDOM_POLYGONS_H

#include "memory.h"
#include "polymesh.h"
#include "random.h"
#include "testing.h"

enum { POLYGON_MOST = 12 };

typedef struct polygon {
    int count;
    pc_index corner[POLYGON_MOST];
} polygon;

typedef struct polygon_list {
    pc_index count;
    polygon *at;
} polygon_list;

static inline int polygon_find(const polygon *p, pc_index v) {
    for (int i = 0; i < p->count; i++)
        if (p->corner[i] == v) return i;
    return -1;
}

static inline bool polygons_touch(const polygon_list *list, pc_index v, pc_index w) {
    for (pc_index f = 0; f < list->count; f++) {
        const polygon *p = list->at + f;
        for (int i = 0; i < p->count; i++) {
            pc_index a = p->corner[i], b = p->corner[(i + 1) % p->count];
            if ((a == v && b == w) || (a == w && b == v)) return true;
        }
    }
    return false;
}

static inline int polygons_around(const polygon_list *list, pc_index v) {
    int count = 0;
    for (pc_index f = 0; f < list->count; f++)
        count += polygon_find(list->at + f, v) >= 0;
    return count;
}

/* From corner i to corner j of polygon f. */
static inline void polygon_cut(polygon_list *list, pc_index f, int i, int j) {
    polygon whole = list->at[f], *one = list->at + f, *two = list->at + list->count;
    if (polygons_touch(list, whole.corner[i], whole.corner[j])) return;
    one->count = two->count = 0;
    for (int k = i; k != j; k = (k + 1) % whole.count)
        one->corner[one->count++] = whole.corner[k];
    one->corner[one->count++] = whole.corner[j];
    for (int k = j; k != i; k = (k + 1) % whole.count)
        two->corner[two->count++] = whole.corner[k];
    two->corner[two->count++] = whole.corner[i];
    list->count++;
}

/* The polygons f and g, which share the edge after corner i of f and only that; its ends stay between three.
 */
static inline bool polygon_join(polygon_list *list, pc_index f, int i, pc_index g) {
    const polygon *p = list->at + f, *q = list->at + g;
    polygon both = {0};
    int shared = 0;
    if (p->count + q->count - 2 > POLYGON_MOST) return false;
    for (int k = 0; k < q->count; k++)
        shared += polygon_find(p, q->corner[k]) >= 0;
    if (shared != 2 || polygons_around(list, p->corner[i]) < 4 ||
        polygons_around(list, p->corner[(i + 1) % p->count]) < 4)
        return false;
    for (int k = 1; k <= p->count; k++)
        both.corner[both.count++] = p->corner[(i + k) % p->count];
    int at = polygon_find(q, p->corner[i]);
    for (int k = 1; k < q->count - 1; k++)
        both.corner[both.count++] = q->corner[(at + k) % q->count];
    list->at[f] = both;
    list->at[g] = list->at[--list->count];
    return true;
}

static inline void polygons_disturb(polygon_list *list, pc_random *random) {
    pc_index f = (pc_index)(pc_random_uniform(random) * list->count);
    int i = (int)(pc_random_uniform(random) * list->at[f].count);
    if (pc_random_uniform(random) < 0.4) {
        if (list->at[f].count > 3)
            polygon_cut(list, f, i,
                        (i + 2 + (int)(pc_random_uniform(random) * (list->at[f].count - 3))) %
                            list->at[f].count);
        return;
    }
    pc_index v = list->at[f].corner[i], w = list->at[f].corner[(i + 1) % list->at[f].count];
    for (pc_index g = 0; g < list->count; g++) {
        int k = g == f ? -1 : polygon_find(list->at + g, w);
        if (k >= 0 && list->at[g].corner[(k + 1) % list->at[g].count] == v) {
            (void)polygon_join(list, f, i, g);
            return;
        }
    }
}

/* `mesh` comes with quads and leaves with polygons, disturbed so many times. */
static inline void make_random_polygons(pc_polymesh *mesh, pc_context *ctx, uint64_t seed, int times) {
    pc_random random = {seed};
    polygon_list list = {mesh->face_count, NULL};
    pc_polymesh out;
    size_t corners = 0;
    assert_ok(ctx, pc_new(&list.at, ctx, mesh->face_count + (size_t)times));
    for (pc_index f = 0; f < mesh->face_count; f++) {
        list.at[f].count = 4;
        memcpy(list.at[f].corner, mesh->corner + 4 * (size_t)f, 4 * sizeof(pc_index));
    }
    for (int i = 0; i < times; i++)
        polygons_disturb(&list, &random);
    for (pc_index f = 0; f < list.count; f++)
        corners += (size_t)list.at[f].count;
    assert_ok(ctx, pc_polymesh_make(&out, ctx, mesh->vertex_count, list.count, corners));
    memcpy(out.position, mesh->position, 3 * sizeof(double) * mesh->vertex_count);
    pc_index at = 0;
    for (pc_index f = 0; f < list.count; f++) {
        const polygon *p = list.at + f;
        for (int k = 0; k < p->count; k++) {
            out.corner_flat[at] =
                p->count > 4 && polygons_around(&list, p->corner[k]) == 3 && pc_random_uniform(&random) < 0.7;
            out.corner[at++] = p->corner[k];
        }
        out.start[f + 1] = at;
    }
    pc_free(ctx, list.at);
    pc_polymesh_free(mesh, ctx);
    *mesh = out;
}

#endif
