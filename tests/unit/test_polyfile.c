/* What is written is read back bit for bit; files appear whole, or not at all, and replace others only when
 * told to. */
#include "file.h"
#include "polyfile.h"
#include "random.h"
#include "scan_testing.h"
#include "synth.h"
#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[64];

static int make_folder(void **state) {
    (void)snprintf(folder, sizeof folder, "/tmp/percale-test-XXXXXX");
    return mkdtemp(folder) ? make_context(state) : -1;
}

static int remove_folder(void **state) {
    DIR *entries = opendir(folder);
    for (struct dirent *entry; entries && (entry = readdir(entries));) {
        char path[400];
        (void)snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        (void)unlink(path);
    }
    if (entries) (void)closedir(entries);
    (void)rmdir(folder);
    return free_context(state);
}

static const char *in_folder(const char *name) {
    static char path[2][128];
    static int which;
    which = !which;
    (void)snprintf(path[which], sizeof path[which], "%s/%s", folder, name);
    return path[which];
}

static int entry_count(void) {
    int count = 0;
    DIR *entries = opendir(folder);
    for (struct dirent *entry; entries && (entry = readdir(entries));)
        count += entry->d_name[0] != '.' || strlen(entry->d_name) > 2;
    if (entries) (void)closedir(entries);
    return count;
}

static void triangles_come_back_bit_for_bit(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 1, 60, 40));
    pc_random random = {11};
    for (size_t i = 0; i < 3 * (size_t)mesh.vertex_count; i++)
        mesh.position[i] *= i % 5 ? 1 + pc_random_uniform(&random) : 1e-200;
    assert_ok(ctx, pc_polyfile_write_mesh_obj(ctx, &mesh, in_folder("m.obj"), false));
    assert_ok(ctx, pc_polyfile_write_mesh_ply(ctx, &mesh, in_folder("m.ply"), false));
    static const char *const names[] = {"m.obj", "m.ply"};
    for (int i = 0; i < 2; i++) {
        pc_mesh back;
        pc_scan_info info;
        assert_ok(ctx, pc_scan_read(&back, &info, ctx, in_folder(names[i])));
        assert_int_equal(back.vertex_count, mesh.vertex_count);
        assert_int_equal(back.face_count, mesh.face_count);
        assert_memory_equal(back.position, mesh.position, 24 * (size_t)mesh.vertex_count);
        assert_memory_equal(back.triangle, mesh.triangle, 12 * (size_t)mesh.face_count);
        pc_mesh_free(&back, ctx);
    }
    assert_int_equal(entry_count(), 2);
    pc_mesh_free(&mesh, ctx);
}

static void compare_text(const char *path, const char *expected) {
    char text[512] = "";
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    size_t n = fread(text, 1, sizeof text - 1, file);
    text[n] = '\0';
    (void)fclose(file);
    assert_string_equal(text, expected);
}

static void polygons_are_written_as_they_are(void **state) {
    pc_context *ctx = *state;
    const double position[15] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 1.5, -0.1};
    const pc_index corner[7] = {0, 1, 2, 3, 3, 2, 4};
    pc_polymesh mesh;
    assert_ok(ctx, pc_polymesh_make(&mesh, ctx, 5, 2, 7));
    memcpy(mesh.position, position, sizeof position);
    memcpy(mesh.corner, corner, sizeof corner);
    mesh.start[1] = 4;
    mesh.start[2] = 7;
    assert_ok(ctx, pc_polyfile_write_obj(ctx, &mesh, in_folder("p.obj"), false));
    compare_text(in_folder("p.obj"),
                 "# Percale: 5 vertices, 2 faces\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 1.5 -0.1\n"
                 "f 1 2 3 4\nf 4 3 5\n");
    assert_ok(ctx, pc_polyfile_write_ply(ctx, &mesh, in_folder("p.ply"), false));
    pc_mesh back;
    pc_scan_info info;
    assert_ok(ctx, pc_scan_read(&back, &info, ctx, in_folder("p.ply")));
    assert_int_equal(info.face_count, 2);
    assert_int_equal(info.polygon_count, 1);
    assert_int_equal(back.face_count, 3);
    assert_memory_equal(back.position, position, sizeof position);
    pc_mesh_free(&back, ctx);
    pc_polymesh_free(&mesh, ctx);
}

