/* OBJ in all its forms, and what is refused. */
#include "random.h"
#include "scan_testing.h"

static void read_text(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const char *text) {
    assert_ok(ctx, pc_scan_read_bytes(mesh, info, ctx, "t.obj", text, strlen(text)));
}

static void the_tetrahedron_with_all_habits(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    pc_mesh mesh;
    pc_scan_info info;
    make_obj(&b);
    read_fine(&mesh, &info, ctx, "t.obj", &b);
    is_tetrahedron(&mesh);
    assert_string_equal(info.format, "OBJ");
    assert_string_equal(info.ignored, "normals, texture coordinates, colours");
    pc_mesh_free(&mesh, ctx);
    scan_bytes marked = {.size = 0};
    put_text(&marked, "\xef\xbb\xbf");
    put_bytes(&marked, b.data, b.size);
    reads_tetrahedron(ctx, "t.obj", &marked);
}

static void lone_carriage_returns_end_lines(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_scan_info info;
    read_text(&mesh, &info, ctx, "v 0 0 0\rv 1 0 0\rv 0 1 0\r# f 1 2 3\rf 1 2 \\\r 3\r");
    assert_int_equal(mesh.vertex_count, 3);
    assert_int_equal(mesh.face_count, 1);
    pc_mesh_free(&mesh, ctx);
    text_is_refused(ctx, "t.obj", "v 0 0 0\rv 1 0 0\rf 1 2 3\r", "t.obj:3: |face 0");
}

static void faces_may_come_first_and_odd_ones_stay(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_scan_info info;
    const pc_index expected[6] = {0, 2, 1, 0, 0, 2};
    read_text(&mesh, &info, ctx, "f 1 3 2\nf 1 1 3\nf 1 2\nl 1 2\nv 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nvp 1\n");
    assert_int_equal(mesh.face_count, 2);
    assert_memory_equal(mesh.triangle, expected, sizeof expected);
    assert_int_equal(info.face_count, 3);
    assert_int_equal(info.short_face_count, 1);
    assert_string_equal(info.ignored, "other statements");
    pc_mesh_free(&mesh, ctx);
}

static double area_of(const pc_mesh *mesh, pc_index first, pc_index last) {
    double area = 0;
    for (pc_index f = first; f < last; f++) {
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        const double *a = mesh->position + 3 * (size_t)t[0];
        const double *b = mesh->position + 3 * (size_t)t[1];
        const double *c = mesh->position + 3 * (size_t)t[2];
        double twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert_true(twice > 0);
        area += twice / 2;
    }
    return area;
}

static void polygons_are_cut_inside_their_outline(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    pc_mesh mesh;
    pc_scan_info info;
    make_obj_polygons(&b);
    read_fine(&mesh, &info, ctx, "t.obj", &b);
    assert_int_equal(mesh.face_count, 4 + 2 + 1);
    assert_int_equal(info.polygon_count, 2);
    assert_int_equal(info.face_count, 3);
    assert_true(area_of(&mesh, 0, 4) == 3);
    pc_mesh_free(&mesh, ctx);
}

/* Stars of random radii: concave everywhere, and still every triangle must turn left and the areas add up. */
static void random_stars_are_cut_well(void **state) {
    pc_context *ctx = *state;
    const double cosine[8] = {1, 0.7, 0, -0.7, -1, -0.7, 0, 0.7};
    for (uint64_t seed = 1; seed <= 300; seed++) {
        pc_random random = {seed};
        scan_bytes b = {.size = 0};
        double x[8];
        double y[8];
        double area = 0;
        for (int i = 0; i < 8; i++) {
            double r = 0.1 + pc_random_uniform(&random);
            x[i] = r * cosine[i];
            y[i] = r * cosine[(i + 6) % 8];
            put_text(&b, "v %.17g %.17g 3\n", x[i], y[i]);
        }
        for (int i = 0; i < 8; i++)
            area += (x[i] * y[(i + 1) % 8] - y[i] * x[(i + 1) % 8]) / 2;
        put_text(&b, "f 1 2 3 4 5 6 7 8\n");
        pc_mesh mesh;
        pc_scan_info info;
        read_fine(&mesh, &info, ctx, "t.obj", &b);
        double got = area_of(&mesh, 0, 6);
        if (!(got > area * (1 - 1e-12) && got < area * (1 + 1e-12))) fail_msg("seed %d", (int)seed);
        pc_mesh_free(&mesh, ctx);
    }
}

/* The shorter diagonal of a kite, and corners on a straight side: no flat triangle where one can be avoided.
 */
