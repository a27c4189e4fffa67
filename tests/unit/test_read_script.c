/* scripts/percale_read.py reads what we gather, and we read what it sealed; skipped where h5py is not
 * installed. */
#include "folder_testing.h"
#include "gather.h"
#include "memory.h"
#include "products.h"
#include "python.h"
#include "synth.h"

static bool skipped;

static pc_store *create(pc_context *ctx, const char *path, bool compress) {
    pc_store *store;
    const pc_store_options options = {.force = true, .compress = compress};
    assert_ok(ctx, pc_store_create(&store, ctx, path, &options));
    return store;
}

static void write_mesh_stage(pc_context *ctx, const pc_mesh *mesh, bool compress) {
    pc_store *store = create(ctx, "mesh.h5", compress);
    assert_ok(ctx, pc_store_set_text(store, "/", "options", "{\"name\": \"größer\"}"));
    assert_ok(ctx, pc_mesh_save(store, "mesh", mesh));
    assert_ok(ctx, pc_store_commit(&store));
}

static void write_field_stage(pc_context *ctx, const pc_mesh *mesh, bool compress) {
    pc_field field = {.symmetry = 4, .vertex_count = mesh->vertex_count, .face_count = mesh->face_count};
    assert_ok(ctx, pc_new(&field.normal, ctx, 3 * (size_t)mesh->vertex_count));
    assert_ok(ctx, pc_new(&field.direction, ctx, 3 * (size_t)mesh->vertex_count));
    assert_ok(ctx, pc_new(&field.index, ctx, mesh->face_count));
    assert_ok(ctx, pc_new(&field.loop_index, ctx, 0));
    for (pc_index f = 0; f < mesh->face_count; f++)
        field.index[f] = f % 41 == 7;
    pc_store *store = create(ctx, "field.h5", compress);
    assert_ok(ctx, pc_store_set_text(store, "/", "key", "0123"));
    assert_ok(ctx, pc_field_save(store, "field", &field));
    /* a stage that adds to the group of another one */
    assert_ok(ctx,
              pc_reals_save(store, "mesh/weight", mesh->position, 5, "1", "an array from another stage"));
    assert_ok(ctx, pc_store_commit(&store));
    pc_field_free(&field, ctx);
}

static void write_quads_stage(pc_context *ctx, bool compress) {
    static double position[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0.5, 0};
    static pc_index start[] = {0, 3, 7, 12}, corner[] = {0, 1, 2, 3, 2, 1, 0, 4, 3, 2, 1, 0};
    static uint8_t flat[12] = {[7] = 1};
    const pc_polymesh mesh = {5, 3, position, start, corner, flat};
    pc_store *store = create(ctx, "quads.h5", compress);
    assert_ok(ctx, pc_polymesh_save(store, "quads", &mesh));
    assert_ok(ctx, pc_store_commit(&store));
}

static void gather(pc_context *ctx, const char *path, bool compress) {
    static const char *const titles[] = {"mesh", "field", "quads"};
    char name[32];
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 1, 200, 100));
    write_mesh_stage(ctx, &mesh, compress);
    write_field_stage(ctx, &mesh, compress);
    write_quads_stage(ctx, compress);
    pc_store *result = create(ctx, path, compress), *stage;
    for (int i = 0; i < 3; i++) {
        (void)snprintf(name, sizeof name, "%s.h5", titles[i]);
        assert_ok(ctx, pc_store_open(&stage, ctx, name));
        assert_ok(ctx, pc_gather_stage(result, stage, titles[i]));
        if (i == 0) assert_int_equal(pc_gather_stage(result, stage, titles[i]), PC_E_BUG);
        pc_store_close(stage);
        assert_int_equal(unlink(name), 0);
    }
    assert_ok(ctx, pc_store_commit(&result));
    pc_mesh_free(&mesh, ctx);
}

/* The products come out of the gathered file as they were saved, and the file is the same each time. */
static void check_result(pc_context *ctx, const char *path) {
    pc_store *store;
    pc_mesh mesh, expected;
    pc_polymesh quads;
    assert_ok(ctx, pc_synth_torus(&expected, ctx, 2, 1, 200, 100));
    assert_ok(ctx, pc_store_open(&store, ctx, path));
    assert_ok(ctx, pc_mesh_load(&mesh, store, "mesh"));
    assert_memory_equal(mesh.position, expected.position, 3 * sizeof(double) * expected.vertex_count);
    assert_memory_equal(mesh.triangle, expected.triangle, 3 * sizeof(pc_index) * expected.face_count);
    assert_ok(ctx, pc_polymesh_load(&quads, store, "quads"));
    assert_int_equal(quads.face_count, 3);
    pc_mesh_free(&mesh, ctx), pc_mesh_free(&expected, ctx);
    pc_polymesh_free(&quads, ctx);
    pc_store_close(store);
}

static void equal_stages_gather_to_equal_bytes(void **state) {
    for (int compress = 0; compress < 2; compress++) {
        gather(*state, "one.h5", compress);
        (void)sleep(1); /* a time in seconds would show */
        gather(*state, "two.h5", compress);
        FILE *one = fopen("one.h5", "rb"), *two = fopen("two.h5", "rb");
        assert_true(one && two);
        for (int c = 0; c != EOF;) {
            c = getc(one);
            assert_int_equal(c, getc(two));
        }
        (void)fclose(one), (void)fclose(two);
    }
    assert_int_equal(unlink("one.h5") | unlink("two.h5"), 0);
}

static void python_reads_them(void **state) {
    pc_context *ctx = *state;
    int64_t symmetry;
    pc_store *store;
    gather(ctx, "plain.h5", false);
    gather(ctx, "compressed.h5", true);
    check_result(ctx, "plain.h5");
    check_result(ctx, "compressed.h5");
    int result = run_python("tests/readers/check_h5py.py", "plain.h5", "compressed.h5", NULL);
    skipped = result == PYTHON_SKIPS;
    if (!skipped) {
        assert_int_equal(result, 0);
        assert_ok(ctx, pc_store_open(&store, ctx, "plain.h5"));
        assert_ok(ctx, pc_store_get_int(&symmetry, store, "field", "symmetry"));
        assert_int_equal(symmetry, 2); /* changed by the script, and sealed again */
        pc_store_close(store);
    }
    assert_int_equal(unlink("plain.h5") | unlink("compressed.h5"), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(equal_stages_gather_to_equal_bytes, make_context, free_context),
        cmocka_unit_test_setup_teardown(python_reads_them, make_context, free_context),
    };
    int failed = cmocka_run_group_tests(tests, enter_folder, leave_folder);
    return failed == 0 && skipped ? PYTHON_SKIPS : failed;
}
