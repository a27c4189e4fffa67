/* Lengths, angles, normals, topology and refinement on shapes of known answers and on bad triangles. */
#include "geometry.h"
#include "random.h"
#include "refine.h"
#include "synth.h"
#include "testing.h"
#include "topology.h"
#include <stdlib.h>

static void close_to(double value, double wanted, double tolerance) {
    if (!(fabs(value - wanted) <= tolerance)) fail_msg("%.17g is not %.17g", value, wanted);
}

static void angles_of_any_triangle_sum_to_pi(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 2000; seed++) {
        pc_random random = {pc_hash64(seed)};
        double size = pow(10, floor(600 * pc_random_uniform(&random)) - 300), angle[3], c[9];
        for (int i = 0; i < 9; i++)
            c[i] = size * floor(3 * pc_random_uniform(&random)); /* often collinear or coincident */
        if (seed % 3 == 0) c[8] += 1e-12 * size;
        pc_vec3 p = pc_vec3_at(c, 0), q = pc_vec3_at(c, 1), r = pc_vec3_at(c, 2);
        pc_triangle_angles(angle, p, q, r);
        if (!(fabs(angle[0] + angle[1] + angle[2] - PC_PI) < 1e-12))
            fail_msg("seed %llu: angles %g %g %g", (unsigned long long)seed, angle[0], angle[1], angle[2]);
        double n = pc_norm(pc_triangle_normal(p, q, r)), cot = pc_cotangent(pc_sub(q, p), pc_sub(r, p));
        if (!(n == 0 || fabs(n - 1) < 1e-14))
            fail_msg("seed %llu: normal of %g", (unsigned long long)seed, n);
        if (!(fabs(cot) <= PC_COTANGENT_LIMIT))
            fail_msg("seed %llu: cotangent %g", (unsigned long long)seed, cot);
        assert_true(pc_triangle_area(p, q, r) >= 0);
    }
}

static void sphere_has_its_area_volume_and_normals(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_adjacency a;
    double *normal;
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 40));
    assert_ok(ctx, pc_adjacency_make(&a, ctx, &mesh));
    close_to(pc_geometry_area(&mesh), 4 * PC_PI, 0.02);
    close_to(pc_geometry_volume(&mesh), 4 * PC_PI / 3, 0.02);
    close_to(pc_box_diagonal(pc_geometry_box(&mesh)), 2 * sqrt(3), 1e-12);
    assert_ok(ctx, pc_new(&normal, ctx, 3 * (size_t)mesh.vertex_count));
    for (int weight = PC_NORMAL_ANGLE; weight <= PC_NORMAL_AREA; weight++) {
        pc_geometry_vertex_normals(normal, &mesh, &a, (pc_normal_weight)weight);
        for (pc_index v = 0; v < mesh.vertex_count; v++)
            if (pc_dot(pc_vec3_at(normal, v), pc_vec3_at(mesh.position, v)) < 0.999) fail_msg("normal %u", v);
    }
    pc_free(ctx, normal);
    pc_adjacency_free(&a, ctx);
    pc_mesh_free(&mesh, ctx);
}

/* Twice the area is the sum of cotangent times squared length over the half-edges, halved. */
static void cotangents_give_the_area(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    double *cotangent, sum = 0;
    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 1, 30, 11));
    assert_ok(ctx, pc_new(&cotangent, ctx, 3 * (size_t)mesh.face_count));
    pc_geometry_cotangents(cotangent, &mesh);
    for (pc_index h = 0; h < 3 * mesh.face_count; h++) {
        double l = pc_distance(pc_vec3_at(mesh.position, pc_tail(&mesh, h)),
                               pc_vec3_at(mesh.position, pc_head(&mesh, h)));
        sum += cotangent[h] * l * l / 4;
    }
    close_to(sum, pc_geometry_area(&mesh), 1e-9);
    pc_free(ctx, cotangent);
    pc_mesh_free(&mesh, ctx);
}

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static void spread_agrees_with_sorting(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 500; seed++) {
        pc_random random = {pc_hash64(seed)};
        double value[300], sorted[300];
        size_t n = 1 + pc_random_next(&random) % 300;
        int grid = seed % 2 ? 5 : 100000;
        for (size_t i = 0; i < n; i++)
            sorted[i] = value[i] = floor(grid * pc_random_uniform(&random));
        qsort(sorted, n, sizeof *sorted, compare_doubles);
        pc_spread s = pc_spread_of(value, n);
        double dn = (double)n;
        bool good =
            s.min == sorted[0] && s.max == sorted[n - 1] && s.median == sorted[(size_t)ceil(0.5 * dn) - 1] &&
            s.q05 == sorted[(size_t)ceil(0.05 * dn) - 1] && s.q95 == sorted[(size_t)ceil(0.95 * dn) - 1] &&
            s.q01 == sorted[(size_t)ceil(0.01 * dn) - 1] && s.q99 == sorted[(size_t)ceil(0.99 * dn) - 1];
        if (!good) fail_msg("seed %llu", (unsigned long long)seed);
    }
    assert_int_equal(pc_spread_of(NULL, 0).count, 0);
}

