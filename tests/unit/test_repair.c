/* Repair: known defects are cured as stated, and any soup becomes a manifold mesh. */
#include "geometry.h"
#include "random.h"
#include "repair.h"
#include "synth.h"
#include "testing.h"
#include "topology.h"

static const pc_repair_options PLAIN = PC_REPAIR_DEFAULTS;

static void make_soup(pc_mesh *mesh, pc_context *ctx, const double *position, size_t vertices,
                      const pc_index *triangle, size_t faces) {
    assert_ok(ctx, pc_mesh_make(mesh, ctx, vertices, faces));
    memcpy(mesh->position, position, 3 * vertices * sizeof *position);
    memcpy(mesh->triangle, triangle, 3 * faces * sizeof *triangle);
}

/* What holds for every result, whatever went in. Leaves its topology in *t. */
static void check_result(pc_topology *t, pc_context *ctx, const pc_mesh *in, const pc_mesh *out,
                         const pc_repair_report *report) {
    pc_adjacency a;
    double area = 0;
    assert_ok(ctx, pc_mesh_check(out, ctx));
    assert_ok(ctx, pc_adjacency_make(&a, ctx, out));
    assert_ok(ctx, pc_topology_make(t, ctx, out, &a));
    assert_ok(ctx, pc_topology_check(t, ctx, out, &a));
    assert_int_equal(report->vertex_count, out->vertex_count);
    assert_int_equal(report->face_count, out->face_count);
    for (pc_index v = 0; v < out->vertex_count; v++) {
        assert_true(a.vertex_half[v] != PC_NONE);
        assert_true(report->vertex_source[v] < in->vertex_count);
    }
    for (pc_index h = 0; h < 3 * out->face_count; h++)
        assert_true(pc_distance(pc_vec3_at(out->position, pc_tail(out, h)),
                                pc_vec3_at(out->position, pc_head(out, h))) > 0);
    for (pc_index f = 0; f < out->face_count; f++) {
        assert_true(report->face_source[f] < in->face_count);
        if (f && report->face_source[f] == report->face_source[f - 1]) continue;
        const pc_index *s = in->triangle + 3 * (size_t)report->face_source[f];
        area += pc_triangle_area(pc_vec3_at(in->position, s[0]), pc_vec3_at(in->position, s[1]),
                                 pc_vec3_at(in->position, s[2]));
    }
    for (pc_index v = 0; v < in->vertex_count; v++)
        if (report->vertex_target[v] != PC_NONE) {
            pc_vec3 p = pc_vec3_at(in->position, v), q = pc_vec3_at(out->position, report->vertex_target[v]);
            assert_true(p.x == q.x && p.y == q.y && p.z == q.z);
        }
    if (!report->cured_zero_area && fabs(area - pc_geometry_area(out)) > 1e-9 * (area + 1))
        fail_msg("area %g became %g", area, pc_geometry_area(out));
    pc_adjacency_free(&a, ctx);
}

static void clean_mesh_stays_as_it_is(void **state) {
    pc_context *ctx = *state;
    pc_mesh in, out;
    pc_repair_report report;
    pc_topology t;
    assert_ok(ctx, pc_synth_torus(&in, ctx, 2, 1, 17, 9));
    assert_ok(ctx, pc_repair(&out, &report, ctx, &in, &PLAIN));
    check_result(&t, ctx, &in, &out, &report);
    assert_false(report.changed);
    assert_int_equal(t.genus, 1);
    assert_memory_equal(in.position, out.position, 3 * sizeof(double) * in.vertex_count);
    assert_memory_equal(in.triangle, out.triangle, 3 * sizeof(pc_index) * in.face_count);
    pc_topology_free(&t, ctx);
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&in, ctx);
    pc_mesh_free(&out, ctx);
}

