#include "deviation.h"
#include "geometry.h"
#include "memory.h"
#include <string.h>

enum { DIGIT_BITS = 8, DIGITS = 1 << DIGIT_BITS, MOST_PER_SIDE = 64, CHUNK = 128 };

static uint64_t bits_of(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits; /* grows with x where x >= 0 */
}

double pc_weighted_quantile(const double *value, const double *weight, size_t count, double fraction) {
    _Static_assert(sizeof(double) == 8, "doubles are selected by their bits");
    uint64_t prefix = 0;
    double total = 0, below = 0;
    for (size_t i = 0; i < count; i++)
        total += weight[i];
    if (!(total > 0)) return 0;
    for (int shift = 64 - DIGIT_BITS; shift >= 0; shift -= DIGIT_BITS) {
        double bin[DIGITS];
        size_t digit = 0, last = 0;
        memset(bin, 0, sizeof bin);
        for (size_t i = 0; i < count; i++) {
            uint64_t bits = bits_of(value[i]);
            if (shift + DIGIT_BITS < 64 && bits >> (shift + DIGIT_BITS) != prefix) continue;
            bin[bits >> shift & (DIGITS - 1)] += weight[i];
        }
        for (size_t d = 0; d < DIGITS; d++)
            if (bin[d] > 0) last = d;
        while (digit < last && below + bin[digit] < fraction * total)
            below += bin[digit++];
        prefix = prefix << DIGIT_BITS | digit;
    }
    double result;
    memcpy(&result, &prefix, sizeof result);
    return result;
}

typedef struct samples {
    const pc_mesh *mesh;
    const pc_bvh *to;
    uint8_t *per_side; /* per face: k, where the inside has k^2 samples */
    size_t *start;     /* per face: its first sample; the vertices come before all */
    double *distance, *weight;
} samples;

static void triangle_corners(pc_vec3 p[3], const pc_mesh *mesh, size_t f) {
    for (int k = 0; k < 3; k++)
        p[k] = pc_vec3_at(mesh->position, mesh->triangle[3 * f + k]);
}

static uint8_t samples_per_side(const pc_vec3 p[3], const pc_deviation_options *options) {
    double longest = fmax(pc_distance(p[0], p[1]), fmax(pc_distance(p[1], p[2]), pc_distance(p[2], p[0])));
    double wanted = options->spacing > 0 ? ceil(longest / options->spacing) : 0;
    if (wanted <= 1) wanted = 0; /* the corners will do */
    if (wanted < options->least) wanted = options->least;
    return (uint8_t)(wanted < MOST_PER_SIDE ? wanted : MOST_PER_SIDE);
}

static pc_status plan_samples(samples *s, pc_context *ctx, const pc_deviation_options *options) {
    pc_status status = PC_OK;
    size_t faces = s->mesh->face_count;
    PC_TRY(pc_new(&s->per_side, ctx, faces));
    PC_TRY(pc_new(&s->start, ctx, faces + 1));
#pragma omp parallel for schedule(static)
    for (size_t f = 0; f < faces; f++) {
        pc_vec3 p[3];
        triangle_corners(p, s->mesh, f);
        s->per_side[f] = samples_per_side(p, options);
    }
    s->start[0] = s->mesh->vertex_count;
    for (size_t f = 0; f < faces; f++)
        s->start[f + 1] = s->start[f] + (size_t)s->per_side[f] * s->per_side[f];
    PC_TRY(pc_new(&s->distance, ctx, s->start[faces]));
    PC_TRY(pc_new(&s->weight, ctx, s->start[faces]));
done:
    return status;
}

/* The centre of part i of the k^2 equal parts of a triangle: row by row, upright and hanging ones
 * alternating. */
static pc_vec3 part_centre(const pc_vec3 p[3], int k, int i) {
    int row = 0;
    while (i >= 2 * (k - row) - 1)
        i -= 2 * (k - row) - 1, row++;
    int column = i / 2;
    double third = i % 2 ? 2.0 / 3 : 1.0 / 3, u = (column + third) / k, v = (row + third) / k;
    return pc_add(pc_scale(1 - u - v, p[0]), pc_add(pc_scale(u, p[1]), pc_scale(v, p[2])));
}

static void measure_faces(samples *s) {
    size_t chunks = (s->mesh->face_count + (size_t)CHUNK - 1) / CHUNK;
#pragma omp parallel for schedule(dynamic, 4)
    for (size_t c = 0; c < chunks; c++) {
        size_t end = (c + 1) * CHUNK < s->mesh->face_count ? (c + 1) * CHUNK : s->mesh->face_count;
        pc_index hint = PC_NONE;
        for (size_t f = c * CHUNK; f < end; f++) {
            pc_vec3 p[3];
            int k = s->per_side[f];
            triangle_corners(p, s->mesh, f);
            double area = pc_triangle_area(p[0], p[1], p[2]);
            for (int i = 0; i < k * k; i++) {
                pc_bvh_hit hit = pc_bvh_closest(s->to, part_centre(p, k, i), hint);
                hint = hit.face;
                s->distance[s->start[f] + (size_t)i] = hit.distance;
                s->weight[s->start[f] + (size_t)i] = area / (k * k);
            }
        }
    }
}

