#include "scatter.h"
#include "memory.h"
#include "random.h"
#include "vec3.h"

enum { POINTS_MOST = 200000, TRIES_PER_POINT = 12 };

typedef struct bin_grid {
    double size; /* of a cell = the spacing */
    size_t mask;
    pc_index *head; /* per bucket: the last point put in, plus 1 */
    pc_index *next; /* per point: the one before it in the bucket, plus 1 */
    double *point;  /* 3 per point taken */
} bin_grid;

static size_t bucket_of(const bin_grid *g, int64_t i, int64_t j, int64_t k) {
    return (size_t)pc_hash64((uint64_t)i * 73856093u ^ (uint64_t)j * 19349663u ^ (uint64_t)k * 83492791u) &
           g->mask;
}

static int crowded(const bin_grid *g, pc_vec3 p, const int64_t c[3]) {
    for (int64_t k = c[2] - 1; k <= c[2] + 1; k++)
        for (int64_t j = c[1] - 1; j <= c[1] + 1; j++)
            for (int64_t i = c[0] - 1; i <= c[0] + 1; i++)
                for (pc_index n = g->head[bucket_of(g, i, j, k)]; n; n = g->next[n - 1])
                    if (pc_distance(p, pc_vec3_at(g->point, n - 1)) < g->size) return 1;
    return 0;
}

static double face_area(const pc_mesh *mesh, size_t f) {
    const pc_index *v = mesh->triangle + 3 * f;
    pc_vec3 a = pc_vec3_at(mesh->position, v[0]);
    pc_vec3 n =
        pc_cross(pc_sub(pc_vec3_at(mesh->position, v[1]), a), pc_sub(pc_vec3_at(mesh->position, v[2]), a));
    double area = 0.5 * pc_norm(n);
    return isfinite(area) ? area : 0;
}

double pc_scatter_area(const pc_mesh *mesh) {
    double sum = 0;
    for (size_t f = 0; f < mesh->face_count; f++)
        sum += face_area(mesh, f);
    return sum;
}

/* The face in which the running sum of areas passes `at`. */
static size_t find_face(const double *sum, size_t count, double at) {
    size_t low = 0, high = count - 1;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (sum[middle] > at)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

static pc_vec3 point_of(const pc_mesh *mesh, size_t face, const float w[3]) {
    pc_vec3 p = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        p = pc_madd(p, w[k], pc_vec3_at(mesh->position, mesh->triangle[3 * face + (size_t)k]));
    return p;
}

static void try_point(pc_scatter *scatter, bin_grid *g, const pc_mesh *mesh, const double *sum,
                      pc_random *random) {
    size_t face = find_face(sum, mesh->face_count, sum[mesh->face_count - 1] * pc_random_uniform(random));
    double r = sqrt(pc_random_uniform(random)), q = pc_random_uniform(random);
    float w[3] = {(float)(1 - r), (float)(r * (1 - q)), (float)(r * q)};
    pc_vec3 p = point_of(mesh, face, w), o = pc_sub(p, pc_vec3_at(mesh->position, mesh->triangle[0]));
    int64_t c[3] = {(int64_t)floor(o.x / g->size), (int64_t)floor(o.y / g->size),
                    (int64_t)floor(o.z / g->size)};
    if (crowded(g, p, c)) return;
    size_t n = scatter->count++;
    scatter->face[n] = (pc_index)face;
    for (int k = 0; k < 3; k++)
        scatter->weight[3 * n + (size_t)k] = w[k];
    pc_vec3_put(g->point, n, p);
    size_t bucket = bucket_of(g, c[0], c[1], c[2]);
    g->next[n] = g->head[bucket];
    g->head[bucket] = (pc_index)n + 1;
}

pc_status pc_scatter_make(pc_scatter *scatter, pc_context *ctx, const pc_mesh *mesh, double spacing) {
    pc_status status = PC_OK;
    double *sum = NULL;
    bin_grid g = {0};
    *scatter = (pc_scatter){0};
    if (mesh->face_count == 0) return PC_OK;
    PC_TRY(pc_new(&sum, ctx, mesh->face_count));
    double total = 0;
    for (size_t f = 0; f < mesh->face_count; f++)
        sum[f] = total += face_area(mesh, f);
    if (!(total > 0) || !(spacing > 0)) goto done;
    /* Disks of radius spacing/2 thrown at random until full cover a little over half of a plane. */
    g.size = fmax(spacing, sqrt(0.9 * total / POINTS_MOST));
    size_t expected = (size_t)(0.9 * total / (g.size * g.size)) + 16, buckets = 64;
    while (buckets < 2 * expected)
        buckets *= 2;
    g.mask = buckets - 1;
    size_t most = 2 * expected;
    PC_TRY(pc_new(&g.head, ctx, buckets));
    PC_TRY(pc_new(&g.next, ctx, most));
    PC_TRY(pc_new(&g.point, ctx, 3 * most));
    PC_TRY(pc_new(&scatter->face, ctx, most));
    PC_TRY(pc_new(&scatter->weight, ctx, 3 * most));
    pc_random random = {12345};
    for (size_t k = 0; k < TRIES_PER_POINT * expected && scatter->count < most; k++)
        try_point(scatter, &g, mesh, sum, &random);
done:
    pc_free(ctx, sum);
    pc_free(ctx, g.head);
    pc_free(ctx, g.next);
    pc_free(ctx, g.point);
    if (status != PC_OK) pc_scatter_free(scatter, ctx);
    return status;
}

void pc_scatter_free(pc_scatter *scatter, pc_context *ctx) {
    pc_free(ctx, scatter->face);
    pc_free(ctx, scatter->weight);
    *scatter = (pc_scatter){0};
}
