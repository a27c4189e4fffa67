/* Parameterizations of surfaces whose answer is known, and what must not change them. */
#include "connection.h"
#include "param_testing.h"
#include "singularity.h"

static pc_param_stats parameterize(pc_param *param, pc_context *ctx, pc_device *device, const shape *s,
                                   double period, pc_pgp_scheme scheme) {
    pc_param_options options = PC_PARAM_DEFAULTS;
    pc_param_stats stats;
    options.period_length = period;
    options.pgp.scheme = scheme;
    assert_ok(ctx,
              pc_param_make(param, &stats, ctx, device, &s->mesh, &s->adjacency, &s->field, NULL, &options));
    assert_ok(ctx, pc_param_check(param, ctx, &s->mesh, &s->adjacency));
    pc_index counts[4] = {0, 0, 0, 0};
    for (pc_index f = 0; f < param->face_count; f++)
        counts[param->singular[f]]++;
    assert_int_equal(counts[PC_DISLOCATION], stats.dislocations);
    assert_int_equal(counts[PC_FIELD_SINGULARITY], stats.field_singularities);
    assert_int_equal(counts[PC_FLIPPED], stats.flipped);
    return stats;
}

/* A field along `along`, projected, turned by a random quarter at every vertex unless seed is 0. */
static void lay_field(shape *s, pc_context *ctx, pc_vec3 (*along)(pc_vec3 p), uint64_t seed) {
    pc_connection connection;
    pc_random random = {seed};
    pc_index n = s->mesh.vertex_count;
    measure_shape(s, ctx);
    assert_ok(ctx, pc_connection_make(&connection, ctx, &s->mesh, &s->adjacency));
    s->field = (pc_field){.symmetry = 4, .vertex_count = n, .face_count = s->mesh.face_count};
    assert_ok(ctx, pc_new(&s->field.normal, ctx, 3 * (size_t)n));
    assert_ok(ctx, pc_new(&s->field.direction, ctx, 3 * (size_t)n));
    assert_ok(ctx, pc_new(&s->field.angle, ctx, n));
    memcpy(s->field.normal, connection.normal, 3 * sizeof(double) * n);
    for (pc_index v = 0; v < n; v++) {
        double wanted[3], quarter = seed ? (double)(pc_random_next(&random) % 4) : 0;
        pc_vec3_put(wanted, 0, along(pc_vec3_at(s->mesh.position, v)));
        s->field.angle[v] = pc_connection_angle(&connection, v, wanted) + quarter * PC_PI / 2;
        pc_connection_direction(s->field.direction + 3 * (size_t)v, &connection, v, s->field.angle[v]);
    }
    assert_ok(ctx, pc_singularity_find(&s->field, ctx, &s->mesh, &s->adjacency, &connection));
    assert_ok(ctx, pc_field_check(&s->field, ctx, &s->mesh, &s->adjacency));
    pc_connection_free(&connection, ctx);
}

static pc_vec3 slanting(pc_vec3 p) {
    (void)p;
    return (pc_vec3){cos(0.3), sin(0.3), 0};
}

static pc_vec3 upwards(pc_vec3 p) {
    (void)p;
    return (pc_vec3){0, 0, 1};
}

/* Energy 0 and no singular triangle, whatever quarters the field has been turned by. */
static void plane_is_exact(void **state) {
    pc_context *ctx = *state;
    pc_device *host = open_host(ctx);
    for (uint64_t seed = 0; seed < 4; seed++) {
        shape s = {0};
        pc_param param;
        assert_ok(ctx, pc_synth_plane(&s.mesh, ctx, 8, 5, 40, 25));
        lay_field(&s, ctx, slanting, seed);
        pc_param_stats stats = parameterize(&param, ctx, host, &s, 0.9, (pc_pgp_scheme)(seed % 2));
        if (stats.energy > 1e-4 || stats.dislocations + stats.field_singularities + stats.flipped)
            fail_msg("seed %llu: energy %g, %u dislocations, %u singularities, %u flipped",
                     (unsigned long long)seed, stats.energy, stats.dislocations, stats.field_singularities,
                     stats.flipped);
        pc_param_free(&param, ctx);
        free_shape(&s, ctx);
    }
    pc_device_close(host, ctx);
}

