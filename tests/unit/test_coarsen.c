/* A coarse mesh is the same surface: its vertices, its borders, its Euler number; edges as long as allowed.
 */
#include "coarsen.h"
#include "memory.h"
#include "random.h"
#include "synth.h"
#include "synth_wear.h"
#include "testing.h"
#include "topology.h"
#include "vec3.h"
#include <omp.h>

typedef struct dense {
    pc_mesh mesh;
    pc_adjacency adjacency;
    double *longest;
} dense;

static double edge_length(const pc_mesh *mesh, pc_index h) {
    return pc_distance(pc_vec3_at(mesh->position, pc_tail(mesh, h)),
                       pc_vec3_at(mesh->position, pc_head(mesh, h)));
}

/* A sphere, a torus, a plane, a torus with holes, or a thin one that must not be pinched, with noise or
 * without, in any order; `longest` falls off to a third along x. */
static void make_dense(dense *d, pc_context *ctx, uint64_t seed) {
    const int kind = (int)(seed % 5);
    if (kind == 0) assert_ok(ctx, pc_synth_sphere(&d->mesh, ctx, 40));
    if (kind == 1) assert_ok(ctx, pc_synth_torus(&d->mesh, ctx, 2, 1, 150, 90));
    if (kind == 2) assert_ok(ctx, pc_synth_plane(&d->mesh, ctx, 3, 2, 90, 60));
    if (kind == 3) {
        assert_ok(ctx, pc_synth_torus(&d->mesh, ctx, 2, 1, 150, 90));
        assert_ok(ctx, pc_synth_holes(&d->mesh, ctx, 4, 60, seed));
    }
    if (kind == 4) assert_ok(ctx, pc_synth_torus(&d->mesh, ctx, 2, 0.1, 300, 7));
    if (seed % 3 == 1) assert_ok(ctx, pc_synth_noise(&d->mesh, ctx, 0.1, seed));
    if (seed % 2) assert_ok(ctx, pc_synth_shuffle(&d->mesh, ctx, seed));
    const double edge = pc_synth_mean_edge(&d->mesh);
    assert_ok(ctx, pc_adjacency_make(&d->adjacency, ctx, &d->mesh));
    assert_ok(ctx, pc_new(&d->longest, ctx, d->mesh.vertex_count));
    for (pc_index v = 0; v < d->mesh.vertex_count; v++)
        d->longest[v] = edge * (4 + tanh(d->mesh.position[3 * (size_t)v])) * 1.2;
}

static void free_dense(dense *d, pc_context *ctx) {
    pc_free(ctx, d->longest);
    pc_adjacency_free(&d->adjacency, ctx);
    pc_mesh_free(&d->mesh, ctx);
}

static void assert_same_surface(const dense *d, const pc_coarse *coarse, pc_context *ctx, uint64_t seed) {
    pc_adjacency adjacency;
    pc_topology topology, before;
    assert_ok(ctx, pc_mesh_check(&coarse->mesh, ctx));
    assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &coarse->mesh));
    assert_ok(ctx, pc_topology_make(&topology, ctx, &coarse->mesh, &adjacency));
    assert_ok(ctx, pc_topology_make(&before, ctx, &d->mesh, &d->adjacency));
    if (topology.chi != before.chi || topology.loop_count != before.loop_count ||
        topology.component_count != before.component_count ||
        adjacency.boundary_edge_count != d->adjacency.boundary_edge_count)
        fail_msg("seed %llu: another surface, chi %lld not %lld", (unsigned long long)seed,
                 (long long)topology.chi, (long long)before.chi);
    pc_topology_free(&topology, ctx);
    pc_topology_free(&before, ctx);
    pc_adjacency_free(&adjacency, ctx);
}

/* What was asked of edges, of faces' normals and of the two maps. */
static void assert_as_asked(const dense *d, const pc_coarse *coarse, uint64_t seed) {
    const pc_mesh *mesh = &coarse->mesh;
    double longest = 0;
    for (pc_index h = 0; h < 3 * d->mesh.face_count; h++)
        longest = fmax(longest, edge_length(&d->mesh, h));
    for (pc_index h = 0; h < 3 * mesh->face_count; h++) {
        const double most =
            fmin(d->longest[coarse->source[pc_tail(mesh, h)]], d->longest[coarse->source[pc_head(mesh, h)]]);
        if (edge_length(mesh, h) > fmax(most, longest))
            fail_msg("seed %llu: an edge of %g, %g allowed", (unsigned long long)seed, edge_length(mesh, h),
                     most);
    }
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        const pc_index from = coarse->source[v];
        assert_int_equal(coarse->into[from], v);
        assert_true(v == 0 || coarse->source[v - 1] < from);
        assert_memory_equal(mesh->position + 3 * (size_t)v, d->mesh.position + 3 * (size_t)from,
                            3 * sizeof(double));
    }
    for (pc_index v = 0; v < d->mesh.vertex_count; v++) {
        assert_true(coarse->into[v] < mesh->vertex_count);
        if (d->adjacency.vertex_boundary[v]) assert_int_equal(coarse->source[coarse->into[v]], v);
    }
}

