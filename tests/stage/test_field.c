/* The field stage on shapes with known answers, and its refusals. */
#include "connection.h"
#include "curl.h"
#include "field.h"
#include "memory.h"
#include "singularity.h"
#include "synth.h"
#include "synth_wear.h"
#include "testing.h"
#include "vec3.h"

typedef struct stage {
    pc_mesh mesh;
    pc_adjacency adjacency;
    pc_curvature curvature;
    pc_field field;
    pc_device *device;
} stage;

static const pc_field_options field_defaults = PC_FIELD_DEFAULTS;

/* Takes the mesh in s->mesh through curvature and field. */
static void run(stage *s, pc_context *ctx, const pc_field_options *options) {
    pc_curvature_options defaults = PC_CURVATURE_DEFAULTS;
    assert_ok(ctx, pc_device_open(&s->device, ctx, "host"));
    assert_ok(ctx, pc_adjacency_make(&s->adjacency, ctx, &s->mesh));
    assert_ok(ctx, pc_curvature_make(&s->curvature, ctx, s->device, &s->mesh, &s->adjacency, &defaults));
    assert_ok(ctx, pc_field_make(&s->field, ctx, s->device, &s->mesh, &s->adjacency, &s->curvature, options));
    assert_ok(ctx, pc_field_check(&s->field, ctx, &s->mesh, &s->adjacency));
}

static void drop(stage *s, pc_context *ctx) {
    pc_device_close(s->device, ctx);
    pc_field_free(&s->field, ctx);
    pc_curvature_free(&s->curvature, ctx);
    pc_adjacency_free(&s->adjacency, ctx);
    pc_mesh_free(&s->mesh, ctx);
}

/* Degrees between a direction of the cross at v and the given one. */
static double cross_angle(const pc_field *field, pc_index v, pc_vec3 along) {
    pc_vec3 k = pc_vec3_at(field->direction, v), n = pc_vec3_at(field->normal, v);
    double a = fmod(fabs(atan2(pc_dot(along, pc_cross(n, k)), pc_dot(along, k))), PC_PI / 2);
    return (a > PC_PI / 4 ? PC_PI / 2 - a : a) * 180 / PC_PI;
}

static void sphere_has_the_fewest_singularities(void **state) {
    pc_context *ctx = *state;
    for (int symmetry = 1; symmetry <= 4; symmetry *= 2) {
        stage s = {0};
        pc_field_options options = field_defaults;
        options.symmetry = symmetry;
        assert_ok(ctx, pc_synth_sphere(&s.mesh, ctx, 24));
        run(&s, ctx, &options);
        assert_int_equal(pc_singularity_count(&s.field), 2 * symmetry);
        drop(&s, ctx);
    }
}

/* One direction stands for its cross; few edges turn from one to another. */
static void fields_are_combed(void **state) {
    pc_context *ctx = *state;
    stage s = {0};
    assert_ok(ctx, pc_synth_sphere(&s.mesh, ctx, 24));
    run(&s, ctx, &field_defaults);
    pc_index turned = 0, halves = 3 * s.mesh.face_count;
    for (pc_index h = 0; h < halves; h++)
        turned += s.field.turn[h] != 0;
    assert_true(turned > 0);
    assert_true(turned < halves / 20);
    drop(&s, ctx);
}

static void noise_does_not_litter_a_torus(void **state) {
    pc_context *ctx = *state;
    stage s = {0};
    double sum = 0;
    assert_ok(ctx, pc_synth_torus(&s.mesh, ctx, 2, 1, 160, 80));
    assert_ok(ctx, pc_synth_noise(&s.mesh, ctx, 0.13, 4)); /* 1 % of the tube's radius */
    run(&s, ctx, &field_defaults);
    assert_int_equal(pc_singularity_count(&s.field), 0);
    for (pc_index v = 0; v < s.mesh.vertex_count; v++) {
        pc_vec3 p = pc_vec3_at(s.mesh.position, v);
        sum += cross_angle(&s.field, v, pc_unit((pc_vec3){-p.y, p.x, 0})) / s.mesh.vertex_count;
    }
    print_message("noisy torus: the field is off by %.2f degrees\n", sum);
    assert_true(sum < 3);
    drop(&s, ctx);
}

