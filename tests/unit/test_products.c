/* load(save(x)) = x for every product, on random arrays; wrong indices in a file are refused. */
#include "memory.h"
#include "products.h"
#include "python.h"
#include "random.h"
#include "testing.h"

static char path[64];
static const pc_store_options options = {.force = true};

static int enter(void **state) {
    (void)state;
    (void)snprintf(path, sizeof path, "/tmp/percale-products-%ld.h5", (long)getpid());
    return 0;
}

static int leave(void **state) {
    (void)state;
    return unlink(path);
}

static void *random_bytes(pc_context *ctx, pc_random *random, size_t count, size_t size) {
    unsigned char *bytes;
    assert_ok(ctx, pc_new(&bytes, ctx, count * size));
    for (size_t i = 0; i < count * size; i++)
        bytes[i] = (unsigned char)pc_random_next(random);
    return bytes;
}

/* Indices below `limit`; now and then PC_NONE where that is allowed. */
static pc_index *random_indices(pc_context *ctx, pc_random *random, size_t count, size_t limit, bool none) {
    pc_index *list;
    assert_ok(ctx, pc_new(&list, ctx, count));
    for (size_t i = 0; i < count; i++)
        list[i] =
            none && pc_random_next(random) % 5 == 0 ? PC_NONE : (pc_index)(pc_random_next(random) % limit);
    return list;
}

/* count+1 offsets with steps of 2 to 5. */
static pc_index *random_offsets(pc_context *ctx, pc_random *random, size_t count) {
    pc_index *list;
    assert_ok(ctx, pc_new(&list, ctx, count + 1));
    for (size_t i = 0; i < count; i++)
        list[i + 1] = list[i] + 2 + (pc_index)(pc_random_next(random) % 4);
    return list;
}

static uint8_t *random_small(pc_context *ctx, pc_random *random, size_t count, unsigned limit) {
    uint8_t *list;
    assert_ok(ctx, pc_new(&list, ctx, count));
    for (size_t i = 0; i < count; i++)
        list[i] = (uint8_t)(pc_random_next(random) % limit);
    return list;
}

static pc_store *writing(pc_context *ctx) {
    pc_store *store;
    assert_ok(ctx, pc_store_create(&store, ctx, path, &options));
    return store;
}

static pc_store *written(pc_context *ctx, pc_store *store) {
    assert_ok(ctx, pc_store_commit(&store));
    assert_ok(ctx, pc_store_open(&store, ctx, path));
    return store;
}

static pc_mesh random_mesh(pc_context *ctx, pc_random *random, size_t vertices, size_t faces) {
    return (pc_mesh){(pc_index)vertices, (pc_index)faces,
                     random_bytes(ctx, random, 3 * vertices, sizeof(double)),
                     random_indices(ctx, random, 3 * faces, vertices, false)};
}

#define assert_same(one, two, array, count)                                                                  \
    assert_memory_equal((one).array, (two).array, (count) * sizeof *(one).array)

static void meshes_and_lists(void **state) {
    pc_context *ctx = *state;
    pc_random random = {1};
    for (size_t size = 0; size < 3; size++) {
        pc_mesh mesh = random_mesh(ctx, &random, 1 + 100 * size, 173 * size), copy;
        pc_index *list;
        double *reals;
        size_t count = 3 * (size_t)mesh.vertex_count;
        pc_store *store = writing(ctx);
        assert_ok(ctx, pc_mesh_save(store, "mesh", &mesh));
        assert_ok(ctx, pc_indices_save(store, "mesh/face_source", mesh.triangle, 3 * (size_t)mesh.face_count,
                                       "map"));
        assert_ok(ctx, pc_reals_save(store, "curl/scale", mesh.position, count, "1", "scale"));
        store = written(ctx, store);
        assert_ok(ctx, pc_mesh_load(&copy, store, "mesh"));
        assert_int_equal(copy.vertex_count, mesh.vertex_count);
        assert_int_equal(copy.face_count, mesh.face_count);
        assert_same(mesh, copy, position, count);
        assert_same(mesh, copy, triangle, 3 * (size_t)mesh.face_count);
        assert_ok(ctx, pc_reals_load(&reals, &count, store, "curl/scale"));
        assert_memory_equal(reals, mesh.position, count * sizeof *reals);
        count = PC_STORE_ANY;
        assert_ok(ctx, pc_indices_load(&list, &count, store, "mesh/face_source"));
        assert_int_equal(count, 3 * (size_t)mesh.face_count);
        assert_memory_equal(list, mesh.triangle, count * sizeof *list);
        pc_free(ctx, list), pc_free(ctx, reals);
        pc_mesh_free(&mesh, ctx), pc_mesh_free(&copy, ctx);
        pc_store_close(store);
    }
}

