/* Layouts are closed cell complexes with the scan's topology, of good parameterizations and of garbage alike.
 */
#include "bvh.h"
#include "closure.h"
#include "doublet.h"
#include "layout.h"
#include "param_testing.h"
#include "polygraph.h"
#include "quads.h"
#include "reconstruct.h"
#include "tspline.h"

typedef struct trial {
    pc_context *ctx;
    const shape *s;
    const pc_param *param;
    const char *what;
    int kind;
    uint64_t seed;
} trial;

#define expect(t, condition)                                                                                 \
    do {                                                                                                     \
        if (!(condition))                                                                                    \
            fail_msg("%s, shape %d, seed %llu: not %s (%s)", (t)->what, (t)->kind,                           \
                     (unsigned long long)(t)->seed, #condition, pc_context_message((t)->ctx));               \
    } while (0)

/* Every interior edge has two faces that run along it in opposite directions, every vertex one fan. */
static void is_manifold_like_the_scan(const trial *t, const pc_surface_count *quads,
                                      const pc_surface_count *scan) {
    expect(t, quads->overfull_edges == 0);
    expect(t, quads->clashing_edges == 0);
    expect(t, quads->broken_faces == 0);
    expect(t, quads->split_vertices == 0);
    expect(t, quads->unused_vertices == 0);
    expect(t, quads->chi == scan->chi);
    expect(t, quads->loops == scan->loops);
    expect(t, quads->components == scan->components);
}

static void lies_on_the_scan(const trial *t, const pc_polymesh *quads) {
    pc_bvh tree;
    assert_ok(t->ctx, pc_bvh_make(&tree, t->ctx, &t->s->mesh));
    for (pc_index v = 0; v < quads->vertex_count; v++) {
        pc_bvh_hit hit = pc_bvh_closest(&tree, pc_vec3_at(quads->position, v), PC_NONE);
        expect(t, hit.distance <= 1e-9 * (1 + pc_norm(pc_vec3_at(quads->position, v))));
    }
    pc_bvh_free(&tree, t->ctx);
}

/* Where there is more than a few cells, which may be two triangles back to back. */
static void becomes_a_spline(const trial *t, pc_polymesh *polygons) {
    enum { FEW = 30 };
    const pc_tmesh_options options = PC_TMESH_DEFAULTS;
    pc_tspline spline;
    pc_index removed;
    assert_ok(t->ctx, pc_doublets_remove(polygons, &removed, t->ctx, true));
    pc_status status = pc_tspline_make(&spline, t->ctx, polygons, &options);
    expect(t, status == PC_OK || (status == PC_E_MESH && polygons->face_count < FEW));
    pc_context_clear_message(t->ctx);
    if (status != PC_OK) return;
    expect(t, pc_tmesh_check(&spline.mesh, t->ctx) == PC_OK);
    expect(t, pc_closure_check(&spline.mesh, t->ctx) == PC_OK);
    pc_tspline_free(&spline, t->ctx);
}

static void becomes_polygons(const trial *t, const pc_layout *layout, const pc_surface_count *scan) {
    for (int mode = 0; mode < 2; mode++) {
        pc_ngons ngons = mode == 0 ? PC_NGONS_SPLIT : PC_NGONS_KEEP;
        pc_polymesh quads;
        pc_polygraph graph;
        assert_ok(t->ctx, pc_quads_make(&quads, t->ctx, layout, ngons));
        expect(t, mode == 1 || quads.face_count == pc_quads_count(layout, ngons));
        for (pc_index f = 0; mode == 0 && f < quads.face_count; f++)
            expect(t, quads.start[f + 1] - quads.start[f] == 4);
        assert_ok(t->ctx, pc_polygraph_of_polymesh(&graph, t->ctx, &quads));
        is_manifold_like_the_scan(t, &graph.count, scan);
        lies_on_the_scan(t, &quads);
        if (mode == 1) becomes_a_spline(t, &quads);
        pc_polygraph_free(&graph, t->ctx);
        pc_polymesh_free(&quads, t->ctx);
    }
}

static void check_layout(const trial *t) {
    pc_layout layout;
    pc_layout_stats stats;
    pc_polygraph scan, refined;
    const pc_mesh *mesh = &t->s->mesh;
    pc_status status = pc_layout_make(&layout, &stats, t->ctx, mesh, t->param);
    expect(t, status == PC_OK);
    status = pc_layout_check(&layout, t->ctx);
    expect(t, status == PC_OK);
    assert_ok(t->ctx, pc_polygraph_of_mesh(&scan, t->ctx, mesh));
    assert_ok(t->ctx, pc_polygraph_of_mesh(&refined, t->ctx, &layout.mesh));
    is_manifold_like_the_scan(t, &refined.count, &scan.count);
    expect(t, (int64_t)layout.node_count - layout.arc_count + layout.cell_count == scan.count.chi);
    expect(t, memcmp(layout.mesh.position, mesh->position, 3 * sizeof(double) * mesh->vertex_count) == 0);
    becomes_polygons(t, &layout, &scan.count);
    pc_polygraph_free(&scan, t->ctx);
    pc_polygraph_free(&refined, t->ctx);
    pc_layout_free(&layout, t->ctx);
}

/* Cells a little longer than two edges, some edges, and so large that one would hold the whole shape. */
static void layouts_of_parameterizations(void **state) {
    pc_context *ctx = *state;
    static const double factors[] = {2.01, 6, 1e5};
    pc_device *host = open_host(ctx);
    for (int kind = 0; kind < SHAPE_KINDS; kind += kind == 6 ? 2 : 1) {
        shape s = {0};
        make_mesh(&s.mesh, ctx, kind, 7);
        finish_shape(&s, ctx, host);
        for (size_t k = 0; k < (kind < 7 ? 3 : 2); k++) {
            pc_param param;
            pc_param_stats stats;
            pc_param_options options = PC_PARAM_DEFAULTS;
            options.period_length = factors[k] * s.longest_edge;
            const trial t = {ctx, &s, &param, "parameterized", kind, k};
            assert_ok(ctx, pc_param_make(&param, &stats, ctx, host, &s.mesh, &s.adjacency, &s.field, NULL,
                                         &options));
            assert_ok(ctx, pc_param_check(&param, ctx, &s.mesh, &s.adjacency));
            check_layout(&t);
            pc_param_free(&param, ctx);
        }
        free_shape(&s, ctx);
    }
    pc_device_close(host, ctx);
}

/* ---- garbage ---- */

static void make_param(pc_param *param, pc_context *ctx, const pc_mesh *mesh) {
    *param =
        (pc_param){.vertex_count = mesh->vertex_count, .face_count = mesh->face_count, .period_length = 1};
    assert_ok(ctx, pc_new(&param->phase, ctx, 4 * (size_t)mesh->vertex_count));
    assert_ok(ctx, pc_new(&param->coordinate, ctx, 2 * (size_t)mesh->vertex_count));
    assert_ok(ctx, pc_new(&param->turn, ctx, 3 * (size_t)mesh->face_count));
    assert_ok(ctx, pc_new(&param->shift, ctx, 6 * (size_t)mesh->face_count));
    assert_ok(ctx, pc_new(&param->singular, ctx, mesh->face_count));
}

/* Random coordinates in steps of 2^grain, a share of random turns, shifts that follow random advances. Coarse
 * steps make many ties. */
static void make_garbage(pc_param *param, pc_context *ctx, const shape *s, uint64_t seed) {
    pc_random random = {seed * 77};
    pc_coupling coupling = {.edge_count = s->adjacency.edge_count};
    int grain = (int)(seed % 4) * 7 + 1;
    double turned = seed % 5 == 0 ? 0 : seed % 5 == 1 ? 0.02 : seed % 5 == 2 ? 0.2 : 1;
    double reach = seed % 3 == 0 ? 0 : seed % 3 == 1 ? 0.49 : 0.1;
    bool wide = seed % 7 == 0, smooth = seed % 2 == 0;
    make_param(param, ctx, &s->mesh);
    assert_ok(ctx, pc_new(&coupling.turn, ctx, coupling.edge_count));
    assert_ok(ctx, pc_new(&coupling.advance, ctx, 2 * (size_t)coupling.edge_count));
    for (size_t i = 0; i < 2 * (size_t)s->mesh.vertex_count; i++) {
        double x =
            smooth ? s->mesh.position[i / 2 * 3 + i % 2] * 0.9 / s->longest_edge : pc_random_uniform(&random);
        if (wide) x = 200 * pc_random_uniform(&random) - 100;
        param->coordinate[i] = ((int32_t)llround(fmod(x, 100) * PC_PERIOD) & -(1 << grain)) | 1;
    }
    for (size_t e = 0; e < coupling.edge_count; e++) {
        coupling.turn[e] = pc_random_uniform(&random) < turned ? pc_random_next(&random) % 4 : 0;
        for (int k = 0; k < 2; k++)
            coupling.advance[2 * e + k] = (float)(reach * (2 * pc_random_uniform(&random) - 1));
    }
    pc_reconstruct_shifts(param, &s->mesh, &s->adjacency, &coupling);
    pc_reconstruct_flags(param, &s->mesh);
    assert_ok(ctx, pc_param_check(param, ctx, &s->mesh, &s->adjacency));
    pc_coupling_free(&coupling, ctx);
}

static void make_small_mesh(pc_mesh *mesh, pc_context *ctx, int kind, uint64_t seed) {
    pc_mesh other;
    pc_index size = 1 + (pc_index)(seed % 3);
    switch (kind) {
    case 0:
        assert_ok(ctx, pc_synth_sphere(mesh, ctx, size));
        break;
    case 1:
        assert_ok(ctx, pc_synth_torus(mesh, ctx, 2, 0.8, 5 + 4 * size, 4 + size));
        break;
    case 2:
        assert_ok(ctx, pc_synth_cylinder(mesh, ctx, 1 + size, 4 + 3 * size, 2 * size));
        break;
    case 3:
        assert_ok(ctx, pc_synth_plane(mesh, ctx, 3, 2, 3 * size, 2 * size));
        break;
    case 4:
        assert_ok(ctx, pc_synth_cube(mesh, ctx, size));
        break;
    case 5:
        assert_ok(ctx, pc_synth_plane(mesh, ctx, 3, 2, 15, 10));
        assert_ok(ctx, pc_synth_holes(mesh, ctx, size, 6, seed));
        break;
    default:
        assert_ok(ctx, pc_synth_torus(mesh, ctx, 1, 0.4, 7, 5));
        assert_ok(ctx, pc_synth_sphere(&other, ctx, size));
        assert_ok(ctx, pc_synth_append(mesh, ctx, &other, (pc_vec3){3, 0, 0}));
        pc_mesh_free(&other, ctx);
        break;
    }
    assert_ok(ctx, pc_synth_shuffle(mesh, ctx, seed));
}

static void layouts_of_garbage(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 2100; seed++) {
        shape s = {0};
        pc_param param;
        int kind = (int)(seed % 7);
        const trial t = {ctx, &s, &param, "garbage", kind, seed};
        make_small_mesh(&s.mesh, ctx, kind, seed / 7);
        measure_shape(&s, ctx);
        make_garbage(&param, ctx, &s, seed / 7);
        check_layout(&t);
        pc_param_free(&param, ctx);
        free_shape(&s, ctx);
    }
}

