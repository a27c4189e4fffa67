/* Curvature on shapes with known answers: orders of convergence, noise, and the window against a ball with a
 * rim. */
#include "curvature.h"
#include "geometry.h"
#include "memory.h"
#include "synth.h"
#include "synth_wear.h"
#include "testing.h"
#include "vec3.h"

/* What is right at a point: curvatures and the direction of k1. */
typedef struct truth {
    double k1, k2;
    pc_vec3 along;
} truth;
typedef truth truth_at(pc_vec3 p);

static truth on_sphere(pc_vec3 p) {
    (void)p;
    return (truth){1, 1, {0, 0, 0}};
}
static truth on_cylinder(pc_vec3 p) {
    return (truth){1, 0, pc_unit((pc_vec3){-p.y, p.x, 0})};
}
/* Centre circle 2, tube 1. */
static truth on_torus(pc_vec3 p) {
    double r = hypot(p.x, p.y), cosine = r - 2;
    pc_vec3 around = pc_unit((pc_vec3){-p.y, p.x, 0}), out = pc_unit((pc_vec3){p.x, p.y, 0});
    pc_vec3 normal = pc_unit((pc_vec3){out.x * cosine, out.y * cosine, p.z});
    return (truth){1, cosine / r, pc_cross(normal, around)};
}
/* z = (x^2 - y^2)/2: the shape operator in x and y, positive where convex against the normal that points up.
 */
static truth on_saddle(pc_vec3 p) {
    double e = 1 + p.x * p.x, f = -p.x * p.y, g = 1 + p.y * p.y, det = e * g - f * f, w = sqrt(det);
    double s00 = -g / (det * w), s01 = -f / (det * w), s10 = f / (det * w), s11 = e / (det * w);
    double mean = 0.5 * (s00 + s11), root = sqrt(mean * mean - (s00 * s11 - s01 * s10)), k1 = mean + root;
    double u = s01, v = k1 - s00;
    return (truth){k1, mean - root, pc_unit((pc_vec3){u, v, u * p.x - v * p.y})};
}

typedef struct errors {
    double value;     /* root mean square over both curvatures */
    double direction; /* mean angle, degrees, weighted as the field would */
    double weight;    /* mean */
    pc_index used;
} errors;

static double angle_between(pc_vec3 a, pc_vec3 b) {
    return atan2(pc_norm(pc_cross(a, b)), fabs(pc_dot(a, b))) * 180 / PC_PI;
}

static errors compare(const pc_curvature *c, const pc_mesh *mesh, truth_at *right, double reach) {
    errors e = {0, 0, 0, 0};
    double weights = 0;
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_vec3 p = pc_vec3_at(mesh->position, v);
        if (fabs(p.x) > reach || fabs(p.y) > reach || fabs(p.z) > reach) continue;
        truth t = right(p);
        double d1 = c->value[2 * v] - t.k1, d2 = c->value[2 * v + 1] - t.k2;
        e.value += d1 * d1 + d2 * d2;
        if (pc_norm(t.along) > 0.5) {
            e.direction += c->weight[v] * angle_between(pc_vec3_at(c->direction, v), t.along);
            weights += c->weight[v];
        }
        e.weight += c->weight[v];
        e.used++;
    }
    e.value = sqrt(e.value / (2.0 * e.used));
    e.direction = weights > 0 ? e.direction / weights : 0;
    e.weight /= e.used;
    return e;
}

static errors measure(pc_context *ctx, pc_mesh *mesh, truth_at *right, double reach) {
    pc_adjacency a;
    pc_curvature c;
    pc_curvature_options options = PC_CURVATURE_DEFAULTS;
    assert_ok(ctx, pc_adjacency_make(&a, ctx, mesh));
    assert_ok(ctx, pc_curvature_make(&c, ctx, NULL, mesh, &a, &options));
    assert_ok(ctx, pc_curvature_check(&c, ctx));
    errors e = compare(&c, mesh, right, reach);
    pc_curvature_free(&c, ctx);
    pc_adjacency_free(&a, ctx);
    pc_mesh_free(mesh, ctx);
    return e;
}

static void make_saddle(pc_mesh *mesh, pc_context *ctx, pc_index n) {
    assert_ok(ctx, pc_synth_plane(mesh, ctx, 2, 2, n, n));
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *p = mesh->position + 3 * v;
        p[0] -= 1;
        p[1] -= 1;
        p[2] = 0.5 * (p[0] * p[0] - p[1] * p[1]);
    }
}

