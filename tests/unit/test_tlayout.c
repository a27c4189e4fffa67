/* Polygons with T-junctions as T-meshes: four corners each, sums of knot intervals, analysis-suitable. */
#include "closure.h"
#include "intervals.h"
#include "polygraph.h"
#include "random_polygons.h"
#include "random_quads.h"
#include "synth_quads.h"
#include "tlayout.h"
#include "tspline.h"
#include <math.h>

/* Rule 1, exactly, and the same interval from both sides of an edge. */
static void fulfils_rule_one(pc_context *ctx, const pc_polymesh *faces, const double *interval,
                             double least) {
    pc_polygraph graph;
    assert_ok(ctx, pc_polygraph_of_polymesh(&graph, ctx, faces));
    for (pc_index f = 0; f < faces->face_count; f++) {
        double sum[4] = {0};
        pc_index from = faces->start[f], count = faces->start[f + 1] - from, first = 0;
        int side = -1;
        while (faces->corner_flat[from + first])
            first++;
        for (pc_index k = 0; k < count; k++) {
            pc_index c = from + (first + k) % count, twin = graph.twin[c];
            side += !faces->corner_flat[c];
            assert_in_range(side, 0, 3);
            assert_true(interval[c] >= least);
            assert_true(twin == PC_NONE || interval[c] == interval[twin]);
            sum[side] += interval[c];
        }
        assert_int_equal(side, 3);
        assert_true(sum[0] == sum[2] && sum[1] == sum[3]);
    }
    pc_polygraph_free(&graph, ctx);
}

/* A T-mesh with all that is promised of one, as large as the polygons and their surroundings ask for. */
static pc_index becomes_a_spline(pc_context *ctx, const pc_polymesh *polygons) {
    const pc_tmesh_options options = PC_TMESH_DEFAULTS;
    pc_tspline spline;
    pc_basis_facts facts;
    pc_index points;
    double most = 0;
    assert_ok(ctx, pc_tspline_make(&spline, ctx, polygons, &options));
    assert_ok(ctx, pc_tspline_check(&spline, &facts, ctx));
    assert_ok(ctx, pc_closure_check(&spline.mesh, ctx));
    for (size_t i = 0; i < 3 * (size_t)polygons->vertex_count; i++)
        most = fmax(most, fabs(polygons->position[i]));
    for (size_t i = 0; i < 3 * (size_t)spline.mesh.vertex_count; i++)
        assert_true(fabs(spline.position[i]) <= 3 * most); /* NaN fails too */
    points = spline.mesh.vertex_count;
    pc_tspline_free(&spline, ctx);
    return points;
}

static void random_polygons_become_splines(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 24; seed++) {
        pc_polymesh mesh;
        pc_tlayout layout;
        print_message("seed %d: ", (int)seed);
        if (seed % 4 == 0) assert_ok(ctx, pc_synth_quad_torus(&mesh, ctx, 2, 1, 12, 8));
        if (seed % 4 == 1) assert_ok(ctx, pc_synth_quad_sphere(&mesh, ctx, 4));
        if (seed % 4 == 2) assert_ok(ctx, pc_synth_quad_plane(&mesh, ctx, 6, 4, 9, 7));
        if (seed % 4 == 3) make_random_quads(&mesh, ctx, seed, 4, 6);
        make_random_polygons(&mesh, ctx, seed, 5 * (int)seed);
        assert_ok(ctx, pc_tlayout_make(&layout, ctx, &mesh));
        fulfils_rule_one(ctx, &layout.faces, layout.interval, 0.0625);
        print_message("%u polygons, %u faces, ", mesh.face_count, layout.faces.face_count);
        print_message("%u control points\n", becomes_a_spline(ctx, &mesh));
        pc_tlayout_free(&layout, ctx);
        pc_polymesh_free(&mesh, ctx);
    }
}

/* Two rows of `fine` columns each go on as one row, around a torus or, open, on a plane: nothing needs to go
 * apart. Rows: 2 `rows` fine ones, `rows` coarse ones. */