static void nothing_is_replaced_unasked(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 2));
    const char *path = in_folder("m.obj");
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    (void)fputs("precious", file);
    (void)fclose(file);
    assert_int_equal(pc_polyfile_write_mesh_obj(ctx, &mesh, path, false), PC_E_IO);
    assert_non_null(strstr(pc_context_message(ctx), "exists already"));
    compare_text(path, "precious");
    assert_int_equal(entry_count(), 1);
    assert_ok(ctx, pc_polyfile_write_mesh_obj(ctx, &mesh, path, true));
    assert_int_equal(entry_count(), 1);
    pc_context_clear_message(ctx);
    assert_int_equal(pc_polyfile_write_mesh_ply(ctx, &mesh, "/no/such/folder/m.ply", true), PC_E_IO);
    pc_context_clear_message(ctx);
    assert_int_equal(pc_polyfile_write_mesh_ply(ctx, &mesh, "/dev/full", true), PC_E_IO);
    assert_non_null(strstr(pc_context_message(ctx), "not a regular file"));
    pc_mesh_free(&mesh, ctx);
}

/* Somebody else puts a file there between the first look and the end. */
static void a_file_that_comes_meanwhile_is_kept(void **state) {
    pc_context *ctx = *state;
    pc_writer writer;
    const char *path = in_folder("late.txt");
    assert_ok(ctx, pc_writer_open(&writer, ctx, path, false));
    assert_ok(ctx, pc_writer_put(&writer, "ours", 4));
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    (void)fputs("theirs", file);
    (void)fclose(file);
    assert_int_equal(pc_writer_commit(&writer), PC_E_IO);
    compare_text(path, "theirs");
    assert_int_equal(entry_count(), 1);
}

static void abandoned_and_failed_writers_leave_nothing(void **state) {
    pc_context *ctx = *state;
    pc_writer writer;
    assert_ok(ctx, pc_writer_open(&writer, ctx, in_folder("a.txt"), false));
    assert_ok(ctx, pc_writer_put(&writer, "half", 4));
    assert_int_equal(entry_count(), 1);
    pc_writer_abandon(&writer);
    pc_writer_abandon(&writer);
    assert_int_equal(entry_count(), 0);
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 2));
    for (size_t n = 1;; n++) {
        pc_context_clear_message(ctx);
        pc_memory_fail_at(ctx, n);
        pc_status status = pc_polyfile_write_mesh_obj(ctx, &mesh, in_folder("a.obj"), false);
        pc_memory_fail_at(ctx, 0);
        if (status == PC_OK) break;
        assert_int_equal(status, PC_E_NOMEM);
    }
    assert_int_equal(entry_count(), 1);
    pc_mesh_free(&mesh, ctx);
}

static void links_stay_links(void **state) {
    pc_context *ctx = *state;
    pc_writer writer;
    struct stat about;
    const char *link_path = in_folder("link");
    FILE *file = fopen(in_folder("real"), "w");
    assert_non_null(file);
    (void)fclose(file);
    assert_int_equal(symlink("real", link_path), 0);
    assert_ok(ctx, pc_writer_open(&writer, ctx, link_path, true));
    assert_ok(ctx, pc_writer_put(&writer, "new", 3));
    assert_ok(ctx, pc_writer_commit(&writer));
    assert_int_equal(lstat(link_path, &about), 0);
    assert_true(S_ISLNK(about.st_mode));
    compare_text(in_folder("real"), "new");
}

static void pipes_are_read_to_their_end(void **state) {
    pc_context *ctx = *state;
    int ends[2];
    char path[64];
    pc_file file;
    assert_int_equal(pipe(ends), 0);
    assert_int_equal(write(ends[1], "through a pipe", 14), 14);
    (void)close(ends[1]);
    (void)snprintf(path, sizeof path, "/dev/fd/%d", ends[0]);
    assert_ok(ctx, pc_file_open(&file, ctx, path));
    assert_int_equal(file.size, 14);
    assert_memory_equal(file.data, "through a pipe", 14);
    pc_file_close(&file, ctx);
    (void)close(ends[0]);
}

#define folder_test(name) cmocka_unit_test_setup_teardown(name, make_folder, remove_folder)

int main(void) {
    const struct CMUnitTest tests[] = {
        folder_test(triangles_come_back_bit_for_bit),
        folder_test(polygons_are_written_as_they_are),
        folder_test(nothing_is_replaced_unasked),
        folder_test(a_file_that_comes_meanwhile_is_kept),
        folder_test(abandoned_and_failed_writers_leave_nothing),
        folder_test(links_stay_links),
        folder_test(pipes_are_read_to_their_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
