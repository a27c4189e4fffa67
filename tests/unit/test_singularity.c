/* Indices sum to N times the Euler number, whatever the field and the mesh. */
#include "connection.h"
#include "field.h"
#include "memory.h"
#include "random.h"
#include "singularity.h"
#include "synth.h"
#include "synth_blob.h"
#include "synth_wear.h"
#include "testing.h"
#include "vec3.h"

static void random_field(pc_field *field, pc_context *ctx, const pc_mesh *mesh, const pc_connection *c,
                         int symmetry, uint64_t seed) {
    pc_random random = {seed};
    *field =
        (pc_field){.symmetry = symmetry, .vertex_count = mesh->vertex_count, .face_count = mesh->face_count};
    assert_ok(ctx, pc_new(&field->angle, ctx, mesh->vertex_count));
    assert_ok(ctx, pc_new(&field->normal, ctx, 3 * (size_t)mesh->vertex_count));
    assert_ok(ctx, pc_new(&field->direction, ctx, 3 * (size_t)mesh->vertex_count));
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        field->angle[v] = 50 * (pc_random_uniform(&random) - 0.5);
        pc_vec3_put(field->normal, v, pc_vec3_at(c->normal, v));
        pc_connection_direction(field->direction + 3 * (size_t)v, c, v, field->angle[v]);
    }
}

/* A random mesh: `kind` picks the shape, the seed what was done to it. */
static void random_mesh(pc_mesh *mesh, pc_context *ctx, int kind, uint64_t seed) {
    if (kind == 0) assert_ok(ctx, pc_synth_sphere(mesh, ctx, 9));
    if (kind == 1) assert_ok(ctx, pc_synth_torus(mesh, ctx, 2, 1, 30, 15));
    if (kind == 2) assert_ok(ctx, pc_synth_cylinder(mesh, ctx, 2, 24, 11));
    if (kind == 3) assert_ok(ctx, pc_synth_blob(mesh, ctx, 3, 6));
    if (kind == 4) assert_ok(ctx, pc_synth_plane(mesh, ctx, 2, 1, 20, 10));
    assert_ok(ctx, pc_synth_noise(mesh, ctx, 0.6, seed));
    if (seed % 2) assert_ok(ctx, pc_synth_needles(mesh, ctx, 0.1, seed));
    if (seed % 3) assert_ok(ctx, pc_synth_holes(mesh, ctx, 3, 6, seed));
    if (seed % 5 == 0) /* zero-area faces: a vertex falls on a neighbour */
        for (pc_index f = 0; f < mesh->face_count; f += 17)
            pc_vec3_put(mesh->position, mesh->triangle[3 * f],
                        pc_vec3_at(mesh->position, mesh->triangle[3 * f + 1]));
}

static void sums_are_exact(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 12; seed++)
        for (int kind = 0; kind < 5; kind++)
            for (int symmetry = 1; symmetry <= 4; symmetry *= 2) {
                pc_mesh mesh;
                pc_adjacency a;
                pc_connection c;
                pc_field field;
                random_mesh(&mesh, ctx, kind, seed);
                assert_ok(ctx, pc_adjacency_make(&a, ctx, &mesh));
                assert_ok(ctx, pc_connection_make(&c, ctx, &mesh, &a));
                random_field(&field, ctx, &mesh, &c, symmetry, seed);
                assert_ok(ctx, pc_singularity_find(&field, ctx, &mesh, &a, &c));
                if (pc_field_check(&field, ctx, &mesh, &a) != PC_OK)
                    fail_msg("seed %llu, kind %d, N %d: %s", (unsigned long long)seed, kind, symmetry,
                             pc_context_message(ctx));
                pc_field_free(&field, ctx);
                pc_connection_free(&c, ctx);
                pc_adjacency_free(&a, ctx);
                pc_mesh_free(&mesh, ctx);
            }
}

/* Turns of opposite half-edges undo each other, and around a regular face they cancel. */
static void turns_agree(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_adjacency a;
    pc_connection c;
    pc_field field;
    random_mesh(&mesh, ctx, 2, 7);
    assert_ok(ctx, pc_adjacency_make(&a, ctx, &mesh));
    assert_ok(ctx, pc_connection_make(&c, ctx, &mesh, &a));
    random_field(&field, ctx, &mesh, &c, 4, 7);
    assert_ok(ctx, pc_singularity_find(&field, ctx, &mesh, &a, &c));
    for (pc_index h = 0; h < 3 * mesh.face_count; h++) {
        if (a.twin[h] != PC_NONE) assert_int_equal((field.turn[h] + field.turn[a.twin[h]]) % 4, 0);
        if (h % 3 == 0) {
            int sum = field.turn[h] + field.turn[h + 1] + field.turn[h + 2] - field.index[h / 3];
            assert_int_equal((sum + 400) % 4, 0);
        }
    }
    pc_field_free(&field, ctx);
    pc_connection_free(&c, ctx);
    pc_adjacency_free(&a, ctx);
    pc_mesh_free(&mesh, ctx);
}

/* Known answers on a disk: a constant field leaves everything to the hole, a field around the centre is
 * index 1. */
static void known_fields_on_a_disk(void **state) {
    pc_context *ctx = *state;
    for (int around = 0; around < 2; around++) {
        pc_mesh mesh;
        pc_adjacency a;
        pc_connection c;
        pc_field field;
        int sum = 0;
        assert_ok(ctx, pc_synth_plane(&mesh, ctx, 2, 2, 21, 21));
        assert_ok(ctx, pc_adjacency_make(&a, ctx, &mesh));
        assert_ok(ctx, pc_connection_make(&c, ctx, &mesh, &a));
        random_field(&field, ctx, &mesh, &c, 4, 1);
        for (pc_index v = 0; v < mesh.vertex_count; v++) {
            const double *p = mesh.position + 3 * (size_t)v;
            const double vector[3] = {around ? -(p[1] - 1) : 1, around ? p[0] - 1 : 0.3, 0};
            field.angle[v] = pc_connection_angle(&c, v, vector);
        }
        assert_ok(ctx, pc_singularity_find(&field, ctx, &mesh, &a, &c));
        for (pc_index f = 0; f < mesh.face_count; f++)
            sum += field.index[f];
        assert_int_equal(sum, around ? 4 : 0);
        assert_int_equal(field.loop_count, 1);
        assert_int_equal(field.loop_index[0], around ? 0 : 4);
        pc_field_free(&field, ctx);
        pc_connection_free(&c, ctx);
        pc_adjacency_free(&a, ctx);
        pc_mesh_free(&mesh, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(sums_are_exact, make_context, free_context),
        cmocka_unit_test_setup_teardown(turns_agree, make_context, free_context),
        cmocka_unit_test_setup_teardown(known_fields_on_a_disk, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