static void make_two_widths(pc_polymesh *mesh, pc_context *ctx, bool around, pc_index fine, pc_index coarse,
                            pc_index rows) {
    pc_index columns = fine + coarse, lines = around ? columns : columns + 1, high = 2 * rows + 1, at = 0;
    pc_index face = 0;
    assert_ok(ctx, pc_polymesh_make(mesh, ctx, (size_t)lines * high, (size_t)rows * (2 * fine + coarse),
                                    4 * (size_t)rows * (2 * fine + coarse) + 2 * rows));
    for (pc_index i = 0; i < lines; i++)
        for (pc_index j = 0; j < high; j++) {
            double turn = 2 * PC_PI * i / columns, height = (double)j / rows;
            pc_vec3 p = around ? (pc_vec3){cos(turn), sin(turn), height} : (pc_vec3){i, 0, height};
            pc_vec3_put(mesh->position, i * high + j, p);
        }
    for (pc_index i = 0; i < columns; i++) {
        pc_index left = i * high, right = (i + 1) % lines * high, step = i < fine ? 1 : 2;
        for (pc_index j = 0; j < 2 * rows; j += step) {
            mesh->corner[at++] = left + j;
            mesh->corner[at++] = right + j;
            if (step == 2 && around && i + 1 == columns) {
                mesh->corner_flat[at] = 1;
                mesh->corner[at++] = right + j + 1;
            }
            mesh->corner[at++] = right + j + step;
            mesh->corner[at++] = left + j + step;
            if (step == 2 && i == fine) {
                mesh->corner_flat[at] = 1;
                mesh->corner[at++] = left + j + 1;
            }
            mesh->start[++face] = at;
        }
    }
}

static void agreeing_rows_stay_whole(void **state) {
    pc_context *ctx = *state;
    for (int k = 0; k < 6; k++) {
        pc_polymesh mesh;
        pc_tlayout layout;
        make_two_widths(&mesh, ctx, k % 2, 3 + (pc_index)k, 4, 3);
        assert_ok(ctx, pc_tlayout_make(&layout, ctx, &mesh));
        assert_int_equal(layout.faces.face_count, mesh.face_count);
        fulfils_rule_one(ctx, &layout.faces, layout.interval, 0.125);
        /* Halves of a row that is 1 to 2 wide: both kinds as near to 1 as they can be. */
        for (pc_index c = 0; c < layout.faces.start[layout.faces.face_count]; c++)
            assert_true(layout.interval[c] >= 0.5 && layout.interval[c] <= 2);
        (void)becomes_a_spline(ctx, &mesh);
        pc_tlayout_free(&layout, ctx);
        pc_polymesh_free(&mesh, ctx);
    }
}

/* A sphere with one quad halved: its neighbours have T-junctions. Half an edge that leaves a vertex of
 * valence 3 would have to be as long as the whole ones there. */
static void make_halved_sphere(pc_polymesh *mesh, pc_context *ctx) {
    pc_polymesh quads;
    pc_polygraph graph;
    assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 2));
    assert_ok(ctx, pc_polygraph_of_polymesh(&graph, ctx, &quads));
    const pc_index *q = quads.corner, n = quads.vertex_count, faces = quads.face_count;
    const pc_index beside[2] = {graph.twin[0], graph.twin[2]};
    pc_index at = 0;
    assert_ok(ctx, pc_polymesh_make(mesh, ctx, (size_t)n + 2, (size_t)faces + 1, 4 * (size_t)faces + 6));
    memcpy(mesh->position, quads.position, 3 * sizeof(double) * n);
    for (pc_index k = 0; k < 2; k++)
        pc_vec3_put(mesh->position, n + k,
                    pc_scale(0.5, pc_add(pc_vec3_at(quads.position, q[2 * k]),
                                         pc_vec3_at(quads.position, q[2 * k + 1]))));
    const pc_index halves[8] = {q[0], n, n + 1, q[3], n, q[1], q[2], n + 1};
    memcpy(mesh->corner, halves, sizeof halves);
    mesh->start[1] = 4, mesh->start[2] = at = 8;
    for (pc_index f = 1; f < faces; f++) {
        for (pc_index c = 4 * f; c < 4 * f + 4; c++) {
            mesh->corner[at++] = q[c];
            if (c != beside[0] && c != beside[1]) continue;
            mesh->corner_flat[at] = 1;
            mesh->corner[at++] = n + (c == beside[1]);
        }
        mesh->start[f + 2] = at;
    }
    pc_polygraph_free(&graph, ctx);
    pc_polymesh_free(&quads, ctx);
}