static void surfaces_stay(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 30; seed++) {
        dense d;
        pc_coarse coarse;
        make_dense(&d, ctx, seed);
        assert_ok(ctx, pc_coarsen(&coarse, ctx, &d.mesh, &d.adjacency, d.longest));
        assert_same_surface(&d, &coarse, ctx, seed);
        assert_as_asked(&d, &coarse, seed);
        if (coarse.mesh.face_count > d.mesh.face_count / (seed % 5 == 4 ? 2 : 4))
            fail_msg("seed %llu: %u faces of %u are left", (unsigned long long)seed, coarse.mesh.face_count,
                     d.mesh.face_count);
        pc_coarse_free(&coarse, ctx);
        free_dense(&d, ctx);
    }
}

/* Chords of a sphere with edges of up to e are e^2/8 below it, a little more across bad triangles; and all
 * faces look outward. */
static void a_sphere_stays_round(void **state) {
    pc_context *ctx = *state;
    dense d;
    pc_coarse coarse;
    const double edge = 0.15;
    assert_ok(ctx, pc_synth_sphere(&d.mesh, ctx, 60));
    assert_ok(ctx, pc_adjacency_make(&d.adjacency, ctx, &d.mesh));
    assert_ok(ctx, pc_new(&d.longest, ctx, d.mesh.vertex_count));
    for (pc_index v = 0; v < d.mesh.vertex_count; v++)
        d.longest[v] = edge;
    assert_ok(ctx, pc_coarsen(&coarse, ctx, &d.mesh, &d.adjacency, d.longest));
    for (pc_index f = 0; f < coarse.mesh.face_count; f++) {
        const pc_index *t = coarse.mesh.triangle + 3 * (size_t)f;
        const pc_vec3 a = pc_vec3_at(coarse.mesh.position, t[0]), b = pc_vec3_at(coarse.mesh.position, t[1]),
                      c = pc_vec3_at(coarse.mesh.position, t[2]);
        const pc_vec3 centre = pc_scale(1.0 / 3, pc_add(pc_add(a, b), c));
        assert_true(pc_dot(pc_cross(pc_sub(b, a), pc_sub(c, a)), centre) > 0);
        assert_true(pc_norm(centre) > 1 - edge * edge / 4);
    }
    pc_coarse_free(&coarse, ctx);
    free_dense(&d, ctx);
}

static void threads_change_nothing(void **state) {
    pc_context *ctx = *state;
    const int threads = omp_get_max_threads();
    dense d;
    pc_coarse one, four;
    make_dense(&d, ctx, 7);
    omp_set_num_threads(1);
    assert_ok(ctx, pc_coarsen(&one, ctx, &d.mesh, &d.adjacency, d.longest));
    omp_set_num_threads(4);
    assert_ok(ctx, pc_coarsen(&four, ctx, &d.mesh, &d.adjacency, d.longest));
    omp_set_num_threads(threads);
    assert_int_equal(one.mesh.face_count, four.mesh.face_count);
    assert_memory_equal(one.mesh.triangle, four.mesh.triangle,
                        3 * (size_t)one.mesh.face_count * sizeof *one.mesh.triangle);
    assert_memory_equal(one.into, four.into, d.mesh.vertex_count * sizeof *one.into);
    pc_coarse_free(&one, ctx);
    pc_coarse_free(&four, ctx);
    free_dense(&d, ctx);
}

/* Isolated vertices go nowhere; where nothing may get longer nothing changes. */
static void nothing_to_do(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_adjacency adjacency;
    pc_coarse coarse;
    double longest[8] = {0};
    static const double position[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 5, 5, 0, 0, 1};
    static const pc_index triangle[] = {0, 2, 1, 0, 1, 4, 1, 2, 4, 2, 0, 4};
    assert_ok(ctx, pc_mesh_make(&mesh, ctx, 5, 4));
    memcpy(mesh.position, position, sizeof position);
    memcpy(mesh.triangle, triangle, sizeof triangle);
    assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &mesh));
    for (int k = 0; k < 2; k++) { /* a tetrahedron has nothing to spare either */
        for (int v = 0; v < 5; v++)
            longest[v] = k * 100.0;
        assert_ok(ctx, pc_coarsen(&coarse, ctx, &mesh, &adjacency, longest));
        assert_int_equal(coarse.mesh.vertex_count, 4);
        assert_int_equal(coarse.mesh.face_count, 4);
        assert_int_equal(coarse.into[3], PC_NONE);
        assert_int_equal(coarse.source[3], 4);
        pc_coarse_free(&coarse, ctx);
    }
    pc_adjacency_free(&adjacency, ctx);
    pc_mesh_free(&mesh, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(surfaces_stay, make_context, free_context),
        cmocka_unit_test_setup_teardown(a_sphere_stays_round, make_context, free_context),
        cmocka_unit_test_setup_teardown(threads_change_nothing, make_context, free_context),
        cmocka_unit_test_setup_teardown(nothing_to_do, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
