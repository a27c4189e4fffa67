/* OFF with its prefixes, comments and counts, and what is refused. */
#include "scan_testing.h"

static void the_tetrahedron(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    pc_mesh mesh;
    pc_scan_info info;
    make_off(&b);
    read_fine(&mesh, &info, ctx, "t.off", &b);
    is_tetrahedron(&mesh);
    assert_string_equal(info.format, "OFF");
    assert_non_null(strstr(info.ignored, "colours"));
    pc_mesh_free(&mesh, ctx);
}

static void heads_of_many_kinds(void **state) {
    pc_context *ctx = *state;
    static const char *const heads[] = {"OFF\n4 4 6\n",      "OFF 4 4 6\n",         "OFF\n4 4\n",
                                        "NOFF\r\n4 4 0\r\n", "STOFF 4 4 0\n",       "STCNOFF\n# x\n\n4 4 0\n",
                                        "4 4 6\n",           "OFF # c\n4 4 6 # d\n"};
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++) {
        scan_bytes b = {.size = 0};
        put_text(&b, "%s", heads[i]);
        for (int v = 0; v < 4; v++)
            put_text(&b, "%g %g %g%s\n", tetra_position[v][0], tetra_position[v][1], tetra_position[v][2],
                     heads[i][0] == 'N' || heads[i][0] == 'S' ? " 0.5 0.25 0.125" : "");
        for (int f = 0; f < 4; f++)
            put_text(&b, "3 %u %u %u\n", tetra_face[f][0], tetra_face[f][1], tetra_face[f][2]);
        reads_tetrahedron(ctx, "t.off", &b);
    }
}

static const char square[] =
    "OFF\n5 3 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 2 0\n5 0 1 2 4 3\n2 0 1\n3 1 1 2 0.5 0.5 0.5\n";

static void polygons_and_odd_faces(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_scan_info info;
    assert_ok(ctx, pc_scan_read_bytes(&mesh, &info, ctx, "t.off", square, strlen(square)));
    assert_int_equal(mesh.face_count, 4);
    assert_int_equal(info.polygon_count, 1);
    assert_int_equal(info.short_face_count, 1);
    assert_int_equal(mesh.triangle[9], 1);
    assert_int_equal(mesh.triangle[10], 1);
    pc_mesh_free(&mesh, ctx);
}

static void damaged_files_are_refused_with_their_line(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    put_text(&b, "%s", square);
    replaced_is_refused(ctx, "t.off", &b, "1 1 0", "1 x 0", "t.off:5: |vertex 2|'x'|not a number");
    replaced_is_refused(ctx, "t.off", &b, "1 1 0", "1 1", "t.off:5: |vertex 2|fewer than three");
    replaced_is_refused(ctx, "t.off", &b, "1 1 0", "1 1 nan", "t.off:5: |vertex 2|'nan'|finite");
    replaced_is_refused(ctx, "t.off", &b, "5 0 1 2 4 3", "5 0 1 2 5 3", "t.off:8: |face 0|vertex index 5");
    replaced_is_refused(ctx, "t.off", &b, "5 0 1 2 4 3", "5 0 1 2 -4 3", "t.off:8: |face 0|vertex index -4");
    replaced_is_refused(ctx, "t.off", &b, "5 0 1 2 4 3", "6 0 1 2 4 3", "t.off:8: |face 0|fewer corners");
    replaced_is_refused(ctx, "t.off", &b, "5 0 1 2 4 3", "99999999999 0 1", "face 0|corners are more than");
    replaced_is_refused(ctx, "t.off", &b, "5 0 1 2 4 3", "five 0 1 2 4 3", "face 0|'five'");
    replaced_is_refused(ctx, "t.off", &b, "5 3 0", "5 4 0", "t.off:11: |face 3|truncated");
    replaced_is_refused(ctx, "t.off", &b, "5 3 0", "4000000000 3 0",
                        "t.off:2: |4000000000 vertices|do not fit");
    replaced_is_refused(ctx, "t.off", &b, "5 3 0", "5 9223372036854775807 0", "do not fit");
    replaced_is_refused(ctx, "t.off", &b, "5 3 0", "5 0 0", "without a face");
    replaced_is_refused(ctx, "t.off", &b, "5 3 0", "five 3 0", "'five' is not a number of vertices");
    replaced_is_refused(ctx, "t.off", &b, "OFF", "4OFF", "4OFF|convert it to PLY");
    replaced_is_refused(ctx, "t.off", &b, "OFF", "OFF BINARY", "binary OFF|convert it to PLY");
}

static void every_truncation_is_refused(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    make_off(&b);
    for (size_t size = 0; size + 20 < b.size; size++)
        is_refused(ctx, "cut.off", b.data, size, "cut.off");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        scan_test(the_tetrahedron),
        scan_test(heads_of_many_kinds),
        scan_test(polygons_and_odd_faces),
        scan_test(damaged_files_are_refused_with_their_line),
        scan_test(every_truncation_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