/* A sphere as STL has it: three vertices per face; some faces turned round, some twice. */
static void unwelded_turned_and_doubled_faces(void **state) {
    pc_context *ctx = *state;
    pc_mesh sphere, in, out;
    pc_repair_report report;
    pc_topology t;
    pc_random random = {7};
    assert_ok(ctx, pc_synth_sphere(&sphere, ctx, 6));
    pc_index n = sphere.face_count, extra = 20;
    assert_ok(ctx, pc_mesh_make(&in, ctx, 3 * (size_t)n + 2, n + extra));
    for (pc_index h = 0; h < 3 * n; h++) {
        pc_vec3_put(in.position, h, pc_vec3_at(sphere.position, sphere.triangle[h]));
        in.triangle[h] = h;
    }
    for (pc_index f = 0; f < n; f++)
        if (pc_random_uniform(&random) < 0.6) in.triangle[3 * f] = 3 * f + 1, in.triangle[3 * f + 1] = 3 * f;
    for (pc_index f = 0; f < extra; f++)
        for (pc_index k = 0; k < 3; k++)
            in.triangle[3 * (n + f) + k] = in.triangle[3 * (7 * f) + (k + f) % 3];
    in.triangle[3 * n] = in.triangle[3 * n + 1]; /* one of them degenerate */
    assert_ok(ctx, pc_repair(&out, &report, ctx, &in, &PLAIN));
    check_result(&t, ctx, &in, &out, &report);
    assert_int_equal(out.vertex_count, sphere.vertex_count);
    assert_int_equal(out.face_count, n);
    assert_int_equal(t.chi, 2);
    assert_int_equal(t.loop_count, 0);
    assert_int_equal(report.degenerate_faces.count, 1);
    assert_int_equal(report.duplicate_faces.count, extra - 1);
    assert_int_equal(report.merged_vertices.count, 3 * n - sphere.vertex_count);
    assert_int_equal(report.isolated_vertices.count, 2);
    assert_true(report.flipped_faces.count > n / 4);
    assert_true(pc_geometry_volume(&out) > 0); /* most faces were turned inward, but it is closed */
    pc_topology_free(&t, ctx);
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&sphere, ctx);
    pc_mesh_free(&in, ctx);
    pc_mesh_free(&out, ctx);
}

/* Two closed fans that meet at a place but not at a vertex are left as they are. */
static void touching_interior_vertices_stay_apart(void **state) {
    pc_context *ctx = *state;
    pc_mesh one, in, out;
    pc_repair_report report;
    pc_topology t;
    assert_ok(ctx, pc_synth_sphere(&one, ctx, 4));
    assert_ok(ctx, pc_mesh_make(&in, ctx, 2 * one.vertex_count, 2 * one.face_count));
    for (pc_index v = 0; v < one.vertex_count; v++) {
        pc_vec3 p = pc_vec3_at(one.position, v);
        pc_vec3_put(in.position, v, p);
        pc_vec3_put(in.position, v + one.vertex_count, (pc_vec3){2 - p.x, p.y, -p.z});
    }
    for (pc_index i = 0; i < 3 * one.face_count; i++) {
        in.triangle[i] = one.triangle[i];
        in.triangle[3 * one.face_count + i] = one.triangle[i] + one.vertex_count;
    }
    assert_ok(ctx, pc_repair(&out, &report, ctx, &in, &PLAIN));
    check_result(&t, ctx, &in, &out, &report);
    assert_false(report.changed);
    assert_int_equal(report.merged_vertices.count + report.split_vertices.count, 0);
    assert_int_equal(t.component_count, 2);
    pc_topology_free(&t, ctx);
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&one, ctx);
    pc_mesh_free(&in, ctx);
    pc_mesh_free(&out, ctx);
}

