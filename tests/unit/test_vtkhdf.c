/* VTK reads what we write (check_vtk.py compares the numbers); skipped where VTK is not installed. */
#include "memory.h"
#include "python.h"
#include "synth.h"
#include "vtkhdf.h"

static char path[3][64];
static bool skipped;

static void *filled(pc_context *ctx, size_t count, double scale, double shift) {
    double *array;
    assert_ok(ctx, pc_new(&array, ctx, count));
    for (size_t i = 0; i < count; i++)
        array[i] = (double)i * scale + shift;
    return array;
}

static pc_curvature example_curvature(pc_context *ctx, pc_index n) {
    pc_curvature c = {.vertex_count = n, .value = filled(ctx, 2 * (size_t)n, 0, 0)};
    for (pc_index v = 0; v < n; v++)
        c.value[2 * v] = v + 0.25, c.value[2 * v + 1] = -(double)v - 0.5;
    c.direction = filled(ctx, 3 * (size_t)n, 0.5, 0);
    assert_ok(ctx, pc_new(&c.weight, ctx, n));
    for (pc_index v = 0; v < n; v++)
        c.weight[v] = v / 1000.0;
    return c;
}

static pc_field example_field(pc_context *ctx, pc_index n, pc_index m) {
    pc_field field = {.symmetry = 4, .vertex_count = n, .face_count = m};
    field.normal = filled(ctx, 3 * (size_t)n, 2, 0);
    field.direction = filled(ctx, 3 * (size_t)n, 3, 0);
    assert_ok(ctx, pc_new(&field.index, ctx, m));
    for (pc_index f = 0; f < m; f++)
        field.index[f] = (int8_t)((int)(f % 5) - 2);
    return field;
}

static pc_param example_param(pc_context *ctx, pc_index n, pc_index m) {
    pc_param param = {.vertex_count = n, .face_count = m};
    assert_ok(ctx, pc_new(&param.coordinate, ctx, 2 * (size_t)n));
    assert_ok(ctx, pc_new(&param.singular, ctx, m));
    for (pc_index i = 0; i < 2 * n; i++)
        param.coordinate[i] = (int32_t)(1000 * (i + 1));
    for (pc_index f = 0; f < m; f++)
        param.singular[f] = (uint8_t)(f % 4);
    return param;
}

static void write_scan(pc_context *ctx) {
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 1, 20, 10));
    pc_curvature curvature = example_curvature(ctx, mesh.vertex_count);
    pc_field field = example_field(ctx, mesh.vertex_count, mesh.face_count);
    pc_param param = example_param(ctx, mesh.vertex_count, mesh.face_count);
    assert_ok(ctx, pc_vtkhdf_write_scan(ctx, path[0], &mesh, &curvature, &field, &param, NULL));
    pc_layout layout = {.mesh = mesh};
    assert_ok(ctx, pc_new(&layout.cell, ctx, mesh.face_count));
    assert_ok(ctx, pc_new(&layout.source_face, ctx, mesh.face_count));
    for (pc_index f = 0; f < mesh.face_count; f++)
        layout.cell[f] = f / 2, layout.source_face[f] = f / 3;
    assert_ok(ctx, pc_vtkhdf_write_layout(ctx, path[2], &layout, NULL));
    pc_curvature_free(&curvature, ctx);
    pc_field_free(&field, ctx);
    pc_param_free(&param, ctx);
    pc_layout_free(&layout, ctx);
}

static void write_polygons(pc_context *ctx) {
    static double position[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0.5, 0};
    static pc_index start[] = {0, 3, 7, 12}, corner[] = {0, 1, 2, 3, 2, 1, 0, 4, 3, 2, 1, 0};
    static uint8_t flat[12] = {[7] = 1};
    static const double extra[] = {1.5, 2.5, 3.5};
    const pc_vtk_array array = {"extra", PC_STORE_F64, 1, true, extra, "1", "something else"};
    const pc_polymesh mesh = {5, 3, position, start, corner, flat};
    assert_ok(ctx, pc_vtkhdf_write_polygons(ctx, path[1], &mesh, &array, 1, NULL));
}

static void vtk_reads_them(void **state) {
    static const char *const names[] = {"scan", "polygons", "layout"};
    for (int i = 0; i < 3; i++)
        (void)snprintf(path[i], sizeof path[i], "/tmp/percale-vtk-%ld-%s.hdf", (long)getpid(), names[i]);
    write_scan(*state);
    write_polygons(*state);
    int result = run_python("tests/readers/check_vtk.py", path[0], path[1], path[2]);
    for (int i = 0; i < 3; i++)
        assert_int_equal(unlink(path[i]), 0);
    skipped = result == PYTHON_SKIPS;
    if (!skipped) assert_int_equal(result, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(vtk_reads_them, make_context, free_context),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    return failed == 0 && skipped ? PYTHON_SKIPS : failed;
}
