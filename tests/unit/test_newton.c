/* The penalty on norms: its derivatives by finite differences, and what Newton's method makes of it. */
#include "newton.h"
#include "param_testing.h"
#include "pgp.h"

/* A shape's system and random strengths. */
typedef struct posed {
    shape s;
    pc_device *host;
    pc_edge_rows rows;
    pc_coupling coupling;
    pc_system system;
    double *strength, *x, *p, *y, *g, *g_other;
    size_t count;
} posed;

static void pose(posed *q, pc_context *ctx, int kind, pc_random *random) {
    *q = (posed){.host = open_host(ctx)};
    make_mesh(&q->s.mesh, ctx, kind, 40 + (uint64_t)kind);
    finish_shape(&q->s, ctx, q->host);
    assert_ok(ctx, pc_edge_rows_make(&q->rows, ctx, &q->s.mesh, &q->s.adjacency));
    assert_ok(ctx, pc_coupling_make(&q->coupling, ctx, q->host, &q->s.mesh, &q->s.adjacency, &q->s.field,
                                    NULL, 2.5 * q->s.longest_edge));
    assert_ok(ctx,
              pc_pgp_assemble(&q->system, ctx, q->host, &q->s.mesh, &q->s.adjacency, &q->rows, &q->coupling));
    q->count = 4 * (size_t)q->s.mesh.vertex_count;
    double **vectors[] = {&q->x, &q->p, &q->y, &q->g, &q->g_other};
    for (int k = 0; k < 5; k++)
        assert_ok(ctx, pc_new(vectors[k], ctx, q->count));
    assert_ok(ctx, pc_new(&q->strength, ctx, q->count / 4));
    for (size_t i = 0; i < q->count; i++) {
        q->x[i] = 2 * pc_random_uniform(random) - 1;
        q->p[i] = 2 * pc_random_uniform(random) - 1;
        q->strength[i / 4] = 0.01 + pc_random_uniform(random);
    }
}

static void clear(posed *q, pc_context *ctx) {
    double *vectors[] = {q->strength, q->x, q->p, q->y, q->g, q->g_other};
    for (int k = 0; k < 6; k++)
        pc_free(ctx, vectors[k]);
    pc_system_free(&q->system, ctx);
    pc_coupling_free(&q->coupling, ctx);
    pc_edge_rows_free(&q->rows, ctx);
    free_shape(&q->s, ctx);
    pc_device_close(q->host, ctx);
}

static double dot(const double *a, const double *b, size_t n) {
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

static void move(double *x, const double *p, double by, size_t n) {
    for (size_t i = 0; i < n; i++)
        x[i] += by * p[i];
}

/* Central differences of a quartic miss its slope by the third derivative times step^2/6 only. */
static void derivatives_are_differences(void **state) {
    pc_context *ctx = *state;
    const double step = 1e-4;
    for (int kind = 0; kind < SHAPE_KINDS; kind += 3) {
        posed q;
        pc_random random = {900 + (uint64_t)kind};
        pose(&q, ctx, kind, &random);
        (void)pc_newton_gradient(q.g, &q.system, q.strength, q.x);
        pc_newton_hessian(q.y, &q.system, q.strength, q.x, q.p);
        double slope = dot(q.g, q.p, q.count), size = sqrt(dot(q.y, q.y, q.count)), off = 0;
        move(q.x, q.p, step, q.count);
        double above = pc_newton_gradient(q.g, &q.system, q.strength, q.x);
        move(q.x, q.p, -2 * step, q.count);
        double below = pc_newton_gradient(q.g_other, &q.system, q.strength, q.x);
        double by_values = (above - below) / (2 * step), scale = fabs(slope) + size;
        if (!(fabs(by_values - slope) <= 1e-6 * scale))
            fail_msg("shape %d: slope %.12g, by differences %.12g", kind, slope, by_values);
        for (size_t i = 0; i < q.count; i++)
            off = fmax(off, fabs((q.g[i] - q.g_other[i]) / (2 * step) - q.y[i]));
        if (!(off <= 1e-6 * scale)) fail_msg("shape %d: the Hessian is off by %g", kind, off);
        clear(&q, ctx);
    }
}

/* The product with the Hessian is symmetric, and its penalty part is indefinite inside the unit circle. */
static void hessian_is_symmetric(void **state) {
    pc_context *ctx = *state;
    posed q;
    pc_random random = {77};
    pose(&q, ctx, 1, &random);
    for (size_t i = 0; i < q.count; i++)
        q.g[i] = pc_random_uniform(&random) - 0.5;
    pc_newton_hessian(q.y, &q.system, q.strength, q.x, q.p);
    double one = dot(q.y, q.g, q.count);
    pc_newton_hessian(q.y, &q.system, q.strength, q.x, q.g);
    double other = dot(q.y, q.p, q.count);
    assert_true(fabs(one - other) <= 1e-12 * (fabs(one) + (double)q.count));
    memset(q.x, 0, q.count * sizeof *q.x);
    for (size_t i = 0; i < q.count / 4; i++)
        q.strength[i] = 100;
    pc_newton_hessian(q.y, &q.system, q.strength, q.x, q.p);
    assert_true(dot(q.y, q.p, q.count) < 0);
    clear(&q, ctx);
}

/* Ends where the gradient vanishes, no higher than it began; norms neither fade nor grow, nowhere pinned. */
static void newton_finds_a_minimum(void **state) {
    pc_context *ctx = *state;
    static const int kinds[] = {1, 2}; /* others take long */
    for (size_t nth = 0; nth < sizeof kinds / sizeof *kinds; nth++) {
        const int kind = kinds[nth];
        posed q;
        pc_newton_options options = PC_NEWTON_DEFAULTS;
        pc_newton_stats stats;
        pc_random random = {5 + (uint64_t)kind};
        pose(&q, ctx, kind, &random);
        for (size_t i = 0; i < q.count / 4; i++)
            q.strength[i] = 0.5;
        options.least_gain = 0, options.most_steps = 200;
        double first = pc_newton_gradient(q.g, &q.system, q.strength, q.x), rising = 0;
        assert_ok(ctx, pc_newton_solve(q.x, &stats, ctx, q.host, &q.system, q.strength, &options));
        if (!(stats.gradient <= options.tolerance && stats.value < first))
            fail_msg("shape %d: from %g to %g, gradient %g after %u steps", kind, first, stats.value,
                     stats.gradient, stats.steps);
        for (int k = 0; k < 20; k++) { /* a minimum: no way leads down */
            for (size_t i = 0; i < q.count; i++)
                q.p[i] = 2e-3 * (pc_random_uniform(&random) - 0.5);
            move(q.x, q.p, 1, q.count);
            rising += pc_newton_gradient(q.g, &q.system, q.strength, q.x) > stats.value;
            move(q.x, q.p, -1, q.count);
        }
        assert_true(rising == 20);
        double square = dot(q.x, q.x, q.count) / ((double)q.count / 2);
        if (!(square > 0.5 && square < 1.01)) fail_msg("shape %d: mean square of the norms %g", kind, square);
        clear(&q, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(derivatives_are_differences, make_context, free_context),
        cmocka_unit_test_setup_teardown(hessian_is_symmetric, make_context, free_context),
        cmocka_unit_test_setup_teardown(newton_finds_a_minimum, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
