#include "bvh.h"
#include "geometry.h"
#include "memory.h"
#include <float.h>
#include <string.h>

enum { CELL_BITS = 30, QUERY_CHUNK = 256, STACK_SIZE = PC_BVH_WIDTH * PC_BVH_LEVELS };

/* A triangle by its centre, in cells of the box frame. */
typedef struct item {
    uint32_t cell[3];
    pc_index face;
} item;

static float round_down(double x) {
    float f = (float)x;
    return (double)f > x ? nextafterf(f, -FLT_MAX) : f;
}

static float round_up(double x) {
    float f = (float)x;
    return (double)f < x ? nextafterf(f, FLT_MAX) : f;
}

static pc_vec3 to_box_frame(const pc_bvh *bvh, pc_vec3 p) {
    return pc_scale(bvh->scale, pc_sub(p, bvh->centre));
}

static void fit_frame(pc_bvh *bvh) {
    const pc_box box = pc_geometry_box(bvh->mesh);
    const pc_vec3 sides = pc_sub(box.high, box.low);
    const double size = fmax(sides.x, fmax(sides.y, sides.z));
    int exponent = 0;
    (void)frexp(size, &exponent);
    bvh->scale = size > 0 ? ldexp(1, 1 - exponent) : 1; /* a power of two: the larger side is in 1..2 */
    bvh->centre = pc_add(pc_scale(0.5, box.low), pc_scale(0.5, box.high));
}

static item item_of(const pc_bvh *bvh, pc_index f) {
    const pc_index *t = bvh->mesh->triangle + 3 * (size_t)f;
    const double *p = bvh->mesh->position;
    const double most = 1u << CELL_BITS;
    item out = {.face = f};
    pc_vec3 sum = to_box_frame(bvh, pc_vec3_at(p, t[0]));
    sum = pc_add(sum, to_box_frame(bvh, pc_vec3_at(p, t[1])));
    sum = pc_add(sum, to_box_frame(bvh, pc_vec3_at(p, t[2])));
    const double centre[3] = {sum.x / 3, sum.y / 3, sum.z / 3};
    for (int k = 0; k < 3; k++) {
        const double x = (centre[k] + 1) * (most / 2);
        out.cell[k] = x > 0 ? (uint32_t)fmin(x, most - 1) : 0;
    }
    return out;
}

/* By one coordinate; no two items are equal. */
static uint64_t key_of(const item *i, int axis) {
    return (uint64_t)i->cell[axis] << 32 | i->face;
}

static uint64_t middle_of(uint64_t a, uint64_t b, uint64_t c) {
    const uint64_t low = a < b ? a : b, high = a < b ? b : a;
    return c < low ? low : c > high ? high : c;
}

/* Those before `at` are smaller along the axis than those from there on (Hoare 1961). */
static void part_at(item *items, size_t count, size_t at, int axis) {
    size_t low = 0, high = count;
    while (high - low > 1) {
        uint64_t pivot = key_of(items + low, axis);
        size_t i = low, j = high - 1;
        if (high - low > 2)
            pivot = middle_of(pivot, key_of(items + low + (high - low) / 2, axis), key_of(items + j, axis));
        for (;; i++, j--) {
            while (key_of(items + i, axis) < pivot)
                i++;
            while (key_of(items + j, axis) > pivot)
                j--;
            if (i >= j) break;
            const item swapped = items[i];
            items[i] = items[j], items[j] = swapped;
        }
        if (at <= j)
            high = j + 1;
        else
            low = j + 1;
    }
}

static int longest_axis(const item *items, size_t count) {
    uint32_t size[3];
    for (int k = 0; k < 3; k++) {
        uint32_t low = UINT32_MAX, high = 0;
        for (size_t i = 0; i < count; i++) {
            low = items[i].cell[k] < low ? items[i].cell[k] : low;
            high = items[i].cell[k] > high ? items[i].cell[k] : high;
        }
        size[k] = high - low;
    }
    return size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
}