static void better_diagonals(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_scan_info info;
    const pc_index kite[6] = {1, 2, 3, 1, 3, 0};
    read_text(&mesh, &info, ctx, "v 0 0 0\nv 5 -1 0\nv 10 0 0\nv 5 1 0\nf 1 2 3 4\n");
    assert_memory_equal(mesh.triangle, kite, sizeof kite);
    pc_mesh_free(&mesh, ctx);
    read_text(&mesh, &info, ctx, "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 2 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n");
    assert_true(area_of(&mesh, 0, 4) == 4);
    pc_mesh_free(&mesh, ctx);
}

static void damaged_files_are_refused_with_their_line(void **state) {
    pc_context *ctx = *state;
    scan_bytes b = {.size = 0};
    make_obj(&b);
    replaced_is_refused(ctx, "t.obj", &b, "v 0 1 0", "v 0 one 0", "t.obj:8: |vertex 2|'one'|not a number");
    replaced_is_refused(ctx, "t.obj", &b, "v 0 1 0", "v 0 1", "t.obj:8: |vertex 2|fewer than three");
    replaced_is_refused(ctx, "t.obj", &b, "v 0 1 0", "v 0 -inf 0", "t.obj:8: |vertex 2|'-inf'|finite");
    replaced_is_refused(ctx, "t.obj", &b, "v 0 1 0", "v 0 1 0 red", "vertex 2|'red'");
    replaced_is_refused(ctx, "t.obj", &b, "f 2/1 3/1 4/1", "f 2/1 3/1 5/1",
                        "t.obj:18: |face 2|'5/1'|does not exist");
    replaced_is_refused(ctx, "t.obj", &b, "f 2/1 3/1 4/1", "f 2/1 0 4/1", "face 2|'0'|does not exist");
    replaced_is_refused(ctx, "t.obj", &b, "f 2/1 3/1 4/1", "f 2/1 -5 4/1", "face 2|'-5'|does not exist");
    replaced_is_refused(ctx, "t.obj", &b, "f 2/1 3/1 4/1", "f 2/1 3/x 4/1",
                        "face 2|'3/x'|not a vertex index");
    replaced_is_refused(ctx, "t.obj", &b, "f 2/1 3/1 4/1", "f 99999999999999999999 1 2",
                        "face 2|does not exist");
    text_is_refused(ctx, "t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2", "t.obj:4: |face 0|truncated");
    text_is_refused(ctx, "t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "t.obj:4: |without a face");
    text_is_refused(ctx, "t.obj", "f 1 2 3\n", "face 0|does not exist");
    text_is_refused(ctx, "t.obj", "# nothing\n", "without a single vertex");
}

/* Over many pieces, with everything that could fall on their borders; also the same with one thread. */
static void long_files_are_read_in_pieces(void **state) {
    pc_context *ctx = *state;
    enum { QUADS = 60000 };
    size_t room = (size_t)QUADS * 128;
    char *text = malloc(room);
    size_t n = 0;
    assert_non_null(text);
    for (int i = 0; i < QUADS; i++) {
        n += (size_t)snprintf(text + n, room - n, "v %d 0 0\nv %d.25 0 %s1\r\nv %d 1 0 # \\\n", i, i,
                              i % 3 ? "" : "\\\n", i);
        n += (size_t)snprintf(text + n, room - n, i % 2 ? "f -3 -2 \\\r\n -1\n" : "v 0 9 %d\nf -4 -3 -2 -1\n",
                              i);
    }
    pc_mesh mesh;
    pc_scan_info info;
    assert_true(n > 3 << 20);
    assert_ok(ctx, pc_scan_read_bytes(&mesh, &info, ctx, "t.obj", text, n));
    assert_int_equal(mesh.vertex_count, QUADS * 7 / 2);
    assert_int_equal(mesh.face_count, QUADS * 3 / 2);
    assert_int_equal(info.polygon_count, QUADS / 2);
    size_t vertex = 0;
    size_t face = 0;
    for (size_t i = 0; i < QUADS; i++) {
        assert_true(mesh.position[3 * vertex] == (double)i &&
                    mesh.position[3 * vertex + 3] == (double)i + 0.25);
        size_t sides = i % 2 ? 3 : 4;
        for (size_t k = 0; k < 3 * (sides - 2); k++) {
            size_t corner = mesh.triangle[3 * face + k];
            assert_true(corner >= vertex && corner < vertex + sides);
        }
        vertex += sides;
        face += sides - 2;
    }
    pc_mesh_free(&mesh, ctx);
    text[n - 2] = 'x';
    is_refused(ctx, "t.obj", text, n, "face 59999");
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        scan_test(the_tetrahedron_with_all_habits),
        scan_test(lone_carriage_returns_end_lines),
        scan_test(faces_may_come_first_and_odd_ones_stay),
        scan_test(polygons_are_cut_inside_their_outline),
        scan_test(random_stars_are_cut_well),
        scan_test(better_diagonals),
        scan_test(damaged_files_are_refused_with_their_line),
        scan_test(long_files_are_read_in_pieces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