static const double CUBE[24] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
static const pc_index CUBE_FACES[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                        2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

/* Two cubes, the second shifted by `shift`; where they touch they share vertices (the second one's are
 * unused). */
static void two_cubes(pc_mesh *mesh, pc_context *ctx, pc_vec3 shift) {
    assert_ok(ctx, pc_mesh_make(mesh, ctx, 16, 24));
    for (pc_index v = 0; v < 8; v++) {
        pc_vec3_put(mesh->position, v, pc_vec3_at(CUBE, v));
        pc_vec3_put(mesh->position, v + 8, pc_add(pc_vec3_at(CUBE, v), shift));
    }
    for (pc_index i = 0; i < 36; i++)
        mesh->triangle[i] = CUBE_FACES[i], mesh->triangle[36 + i] = CUBE_FACES[i] + 8;
    for (pc_index i = 36; i < 72; i++)
        for (pc_index v = 0; v < 8; v++)
            if (pc_distance(pc_vec3_at(mesh->position, v), pc_vec3_at(mesh->position, mesh->triangle[i])) ==
                0)
                mesh->triangle[i] = v;
}

static void touching_cubes_come_apart(void **state) {
    pc_context *ctx = *state;
    const pc_vec3 shifts[2] = {{1, 1, 1}, {1, 1, 0}}; /* by a corner, by an edge */
    for (int i = 0; i < 2; i++) {
        pc_mesh in, out;
        pc_repair_report report;
        pc_topology t;
        pc_repair_options strict = {.strict = true};
        two_cubes(&in, ctx, shifts[i]);
        assert_ok(ctx, pc_repair(&out, &report, ctx, &in, &PLAIN));
        check_result(&t, ctx, &in, &out, &report);
        assert_int_equal(t.component_count, 2);
        assert_int_equal(t.chi, 4);
        assert_int_equal(t.loop_count, 0);
        assert_int_equal(out.vertex_count, 16);
        assert_int_equal(report.crowded_edges.count, i);
        assert_int_equal(report.split_vertices.count, 1 - i);
        assert_int_equal(report.cut_vertices.count, 2 * i);
        assert_int_equal(report.flipped_faces.count, 0);
        pc_topology_free(&t, ctx);
        pc_repair_report_free(&report, ctx);
        pc_mesh_free(&out, ctx);
        assert_int_equal(pc_repair(&out, &report, ctx, &in, &strict), i ? PC_E_MESH : PC_OK);
        pc_repair_report_free(&report, ctx);
        pc_mesh_free(&out, ctx);
        pc_mesh_free(&in, ctx);
    }
}

static void unjoined_triangles_are_refused(void **state) {
    pc_context *ctx = *state;
    enum { COUNT = 100 };
    double position[9 * COUNT];
    pc_index triangle[3 * COUNT];
    pc_mesh in, out;
    pc_repair_report report;
    pc_repair_options lenient = PLAIN;
    lenient.shred_share = 1;
    for (pc_index i = 0; i < 3 * COUNT; i++) {
        triangle[i] = i;
        pc_vec3_put(position, i, (pc_vec3){i / 3 + 0.9 * (i % 3 == 1), i % 3 == 2, 0});
    }
    make_soup(&in, ctx, position, 3 * COUNT, triangle, COUNT);
    assert_int_equal(pc_repair(&out, &report, ctx, &in, &PLAIN), PC_E_MESH);
    assert_non_null(strstr(pc_context_message(ctx), "not joined"));
    pc_context_clear_message(ctx);
    assert_ok(ctx, pc_repair(&out, &report, ctx, &in, &lenient));
    assert_int_equal(out.face_count, COUNT);
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&out, ctx);
    pc_mesh_free(&in, ctx);
}

static void fin_is_cut_off_and_dropped(void **state) {
    pc_context *ctx = *state;
    pc_mesh cube, in, out;
    pc_repair_report report;
    pc_topology t;
    pc_repair_options drop = PLAIN;
    drop.min_component = 2;
    two_cubes(&cube, ctx, (pc_vec3){5, 0, 0});
    make_soup(&in, ctx, cube.position, 9, cube.triangle, 13);
    pc_vec3_put(in.position, 8, (pc_vec3){2, 0, 2});
    in.triangle[36] = 1, in.triangle[37] = 5, in.triangle[38] = 8;
    assert_ok(ctx, pc_repair(&out, &report, ctx, &in, &PLAIN));
    check_result(&t, ctx, &in, &out, &report);
    assert_int_equal(t.component_count, 2);
    assert_int_equal(t.component[0].chi, 2);
    assert_int_equal(report.crowded_edges.count, 1);
    pc_topology_free(&t, ctx);
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&out, ctx);
    assert_ok(ctx, pc_repair(&out, &report, ctx, &in, &drop));
    check_result(&t, ctx, &in, &out, &report);
    assert_int_equal(t.component_count, 1);
    assert_int_equal(report.dropped_components.count, 1);
    assert_int_equal(report.dropped_components.id[0], 12);
    assert_int_equal(out.vertex_count, 8);
    pc_topology_free(&t, ctx);
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&out, ctx);
    pc_mesh_free(&in, ctx);
    pc_mesh_free(&cube, ctx);
}

/* A strip of n squares closed with a half twist. */
static void moebius(pc_mesh *mesh, pc_context *ctx, pc_index n) {
    assert_ok(ctx, pc_mesh_make(mesh, ctx, 2 * n, 2 * n));
    for (pc_index i = 0; i < n; i++) {
        double angle = 2 * PC_PI * i / n, r = 0.3 * cos(angle / 2), z = 0.3 * sin(angle / 2);
        pc_vec3_put(mesh->position, 2 * i, (pc_vec3){(1 + r) * cos(angle), (1 + r) * sin(angle), z});
        pc_vec3_put(mesh->position, 2 * i + 1, (pc_vec3){(1 - r) * cos(angle), (1 - r) * sin(angle), -z});
        pc_index a = 2 * i, b = a + 1, c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? a + 3 : 0;
        const pc_index faces[6] = {a, c, b, b, c, d};
        memcpy(mesh->triangle + 6 * (size_t)i, faces, sizeof faces);
    }
}