static void layouts_of_garbage_on_blobs(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 10; seed++) {
        shape s = {0};
        pc_param param;
        const trial t = {ctx, &s, &param, "garbage on a blob", (int)(seed % 5), seed};
        assert_ok(ctx, pc_synth_blob(&s.mesh, ctx, (pc_index)(seed % 5), 6));
        measure_shape(&s, ctx);
        make_garbage(&param, ctx, &s, seed);
        check_layout(&t);
        pc_param_free(&param, ctx);
        free_shape(&s, ctx);
    }
}

/* Wherever memory runs out, that is the answer and nothing is left behind. */
static void survives_without_memory(void **state) {
    pc_context *ctx = *state;
    shape s = {0};
    pc_param param;
    bool done = false;
    make_small_mesh(&s.mesh, ctx, 1, 0);
    measure_shape(&s, ctx);
    make_garbage(&param, ctx, &s, 3);
    size_t used = pc_memory_used(ctx);
    for (size_t n = 1; !done; n++) {
        pc_layout layout;
        pc_layout_stats stats;
        pc_polymesh quads = {0};
        pc_memory_fail_at(ctx, n);
        pc_status status = pc_layout_make(&layout, &stats, ctx, &s.mesh, &param);
        if (status == PC_OK)
            status = pc_quads_make(&quads, ctx, &layout, n % 2 ? PC_NGONS_SPLIT : PC_NGONS_KEEP);
        assert_true(status == PC_OK || status == PC_E_NOMEM);
        done = status == PC_OK;
        pc_memory_fail_at(ctx, 0);
        pc_context_clear_message(ctx);
        pc_polymesh_free(&quads, ctx);
        pc_layout_free(&layout, ctx);
        assert_int_equal(pc_memory_used(ctx), used);
    }
    pc_param_free(&param, ctx);
    free_shape(&s, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(layouts_of_garbage, make_context, free_context),
        cmocka_unit_test_setup_teardown(layouts_of_garbage_on_blobs, make_context, free_context),
        cmocka_unit_test_setup_teardown(layouts_of_parameterizations, make_context, free_context),
        cmocka_unit_test_setup_teardown(survives_without_memory, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