static void weigh_vertices(samples *s) {
    for (size_t f = 0; f < s->mesh->face_count; f++) {
        pc_vec3 p[3];
        if (s->per_side[f]) continue;
        triangle_corners(p, s->mesh, f);
        double third = pc_triangle_area(p[0], p[1], p[2]) / 3;
        for (int k = 0; k < 3; k++)
            s->weight[s->mesh->triangle[3 * f + k]] += third;
    }
}

/* Vertices of no face stay at distance -1. */
static pc_status measure_vertices(samples *s, pc_context *ctx) {
    pc_status status = PC_OK;
    uint8_t *used = NULL;
    size_t vertices = s->mesh->vertex_count, chunks = (vertices + CHUNK - 1) / CHUNK;
    PC_TRY(pc_new(&used, ctx, vertices));
    for (size_t c = 0; c < 3 * (size_t)s->mesh->face_count; c++)
        used[s->mesh->triangle[c]] = 1;
#pragma omp parallel for schedule(dynamic, 4)
    for (size_t c = 0; c < chunks; c++) {
        size_t end = (c + 1) * CHUNK < vertices ? (c + 1) * CHUNK : vertices;
        pc_index hint = PC_NONE;
        for (size_t v = c * CHUNK; v < end; v++) {
            s->distance[v] = -1;
            if (!used[v]) continue;
            pc_bvh_hit hit = pc_bvh_closest(s->to, pc_vec3_at(s->mesh->position, v), hint);
            hint = hit.face;
            s->distance[v] = hit.distance;
        }
    }
done:
    pc_free(ctx, used);
    return status;
}

static void find_largest(double *label_max, samples *s, const pc_deviation_options *options) {
    for (pc_index i = 0; i < options->label_count; i++)
        label_max[i] = 0;
    for (size_t f = 0; f < s->mesh->face_count; f++) {
        double *most = label_max + options->label[f];
        for (int k = 0; k < 3; k++)
            *most = fmax(*most, s->distance[s->mesh->triangle[3 * f + k]]);
        for (size_t i = s->start[f]; i < s->start[f + 1]; i++)
            *most = fmax(*most, s->distance[i]);
    }
}

static pc_vec3 sample_point(const samples *s, size_t i) {
    pc_vec3 p[3];
    size_t low = 0, high = s->mesh->face_count;
    if (i < s->mesh->vertex_count) return pc_vec3_at(s->mesh->position, i);
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (s->start[middle] <= i)
            low = middle;
        else
            high = middle;
    }
    triangle_corners(p, s->mesh, low);
    return part_centre(p, s->per_side[low], (int)(i - s->start[low]));
}

static void sum_up(pc_deviation *deviation, samples *s) {
    size_t count = s->start[s->mesh->face_count], worst = 0, unused = 0;
    double sum = 0, total = 0;
    for (size_t i = 0; i < count; i++) {
        if (s->distance[i] < 0) {
            s->distance[i] = 0, s->weight[i] = 0;
            unused++;
            continue;
        }
        sum += s->weight[i] * s->distance[i];
        total += s->weight[i];
        if (s->distance[i] > s->distance[worst]) worst = i;
    }
    deviation->sample_count = count - unused;
    if (count == unused) return;
    deviation->mean = total > 0 ? sum / total : 0;
    deviation->q95 = pc_weighted_quantile(s->distance, s->weight, count, 0.95);
    deviation->max = s->distance[worst];
    deviation->worst = sample_point(s, worst);
}

pc_status pc_deviation_measure(pc_deviation *deviation, double *label_max, pc_context *ctx,
                               const pc_mesh *from, const pc_bvh *to, const pc_deviation_options *options) {
    pc_status status = PC_OK;
    samples s = {.mesh = from, .to = to};
    *deviation = (pc_deviation){0};
    PC_TRY(plan_samples(&s, ctx, options));
    PC_TRY(measure_vertices(&s, ctx));
    weigh_vertices(&s);
    measure_faces(&s);
    if (label_max && options->label) find_largest(label_max, &s, options);
    sum_up(deviation, &s);
done:
    pc_free(ctx, s.per_side);
    pc_free(ctx, s.start);
    pc_free(ctx, s.distance);
    pc_free(ctx, s.weight);
    return status;
}