static void topology_of_a_cylinder_with_a_torus(void **state) {
    pc_context *ctx = *state;
    pc_mesh torus, cylinder, both;
    pc_adjacency a;
    pc_topology t;
    assert_ok(ctx, pc_synth_torus(&torus, ctx, 2, 1, 12, 7));
    assert_ok(ctx, pc_synth_cylinder(&cylinder, ctx, 2, 12, 5));
    assert_ok(ctx, pc_mesh_make(&both, ctx, torus.vertex_count + cylinder.vertex_count + 1,
                                torus.face_count + cylinder.face_count));
    memcpy(both.position, torus.position, 24 * (size_t)torus.vertex_count);
    memcpy(both.position + 3 * torus.vertex_count, cylinder.position, 24 * (size_t)cylinder.vertex_count);
    memcpy(both.triangle, torus.triangle, 12 * (size_t)torus.face_count);
    for (pc_index i = 0; i < 3 * cylinder.face_count; i++)
        both.triangle[3 * torus.face_count + i] = cylinder.triangle[i] + torus.vertex_count;
    assert_ok(ctx, pc_adjacency_make(&a, ctx, &both));
    assert_ok(ctx, pc_topology_make(&t, ctx, &both, &a));
    assert_ok(ctx, pc_topology_check(&t, ctx, &both, &a));
    assert_int_equal(t.component_count, 2);
    assert_int_equal(t.component[0].genus, 1);
    assert_int_equal(t.component[0].loop_count, 0);
    assert_int_equal(t.component[1].genus, 0);
    assert_int_equal(t.component[1].loop_count, 2);
    assert_int_equal(t.component[1].first_face, torus.face_count);
    assert_int_equal(t.chi, 0);
    assert_int_equal(t.loop_start[1], 12);
    close_to(t.component[0].area + t.component[1].area, pc_geometry_area(&both), 1e-9);
    t.loop_half[1] ^= 1;
    assert_int_equal(pc_topology_check(&t, ctx, &both, &a), PC_E_BUG);
    pc_topology_free(&t, ctx);
    pc_adjacency_free(&a, ctx);
    pc_mesh_free(&torus, ctx);
    pc_mesh_free(&cylinder, ctx);
    pc_mesh_free(&both, ctx);
}

static double longest_edge(const pc_mesh *mesh) {
    double longest = 0;
    for (pc_index h = 0; h < 3 * mesh->face_count; h++)
        longest = fmax(longest, pc_distance(pc_vec3_at(mesh->position, pc_tail(mesh, h)),
                                            pc_vec3_at(mesh->position, pc_head(mesh, h))));
    return longest;
}

static double least_angle(const pc_mesh *mesh) {
    double least = PC_PI, angle[3];
    for (pc_index f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        pc_triangle_angles(angle, pc_vec3_at(mesh->position, t[0]), pc_vec3_at(mesh->position, t[1]),
                           pc_vec3_at(mesh->position, t[2]));
        for (int k = 0; k < 3; k++)
            least = fmin(least, angle[k]);
    }
    return least;
}

static void refined_mesh_is_the_same_surface(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 24; seed++) {
        pc_random random = {pc_hash64(seed)};
        pc_mesh mesh;
        pc_adjacency before, after;
        pc_topology tb, ta;
        pc_refined refined;
        double stretch = pow(10, 3 * pc_random_uniform(&random)), limit = 0.1 + pc_random_uniform(&random);
        if (seed % 2)
            assert_ok(ctx, pc_synth_cylinder(&mesh, ctx, 1, 3 + seed % 9, 2));
        else
            assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 0.5, 3 + seed % 13, 3 + seed % 5));
        for (pc_index v = 0; v < mesh.vertex_count; v++)
            mesh.position[3 * v + 2] *= fmin(stretch, 30); /* needles */
        pc_refine_options options = PC_REFINE_DEFAULTS;
        options.max_edge = limit;
        assert_ok(ctx, pc_refine(&refined, ctx, &mesh, &options));
        assert_ok(ctx, pc_mesh_check(&refined.mesh, ctx));
        assert_ok(ctx, pc_adjacency_make(&before, ctx, &mesh));
        assert_ok(ctx, pc_adjacency_make(&after, ctx, &refined.mesh));
        assert_ok(ctx, pc_topology_make(&tb, ctx, &mesh, &before));
        assert_ok(ctx, pc_topology_make(&ta, ctx, &refined.mesh, &after));
        if (longest_edge(&refined.mesh) > limit)
            fail_msg("seed %llu: an edge is too long", (unsigned long long)seed);
        assert_int_equal(tb.chi, ta.chi);
        assert_int_equal(tb.loop_count, ta.loop_count);
        assert_memory_equal(mesh.position, refined.mesh.position, 24 * (size_t)mesh.vertex_count);
        close_to(pc_geometry_area(&refined.mesh) / pc_geometry_area(&mesh), 1, 1e-12);
        /* As with bisection of longest edges alone (Rosenberg and Stenger 1975), angles stay above half the
         * least. */
        if (least_angle(&refined.mesh) < 0.499 * least_angle(&mesh))
            fail_msg("seed %llu: angle %g from %g", (unsigned long long)seed, least_angle(&refined.mesh),
                     least_angle(&mesh));
        for (pc_index f = 1; f < refined.mesh.face_count; f++)
            assert_true(refined.face_source[f] >= refined.face_source[f - 1]);
        for (pc_index v = mesh.vertex_count; v < refined.mesh.vertex_count; v++) {
            const pc_index *p = refined.parent + 2 * (size_t)(v - mesh.vertex_count);
            assert_true(p[0] < v && p[1] < v);
            pc_vec3 sum =
                pc_add(pc_vec3_at(refined.mesh.position, p[0]), pc_vec3_at(refined.mesh.position, p[1]));
            close_to(pc_distance(pc_scale(0.5, sum), pc_vec3_at(refined.mesh.position, v)), 0, 1e-12);
        }
        pc_topology_free(&ta, ctx);
        pc_topology_free(&tb, ctx);
        pc_adjacency_free(&before, ctx);
        pc_adjacency_free(&after, ctx);
        pc_refined_free(&refined, ctx);
        pc_mesh_free(&mesh, ctx);
    }
}