static void plane_stays_constant_and_follows_its_border(void **state) {
    pc_context *ctx = *state;
    for (int rule = PC_BORDERS_OFF; rule <= PC_BORDERS_ALL; rule++) {
        stage s = {0};
        pc_field_options options = field_defaults;
        options.borders = (pc_border_rule)rule;
        assert_ok(ctx, pc_synth_plane(&s.mesh, ctx, 3, 2, 30, 20));
        for (size_t v = 0; v < s.mesh.vertex_count; v++) { /* turned off the axes of the start */
            double *p = s.mesh.position + 3 * v, x = p[0], y = p[1];
            p[0] = 0.9 * x - sqrt(0.19) * y;
            p[1] = sqrt(0.19) * x + 0.9 * y;
        }
        run(&s, ctx, &options);
        assert_int_equal(pc_singularity_count(&s.field), 0);
        double first = cross_angle(&s.field, 0, (pc_vec3){0.9, sqrt(0.19), 0}), worst = 0;
        for (pc_index v = 0; v < s.mesh.vertex_count; v++)
            worst = fmax(worst, fabs(cross_angle(&s.field, v, (pc_vec3){0.9, sqrt(0.19), 0}) - first));
        assert_true(worst < 0.5);
        if (rule != PC_BORDERS_OFF) assert_true(first < 0.5);
        drop(&s, ctx);
    }
}

/* Ragged holes do not draw the field of a cylinder away from its axis. */
static void ragged_holes_are_passed_by(void **state) {
    pc_context *ctx = *state;
    stage s = {0};
    double sum = 0;
    assert_ok(ctx, pc_synth_cylinder(&s.mesh, ctx, 4, 96, 60));
    assert_ok(ctx, pc_synth_holes(&s.mesh, ctx, 6, 40, 9));
    run(&s, ctx, &field_defaults);
    for (pc_index v = 0; v < s.mesh.vertex_count; v++)
        sum += cross_angle(&s.field, v, (pc_vec3){0, 0, 1}) / s.mesh.vertex_count;
    assert_true(sum < 1.5);
    drop(&s, ctx);
}

/* Around the axis of a flat ring the scale falls as 1/r; a constant field asks for none. */
static void curl_of_a_ring_is_corrected(void **state) {
    pc_context *ctx = *state;
    stage s = {0};
    double *scale = NULL, sum = 0, square = 0;
    pc_curl_options options = PC_CURL_DEFAULTS;
    assert_ok(ctx, pc_synth_cylinder(&s.mesh, ctx, 1, 120, 30));
    for (size_t v = 0; v < s.mesh.vertex_count; v++) {
        double *p = s.mesh.position + 3 * v, r = 1 + p[2];
        p[0] *= r;
        p[1] *= r;
        p[2] = 0;
    }
    run(&s, ctx, &field_defaults);
    assert_int_equal(pc_singularity_count(&s.field), 0);
    assert_ok(ctx, pc_new(&scale, ctx, s.mesh.vertex_count));
    assert_ok(ctx, pc_curl_correct(scale, ctx, s.device, &s.mesh, &s.adjacency, &s.field, &options));
    for (pc_index v = 0; v < s.mesh.vertex_count; v++) {
        const double *p = s.mesh.position + 3 * (size_t)v;
        double x = log(scale[v] * hypot(p[0], p[1]));
        assert_true(scale[v] > 0.45 && scale[v] <= 1);
        sum += x / s.mesh.vertex_count;
        square += x * x / s.mesh.vertex_count;
    }
    assert_true(sqrt(fabs(square - sum * sum)) < 0.02);
    pc_free(ctx, scale);
    drop(&s, ctx);
}

/* Along the parallels of a surface of revolution, however curved, a turn is a turn: the scale falls as 1/r.
 */
