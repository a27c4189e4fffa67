/* PLY in all its forms, and what is refused. */
#include "scan_testing.h"

static void all_formats_give_the_tetrahedron(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    make_ply_ascii(&b);
    reads_tetrahedron(ctx, "a.ply", &b);
    for (int variant = 0; variant < 4; variant++) {
        b.size = 0;
        make_ply_binary(&b, variant & 1, variant & 2);
        reads_tetrahedron(ctx, "b.PLY", &b);
    }
}

static void info_tells_what_was_there(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    pc_mesh mesh;
    pc_scan_info info;
    make_ply_ascii(&b);
    read_fine(&mesh, &info, ctx, "a.ply", &b);
    assert_string_equal(info.format, "PLY ascii");
    assert_string_equal(info.ignored, "colours");
    assert_int_equal(info.vertex_count, 4);
    assert_int_equal(info.face_count, 4);
    assert_int_equal(info.polygon_count, 0);
    assert_int_equal(info.file_bytes, b.size);
    assert_false(info.gzip);
    pc_mesh_free(&mesh, ctx);
}

static void strips_turn_every_second_triangle(void **state) {
    pc_context *ctx = *state;
    const pc_index expected[9] = {0, 1, 2, 2, 1, 3, 2, 1, 0};
    for (int big = 0; big < 2; big++) {
        scan_bytes b = {.size = 0};
        pc_mesh mesh;
        pc_scan_info info;
        make_ply_strips(&b, big);
        read_fine(&mesh, &info, ctx, "s.ply", &b);
        assert_int_equal(mesh.face_count, 3);
        assert_memory_equal(mesh.triangle, expected, sizeof expected);
        assert_int_equal(info.strip_count, 2);
        assert_int_equal(info.face_count, 3);
        pc_mesh_free(&mesh, ctx);
    }
}

static const char polygons[] = "ply\nformat ascii 1.0\nelement face 3\nproperty list uchar int vertex_index\n"
                               "property int tag\nelement vertex 5\nproperty double x\nproperty double y\n"
                               "property double z\nelement nothing 3\nend_header\n"
                               "4 0 1 2 3 7\n2 0 1 7\n3 0 0 4 7\n0 0 0\n4 0 0\n1 1 0\n0 4 0\n9 9 9\n";

/* Faces before vertices; the quad's corner 2 looks inwards, so that only one diagonal is right. */
static void polygons_come_before_vertices(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_scan_info info;
    const pc_index expected[9] = {0, 1, 2, 0, 2, 3, 0, 0, 4};
    assert_ok(ctx, pc_scan_read_bytes(&mesh, &info, ctx, "p.ply", polygons, strlen(polygons)));
    assert_int_equal(mesh.face_count, 3);
    assert_memory_equal(mesh.triangle, expected, sizeof expected);
    assert_int_equal(info.polygon_count, 1);
    assert_int_equal(info.short_face_count, 1);
    assert_int_equal(info.face_count, 3);
    pc_mesh_free(&mesh, ctx);
}

static void line_ends_of_all_systems(void **state) {
    pc_context *ctx = *state;
    scan_bytes unix_file = {.size = 0};
    make_ply_ascii(&unix_file);
    for (int variant = 0; variant < 2; variant++) {
        scan_bytes other = {.size = 0};
        for (size_t i = 0; i < unix_file.size; i++) {
            if (unix_file.data[i] == '\n')
                put_text(&other, variant ? "\r" : "\r\n");
            else
                put_bytes(&other, &unix_file.data[i], 1);
        }
        reads_tetrahedron(ctx, "a.ply", &other);
    }
}

static void damaged_ascii_is_refused_with_its_line(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    make_ply_ascii(&b);
    replaced_is_refused(ctx, "dir/a.ply", &b, "1 0 0 255", "1 zero 0 255",
                        "dir/a.ply:13: |vertex 1|'zero'|not a number");
    replaced_is_refused(ctx, "a.ply", &b, "1 0 0 255", "1 nan 0 255",
                        "a.ply:13: |vertex 1|y is not a finite");
    replaced_is_refused(ctx, "a.ply", &b, "1 0 0 255", "1e999 0 0 255",
                        "a.ply:13: |vertex 1|x is not a finite");
    replaced_is_refused(ctx, "a.ply", &b, "1 0 0 255", "1 0 255", "vertex 1|as many values");
    replaced_is_refused(ctx, "a.ply", &b, "1 0 0 255", "1 0 0 255 9", "a.ply:13: |vertex 1|as many values");
    replaced_is_refused(ctx, "a.ply", &b, "3 0 1 3", "3 0 1 4",
                        "a.ply:17: |face 1|vertex index 4|4 vertices");
    replaced_is_refused(ctx, "a.ply", &b, "3 0 1 3", "3 0 -1 3", "a.ply:17: |face 1|vertex index -1");
    replaced_is_refused(ctx, "a.ply", &b, "3 0 1 3", "3 0 1.5 3", "face 1|vertex index 1.5");
    replaced_is_refused(ctx, "a.ply", &b, "3 0 1 3", "99999999 0 1 3", "face 1|list of 99999999 items");
    replaced_is_refused(ctx, "a.ply", &b, "3 0 1 3", "-3 0 1 3", "face 1|list of -3 items");
    replaced_is_refused(ctx, "a.ply", &b, "face 4", "face 5", "a.ply:20: |face 4|truncated");
    replaced_is_refused(ctx, "a.ply", &b, "vertex 4", "vertex 4000000000",
                        "4000000000 records of element vertex|truncated");
    replaced_is_refused(ctx, "a.ply", &b, "face 4", "face 0", "without a face|point cloud");
}