static void contradictions_are_refused(void **state) {
    pc_context *ctx = *state;
    pc_polymesh mesh;
    pc_tlayout layout;
    pc_intervals_stats stats;
    double *interval = NULL;
    uint8_t *may_go = NULL, *refused = NULL;
    make_halved_sphere(&mesh, ctx);
    pc_index corners = mesh.start[mesh.face_count];
    assert_ok(ctx, pc_new(&interval, ctx, corners));
    assert_ok(ctx, pc_new(&may_go, ctx, mesh.face_count));
    assert_ok(ctx, pc_new(&refused, ctx, mesh.face_count));
    for (pc_index c = 0; c < corners; c++)
        interval[c] = 1;
    for (pc_index f = 0; f < mesh.face_count; f++)
        may_go[f] = mesh.start[f + 1] - mesh.start[f] > 4;
    assert_ok(ctx, pc_intervals_solve(interval, refused, &stats, ctx, &mesh, may_go, 0.25));
    assert_true(stats.refused > 0);
    for (pc_index f = 0; f < mesh.face_count; f++)
        assert_true(may_go[f] || !refused[f]);
    for (pc_index c = 0; c < corners; c++)
        assert_true(interval[c] == 1);
    memset(may_go, 0, mesh.face_count);
    memset(refused, 0, mesh.face_count);
    assert_int_equal(pc_intervals_solve(interval, refused, &stats, ctx, &mesh, may_go, 0.25), PC_E_BUG);
    pc_context_clear_message(ctx);
    assert_ok(ctx, pc_tlayout_make(&layout, ctx, &mesh));
    assert_true(layout.faces.face_count != mesh.face_count);
    fulfils_rule_one(ctx, &layout.faces, layout.interval, 0.25);
    (void)becomes_a_spline(ctx, &mesh);
    pc_tlayout_free(&layout, ctx);
    pc_polymesh_free(&mesh, ctx);
    pc_free(ctx, interval);
    pc_free(ctx, may_go);
    pc_free(ctx, refused);
}

/* Where intervals around extraordinary vertices differ, faces are cut until they are equal. */
static void uneven_stars_are_cut(void **state) {
    pc_context *ctx = *state;
    const double width[4] = {0.5, 1.5, 0.75, 3};
    for (int k = 0; k < 4; k++) {
        const pc_tmesh_options options = PC_TMESH_DEFAULTS;
        pc_polymesh mesh;
        pc_polygraph graph;
        pc_tmesh tmesh;
        pc_closure_stats stats;
        double *interval = NULL;
        assert_ok(ctx, pc_synth_quad_sphere(&mesh, ctx, 3));
        assert_ok(ctx, pc_polygraph_of_polymesh(&graph, ctx, &mesh));
        assert_ok(ctx, pc_new(&interval, ctx, graph.corner_count));
        for (pc_index c = 0; c < graph.corner_count; c++)
            interval[c] = 1;
        for (pc_index c = 0, first = 0; c != PC_NONE;) { /* a ring of faces around the sphere */
            interval[c] = interval[graph.twin[c]] = width[k];
            c = graph.twin[c];
            c = c / 4 * 4 + (c + 2) % 4;
            if (c == first) break;
        }
        assert_ok(ctx, pc_tmesh_make(&tmesh, NULL, ctx, &mesh, interval, &options));
        assert_int_equal(pc_tmesh_check(&tmesh, ctx), PC_E_BUG);
        assert_ok(ctx, pc_closure_settle(&tmesh, &stats, ctx));
        assert_true(stats.cuts > 0);
        assert_ok(ctx, pc_tmesh_check(&tmesh, ctx));
        assert_ok(ctx, pc_closure_check(&tmesh, ctx));
        pc_tmesh_free(&tmesh, ctx);
        pc_free(ctx, interval);
        pc_polygraph_free(&graph, ctx);
        pc_polymesh_free(&mesh, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(random_polygons_become_splines, make_context, free_context),
        cmocka_unit_test_setup_teardown(agreeing_rows_stay_whole, make_context, free_context),
        cmocka_unit_test_setup_teardown(contradictions_are_refused, make_context, free_context),
        cmocka_unit_test_setup_teardown(uneven_stars_are_cut, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