static void moebius_strip_is_refused_or_torn(void **state) {
    pc_context *ctx = *state;
    pc_mesh in, out;
    pc_repair_report report;
    pc_topology t;
    pc_repair_options tear = {.tear_nonorientable = true};
    moebius(&in, ctx, 20);
    assert_int_equal(pc_repair(&out, &report, ctx, &in, &PLAIN), PC_E_MESH);
    assert_non_null(strstr(pc_context_message(ctx), "orientation"));
    pc_context_clear_message(ctx);
    assert_ok(ctx, pc_repair(&out, &report, ctx, &in, &tear));
    check_result(&t, ctx, &in, &out, &report);
    assert_int_equal(t.component_count, 1);
    assert_int_equal(t.chi, 1); /* a strip */
    assert_int_equal(t.loop_count, 1);
    assert_int_equal(report.torn_edges.count, 1);
    pc_topology_free(&t, ctx);
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&out, ctx);
    pc_mesh_free(&in, ctx);
}

/* Two faces that share an edge, and a pair of opposite faces folded back from it. */
static void fold_vanishes(void **state) {
    pc_context *ctx = *state;
    const double position[15] = {0, 0, 0, 1, 0, 0, 0.5, 1, 0, 0.5, -1, 0, 0.5, 0.5, 0};
    const pc_index faces[12] = {0, 1, 2, 1, 0, 3, 0, 1, 4, 1, 0, 4};
    pc_mesh in, out;
    pc_repair_report report;
    pc_topology t;
    make_soup(&in, ctx, position, 5, faces, 4);
    assert_ok(ctx, pc_repair(&out, &report, ctx, &in, &PLAIN));
    check_result(&t, ctx, &in, &out, &report);
    assert_int_equal(out.face_count, 2);
    assert_int_equal(report.duplicate_faces.count, 2);
    assert_int_equal(report.crowded_edges.count, 0);
    pc_topology_free(&t, ctx);
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&out, ctx);
    pc_mesh_free(&in, ctx);
}

/* A vertex stands on the edge between two faces: the zero-area face there goes by a flip; one on the border
 * goes too. */
static void zero_area_faces_are_cured(void **state) {
    pc_context *ctx = *state;
    const double position[18] = {0, 0, 0, 2, 0, 0, 1, 0, 0, 1, 2, 0, 1, -2, 0, 0.5, 1, 0};
    const pc_index faces[15] = {0, 1, 2, 1, 0, 4, 0, 2, 5, 2, 1, 3, 2, 3, 5};
    pc_mesh in, out;
    pc_repair_report report;
    pc_topology t;
    make_soup(&in, ctx, position, 6, faces, 5);
    assert_ok(ctx, pc_repair(&out, &report, ctx, &in, &PLAIN));
    check_result(&t, ctx, &in, &out, &report);
    assert_int_equal(report.zero_area_faces.count, 1);
    assert_int_equal(report.cured_zero_area, 1);
    assert_int_equal(out.face_count, 5);
    assert_true(fabs(pc_geometry_area(&out) - pc_geometry_area(&in)) < 1e-12);
    for (pc_index f = 0; f < 5; f++) {
        const pc_index *c = out.triangle + 3 * f;
        assert_true(pc_triangle_area(pc_vec3_at(out.position, c[0]), pc_vec3_at(out.position, c[1]),
                                     pc_vec3_at(out.position, c[2])) > 0.1);
    }
    pc_topology_free(&t, ctx);
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&out, ctx);
    pc_mesh_free(&in, ctx);

    make_soup(&in, ctx, position, 6, faces, 5); /* without the face below, the long edge is a border */
    memmove(in.triangle + 3, in.triangle + 6, 9 * sizeof *faces);
    in.face_count = 4;
    assert_ok(ctx, pc_repair(&out, &report, ctx, &in, &PLAIN));
    check_result(&t, ctx, &in, &out, &report);
    assert_int_equal(report.cured_zero_area, 1);
    assert_int_equal(out.face_count, 3);
    assert_int_equal(t.loop_count, 1);
    assert_int_equal(t.chi, 1);
    pc_topology_free(&t, ctx);
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&out, ctx);
    pc_mesh_free(&in, ctx);
}

