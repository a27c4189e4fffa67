/* Doublets go, whatever else the mesh is made of stays. */
#include "doublet.h"
#include "memory.h"
#include "random.h"
#include "surface_testing.h"
#include "synth_quads.h"
#include "vec3.h"

/* Puts a vertex into quad f: two quads that meet in it and in corners `k` and `k`+2 of f; the second one is
 * the last face. */
static void put_doublet(pc_polymesh *mesh, pc_context *ctx, pc_index f, pc_index k) {
    pc_polymesh more;
    pc_index n = mesh->face_count, v = mesh->vertex_count, old[4];
    assert_ok(ctx, pc_polymesh_make(&more, ctx, (size_t)v + 1, (size_t)n + 1, 4 * ((size_t)n + 1)));
    memcpy(more.position, mesh->position, 3 * sizeof(double) * v);
    memcpy(more.corner, mesh->corner, 4 * sizeof(pc_index) * n);
    for (pc_index i = 0; i <= n + 1; i++)
        more.start[i] = 4 * i;
    for (pc_index i = 0; i < 4; i++)
        old[i] = mesh->corner[4 * f + (i + k) % 4];
    const pc_index first[4] = {old[0], old[1], old[2], v}, second[4] = {v, old[2], old[3], old[0]};
    memcpy(more.corner + 4 * (size_t)f, first, sizeof first);
    memcpy(more.corner + 4 * (size_t)n, second, sizeof second);
    pc_vec3 ends = pc_add(pc_vec3_at(mesh->position, old[0]), pc_vec3_at(mesh->position, old[2]));
    pc_vec3_put(more.position, v, pc_scale(0.5, ends));
    pc_polymesh_free(mesh, ctx);
    *mesh = more;
}

static bool same_cycle(const pc_index *a, const pc_index *b) {
    for (pc_index k = 0; k < 4; k++)
        if (a[0] == b[k] && a[1] == b[(k + 1) % 4] && a[2] == b[(k + 2) % 4] && a[3] == b[(k + 3) % 4])
            return true;
    return false;
}

static void make_shape(pc_polymesh *mesh, pc_context *ctx, int kind) {
    if (kind == 0) assert_ok(ctx, pc_synth_quad_plane(mesh, ctx, 3, 2, 7, 5));
    if (kind == 1) assert_ok(ctx, pc_synth_quad_torus(mesh, ctx, 2, 1, 8, 6));
    if (kind == 2) assert_ok(ctx, pc_synth_quad_sphere(mesh, ctx, 4));
}

static const int64_t shape_chi[] = {1, 0, 2};

static void clean_meshes_stay(void **state) {
    pc_context *ctx = *state;
    for (int kind = 0; kind < 3; kind++) {
        pc_polymesh mesh, before;
        pc_index removed = 7;
        make_shape(&mesh, ctx, kind);
        make_shape(&before, ctx, kind);
        assert_ok(ctx, pc_doublets_remove(&mesh, &removed, ctx, false));
        assert_int_equal(removed, 0);
        assert_int_equal(mesh.vertex_count, before.vertex_count);
        assert_int_equal(mesh.face_count, before.face_count);
        assert_memory_equal(mesh.corner, before.corner, 4 * sizeof(pc_index) * mesh.face_count);
        assert_memory_equal(mesh.position, before.position, 3 * sizeof(double) * mesh.vertex_count);
        pc_polymesh_free(&mesh, ctx);
        pc_polymesh_free(&before, ctx);
    }
}

static pc_index faces_at(const pc_polymesh *mesh, pc_index v) {
    pc_index faces = 0;
    for (pc_index c = 0; c < 4 * mesh->face_count; c++)
        faces += mesh->corner[c] == v;
    return faces;
}

/* One doublet in any face, across either diagonal: afterwards the mesh is what it was. Only where one quad
 * would be left at a border vertex, the corner of a plane, it stays. */
static void one_doublet_goes(void **state) {
    pc_context *ctx = *state;
    for (int kind = 0; kind < 3; kind++) {
        pc_polymesh mesh, before;
        pc_index removed, stayed = 0;
        make_shape(&before, ctx, kind);
        for (pc_index i = 0; i < 4 * before.face_count; i++) {
            pc_index f = i / 4, opposite = before.corner[4 * f + (i + 2) % 4];
            bool stays = faces_at(&before, before.corner[i]) < 2 || faces_at(&before, opposite) < 2;
            make_shape(&mesh, ctx, kind);
            put_doublet(&mesh, ctx, f, i % 4);
            is_manifold(ctx, &mesh, shape_chi[kind], i);
            assert_ok(ctx, pc_doublets_remove(&mesh, &removed, ctx, false));
            is_manifold(ctx, &mesh, shape_chi[kind], i);
            assert_int_equal(removed, !stays);
            assert_int_equal(mesh.face_count, before.face_count + stays);
            assert_memory_equal(mesh.position, before.position, 3 * sizeof(double) * before.vertex_count);
            for (pc_index g = 0; g < before.face_count; g++) {
                const pc_index *was = before.corner + 4 * (size_t)g, *is = mesh.corner + 4 * (size_t)g;
                if (g != f) assert_memory_equal(was, is, 4 * sizeof *is);
                if (g == f && !stays) assert_true(same_cycle(was, is));
            }
            stayed += stays;
            pc_polymesh_free(&mesh, ctx);
        }
        assert_int_equal(stayed, kind == 0 ? 8 : 0);
        pc_polymesh_free(&before, ctx);
    }
}

/* Doublets beside and inside each other, on closed meshes. */
static void many_doublets_go(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 300; seed++) {
        pc_random random = {seed};
        pc_polymesh mesh;
        int kind = 1 + (int)(seed % 2);
        pc_index put = 1 + (pc_index)(seed / 2 % 40), removed, least = PC_NONE, *faces;
        make_shape(&mesh, ctx, kind);
        pc_index before = mesh.face_count, vertices = mesh.vertex_count;
        for (pc_index i = 0; i < put; i++) {
            pc_index f = (pc_index)(pc_random_next(&random) % mesh.face_count);
            put_doublet(&mesh, ctx, f, (pc_index)(pc_random_next(&random) % 4));
        }
        is_manifold(ctx, &mesh, shape_chi[kind], seed);
        assert_ok(ctx, pc_doublets_remove(&mesh, &removed, ctx, false));
        is_manifold(ctx, &mesh, shape_chi[kind], seed);
        assert_ok(ctx, pc_new(&faces, ctx, mesh.vertex_count));
        for (pc_index c = 0; c < 4 * mesh.face_count; c++)
            faces[mesh.corner[c]]++;
        for (pc_index v = 0; v < mesh.vertex_count; v++)
            least = faces[v] < least ? faces[v] : least;
        if (least < 3 || mesh.face_count + removed != before + put ||
            mesh.vertex_count + removed != vertices + put || removed < put)
            fail_msg("seed %llu: %u doublets put in, %u taken out, least valence %u",
                     (unsigned long long)seed, put, removed, least);
        pc_free(ctx, faces);
        pc_polymesh_free(&mesh, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(clean_meshes_stay, make_context, free_context),
        cmocka_unit_test_setup_teardown(one_doublet_goes, make_context, free_context),
        cmocka_unit_test_setup_teardown(many_doublets_go, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
