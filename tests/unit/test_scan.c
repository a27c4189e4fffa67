/* Which reader is taken, packed files, and the real scans. */
#include "random.h"
#include "scan_testing.h"
#include <libdeflate.h>
#include <unistd.h>

static size_t pack(char *out, size_t room, const char *data, size_t size) {
    struct libdeflate_compressor *compressor = libdeflate_alloc_compressor(6);
    assert_non_null(compressor);
    size_t packed = libdeflate_gzip_compress(compressor, data, size, out, room);
    libdeflate_free_compressor(compressor);
    assert_true(packed > 0);
    return packed;
}

static void content_decides(void **state) {
    pc_context *ctx = *state;
    scan_bytes b[6] = {{.size = 0}};
    make_ply_ascii(&b[0]);
    make_ply_binary(&b[1], true, true);
    make_obj(&b[2]);
    make_off(&b[3]);
    make_stl_ascii(&b[4]);
    make_stl_binary(&b[5], "solid");
    static const char *const names[] = {"s.ply", "s.ply", "s.obj", "s.off", "s.stl", "s.stl"};
    for (int i = 0; i < 6; i++) {
        reads_tetrahedron(ctx, "scan", &b[i]);
        reads_tetrahedron(ctx, "scan.dat", &b[i]);
        reads_tetrahedron(ctx, names[i], &b[i]);
        for (int j = 0; j < 6; j++)
            if (strcmp(names[i], names[j]) != 0)
                is_refused(ctx, names[j], b[i].data, b[i].size,
                           "byte 0: the content is |rename the file to .");
    }
}

static void other_files_are_named(void **state) {
    pc_context *ctx = *state;
    text_is_refused(ctx, "a.obj", "PK\3\4rest", "zip archive");
    text_is_refused(ctx, "a.ply", "glTF....", "glTF");
    text_is_refused(ctx, "a", "# vtk DataFile Version 3.0\n", "VTK");
    text_is_refused(ctx, "a.txt", "Hello\n", "none of PLY, OBJ, STL, OFF");
    text_is_refused(ctx, "a.txt", "", "empty");
    text_is_refused(ctx, "a.off", "Hello\n", "a.off:1: 'Hello' is not a number of vertices");
}

static void packed_files(void **state) {
    pc_context *ctx = *state;
    scan_bytes plain = {.size = 0};
    scan_bytes packed = {.size = 0};
    pc_mesh mesh;
    pc_scan_info info;
    make_ply_binary(&plain, false, false);
    packed.size = pack(packed.data, sizeof packed.data, plain.data, plain.size);
    reads_tetrahedron(ctx, "t.ply.gz", &packed);
    reads_tetrahedron(ctx, "t.ply", &packed);
    read_fine(&mesh, &info, ctx, "t", &packed);
    assert_true(info.gzip);
    assert_int_equal(info.file_bytes, packed.size);
    assert_int_equal(info.content_bytes, plain.size);
    pc_mesh_free(&mesh, ctx);
    is_refused(ctx, "t.obj.gz", packed.data, packed.size, "byte 0 (unpacked)|content is PLY|name says OBJ");
    for (size_t size = 3; size < packed.size; size++)
        is_refused(ctx, "t.ply.gz", packed.data, size, "t.ply.gz: byte |gzip data is damaged or truncated");
    packed.data[packed.size - 1] = 0x7f; /* the size it claims: 2 GB */
    is_refused(ctx, "t.ply.gz", packed.data, packed.size, "gzip data is damaged");
}

/* Several members, and rubbish or zeros behind them. */
static void packed_in_members(void **state) {
    pc_context *ctx = *state;
    scan_bytes plain = {.size = 0};
    scan_bytes packed = {.size = 0};
    make_obj(&plain);
    for (size_t at = 0; at < plain.size; at += 50) {
        size_t size = plain.size - at < 50 ? plain.size - at : 50;
        packed.size +=
            pack(packed.data + packed.size, sizeof packed.data - packed.size, plain.data + at, size);
    }
    reads_tetrahedron(ctx, "t.obj.gz", &packed);
    put_bytes(&packed, "\0\0\0\0", 4);
    reads_tetrahedron(ctx, "t.obj.gz", &packed);
}