/* Halving the edges (and with them the radius, which is in edges) divides the error by `ratio` at least. */
static void assert_order(const char *what, errors coarse, errors fine, double ratio, double most) {
    print_message("%s: error %.2e -> %.2e, directions %.2f -> %.2f degrees, weight %.2f\n", what,
                  coarse.value, fine.value, coarse.direction, fine.direction, fine.weight);
    if (!(fine.value < most && coarse.value > ratio * fine.value))
        fail_msg("%s: error %g falls to %g only", what, coarse.value, fine.value);
}

static void sphere_converges(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    errors e[2];
    for (int k = 0; k < 2; k++) {
        assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 16U << k));
        e[k] = measure(ctx, &mesh, on_sphere, 9);
    }
    assert_order("sphere", e[0], e[1], 1.0, 0.05);
    assert_true(e[1].weight < 0.1);
}

static void cylinder_converges(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    errors e[2];
    for (int k = 0; k < 2; k++) {
        assert_ok(ctx, pc_synth_cylinder(&mesh, ctx, 4, 48U << k, 30U << k));
        for (size_t v = 0; v < mesh.vertex_count; v++)
            mesh.position[3 * v + 2] -= 2;
        e[k] = measure(ctx, &mesh, on_cylinder, 1.2);
    }
    assert_order("cylinder", e[0], e[1], 3.5, 0.01);
    assert_true(e[1].direction < 0.5);
    assert_true(e[1].weight > 0.8);
}

static void torus_converges(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    errors e[2];
    for (int k = 0; k < 2; k++) {
        assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 1, 80U << k, 40U << k));
        e[k] = measure(ctx, &mesh, on_torus, 9);
    }
    assert_order("torus", e[0], e[1], 3.0, 0.02);
    assert_true(e[1].direction < 1);
}

static void saddle_converges(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    errors e[2];
    for (int k = 0; k < 2; k++) {
        make_saddle(&mesh, ctx, 40U << k);
        e[k] = measure(ctx, &mesh, on_saddle, 0.5);
    }
    assert_order("saddle", e[0], e[1], 3.0, 0.02);
    assert_true(e[1].weight > 0.5);
}

/* Noise of a standard deviation of `share` of the tube's radius, on a mesh with random vertex order. */
static errors noisy_torus(pc_context *ctx, pc_index across, double share, uint64_t seed) {
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 1, 2 * across, across));
    assert_ok(ctx, pc_synth_noise(&mesh, ctx, share / pc_synth_mean_edge(&mesh), seed));
    return measure(ctx, &mesh, on_torus, 9);
}

static void noise_turns_the_torus_little(void **state) {
    pc_context *ctx = *state;
    const pc_index across[3] = {40, 80, 160};
    const double most[3] = {3, 4, 5};
    for (int k = 0; k < 3; k++) {
        errors e = noisy_torus(ctx, across[k], 0.01, 11);
        print_message("torus, 1 %% noise, %u around the tube: directions off by %.2f degrees, weight %.2f\n",
                      across[k], e.direction, e.weight);
        assert_true(e.direction < most[k]);
    }
}

static void noise_on_a_plane_is_not_trusted(void **state) {
    pc_context *ctx = *state;
    for (int k = 1; k <= 3; k++) {
        pc_mesh mesh;
        pc_adjacency a;
        pc_curvature c;
        pc_curvature_options options = PC_CURVATURE_DEFAULTS;
        options.levels = 1;
        options.radius_edges = k == 1 ? 2 : k == 2 ? 3 : 6;
        double sum = 0;
        assert_ok(ctx, pc_synth_plane(&mesh, ctx, 60, 60, 60, 60));
        assert_ok(ctx, pc_synth_noise(&mesh, ctx, 0.1, 5));
        assert_ok(ctx, pc_adjacency_make(&a, ctx, &mesh));
        assert_ok(ctx, pc_curvature_make(&c, ctx, NULL, &mesh, &a, &options));
        for (pc_index v = 0; v < mesh.vertex_count; v++)
            sum += c.weight[v] / mesh.vertex_count;
        print_message("noisy plane, radius %g edges: weight %.3f\n", options.radius_edges, sum);
        assert_true(sum < 0.25);
        pc_curvature_free(&c, ctx);
        pc_adjacency_free(&a, ctx);
        pc_mesh_free(&mesh, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(sphere_converges, make_context, free_context),
        cmocka_unit_test_setup_teardown(cylinder_converges, make_context, free_context),
        cmocka_unit_test_setup_teardown(torus_converges, make_context, free_context),
        cmocka_unit_test_setup_teardown(saddle_converges, make_context, free_context),
        cmocka_unit_test_setup_teardown(noise_turns_the_torus_little, make_context, free_context),
        cmocka_unit_test_setup_teardown(noise_on_a_plane_is_not_trusted, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