static pc_curvature random_curvature(pc_context *ctx, pc_random *random, pc_index n) {
    pc_curvature c = {.vertex_count = n, .radius = 0.3, .mean_edge = 0.1};
    c.normal = random_bytes(ctx, random, 3 * (size_t)n, sizeof(double));
    c.tensor = random_bytes(ctx, random, 6 * (size_t)n, sizeof(double));
    c.value = random_bytes(ctx, random, 2 * (size_t)n, sizeof(double));
    c.direction = random_bytes(ctx, random, 3 * (size_t)n, sizeof(double));
    c.weight = random_bytes(ctx, random, n, sizeof(double));
    return c;
}

static void curvatures(void **state) {
    pc_context *ctx = *state;
    pc_random random = {8};
    enum { N = 91 };
    pc_curvature one = random_curvature(ctx, &random, N), two;
    pc_store *store = writing(ctx);
    assert_ok(ctx, pc_curvature_save(store, "curvature", &one));
    store = written(ctx, store);
    assert_ok(ctx, pc_curvature_load(&two, store, "curvature"));
    assert_true(two.vertex_count == N && two.radius == 0.3 && two.mean_edge == 0.1);
    assert_same(one, two, normal, 3 * N);
    assert_same(one, two, tensor, 6 * N);
    assert_same(one, two, value, 2 * N);
    assert_same(one, two, direction, 3 * N);
    assert_same(one, two, weight, N);
    pc_store_close(store);
    pc_curvature_free(&one, ctx), pc_curvature_free(&two, ctx);
}

static pc_field random_field(pc_context *ctx, pc_random *random, pc_index loops) {
    pc_index n = 50 + loops, m = 93 + loops;
    return (pc_field){.symmetry = 1 << loops,
                      .vertex_count = n,
                      .face_count = m,
                      .loop_count = loops,
                      .normal = random_bytes(ctx, random, 3 * (size_t)n, sizeof(double)),
                      .direction = random_bytes(ctx, random, 3 * (size_t)n, sizeof(double)),
                      .index = random_bytes(ctx, random, m, 1),
                      .loop_index = random_bytes(ctx, random, loops, 4),
                      .angle = random_bytes(ctx, random, n, sizeof(double)),
                      .turn = random_small(ctx, random, 3 * (size_t)m, 1U << loops)};
}

static void fields(void **state) {
    pc_context *ctx = *state;
    pc_random random = {2};
    for (pc_index loops = 0; loops < 3; loops++) {
        pc_field field = random_field(ctx, &random, loops);
        const pc_index n = field.vertex_count, m = field.face_count;
        pc_field copy;
        pc_store *store = writing(ctx);
        assert_ok(ctx, pc_field_save(store, "field", &field));
        store = written(ctx, store);
        assert_ok(ctx, pc_field_load(&copy, store, "field"));
        assert_int_equal(copy.symmetry, field.symmetry);
        assert_int_equal(copy.vertex_count, n);
        assert_int_equal(copy.face_count, m);
        assert_int_equal(copy.loop_count, loops);
        assert_same(field, copy, normal, 3 * (size_t)n);
        assert_same(field, copy, direction, 3 * (size_t)n);
        assert_same(field, copy, index, m);
        assert_same(field, copy, loop_index, loops);
        assert_same(field, copy, angle, n);
        assert_same(field, copy, turn, 3 * (size_t)m);
        pc_field_free(&field, ctx), pc_field_free(&copy, ctx);
        pc_store_close(store);
    }
}

static pc_param random_param(pc_context *ctx, pc_random *random, pc_index n, pc_index m) {
    pc_param param = {.vertex_count = n, .face_count = m, .period_length = pc_random_uniform(random)};
    param.phase = random_bytes(ctx, random, 4 * (size_t)n, sizeof(float));
    param.coordinate = (int32_t *)random_indices(ctx, random, 2 * (size_t)n, PC_PERIOD, false);
    for (size_t i = 0; i < 2 * (size_t)n; i++)
        param.coordinate[i] |= 1;
    param.turn = random_small(ctx, random, 3 * (size_t)m, 4);
    param.shift = random_bytes(ctx, random, 6 * (size_t)m, 4);
    param.singular = random_small(ctx, random, m, PC_FLIPPED + 1);
    return param;
}