/* A packed file that grows a thousandfold is read, in memory that goes with what comes out. */
static void well_packed_files_grow(void **state) {
    pc_context *ctx = *state;
    enum { SIZE = 4 << 20 };
    scan_bytes b = {.size = 0};
    char *text = malloc(SIZE);
    char *packed = malloc(SIZE);
    assert_true(text && packed);
    make_obj(&b);
    memset(text, ' ', SIZE);
    memcpy(text + SIZE - b.size, b.data, b.size);
    size_t size = pack(packed, SIZE, text, SIZE);
    assert_true(size < SIZE / 200);
    pc_mesh mesh;
    pc_scan_info info;
    pc_memory_reset_peak(ctx);
    assert_ok(ctx, pc_scan_read_bytes(&mesh, &info, ctx, "t.obj.gz", packed, size));
    is_tetrahedron(&mesh);
    assert_true(pc_memory_peak(ctx) < (size_t)6 * SIZE);
    pc_mesh_free(&mesh, ctx);
    free(text);
    free(packed);
}

/* Memory may fail at any moment: a status, and nothing left behind. */
static void every_allocation_may_fail(void **state) {
    pc_context *ctx = *state;
    scan_bytes b[5] = {{.size = 0}};
    make_ply_ascii(&b[0]);
    make_ply_strips(&b[1], true);
    make_obj_polygons(&b[2]);
    make_stl_ascii(&b[3]);
    scan_bytes off = {.size = 0};
    make_off(&off);
    b[4].size = pack(b[4].data, sizeof b[4].data, off.data, off.size);
    for (int i = 0; i < 5; i++)
        for (size_t n = 1;; n++) {
            pc_mesh mesh;
            pc_scan_info info;
            pc_context_clear_message(ctx);
            pc_memory_fail_at(ctx, n);
            pc_status status = pc_scan_read_bytes(&mesh, &info, ctx, "t", b[i].data, b[i].size);
            pc_memory_fail_at(ctx, 0);
            pc_mesh_free(&mesh, ctx);
            assert_int_equal(pc_memory_used(ctx), 0);
            if (status == PC_OK) break;
            assert_int_equal(status, PC_E_NOMEM);
            assert_true(n < 100);
        }
}

static void files_that_cannot_be_opened(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_scan_info info;
    assert_int_equal(pc_scan_read(&mesh, &info, ctx, "/no/such/scan.ply"), PC_E_IO);
    assert_non_null(strstr(pc_context_message(ctx), "/no/such/scan.ply: cannot be opened: No such file"));
    pc_context_clear_message(ctx);
    assert_int_equal(pc_scan_read(&mesh, &info, ctx, "/tmp"), PC_E_IO);
    assert_non_null(strstr(pc_context_message(ctx), "folder"));
    pc_context_clear_message(ctx);
    assert_int_equal(pc_scan_read(&mesh, &info, ctx, "/dev/null"), PC_E_FORMAT);
    assert_non_null(strstr(pc_context_message(ctx), "empty"));
}

/* The counts that the scans' README gives. */
static void real_scans(void **state) {
    pc_context *ctx = *state;
    static const struct {
        const char *name;
        size_t triangles;
    } scans[] = {{"rocker-arm.obj", 20088},       {"lucy.ply", 99970},  {"fandisk.off", 14454},
                 {"fertility.off", 9000},         {"beast.obj", 64618}, {"spot.obj", 23062},
                 {"cranium_2.8M.ply.gz", 2787938}};
    const char *folder = getenv("PERCALE_DATA");
    if (!folder || !*folder) folder = "../shared/data";
    for (size_t i = 0; i < sizeof scans / sizeof *scans; i++) {
        char path[1024];
        pc_mesh mesh;
        pc_scan_info info;
        (void)snprintf(path, sizeof path, "%s/%s", folder, scans[i].name);
        if (access(path, R_OK) != 0) continue;
        assert_ok(ctx, pc_scan_read(&mesh, &info, ctx, path));
        assert_int_equal(mesh.face_count, scans[i].triangles);
        pc_index most = 0;
        for (size_t c = 0; c < 3 * (size_t)mesh.face_count; c++)
            most = mesh.triangle[c] > most ? mesh.triangle[c] : most;
        assert_true(most < mesh.vertex_count);
        pc_mesh_free(&mesh, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        scan_test(content_decides),
        scan_test(other_files_are_named),
        scan_test(packed_files),
        scan_test(packed_in_members),
        scan_test(well_packed_files_grow),
        scan_test(every_allocation_may_fail),
        scan_test(files_that_cannot_be_opened),
        scan_test(real_scans),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
