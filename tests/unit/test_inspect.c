/* Inspection of meshes that convert and of meshes that do not, and of the real scans where they are at hand.
 */
#include "inspect.h"
#include "scan.h"
#include "synth.h"
#include "testing.h"
#include <stdlib.h>

static const pc_repair_options PLAIN = PC_REPAIR_DEFAULTS;

static void cylinder_is_measured(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_inspection i;
    assert_ok(ctx, pc_synth_cylinder(&mesh, ctx, 2, 24, 5));
    assert_ok(ctx, pc_inspect(&i, ctx, &mesh, &PLAIN));
    assert_true(i.convertible);
    assert_false(i.repair.changed);
    assert_int_equal(i.topology.loop_count, 2);
    assert_int_equal(i.boundary_edge_count, 48);
    assert_int_equal(i.edge_count, i.edge_length.count);
    assert_in_range(i.valence_least, 3, 4);
    assert_in_range(i.valence_most, 6, 8);
    assert_true(fabs(i.edge_length.min - 2 * sin(PC_PI / 24)) < 1e-12);
    assert_true(fabs(i.angle.max - 90) < 1e-9);
    assert_true(fabs(i.angle.mean - 60) < 1e-9);
    assert_true(fabs(i.boundary_length.max - 48 * sin(PC_PI / 24)) < 1e-12);
    assert_int_equal((int)i.component_faces.max, 240);
    pc_inspection_free(&i, ctx);
    pc_mesh_free(&mesh, ctx);
}

static void refusal_is_told_not_failed(void **state) {
    pc_context *ctx = *state;
    const pc_index faces[9] = {0, 1, 2, 1, 0, 3, 0, 1, 4};
    pc_repair_options strict = {.strict = true};
    pc_mesh mesh;
    pc_inspection i;
    assert_ok(ctx, pc_mesh_make(&mesh, ctx, 5, 3));
    memcpy(mesh.triangle, faces, sizeof faces);
    for (pc_index v = 0; v < 5; v++)
        pc_vec3_put(mesh.position, v, (pc_vec3){v == 1, v == 2, v == 3 ? -1 : v == 4});
    assert_ok(ctx, pc_inspect(&i, ctx, &mesh, &strict));
    assert_false(i.convertible);
    assert_non_null(strstr(i.refusal, "0-1"));
    assert_int_equal(i.repair.crowded_edges.count, 1);
    assert_int_equal(i.mesh.face_count, 3);
    assert_string_equal(pc_context_message(ctx), "");
    pc_inspection_free(&i, ctx);

    for (int k = 0; k < 9; k++)
        mesh.triangle[k] = 0; /* nothing is left of it */
    assert_ok(ctx, pc_inspect(&i, ctx, &mesh, &PLAIN));
    assert_false(i.convertible);
    assert_int_equal(i.repair.degenerate_faces.count, 3);
    assert_int_equal(i.mesh.face_count, 0);
    pc_inspection_free(&i, ctx);
    mesh.triangle[4] = 5;
    assert_int_equal(pc_inspect(&i, ctx, &mesh, &PLAIN), PC_E_MESH);
    mesh.triangle[4] = 0, mesh.position[7] = NAN;
    pc_context_clear_message(ctx);
    assert_int_equal(pc_inspect(&i, ctx, &mesh, &PLAIN), PC_E_MESH);
    pc_mesh_free(&mesh, ctx);
}

static void data_path(char *path, size_t size, const char *name) {
    const char *folder = getenv("PERCALE_DATA");
    if (folder && *folder)
        (void)snprintf(path, size, "%s/%s", folder, name);
    else /* beside the source tree: this file is three levels down in it */
        (void)snprintf(path, size, "%.*s../../../shared/data/%s",
                       (int)(strrchr(__FILE__, '/') + 1 - __FILE__), __FILE__, name);
}

/* What the scans are known to be. */
static void real_scans_are_what_they_are(void **state) {
    static const struct {
        const char *name;
        int64_t chi;
        pc_index loops, boundary_edges, crowded;
        bool convertible;
    } known[] = {{"rocker-arm.obj", 0, 0, 0, 0, true},
                 {"botijo.obj", -8, 0, 0, 0, true},
                 {"fertility.off", -6, 0, 0, 0, true},
                 {"spot.obj", 2, 0, 0, 0, true},
                 {"stanford-bunny.obj", -3, 5, 223, 0, true},
                 {"camelhead.off", 1, 1, 56, 0, true},
                 {"skull.obj", -2, 0, 0, 0, true},
                 {"wingnut.obj", 2, 0, 0, 0, true},
                 {"abominevole.off", 0, 0, 0, 30361, false}};
    pc_context *ctx = *state;
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        char path[1024];
        pc_mesh mesh;
        pc_scan_info info;
        pc_inspection i;
        data_path(path, sizeof path, known[k].name);
        if (pc_scan_read(&mesh, &info, ctx, path) == PC_E_IO) skip();
        assert_ok(ctx, pc_inspect(&i, ctx, &mesh, &PLAIN));
        print_message("%s: %u faces, chi %lld, %u loops\n", known[k].name, i.mesh.face_count,
                      (long long)i.topology.chi, i.topology.loop_count);
        assert_int_equal(i.convertible, known[k].convertible);
        assert_int_equal(i.repair.crowded_edges.count, known[k].crowded);
        if (i.convertible) {
            assert_int_equal(i.topology.component_count, 1);
            assert_int_equal(i.topology.chi, known[k].chi);
            assert_int_equal(i.topology.loop_count, known[k].loops);
            assert_int_equal(i.boundary_edge_count, known[k].boundary_edges);
        }
        pc_inspection_free(&i, ctx);
        pc_mesh_free(&mesh, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(cylinder_is_measured, make_context, free_context),
        cmocka_unit_test_setup_teardown(refusal_is_told_not_failed, make_context, free_context),
        cmocka_unit_test_setup_teardown(real_scans_are_what_they_are, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