/* Halves the items along the longest axis, between whole nodes, until each node has its own. */
static void group(item *items, size_t count) {
    enum { TASK = 4096 };
    size_t node = 1; /* items below each of the largest nodes that they do not all fit into */
    while (node * PC_BVH_WIDTH < count)
        node *= PC_BVH_WIDTH;
    if (count <= PC_BVH_WIDTH) return;
    const size_t nodes = (count + node - 1) / node, left = (nodes + 1) / 2 * node;
    part_at(items, count, left, longest_axis(items, count));
#pragma omp task if (left > TASK)
    group(items, left);
    group(items + left, count - left);
}

static pc_status order_faces(pc_bvh *bvh, pc_context *ctx) {
    pc_status status = PC_OK;
    const size_t count = bvh->mesh->face_count;
    item *items = NULL;
    PC_TRY(pc_resize(&items, ctx, count));
#pragma omp parallel
    {
#pragma omp for schedule(static)
        for (size_t f = 0; f < count; f++)
            items[f] = item_of(bvh, (pc_index)f);
#pragma omp single
        group(items, count);
#pragma omp for schedule(static)
        for (size_t i = 0; i < count; i++)
            bvh->face[i] = items[i].face;
    }
done:
    pc_free(ctx, items);
    return status;
}

/* An empty box is never nearer than anything. */
static void clear_block(pc_bvh_block *block) {
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < PC_BVH_WIDTH; i++)
            block->low[k][i] = INFINITY, block->high[k][i] = -INFINITY;
}

static void fill_triangles(pc_bvh *bvh, size_t b) {
    const pc_mesh *mesh = bvh->mesh;
    pc_bvh_block *block = bvh->block + b;
    clear_block(block);
    for (size_t i = 0; i < PC_BVH_WIDTH && PC_BVH_WIDTH * b + i < mesh->face_count; i++) {
        const pc_index *t = mesh->triangle + 3 * (size_t)bvh->face[PC_BVH_WIDTH * b + i];
        double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
        for (int corner = 0; corner < 3; corner++) {
            pc_vec3 p = to_box_frame(bvh, pc_vec3_at(mesh->position, t[corner]));
            const double x[3] = {p.x, p.y, p.z};
            for (int k = 0; k < 3; k++) {
                low[k] = x[k] < low[k] ? x[k] : low[k];
                high[k] = x[k] > high[k] ? x[k] : high[k];
            }
        }
        for (int k = 0; k < 3; k++)
            block->low[k][i] = round_down(low[k]), block->high[k][i] = round_up(high[k]);
    }
}

static void fill_parents(pc_bvh_block *parent, const pc_bvh_block *children, size_t child_count) {
    clear_block(parent);
    for (size_t c = 0; c < child_count; c++)
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < PC_BVH_WIDTH; i++) {
                if (children[c].low[k][i] < parent->low[k][c]) parent->low[k][c] = children[c].low[k][i];
                if (children[c].high[k][i] > parent->high[k][c]) parent->high[k][c] = children[c].high[k][i];
            }
}

static void fill_levels(pc_bvh *bvh) {
#pragma omp parallel for schedule(static)
    for (size_t b = 0; b < bvh->level_start[1]; b++)
        fill_triangles(bvh, b);
    for (int level = 1; level < bvh->level_count; level++) {
        size_t start = bvh->level_start[level], below = bvh->level_start[level - 1];
        size_t count = bvh->level_start[level + 1] - start, below_count = start - below;
#pragma omp parallel for schedule(static)
        for (size_t b = 0; b < count; b++) {
            size_t left = below_count - PC_BVH_WIDTH * b;
            fill_parents(bvh->block + start + b, bvh->block + below + PC_BVH_WIDTH * b,
                         left < PC_BVH_WIDTH ? left : PC_BVH_WIDTH);
        }
    }
}

pc_status pc_bvh_make(pc_bvh *bvh, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    *bvh = (pc_bvh){.mesh = mesh};
    fit_frame(bvh);
    size_t width = mesh->face_count, total = 0;
    while (width > 1 || bvh->level_count == 0) {
        width = (width + PC_BVH_WIDTH - 1) / PC_BVH_WIDTH;
        total += width;
        bvh->level_start[++bvh->level_count] = total;
    }
    PC_TRY(pc_new(&bvh->block, ctx, total));
    PC_TRY(pc_new(&bvh->face, ctx, mesh->face_count));
    PC_TRY(order_faces(bvh, ctx));
    fill_levels(bvh);
done:
    if (status != PC_OK) pc_bvh_free(bvh, ctx);
    return status;
}

