/* The curvature kernels, in both shapes, against the plain-C reference in double. */
#include "curvature.h"
#include "memory.h"
#include "synth.h"
#include "synth_wear.h"
#include "testing.h"
#include "vec3.h"

static double turned(const pc_curvature *a, const pc_curvature *b, pc_index v) {
    pc_vec3 u = pc_vec3_at(a->direction, v), w = pc_vec3_at(b->direction, v);
    return atan2(pc_norm(pc_cross(u, w)), fabs(pc_dot(u, w)));
}

/* Neighbourhoods are chosen by a threshold: at some vertices rounding may choose the other one. */
static void compare(const pc_curvature *a, const pc_curvature *b, double largest) {
    pc_index other = 0;
    for (pc_index v = 0; v < a->vertex_count; v++) {
        double value =
            fmax(fabs(a->value[2 * v] - b->value[2 * v]), fabs(a->value[2 * v + 1] - b->value[2 * v + 1]));
        double weight = fabs(a->weight[v] - b->weight[v]);
        if (value > 1e-4 * largest || weight > 1e-3 || (a->weight[v] > 0.05 && turned(a, b, v) > 1e-3))
            other++;
    }
    if (other > a->vertex_count / 1000) fail_msg("%u of %u vertices differ", other, a->vertex_count);
}

static void check_mesh(pc_context *ctx, pc_mesh *mesh, pc_shape shape) {
    pc_adjacency a;
    pc_curvature host, other;
    pc_device *device;
    pc_curvature_options options = PC_CURVATURE_DEFAULTS;
    double largest = 0;
    assert_ok(ctx, pc_device_open(&device, ctx, NULL));
    pc_device_set_shape(device, shape);
    assert_ok(ctx, pc_adjacency_make(&a, ctx, mesh));
    assert_ok(ctx, pc_curvature_make(&host, ctx, NULL, mesh, &a, &options));
    assert_ok(ctx, pc_curvature_make(&other, ctx, device, mesh, &a, &options));
    assert_ok(ctx, pc_curvature_check(&other, ctx));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        largest = fmax(largest, fmax(fabs(host.value[2 * v]), fabs(host.value[2 * v + 1])));
    compare(&host, &other, largest);
    pc_curvature_free(&host, ctx);
    pc_curvature_free(&other, ctx);
    pc_adjacency_free(&a, ctx);
    pc_device_close(device, ctx);
}

static void agrees_on_a_noisy_torus(void **state) {
    pc_context *ctx = *state;
    for (int shape = 0; shape < 2; shape++) {
        pc_mesh mesh;
        assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 1, 150, 75));
        assert_ok(ctx, pc_synth_noise(&mesh, ctx, 0.1, 3));
        check_mesh(ctx, &mesh, shape ? PC_SHAPE_ROW : PC_SHAPE_CHUNK);
        pc_mesh_free(&mesh, ctx);
    }
}

/* Scans come in survey coordinates: single floats would see nothing here. */
static void agrees_far_from_the_origin(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_cylinder(&mesh, ctx, 3, 200, 100));
    assert_ok(ctx, pc_synth_holes(&mesh, ctx, 5, 20, 8));
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        mesh.position[3 * v] += 4e5;
        mesh.position[3 * v + 1] -= 5e6;
    }
    check_mesh(ctx, &mesh, PC_SHAPE_CHUNK);
    pc_mesh_free(&mesh, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(agrees_on_a_noisy_torus, make_context, free_context),
        cmocka_unit_test_setup_teardown(agrees_far_from_the_origin, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