/* L goes into the circumference of the polygon 16 times. */
static void cylinder_closes(void **state) {
    pc_context *ctx = *state;
    pc_device *host = open_host(ctx);
    for (uint64_t seed = 0; seed < 3; seed++) {
        shape s = {0};
        pc_param param;
        assert_ok(ctx, pc_synth_cylinder(&s.mesh, ctx, 4, 64, 40));
        lay_field(&s, ctx, upwards, seed);
        pc_param_stats stats =
            parameterize(&param, ctx, host, &s, 2 * 64 * sin(PC_PI / 64) / 16, (pc_pgp_scheme)(seed % 2));
        assert_int_equal(stats.dislocations + stats.field_singularities + stats.flipped, 0);
        pc_param_free(&param, ctx);
        free_shape(&s, ctx);
    }
    pc_device_close(host, ctx);
}

static int64_t whole_turns(const pc_field *field) {
    int64_t sum = 0;
    for (pc_index f = 0; f < field->face_count; f++)
        sum += field->index[f];
    return sum;
}

/* Triangles that come back turned are those where the field is singular, as far as a quarter can tell. */
static void cones_are_the_fields(void **state) {
    pc_context *ctx = *state;
    pc_device *host = open_host(ctx);
    for (int kind = 0; kind < SHAPE_KINDS; kind += kind == 5 ? 4 : 1) { /* not the large ones */
        static const int64_t chi[SHAPE_KINDS] = {2, 0, 0, -2, 2, 2, 0, -2, -4, 2};
        shape s = {0};
        pc_param param;
        pc_index expected = 0;
        make_mesh(&s.mesh, ctx, kind, 3);
        finish_shape(&s, ctx, host);
        pc_param_stats stats = parameterize(&param, ctx, host, &s, 3 * s.longest_edge, PC_PGP_NORMALISE);
        for (pc_index f = 0; f < s.field.face_count; f++)
            expected += s.field.index[f] % 4 != 0;
        assert_int_equal(stats.field_singularities, expected);
        if (kind != 2 && kind != 3) assert_int_equal(whole_turns(&s.field), 4 * chi[kind]);
        pc_param_free(&param, ctx);
        free_shape(&s, ctx);
    }
    pc_device_close(host, ctx);
}

/* A thousand times as large, with cells as much larger: the same coordinates. */
static void scale_does_not_matter(void **state) {
    pc_context *ctx = *state;
    pc_device *host = open_host(ctx);
    shape s = {0};
    pc_param small, large;
    make_mesh(&s.mesh, ctx, 1, 11);
    finish_shape(&s, ctx, host);
    pc_param_stats before = parameterize(&small, ctx, host, &s, 2.5 * s.longest_edge, PC_PGP_NORMALISE);
    for (size_t i = 0; i < 3 * (size_t)s.mesh.vertex_count; i++)
        s.mesh.position[i] *= 1024;
    pc_param_stats after = parameterize(&large, ctx, host, &s, 1024 * 2.5 * s.longest_edge, PC_PGP_NORMALISE);
    assert_int_equal(before.field_singularities, after.field_singularities);
    assert_int_equal(before.dislocations, after.dislocations);
    assert_memory_equal(small.turn, large.turn, 3 * (size_t)s.mesh.face_count);
    size_t apart = 0;
    for (size_t i = 0; i < 2 * (size_t)s.mesh.vertex_count; i++) {
        int32_t gap = (small.coordinate[i] - large.coordinate[i]) & (PC_PERIOD - 1);
        apart += gap > PC_PERIOD / 1000 && gap < PC_PERIOD - PC_PERIOD / 1000;
    }
    assert_int_equal(apart, 0);
    pc_param_free(&small, ctx);
    pc_param_free(&large, ctx);
    free_shape(&s, ctx);
    pc_device_close(host, ctx);
}

/* s and t run along the circles of a torus; where tube and ring are whole cells long nothing has to break
 * outside. */
static pc_vec3 around_axis(pc_vec3 p) {
    return (pc_vec3){-p.y, p.x, 0};
}

static void torus_has_no_cones(void **state) {
    pc_context *ctx = *state;
    pc_device *host = open_host(ctx);
    shape s = {0};
    pc_param param;
    assert_ok(ctx, pc_synth_torus(&s.mesh, ctx, 2, 0.7, 80, 32));
    lay_field(&s, ctx, around_axis, 5);
    pc_param_stats stats = parameterize(&param, ctx, host, &s, 0.55, PC_PGP_NORMALISE);
    assert_int_equal(stats.field_singularities, 0);
    /* The ring is 2*pi*2.7/0.55 cells long outside and 2*pi*1.3/0.55 inside: 16 lines end, on both ways
     * round. */
    assert_true(stats.dislocations <= 64);
    pc_param_free(&param, ctx);
    free_shape(&s, ctx);
    pc_device_close(host, ctx);
}