static void damaged_binary_is_refused_with_its_byte(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    make_ply_binary(&b, false, false);
    size_t faces = b.size - 4 * 15;
    is_refused(ctx, "b.ply", b.data, b.size - 1, "b.ply: byte |face 3|truncated");
    is_refused(ctx, "b.ply", b.data, faces + 3, "records of element face|truncated");
    is_refused(ctx, "b.ply", b.data, faces - 20, "truncated");
    scan_bytes wrong = b;
    wrong.data[faces + 15 + 8] = 77; /* first corner of face 1 */
    char where[64];
    (void)snprintf(where, sizeof where, "b.ply: byte %zu: face 1|vertex index 77", faces + 15 + 4);
    is_refused(ctx, "b.ply", wrong.data, wrong.size, where);
    wrong = b;
    memset(wrong.data + faces + 15 + 4, 0xff, 4);
    is_refused(ctx, "b.ply", wrong.data, wrong.size, "face 1|list of 4294967295 items");
    wrong = b;
    memset(wrong.data + faces - 15 + 1, 0xff, 8); /* z of vertex 3 */
    (void)snprintf(where, sizeof where, "b.ply: byte %zu: vertex 3|z is not a finite", faces - 15 + 1);
    is_refused(ctx, "b.ply", wrong.data, wrong.size, where);
}

static void headers_that_make_no_sense(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    make_ply_ascii(&b);
    replaced_is_refused(ctx, "a.ply", &b, "end_header", "the_end", "a.ply:11: |'the_end'");
    replaced_is_refused(ctx, "a.ply", &b, "format ascii", "format utf8", "a.ply:2: |'utf8'");
    replaced_is_refused(ctx, "a.ply", &b, "format ascii 1.0\n", "", "format line");
    replaced_is_refused(ctx, "a.ply", &b, "property float y", "property real y", "a.ply:6: |'real'");
    replaced_is_refused(ctx, "a.ply", &b, "property float y", "property float v", "vertex has no number y");
    replaced_is_refused(ctx, "a.ply", &b, "vertex_indices", "corners", "face has no list vertex_indices");
    replaced_is_refused(ctx, "a.ply", &b, "list uchar", "list float", "counted by a float");
    replaced_is_refused(ctx, "a.ply", &b, "vertex 4", "vertex -4", "a.ply:4: |sensible count");
    replaced_is_refused(ctx, "a.ply", &b, "vertex 4", "vertex many", "a.ply:4: |sensible count");
    replaced_is_refused(ctx, "a.ply", &b, "element face 4", "element vertex 4", "two elements called vertex");
    text_is_refused(ctx, "a.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", "no end_header|truncated");
    text_is_refused(ctx, "a.ply", "ply\nformat ascii 1.0\nend_header\n", "without a single vertex");
}

static void text_and_binary_are_not_mixed_up(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    make_ply_ascii(&b);
    replaced_is_refused(ctx, "a.ply", &b, "format ascii", "format binary_little_endian",
                        "a.ply: byte |as text, though the header says binary");
    b.size = 0;
    make_ply_binary(&b, true, false);
    replaced_is_refused(ctx, "a.ply", &b, "binary_big_endian", "ascii", "vertex 0|binary bytes|says ascii");
    b.size = 0;
    put_text(&b, "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty char x\nproperty char y\n"
                 "property char z\nend_header\nabc");
    is_refused(ctx, "a.ply", b.data, b.size, "a.ply: byte |after 1 vertices without a face");
}

/* Every cut of every file is refused or, where only the last newline goes, read. */
static void every_truncation_is_refused(void **state) {
    pc_context *ctx = *state;
    for (int variant = 0; variant < 6; variant++) {
        scan_bytes b = {.size = 0};
        if (variant < 4)
            make_ply_binary(&b, variant & 1, variant & 2);
        else if (variant == 4)
            make_ply_strips(&b, false);
        else
            make_ply_ascii(&b);
        for (size_t size = 0; size + 2 < b.size; size++)
            is_refused(ctx, "cut.ply", b.data, size, "cut.ply");
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        scan_test(all_formats_give_the_tetrahedron),
        scan_test(info_tells_what_was_there),
        scan_test(strips_turn_every_second_triangle),
        scan_test(polygons_come_before_vertices),
        scan_test(line_ends_of_all_systems),
        scan_test(damaged_ascii_is_refused_with_its_line),
        scan_test(damaged_binary_is_refused_with_its_byte),
        scan_test(headers_that_make_no_sense),
        scan_test(text_and_binary_are_not_mixed_up),
        scan_test(every_truncation_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