void pc_bvh_free(pc_bvh *bvh, pc_context *ctx) {
    if (!bvh) return;
    pc_free(ctx, bvh->block);
    pc_free(ctx, bvh->face);
    *bvh = (pc_bvh){0};
}

static double closest_on_segment(double *u, pc_vec3 p, pc_vec3 a, pc_vec3 b) {
    pc_vec3 ab = pc_sub(b, a), ap = pc_sub(p, a);
    double length2 = pc_dot(ab, ab), t = length2 > 0 ? pc_dot(ap, ab) / length2 : 0;
    *u = t < 0 ? 0 : t > 1 ? 1 : t;
    pc_vec3 d = pc_madd(ap, -*u, ab);
    return pc_dot(d, d);
}

double pc_closest_on_triangle(double weight[3], pc_vec3 p, pc_vec3 a, pc_vec3 b, pc_vec3 c) {
    pc_vec3 ab = pc_sub(b, a), ac = pc_sub(c, a), ap = pc_sub(p, a);
    pc_vec3 n = pc_cross(ab, ac);
    double area2 = pc_dot(n, n), thin = 1e-20 * pc_dot(ab, ab) * pc_dot(ac, ac);
    double w = pc_dot(pc_cross(ab, ap), n), v = pc_dot(pc_cross(ap, ac), n);
    const bool needle = !(area2 > thin); /* its normal is noise */
    const bool past[3] = {!(w >= 0) || needle, !(v + w <= area2) || needle, !(v >= 0) || needle};
    if (!past[0] && !past[1] && !past[2]) { /* above the inside */
        weight[1] = v / area2, weight[2] = w / area2;
        weight[0] = 1 - weight[1] - weight[2];
        pc_vec3 d = pc_madd(pc_madd(ap, -weight[1], ab), -weight[2], ac);
        return pc_dot(d, d);
    }
    const pc_vec3 corner[3] = {a, b, c};
    double best = INFINITY;
    for (int k = 0; k < 3; k++) { /* on a side that the point is past */
        double u, d;
        if (!past[k]) continue;
        d = closest_on_segment(&u, p, corner[k], corner[(k + 1) % 3]);
        if (d < best) {
            best = d;
            weight[k] = 1 - u, weight[(k + 1) % 3] = u, weight[(k + 2) % 3] = 0;
        }
    }
    return best;
}

typedef struct search {
    pc_vec3 point;
    float low[3], high[3]; /* the point in the frame of the boxes, rounded both ways */
    double best2;          /* squared, model units */
    float reach2;          /* the same in the frame of the boxes, rounded up */
    double reach_scale;
    pc_index face;
    double weight[3];
} search;

static void try_face(search *s, const pc_mesh *mesh, pc_index f) {
    const pc_index *t = mesh->triangle + 3 * (size_t)f;
    const double *p = mesh->position;
    double weight[3];
    double d2 = pc_closest_on_triangle(weight, s->point, pc_vec3_at(p, t[0]), pc_vec3_at(p, t[1]),
                                       pc_vec3_at(p, t[2]));
    if (d2 < s->best2 || (d2 == s->best2 && f < s->face)) {
        s->best2 = d2, s->face = f;
        s->reach2 = round_up(d2 * s->reach_scale);
        memcpy(s->weight, weight, sizeof weight);
    }
}

/* Four floats at once: compilers do not find these selections in a plain loop. */
typedef float lanes __attribute__((vector_size(16)));
typedef int32_t lane_mask __attribute__((vector_size(16)));

static inline lanes load_lanes(const float *from) {
    lanes x;
    memcpy(&x, from, sizeof x);
    return x;
}

static inline lanes larger(lanes a, lanes b) {
    lane_mask first = a > b;
    return (lanes)(((lane_mask)a & first) | ((lane_mask)b & ~first));
}

/* Lower bounds of the squared distances to eight boxes: the factor covers the rounding of the float
 * arithmetic. */