static void params(void **state) {
    pc_context *ctx = *state;
    pc_random random = {3};
    pc_param param = random_param(ctx, &random, 40, 70), copy;
    pc_store *store = writing(ctx);
    assert_ok(ctx, pc_param_save(store, "param", &param));
    store = written(ctx, store);
    assert_ok(ctx, pc_param_load(&copy, store, "param"));
    assert_true(copy.vertex_count == 40 && copy.face_count == 70 &&
                copy.period_length == param.period_length);
    assert_same(param, copy, phase, 4 * 40);
    assert_same(param, copy, coordinate, 2 * 40);
    assert_same(param, copy, turn, 3 * 70);
    assert_same(param, copy, shift, 6 * 70);
    assert_same(param, copy, singular, 70);
    pc_store_close(store);
    pc_param_free(&copy, ctx);

    param.turn[5] = 4;
    store = writing(ctx);
    assert_ok(ctx, pc_param_save(store, "param", &param));
    store = written(ctx, store);
    assert_int_equal(pc_param_load(&copy, store, "param"), PC_E_FORMAT);
    assert_non_null(strstr(pc_context_message(ctx), "'param/turn': 4 in row 5"));
    pc_store_close(store);
    pc_param_free(&param, ctx);
}

static pc_layout random_layout(pc_context *ctx, pc_random *random) {
    enum { VERTICES = 300, FACES = 555, NODES = 31, ARCS = 60, CELLS = 29 };
    pc_layout l = {.mesh = random_mesh(ctx, random, VERTICES, FACES)};
    l.node_count = NODES, l.arc_count = ARCS, l.cell_count = CELLS;
    l.source_face = random_indices(ctx, random, FACES, 100, false);
    l.cell = random_indices(ctx, random, FACES, CELLS, false);
    l.node_vertex = random_indices(ctx, random, NODES, VERTICES, false);
    l.arc_start = random_offsets(ctx, random, ARCS);
    l.arc_vertex = random_indices(ctx, random, l.arc_start[ARCS], VERTICES, false);
    l.arc_node = random_indices(ctx, random, 2 * ARCS, NODES, false);
    l.arc_cell = random_indices(ctx, random, 2 * ARCS, CELLS, true);
    l.cell_start = random_offsets(ctx, random, CELLS);
    l.cell_side = random_indices(ctx, random, l.cell_start[CELLS], 2 * ARCS, false);
    l.cell_side_flat = random_small(ctx, random, l.cell_start[CELLS], 2);
    return l;
}

static void layouts(void **state) {
    pc_context *ctx = *state;
    pc_random random = {4};
    pc_layout l = random_layout(ctx, &random), copy;
    pc_store *store = writing(ctx);
    assert_ok(ctx, pc_layout_save(store, "layout", &l));
    store = written(ctx, store);
    assert_ok(ctx, pc_layout_load(&copy, store, "layout"));
    assert_int_equal(copy.node_count, l.node_count);
    assert_int_equal(copy.arc_count, l.arc_count);
    assert_int_equal(copy.cell_count, l.cell_count);
    assert_int_equal(copy.mesh.vertex_count, l.mesh.vertex_count);
    assert_int_equal(copy.mesh.face_count, l.mesh.face_count);
    assert_same(l, copy, mesh.triangle, 3 * (size_t)l.mesh.face_count);
    assert_same(l, copy, source_face, l.mesh.face_count);
    assert_same(l, copy, cell, l.mesh.face_count);
    assert_same(l, copy, node_vertex, l.node_count);
    assert_same(l, copy, arc_start, (size_t)l.arc_count + 1);
    assert_same(l, copy, arc_vertex, l.arc_start[l.arc_count]);
    assert_same(l, copy, arc_node, 2 * (size_t)l.arc_count);
    assert_same(l, copy, arc_cell, 2 * (size_t)l.arc_count);
    assert_same(l, copy, cell_start, (size_t)l.cell_count + 1);
    assert_same(l, copy, cell_side, l.cell_start[l.cell_count]);
    assert_same(l, copy, cell_side_flat, l.cell_start[l.cell_count]);
    pc_store_close(store);
    pc_layout_free(&copy, ctx);
    pc_layout_free(&l, ctx);
}

/* Every index array of a layout, one past its end; every load must say so and free what it read. */
static void wrong_layouts_are_refused(void **state) {
    pc_context *ctx = *state;
    pc_random random = {5};
    for (int k = 0; k < 9; k++) {
        pc_layout l = random_layout(ctx, &random), copy;
        pc_index *place[] = {&l.mesh.triangle[7], &l.cell[3],      &l.node_vertex[30],
                             &l.arc_vertex[1],    &l.arc_node[9],  &l.arc_cell[4],
                             &l.cell_side[12],    &l.arc_start[7], &l.cell_start[3]};
        const pc_index value[] = {300, 29, 300, 300, 31, 29, 120, 1000000, 1000000};
        *place[k] = value[k];
        pc_store *store = writing(ctx);
        assert_ok(ctx, pc_layout_save(store, "layout", &l));
        store = written(ctx, store);
        pc_context_clear_message(ctx);
        assert_int_equal(pc_layout_load(&copy, store, "layout"), PC_E_FORMAT);
        assert_non_null(strstr(pc_context_message(ctx), "makes no sense"));
        pc_store_close(store);
        pc_layout_free(&l, ctx);
    }
}