static void random_soup(pc_mesh *in, pc_context *ctx, pc_random *random) {
    pc_index vertices = 3 + (pc_index)(pc_random_uniform(random) * 30);
    pc_index faces = 1 + (pc_index)(pc_random_uniform(random) * 90);
    int grid = pc_random_uniform(random) < 0.5 ? 3 : 1000; /* a coarse grid has equal and collinear places */
    assert_ok(ctx, pc_mesh_make(in, ctx, vertices, faces));
    for (pc_index i = 0; i < 3 * vertices; i++)
        in->position[i] = floor(pc_random_uniform(random) * grid);
    for (pc_index i = 0; i < 3 * faces; i++)
        in->triangle[i] = (pc_index)(pc_random_uniform(random) * vertices);
}

static void any_soup_becomes_manifold(void **state) {
    pc_context *ctx = *state;
    int refused = 0, made = 0;
    for (uint64_t seed = 1; seed <= 600; seed++) {
        pc_random random = {pc_hash64(seed)};
        pc_mesh in, out, again;
        pc_repair_report report, second;
        pc_topology t;
        pc_repair_options options = {
            .tear_nonorientable = seed % 4 != 0, .crowded_share = 1, .shred_share = 1};
        random_soup(&in, ctx, &random);
        pc_status status = pc_repair(&out, &report, ctx, &in, &options);
        if (status == PC_OK) {
            made++;
            check_result(&t, ctx, &in, &out, &report);
            pc_topology_free(&t, ctx);
        } else {
            bool empty = strstr(pc_context_message(ctx), "no face is left") != NULL;
            if (status != PC_E_MESH || (options.tear_nonorientable && !empty))
                fail_msg("seed %llu: %s", (unsigned long long)seed, pc_context_message(ctx));
            refused++;
            pc_context_clear_message(ctx);
        }
        pc_mesh_free(&in, ctx);
        pc_repair_report_free(&report, ctx);
        if (status != PC_OK) continue;
        /* Merging puts split vertices together again, so the second result may differ, but it is clean too.
         */
        options.tear_nonorientable = true;
        if (pc_repair(&again, &second, ctx, &out, &options) != PC_OK)
            fail_msg("seed %llu, again: %s", (unsigned long long)seed, pc_context_message(ctx));
        check_result(&t, ctx, &out, &again, &second);
        pc_topology_free(&t, ctx);
        pc_repair_report_free(&second, ctx);
        pc_mesh_free(&again, ctx);
        pc_mesh_free(&out, ctx);
    }
    assert_true(made > 400);
    assert_true(refused > 2);
}

/* Every allocation may fail, and nothing leaks. */
static void no_memory_is_reported(void **state) {
    pc_context *ctx = *state;
    pc_mesh in, out;
    pc_repair_report report;
    pc_random random = {pc_hash64(77)};
    pc_repair_options options = {
        .tear_nonorientable = true, .crowded_share = 1, .shred_share = 1, .min_component = 2};
    random_soup(&in, ctx, &random);
    for (size_t n = 1; n < 1000; n++) {
        pc_memory_fail_at(ctx, n);
        pc_status status = pc_repair(&out, &report, ctx, &in, &options);
        pc_memory_fail_at(ctx, 0);
        pc_repair_report_free(&report, ctx);
        pc_mesh_free(&out, ctx);
        if (status == PC_OK) break;
        if (status != PC_E_NOMEM) fail_msg("allocation %zu: %s", n, pc_context_message(ctx));
        assert_int_equal(status, PC_E_NOMEM);
        pc_context_clear_message(ctx);
        assert_true(n < 999);
    }
    pc_mesh_free(&in, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(clean_mesh_stays_as_it_is, make_context, free_context),
        cmocka_unit_test_setup_teardown(unwelded_turned_and_doubled_faces, make_context, free_context),
        cmocka_unit_test_setup_teardown(touching_interior_vertices_stay_apart, make_context, free_context),
        cmocka_unit_test_setup_teardown(touching_cubes_come_apart, make_context, free_context),
        cmocka_unit_test_setup_teardown(unjoined_triangles_are_refused, make_context, free_context),
        cmocka_unit_test_setup_teardown(fin_is_cut_off_and_dropped, make_context, free_context),
        cmocka_unit_test_setup_teardown(moebius_strip_is_refused_or_torn, make_context, free_context),
        cmocka_unit_test_setup_teardown(fold_vanishes, make_context, free_context),
        cmocka_unit_test_setup_teardown(zero_area_faces_are_cured, make_context, free_context),
        cmocka_unit_test_setup_teardown(any_soup_becomes_manifold, make_context, free_context),
        cmocka_unit_test_setup_teardown(no_memory_is_reported, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