static void box_distances(float *d2, const search *s, const pc_bvh_block *block) {
    const lanes zero = {0, 0, 0, 0};
    for (int i = 0; i < PC_BVH_WIDTH; i += 4) {
        lanes sum = zero;
        for (int k = 0; k < 3; k++) {
            lanes below = load_lanes(block->low[k] + i) - s->high[k];
            lanes above = s->low[k] - load_lanes(block->high[k] + i);
            lanes d = larger(larger(below, above), zero);
            sum += d * d;
        }
        sum *= 0.999999f;
        memcpy(d2 + i, &sum, sizeof sum);
    }
}

typedef struct visit {
    float d2;
    int level;
    size_t block; /* within its level */
} visit;

/* Opens one block: measures the triangles within reach, or stacks the children within reach, the nearest on
 * top. */
static int open_block(visit *stack, int top, search *s, const pc_bvh *bvh, visit at) {
    float d2[PC_BVH_WIDTH];
    int order[PC_BVH_WIDTH], count = 0;
    box_distances(d2, s, bvh->block + bvh->level_start[at.level] + at.block);
    size_t below_count =
        at.level ? bvh->level_start[at.level] - bvh->level_start[at.level - 1] : bvh->mesh->face_count;
    for (int i = 0; i < PC_BVH_WIDTH && PC_BVH_WIDTH * at.block + (size_t)i < below_count; i++) {
        if (!(d2[i] <= s->reach2)) continue;
        int j = count++;
        for (; j > 0 && d2[order[j - 1]] < d2[i]; j--)
            order[j] = order[j - 1];
        order[j] = i;
    }
    if (at.level == 0) {
        while (count-- > 0) {
            size_t place = PC_BVH_WIDTH * at.block + (size_t)order[count];
            if (d2[order[count]] <= s->reach2) try_face(s, bvh->mesh, bvh->face[place]);
        }
        return top;
    }
    for (int j = 0; j < count; j++)
        stack[top++] = (visit){d2[order[j]], at.level - 1, PC_BVH_WIDTH * at.block + (size_t)order[j]};
    return top;
}

pc_bvh_hit pc_bvh_closest(const pc_bvh *bvh, pc_vec3 point, pc_index hint) {
    const pc_mesh *mesh = bvh->mesh;
    pc_vec3 local = to_box_frame(bvh, point);
    search s = {.point = point,
                .best2 = INFINITY,
                .reach2 = INFINITY,
                .face = PC_NONE,
                .low = {round_down(local.x), round_down(local.y), round_down(local.z)},
                .high = {round_up(local.x), round_up(local.y), round_up(local.z)},
                .reach_scale = bvh->scale * bvh->scale * 1.000001};
    pc_bvh_hit hit = {.face = PC_NONE, .distance = INFINITY, .point = point};
    if (mesh->face_count == 0) return hit;
    if (hint < mesh->face_count) try_face(&s, mesh, hint);
    visit stack[STACK_SIZE];
    int top = 0;
    stack[top++] = (visit){0, bvh->level_count - 1, 0};
    while (top > 0) {
        visit at = stack[--top];
        if (at.d2 <= s.reach2) top = open_block(stack, top, &s, bvh, at);
    }
    if (s.face == PC_NONE) return hit;
    const pc_index *t = mesh->triangle + 3 * (size_t)s.face;
    pc_vec3 sum = pc_scale(s.weight[0], pc_vec3_at(mesh->position, t[0]));
    sum = pc_madd(sum, s.weight[1], pc_vec3_at(mesh->position, t[1]));
    hit.point = pc_madd(sum, s.weight[2], pc_vec3_at(mesh->position, t[2]));
    hit.face = s.face, hit.distance = sqrt(s.best2);
    memcpy(hit.weight, s.weight, sizeof s.weight);
    return hit;
}

void pc_bvh_closest_all(pc_bvh_hit *hits, const pc_bvh *bvh, const double *points, size_t count) {
    size_t chunks = (count + QUERY_CHUNK - 1) / QUERY_CHUNK;
#pragma omp parallel for schedule(dynamic, 8)
    for (size_t c = 0; c < chunks; c++) {
        pc_index hint = PC_NONE;
        size_t end = (c + 1) * QUERY_CHUNK < count ? (c + 1) * QUERY_CHUNK : count;
        for (size_t i = c * QUERY_CHUNK; i < end; i++) {
            hits[i] = pc_bvh_closest(bvh, pc_vec3_at(points, i), hint);
            hint = hits[i].face;
        }
    }
}