static pc_polymesh random_polymesh(pc_context *ctx, pc_random *random, bool flat) {
    pc_polymesh mesh = {.vertex_count = 80, .face_count = 77};
    mesh.position = random_bytes(ctx, random, 240, sizeof(double));
    mesh.start = random_offsets(ctx, random, 77);
    mesh.corner = random_indices(ctx, random, mesh.start[77], 80, false);
    if (flat) mesh.corner_flat = random_small(ctx, random, mesh.start[77], 2);
    return mesh;
}

static void polymeshes(void **state) {
    pc_context *ctx = *state;
    pc_random random = {6};
    for (int flat = 0; flat < 2; flat++) {
        pc_polymesh mesh = random_polymesh(ctx, &random, flat), copy;
        pc_store *store = writing(ctx);
        assert_ok(ctx, pc_polymesh_save(store, "quads", &mesh));
        store = written(ctx, store);
        assert_ok(ctx, pc_polymesh_load(&copy, store, "quads"));
        assert_true(copy.vertex_count == 80 && copy.face_count == 77);
        assert_same(mesh, copy, position, 240);
        assert_same(mesh, copy, start, 78);
        assert_same(mesh, copy, corner, mesh.start[77]);
        assert_int_equal(copy.corner_flat != NULL, flat);
        if (flat) assert_same(mesh, copy, corner_flat, mesh.start[77]);
        pc_store_close(store);
        pc_polymesh_free(&copy, ctx), pc_polymesh_free(&mesh, ctx);
    }
}

/* docs/file-format.md has a row for every dataset; skipped without h5py. */
static void all_datasets_are_documented(void **state) {
    pc_context *ctx = *state;
    pc_random random = {9};
    pc_mesh mesh = random_mesh(ctx, &random, 7, 10);
    pc_curvature curvature = random_curvature(ctx, &random, 7);
    pc_field field = random_field(ctx, &random, 2);
    pc_param param = random_param(ctx, &random, 7, 10);
    pc_layout layout = random_layout(ctx, &random);
    pc_polymesh quads = random_polymesh(ctx, &random, true);
    pc_store *store = writing(ctx);
    assert_ok(ctx, pc_mesh_save(store, "mesh", &mesh));
    assert_ok(ctx, pc_curvature_save(store, "curvature", &curvature));
    assert_ok(ctx, pc_field_save(store, "field", &field));
    assert_ok(ctx, pc_param_save(store, "param", &param));
    assert_ok(ctx, pc_layout_save(store, "layout", &layout));
    assert_ok(ctx, pc_polymesh_save(store, "quads", &quads));
    assert_ok(ctx, pc_store_commit(&store));
    pc_mesh_free(&mesh, ctx), pc_curvature_free(&curvature, ctx), pc_field_free(&field, ctx);
    pc_param_free(&param, ctx), pc_layout_free(&layout, ctx), pc_polymesh_free(&quads, ctx);
    int result = run_python("tests/readers/check_documented.py", path, NULL, NULL);
    if (result == PYTHON_SKIPS) skip();
    assert_int_equal(result, 0);
}

/* Whichever allocation fails while loading, the load says so and leaves nothing behind. */
static void loading_survives_missing_memory(void **state) {
    pc_context *ctx = *state;
    pc_random random = {7};
    pc_layout l = random_layout(ctx, &random), copy;
    pc_store *store = writing(ctx);
    assert_ok(ctx, pc_layout_save(store, "layout", &l));
    store = written(ctx, store);
    pc_layout_free(&l, ctx);
    size_t before = pc_memory_used(ctx);
    pc_status status = PC_E_NOMEM;
    for (size_t n = 1; status == PC_E_NOMEM; n++) {
        pc_memory_fail_at(ctx, n);
        status = pc_layout_load(&copy, store, "layout");
        if (status == PC_E_NOMEM) assert_int_equal(pc_memory_used(ctx), before);
    }
    pc_memory_fail_at(ctx, 0);
    assert_int_equal(status, PC_OK);
    pc_layout_free(&copy, ctx);
    pc_store_close(store);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(meshes_and_lists, make_context, free_context),
        cmocka_unit_test_setup_teardown(curvatures, make_context, free_context),
        cmocka_unit_test_setup_teardown(fields, make_context, free_context),
        cmocka_unit_test_setup_teardown(params, make_context, free_context),
        cmocka_unit_test_setup_teardown(layouts, make_context, free_context),
        cmocka_unit_test_setup_teardown(wrong_layouts_are_refused, make_context, free_context),
        cmocka_unit_test_setup_teardown(polymeshes, make_context, free_context),
        cmocka_unit_test_setup_teardown(all_datasets_are_documented, make_context, free_context),
        cmocka_unit_test_setup_teardown(loading_survives_missing_memory, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, enter, leave);
}
