/* STL in both forms: welding, titles that lie, and what is refused. */
#include "random.h"
#include "scan_testing.h"
#include "weld.h"

static void both_forms_give_the_tetrahedron(void **state) {
    pc_context *ctx = *state;
    static const char *const titles[] = {"made by a scanner", "solid and binary all the same", "solid facet"};
    scan_bytes b = {.size = 0};
    pc_mesh mesh;
    pc_scan_info info;
    make_stl_ascii(&b);
    for (int i = 0; i < 4; i++) {
        if (i > 0) {
            b.size = 0;
            make_stl_binary(&b, titles[i - 1]);
        }
        read_fine(&mesh, &info, ctx, "t.stl", &b);
        assert_int_equal(mesh.vertex_count, 4);
        assert_int_equal(mesh.face_count, 4);
        assert_int_equal(info.welded_count, 8);
        assert_int_equal(info.vertex_count, 12);
        assert_string_equal(info.format, i ? "STL binary" : "STL ascii");
        for (size_t c = 0; c < 12; c++)
            for (size_t k = 0; k < 3; k++) {
                double x = mesh.position[3 * (size_t)mesh.triangle[c] + k];
                assert_true(x == tetra_position[tetra_face[c / 3][c % 3]][k]);
                assert_false(x == 0 && 1 / x < 0);
            }
        /* in the order of the file: the first facet names 0, 1, 2 */
        assert_int_equal(mesh.triangle[0] + 10 * mesh.triangle[1] + 100 * mesh.triangle[2], 210);
        pc_mesh_free(&mesh, ctx);
    }
}

static void capitals_and_several_solids(void **state) {
    pc_context *ctx = *state;
    static const char text[] =
        "SOLID\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 1 0\nENDLOOP\n"
        "ENDFACET\nENDSOLID\n\n  solid two\r\n facet normal 0 0 1 outer\n outer loop vertex 0 0 0\n"
        "vertex 0 1 0 vertex 0 0 0 endloop endfacet\nendsolid two words\n";
    pc_mesh mesh;
    pc_scan_info info;
    assert_ok(ctx, pc_scan_read_bytes(&mesh, &info, ctx, "t.stl", text, strlen(text)));
    assert_int_equal(mesh.vertex_count, 3);
    assert_int_equal(mesh.face_count, 2);
    pc_mesh_free(&mesh, ctx);
}

/* Against comparing every point with every other. */
static void welding_is_exact(void **state) {
    pc_context *ctx = *state;
    enum { POINTS = 3000 };
    static double point[3 * POINTS];
    static pc_index index[POINTS];
    static pc_index expected[POINTS];
    pc_index count = 0;
    pc_weld weld = {0};
    pc_random random = {7};
    for (size_t i = 0; i < (size_t)3 * POINTS; i++) {
        uint64_t dice = pc_random_next(&random) % 12;
        point[i] = dice == 0 ? -0.0 : dice == 1 ? 0 : dice == 2 ? 1 : dice == 3 ? 1 + 0x1p-52 : (double)dice;
    }
    for (size_t i = 0; i < POINTS; i++) {
        expected[i] = PC_NONE;
        for (size_t j = 0; j < i && expected[i] == PC_NONE; j++)
            if (point[3 * i] == point[3 * j] && point[3 * i + 1] == point[3 * j + 1] &&
                point[3 * i + 2] == point[3 * j + 2])
                expected[i] = expected[j];
        if (expected[i] == PC_NONE) expected[i] = count++;
    }
    assert_ok(ctx, pc_weld_add(&weld, ctx, index, point, 100));
    assert_ok(ctx, pc_weld_add(&weld, ctx, index + 100, point + 300, POINTS - 100));
    assert_int_equal(weld.count, count);
    assert_memory_equal(index, expected, sizeof index);
    pc_weld_free(&weld, ctx);
}

static void damaged_files_are_refused(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    make_stl_ascii(&b);
    replaced_is_refused(ctx, "t.stl", &b, "vertex 1.000000e+00", "vertex x",
                        "t.stl:6: |facet 0|'x'|not a number");
    replaced_is_refused(ctx, "t.stl", &b, "vertex 1.000000e+00", "vertex inf",
                        "t.stl:6: |facet 0|'inf'|finite");
    replaced_is_refused(ctx, "t.stl", &b, "endloop", "vertex 1 2 3", "facet 0|'vertex'|'endloop'");
    replaced_is_refused(ctx, "t.stl", &b, "endfacet", "end", "t.stl:8: |facet 0|'end'|'endfacet'");
    text_is_refused(ctx, "t.stl", "solid empty\nendsolid empty\n", "not a single facet");
    for (size_t size = 40; size < b.size - 24; size++)
        is_refused(ctx, "t.stl", b.data, size, "t.stl:");
    b.size = 0;
    make_stl_binary(&b, "binary");
    for (size_t size = 1; size < b.size; size++)
        is_refused(ctx, "t.stl", b.data, size, "t.stl: byte ");
    is_refused(ctx, "t.stl", b.data, b.size - 1, "byte 80|promises 4 facets|after facet 3");
    memset(b.data + 84 + 50 + 12, 0xff, 4);
    is_refused(ctx, "t.stl", b.data, b.size, "byte 146: |facet 1|finite");
    memset(b.data + 80, 0xff, 4);
    is_refused(ctx, "t.stl", b.data, b.size, "promises 4294967295 facets");
    memset(b.data + 80, 0, 4);
    is_refused(ctx, "t.stl", b.data, 84, "not a single facet");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        scan_test(both_forms_give_the_tetrahedron),
        scan_test(capitals_and_several_solids),
        scan_test(welding_is_exact),
        scan_test(damaged_files_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