/* The same field on the same mesh with its vertices numbered anew: the cones stay, and so does the quality.
 */
static void numbering_does_not_matter(void **state) {
    pc_context *ctx = *state;
    pc_device *host = open_host(ctx);
    pc_param_stats stats[2];
    for (int k = 0; k < 2; k++) {
        shape s = {0};
        pc_param param;
        assert_ok(ctx, pc_synth_cylinder(&s.mesh, ctx, 4, 64, 40));
        if (k) assert_ok(ctx, pc_synth_shuffle(&s.mesh, ctx, 9));
        lay_field(&s, ctx, upwards, 4);
        stats[k] = parameterize(&param, ctx, host, &s, 2 * 64 * sin(PC_PI / 64) / 16, PC_PGP_NORMALISE);
        pc_param_free(&param, ctx);
        free_shape(&s, ctx);
    }
    assert_int_equal(stats[0].field_singularities, stats[1].field_singularities);
    assert_int_equal(stats[0].dislocations, stats[1].dislocations);
    assert_int_equal(stats[0].flipped, stats[1].flipped);
    pc_device_close(host, ctx);
}

static void wrong_products_are_found(void **state) {
    pc_context *ctx = *state;
    pc_device *host = open_host(ctx);
    shape s = {0};
    pc_param param;
    assert_ok(ctx, pc_synth_plane(&s.mesh, ctx, 8, 5, 16, 10));
    lay_field(&s, ctx, slanting, 3);
    parameterize(&param, ctx, host, &s, 4 * s.longest_edge, PC_PGP_NORMALISE);
    for (int wrong = 0; wrong < 4; wrong++) {
        int32_t coordinate = param.coordinate[7], shift = param.shift[6];
        uint8_t turn = param.turn[3], flag = param.singular[5];
        if (wrong == 0) param.coordinate[7]++;
        if (wrong == 1) param.shift[6] += 2;
        if (wrong == 2) param.turn[3] = (turn + 1) & 3;
        if (wrong == 3) param.singular[5] = flag == PC_REGULAR ? PC_FLIPPED : PC_REGULAR;
        if (pc_param_check(&param, ctx, &s.mesh, &s.adjacency) != PC_E_BUG)
            fail_msg("wrong product %d passes", wrong);
        pc_context_clear_message(ctx);
        param.coordinate[7] = coordinate, param.shift[6] = shift;
        param.turn[3] = turn, param.singular[5] = flag;
        assert_ok(ctx, pc_param_check(&param, ctx, &s.mesh, &s.adjacency));
    }
    pc_param_free(&param, ctx);
    free_shape(&s, ctx);
    pc_device_close(host, ctx);
}

static void long_edges_are_refused(void **state) {
    pc_context *ctx = *state;
    pc_device *host = open_host(ctx);
    shape s = {0};
    pc_param param;
    pc_param_stats stats;
    pc_param_options options = PC_PARAM_DEFAULTS;
    assert_ok(ctx, pc_synth_plane(&s.mesh, ctx, 8, 5, 8, 5));
    lay_field(&s, ctx, slanting, 0);
    options.period_length = 1.9 * s.longest_edge;
    assert_int_equal(
        pc_param_make(&param, &stats, ctx, host, &s.mesh, &s.adjacency, &s.field, NULL, &options), PC_E_MESH);
    pc_context_clear_message(ctx);
    free_shape(&s, ctx);
    pc_device_close(host, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(plane_is_exact, make_context, free_context),
        cmocka_unit_test_setup_teardown(cylinder_closes, make_context, free_context),
        cmocka_unit_test_setup_teardown(cones_are_the_fields, make_context, free_context),
        cmocka_unit_test_setup_teardown(scale_does_not_matter, make_context, free_context),
        cmocka_unit_test_setup_teardown(torus_has_no_cones, make_context, free_context),
        cmocka_unit_test_setup_teardown(numbering_does_not_matter, make_context, free_context),
        cmocka_unit_test_setup_teardown(wrong_products_are_found, make_context, free_context),
        cmocka_unit_test_setup_teardown(long_edges_are_refused, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