static void refinement_keeps_to_its_limits(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_refined refined;
    pc_refine_options options = PC_REFINE_DEFAULTS;
    assert_ok(ctx, pc_synth_plane(&mesh, ctx, 1, 1, 2, 2));
    assert_int_equal(pc_refine(&refined, ctx, &mesh, &options), PC_E_USAGE);
    pc_context_clear_message(ctx);
    options.max_edge = 0.01, options.max_faces = 1000;
    assert_int_equal(pc_refine(&refined, ctx, &mesh, &options), PC_E_MESH);
    assert_non_null(strstr(pc_context_message(ctx), "1000 faces"));
    pc_context_clear_message(ctx);
    options.max_edge = 10;
    assert_ok(ctx, pc_refine(&refined, ctx, &mesh, &options));
    assert_int_equal(refined.rounds, 0);
    assert_memory_equal(refined.mesh.triangle, mesh.triangle, 12 * (size_t)mesh.face_count);
    pc_refined_free(&refined, ctx);
    /* An edge of two neighbouring numbers has no middle: it stays instead of going on for ever. */
    for (pc_index v = 0; v < mesh.vertex_count; v++)
        for (int k = 0; k < 2; k++)
            mesh.position[3 * v + (pc_index)k] =
                1e6 + 0x1p-33 * floor(4 * mesh.position[3 * v + (pc_index)k]);
    options = (pc_refine_options)PC_REFINE_DEFAULTS;
    options.max_edge = 1e-13;
    assert_ok(ctx, pc_refine(&refined, ctx, &mesh, &options));
    pc_refined_free(&refined, ctx);
    pc_mesh_free(&mesh, ctx);
}

static void limit_per_component(void **state) {
    pc_context *ctx = *state;
    pc_mesh one, two;
    pc_refined refined;
    pc_index component[16];
    double limit[2] = {10, 0.2};
    assert_ok(ctx, pc_synth_plane(&one, ctx, 1, 1, 2, 2));
    assert_ok(ctx, pc_mesh_make(&two, ctx, 2 * one.vertex_count, 16));
    memcpy(two.position, one.position, 24 * (size_t)one.vertex_count);
    memcpy(two.position + 3 * one.vertex_count, one.position, 24 * (size_t)one.vertex_count);
    for (pc_index i = 0; i < 48; i++)
        two.triangle[i] = one.triangle[i % 24] + (i < 24 ? 0 : one.vertex_count);
    for (pc_index f = 0; f < 16; f++)
        component[f] = f / 8;
    pc_refine_options options = {.component_max_edge = limit, .face_component = component};
    assert_ok(ctx, pc_refine(&refined, ctx, &two, &options));
    assert_int_equal(refined.face_source[7], 7);
    assert_int_equal(refined.face_source[8], 8);
    assert_true(refined.mesh.face_count > 8 + 8 * 15);
    pc_refined_free(&refined, ctx);
    pc_mesh_free(&one, ctx);
    pc_mesh_free(&two, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(angles_of_any_triangle_sum_to_pi, make_context, free_context),
        cmocka_unit_test_setup_teardown(sphere_has_its_area_volume_and_normals, make_context, free_context),
        cmocka_unit_test_setup_teardown(cotangents_give_the_area, make_context, free_context),
        cmocka_unit_test_setup_teardown(spread_agrees_with_sorting, make_context, free_context),
        cmocka_unit_test_setup_teardown(topology_of_a_cylinder_with_a_torus, make_context, free_context),
        cmocka_unit_test_setup_teardown(refined_mesh_is_the_same_surface, make_context, free_context),
        cmocka_unit_test_setup_teardown(refinement_keeps_to_its_limits, make_context, free_context),
        cmocka_unit_test_setup_teardown(limit_per_component, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
