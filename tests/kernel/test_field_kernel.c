/* The field kernels, in both shapes, against the plain-C reference in double. */
#include "assembly.h"
#include "field.h"
#include "memory.h"
#include "singularity.h"
#include "synth.h"
#include "synth_wear.h"
#include "testing.h"
#include "vec3.h"

static void entries_agree(void **state) {
    pc_context *ctx = *state;
    for (int shape = 0; shape < 2; shape++) {
        pc_mesh mesh;
        pc_adjacency a;
        pc_connection c;
        pc_ring ring;
        pc_device *device;
        double *host = NULL, *other = NULL;
        assert_ok(ctx, pc_device_open(&device, ctx, NULL));
        pc_device_set_shape(device, shape ? PC_SHAPE_ROW : PC_SHAPE_CHUNK);
        assert_ok(ctx, pc_synth_cylinder(&mesh, ctx, 2, 90, 40));
        assert_ok(ctx, pc_synth_noise(&mesh, ctx, 0.3, 5));
        assert_ok(ctx, pc_adjacency_make(&a, ctx, &mesh));
        assert_ok(ctx, pc_connection_make(&c, ctx, &mesh, &a));
        assert_ok(ctx, pc_ring_make(&ring, ctx, &mesh, &a));
        size_t count = 2 * (size_t)ring.start[mesh.vertex_count];
        pc_assembly work = {&mesh, &a, &ring, c.weight, c.transport, 4, 0.8};
        assert_ok(ctx, pc_new(&host, ctx, count));
        assert_ok(ctx, pc_new(&other, ctx, count));
        pc_assembly_ref(host, &work);
        assert_ok(ctx, pc_assembly_launch(other, ctx, device, &work));
        for (size_t k = 0; k < count; k++)
            if (fabs(host[k] - other[k]) > 1e-6 * hypot(host[k & ~(size_t)1], host[k | 1]))
                fail_msg("entry %zu: %.9g on the host, %.9g on the device", k, host[k], other[k]);
        pc_free(ctx, host);
        pc_free(ctx, other);
        pc_ring_free(&ring, ctx);
        pc_connection_free(&c, ctx);
        pc_adjacency_free(&a, ctx);
        pc_mesh_free(&mesh, ctx);
        pc_device_close(device, ctx);
    }
}

/* The whole stage on a device gives the host's field: crosses agree, and so do the singularities' sums. */
static void stage_agrees(void **state) {
    pc_context *ctx = *state;
    const char *names[2] = {"host", NULL};
    pc_field field[2];
    pc_mesh mesh;
    pc_adjacency a;
    double worst = 0;
    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 1, 80, 40));
    assert_ok(ctx, pc_synth_noise(&mesh, ctx, 0.05, 5));
    assert_ok(ctx, pc_adjacency_make(&a, ctx, &mesh));
    for (int k = 0; k < 2; k++) {
        pc_device *device;
        pc_curvature curvature;
        pc_curvature_options curvature_options = PC_CURVATURE_DEFAULTS;
        pc_field_options options = PC_FIELD_DEFAULTS;
        assert_ok(ctx, pc_device_open(&device, ctx, names[k]));
        assert_ok(ctx, pc_curvature_make(&curvature, ctx, device, &mesh, &a, &curvature_options));
        assert_ok(ctx, pc_field_make(&field[k], ctx, device, &mesh, &a, &curvature, &options));
        assert_int_equal(pc_singularity_count(&field[k]), 0);
        pc_curvature_free(&curvature, ctx);
        pc_device_close(device, ctx);
    }
    for (pc_index v = 0; v < mesh.vertex_count; v++)
        worst = fmax(worst, fabs(remainder(field[0].angle[v] - field[1].angle[v], PC_PI / 2)));
    assert_true(worst < 0.01);
    pc_field_free(&field[0], ctx);
    pc_field_free(&field[1], ctx);
    pc_adjacency_free(&a, ctx);
    pc_mesh_free(&mesh, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(entries_agree, make_context, free_context),
        cmocka_unit_test_setup_teardown(stage_agrees, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