static void curl_of_a_torus_is_corrected(void **state) {
    pc_context *ctx = *state;
    stage s = {0};
    double *scale = NULL, sum = 0, square = 0;
    pc_curl_options options = PC_CURL_DEFAULTS;
    options.quantile = 1;
    assert_ok(ctx, pc_synth_torus(&s.mesh, ctx, 2, 0.8, 120, 60));
    run(&s, ctx, &field_defaults);
    assert_int_equal(pc_singularity_count(&s.field), 0);
    assert_ok(ctx, pc_new(&scale, ctx, s.mesh.vertex_count));
    assert_ok(ctx, pc_curl_correct(scale, ctx, s.device, &s.mesh, &s.adjacency, &s.field, &options));
    for (pc_index v = 0; v < s.mesh.vertex_count; v++) {
        const double *p = s.mesh.position + 3 * (size_t)v;
        double x = log(scale[v] * hypot(p[0], p[1]));
        sum += x / s.mesh.vertex_count;
        square += x * x / s.mesh.vertex_count;
    }
    if (!(sqrt(fabs(square - sum * sum)) < 0.02))
        fail_msg("log(scale r) varies by %g", sqrt(fabs(square - sum * sum)));
    pc_free(ctx, scale);
    drop(&s, ctx);
}

static void bad_options_are_refused(void **state) {
    pc_context *ctx = *state;
    stage s = {0};
    pc_field_options options = field_defaults;
    assert_ok(ctx, pc_synth_sphere(&s.mesh, ctx, 4));
    run(&s, ctx, &options);
    pc_field_free(&s.field, ctx);
    options.symmetry = 3;
    assert_int_equal(pc_field_make(&s.field, ctx, s.device, &s.mesh, &s.adjacency, &s.curvature, &options),
                     PC_E_USAGE);
    options.symmetry = 4;
    options.smoothness = 1;
    assert_int_equal(pc_field_make(&s.field, ctx, s.device, &s.mesh, &s.adjacency, &s.curvature, &options),
                     PC_E_USAGE);
    drop(&s, ctx);
}

/* Whichever allocation fails, nothing leaks and the message says so. */
static void survives_lack_of_memory(void **state) {
    pc_context *ctx = *state;
    stage s = {0};
    pc_field_options options = field_defaults;
    assert_ok(ctx, pc_synth_torus(&s.mesh, ctx, 2, 1, 12, 8));
    run(&s, ctx, &options);
    pc_field_free(&s.field, ctx);
    size_t before = pc_memory_used(ctx), n = 1;
    pc_status status = PC_E_NOMEM;
    for (; status == PC_E_NOMEM && n < 1000; n++) {
        pc_memory_fail_at(ctx, n);
        status = pc_field_make(&s.field, ctx, s.device, &s.mesh, &s.adjacency, &s.curvature, &options);
        if (status != PC_OK) assert_int_equal(pc_memory_used(ctx), before);
    }
    pc_memory_fail_at(ctx, 0);
    assert_int_equal(status, PC_OK);
    assert_true(n > 10);
    drop(&s, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(sphere_has_the_fewest_singularities, make_context, free_context),
        cmocka_unit_test_setup_teardown(fields_are_combed, make_context, free_context),
        cmocka_unit_test_setup_teardown(noise_does_not_litter_a_torus, make_context, free_context),
        cmocka_unit_test_setup_teardown(plane_stays_constant_and_follows_its_border, make_context,
                                        free_context),
        cmocka_unit_test_setup_teardown(ragged_holes_are_passed_by, make_context, free_context),
        cmocka_unit_test_setup_teardown(curl_of_a_ring_is_corrected, make_context, free_context),
        cmocka_unit_test_setup_teardown(curl_of_a_torus_is_corrected, make_context, free_context),
        cmocka_unit_test_setup_teardown(bad_options_are_refused, make_context, free_context),
        cmocka_unit_test_setup_teardown(survives_lack_of_memory, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
