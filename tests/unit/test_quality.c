/* Figures of quad meshes whose answers are known, and the certificate on whole and broken ones. */
#include "certificate.h"
#include "memory.h"
#include "quality.h"
#include "synth.h"
#include "synth_blob.h"
#include "synth_quads.h"
#include "synth_wear.h"
#include "testing.h"
#include <omp.h>

/* The scan and quads of a torus, and the field of its parallels and meridians turned by `turned` degrees. */
typedef struct scene {
    pc_mesh scan;
    pc_polymesh quads;
    pc_field field;
} scene;

static void make_field(pc_field *field, pc_context *ctx, const pc_mesh *scan, double turned) {
    *field = (pc_field){.symmetry = 4, .vertex_count = scan->vertex_count, .face_count = scan->face_count};
    assert_ok(ctx, pc_new(&field->normal, ctx, 3 * (size_t)scan->vertex_count));
    assert_ok(ctx, pc_new(&field->direction, ctx, 3 * (size_t)scan->vertex_count));
    assert_ok(ctx, pc_new(&field->index, ctx, scan->face_count));
    assert_ok(ctx, pc_new(&field->loop_index, ctx, 0));
    for (size_t v = 0; v < scan->vertex_count; v++) {
        pc_vec3 p = pc_vec3_at(scan->position, v), out = pc_unit((pc_vec3){p.x, p.y, 0});
        pc_vec3 along = {-out.y, out.x, 0}, n = pc_unit(pc_madd(p, -2, out));
        pc_vec3 other = pc_cross(n, along),
                k = v % 2 ? along : pc_scale(-1, other); /* any of the four will do */
        double t = turned * PC_PI / 180;
        pc_vec3_put(field->normal, v, n);
        pc_vec3_put(field->direction, v, pc_madd(pc_scale(cos(t), k), sin(t), pc_cross(n, k)));
    }
}

static void make_scene(scene *s, pc_context *ctx, pc_index steps) {
    assert_ok(ctx, pc_synth_torus(&s->scan, ctx, 2, 1, 10 * steps, 6 * steps));
    assert_ok(ctx, pc_synth_quad_torus(&s->quads, ctx, 2, 1, 5 * steps, 3 * steps));
    make_field(&s->field, ctx, &s->scan, 0);
}

static void free_scene(scene *s, pc_context *ctx) {
    pc_mesh_free(&s->scan, ctx);
    pc_polymesh_free(&s->quads, ctx);
    pc_field_free(&s->field, ctx);
}

static void measure(pc_quality *q, pc_context *ctx, const scene *s) {
    pc_quality_input input = {.scan = &s->scan, .quads = &s->quads, .field = &s->field};
    assert_ok(ctx, pc_quality_measure(q, ctx, &input));
}

static void torus_has_its_figures(void **state) {
    pc_context *ctx = *state;
    scene s;
    pc_quality q;
    make_scene(&s, ctx, 8);
    measure(&q, ctx, &s);
    assert_true(q.quad_polygon_percent == 100 && q.quad_cell_percent == 100 && q.polygons[4] == 960);
    assert_true(q.irregular_interior == 0 && q.boundary_vertices == 0 && q.t_junctions == 0);
    assert_true(q.inverted == 0 && q.zero_area == 0 && q.missed_components == 0);
    assert_int_equal(q.shape.edge_length.count, 2 * 960);
    assert_true(q.shape.angle.max < 10 && q.shape.scaled_jacobian.min > 0.95 && q.shape.folded_cells == 0);
    assert_true(q.shape.edge_length.min > 0.14 && q.shape.edge_length.max < 0.48);
    assert_true(q.shape.aspect.min >= 1 && q.shape.aspect.max < 2);
    assert_true(q.shape.warp.max < 0.1); /* the quads of a surface of revolution are flat */
    assert_true(q.field_angle.mean < 1 && q.field_angle.max < 2);
    double gap = 3 * (1 - cos(PC_PI / 40)) + 1 - cos(PC_PI / 24);
    assert_true(q.scan_to_quads.max < gap && q.scan_to_quads.max > gap / 3 && q.worst_component > 0);
    assert_true(q.quads_to_scan.max < gap && q.scan_to_quads.mean < q.scan_to_quads.q95);
    assert_true(q.scan_to_quads.q95 < q.scan_to_quads.max);
    assert_true(fabs(q.diagonal - sqrt(36 + 36 + 4)) < 0.01 && fabs(q.scan_area - 8 * PC_PI * PC_PI) < 0.3);
    assert_true(fabs(q.quads_area - q.scan_area) < 0.02 * q.scan_area);
    free_scene(&s, ctx);
}

static void field_angle_is_measured(void **state) {
    pc_context *ctx = *state;
    scene s;
    pc_quality q;
    make_scene(&s, ctx, 4);
    for (int turned = 0; turned <= 90; turned += 15) {
        pc_field_free(&s.field, ctx);
        make_field(&s.field, ctx, &s.scan, turned);
        measure(&q, ctx, &s);
        double expected = turned <= 45 ? turned : 90 - turned;
        assert_true(fabs(q.field_angle.mean - expected) < 2);
    }
    free_scene(&s, ctx);
}

static void irregular_vertices_and_tees(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    pc_quality q;
    pc_quality_input input = {.scan = &s.scan, .quads = &s.quads};
    assert_ok(ctx, pc_synth_sphere(&s.scan, ctx, 20));
    assert_ok(ctx, pc_synth_quad_sphere(&s.quads, ctx, 6));
    assert_ok(ctx, pc_quality_measure(&q, ctx, &input));
    assert_true(q.irregular_interior == 8 && q.inverted == 0 && q.interior_vertices == 218);
    free_scene(&s, ctx);

    assert_ok(ctx, pc_synth_plane(&s.scan, ctx, 2, 1, 8, 4));
    assert_ok(ctx, pc_synth_quad_tee(&s.quads, ctx));
    assert_ok(ctx, pc_quality_measure(&q, ctx, &input));
    assert_true(q.t_junctions == 1 && q.polygons[5] == 1 && q.cells[4] == 3 && q.quad_cell_percent == 100);
    assert_true(fabs(q.quad_polygon_percent - 200.0 / 3) < 1e-12);
    assert_true(q.irregular_interior == 0 && q.irregular_boundary == 0 && q.boundary_vertices == 7);
    assert_true(q.scan_to_quads.max == 0 && q.quads_to_scan.max < 1e-15 && q.shape.angle.max < 1e-5);
    assert_true(fabs(q.shape.aspect.max - 2) < 1e-12 && fabs(q.shape.scaled_jacobian.min - 1) < 1e-12);
    free_scene(&s, ctx);
}

static void threads_do_not_matter(void **state) {
    pc_context *ctx = *state;
    scene s;
    static pc_quality q[2];
    make_scene(&s, ctx, 4);
    for (int i = 0; i < 2; i++) {
        omp_set_num_threads(i ? 3 : 1);
        measure(&q[i], ctx, &s);
    }
    assert_memory_equal(&q[0], &q[1], sizeof q[0]);
    free_scene(&s, ctx);
}

/* The certificate of a scene; `failing` names the checks that must fail, all others must pass. */
static void expect(pc_context *ctx, const scene *s, double asked, const char *const *failing) {
    pc_quality q;
    pc_certificate certificate;
    pc_certificate_options options = PC_CERTIFICATE_DEFAULTS;
    options.faces_asked = asked;
    measure(&q, ctx, s);
    pc_certificate_make(&certificate, &q, &s->field, &options);
    for (int i = 0; i < certificate.count; i++) {
        const pc_check *check = certificate.check + i;
        bool must_fail = false;
        for (const char *const *name = failing; *name; name++)
            must_fail = must_fail || strcmp(*name, check->name) == 0;
        if (check->passed == must_fail)
            fail_msg("\"%s\" %s: %g, expected %g (%s)", check->name, must_fail ? "passed" : "failed",
                     check->value, check->expected, check->note);
    }
    assert_int_equal(certificate.passed, failing[0] == NULL);
    for (const char *const *name = failing; *name; name++)
        assert_non_null(pc_certificate_find(&certificate, *name));
}
#define FAILING(...) ((const char *const[]){__VA_ARGS__, NULL})

static void good_meshes_pass(void **state) {
    pc_context *ctx = *state;
    scene s;
    make_scene(&s, ctx, 4);
    expect(ctx, &s, 0, FAILING(NULL));
    expect(ctx, &s, 250, FAILING(NULL));
    expect(ctx, &s, 260, FAILING("face count"));
    expect(ctx, &s, 225, FAILING("face count"));
    s.field.index[7] = 1;
    expect(ctx, &s, 0, FAILING("singularity sum"));
    free_scene(&s, ctx);
}

static void broken_meshes_fail(void **state) {
    pc_context *ctx = *state;
    scene s;
    make_scene(&s, ctx, 4);
    pc_index *quad = s.quads.corner + 400, keep = quad[1];

    quad[1] = quad[3], quad[3] = keep; /* a flipped face; its edges pair with no others and open the fans */
    expect(ctx, &s, 0, FAILING("manifold", "inverted cells"));
    quad[3] = quad[1], quad[1] = keep;

    s.quads.face_count--; /* a missing face */
    expect(ctx, &s, 0, FAILING("Euler number", "boundary loops"));
    s.quads.face_count++;

    quad[1] = quad[0]; /* a face with a repeated vertex */
    expect(ctx, &s, 0, FAILING("manifold", "broken cells", "Euler number", "boundary loops"));
    quad[1] = keep;

    double *p = s.quads.position + 3 * (size_t)quad[0], x = p[0]; /* a vertex flung away */
    p[0] = 10;
    expect(ctx, &s, 0, FAILING("inverted cells", "no part added")); /* two of its cells fold over */
    p[0] = NAN;
    expect(ctx, &s, 0, FAILING("broken cells", "no part dropped", "no part added", "surface area"));
    p[0] = x;
    expect(ctx, &s, 0, FAILING(NULL));

    double old[12]; /* a cell of no area: its corners in one point */
    for (int k = 0; k < 4; k++) {
        memcpy(old + 3 * k, s.quads.position + 3 * (size_t)quad[k], 3 * sizeof *old);
        memcpy(s.quads.position + 3 * (size_t)quad[k], old, 3 * sizeof *old);
    }
    expect(ctx, &s, 0, FAILING("zero-area cells"));
    free_scene(&s, ctx);
}

/* A shred of the scan, or a heap of folds on it, can keep all else. */
static void wrong_areas_fail(void **state) {
    pc_context *ctx = *state;
    const struct {
        double factor;
        bool passes;
    } cases[] = {{0.2, false}, {0.5, true}, {1.2, true}, {1.8, false}, {100, false}, {NAN, false}};
    pc_quality q;
    scene s;
    make_scene(&s, ctx, 4);
    measure(&q, ctx, &s);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        pc_certificate certificate;
        const pc_certificate_options options = PC_CERTIFICATE_DEFAULTS;
        q.quads_area = cases[k].factor * q.scan_area;
        pc_certificate_make(&certificate, &q, &s.field, &options);
        const pc_check *check = pc_certificate_find(&certificate, "surface area");
        assert_non_null(check);
        if (check->passed != cases[k].passes || certificate.passed != cases[k].passes)
            fail_msg("%g of the area: %d", cases[k].factor, check->passed);
    }
    free_scene(&s, ctx);
}

static void doubled_face_and_stray_vertex_fail(void **state) {
    pc_context *ctx = *state;
    scene s;
    make_scene(&s, ctx, 4);
    pc_index corners = s.quads.start[s.quads.face_count];
    assert_ok(ctx, pc_resize(&s.quads.corner, ctx, corners + 4));
    assert_ok(ctx, pc_resize(&s.quads.corner_flat, ctx, corners + 4));
    assert_ok(ctx, pc_resize(&s.quads.start, ctx, s.quads.face_count + 2));
    memcpy(s.quads.corner + corners, s.quads.corner, 4 * sizeof *s.quads.corner);
    memset(s.quads.corner_flat + corners, 0, 4);
    s.quads.start[++s.quads.face_count] = corners + 4;
    expect(ctx, &s, 0, FAILING("manifold", "Euler number"));
    s.quads.face_count--;
    expect(ctx, &s, 0, FAILING(NULL));
    assert_ok(ctx, pc_resize(&s.quads.position, ctx, 3 * ((size_t)s.quads.vertex_count + 1)));
    memset(s.quads.position + 3 * (size_t)s.quads.vertex_count, 0, 3 * sizeof(double));
    s.quads.vertex_count++;
    expect(ctx, &s, 0, FAILING("manifold"));
    free_scene(&s, ctx);
}

static void dropped_parts_fail(void **state) {
    pc_context *ctx = *state;
    scene s;
    pc_mesh small;
    make_scene(&s, ctx, 4);
    assert_ok(ctx, pc_synth_sphere(&small, ctx, 4));
    for (size_t c = 0; c < 3 * (size_t)small.vertex_count; c++)
        small.position[c] *= 0.05;
    assert_ok(ctx, pc_synth_append(&s.scan, ctx, &small, (pc_vec3){3.1, 0, 0})); /* close by: only counted */
    pc_field_free(&s.field, ctx);
    make_field(&s.field, ctx, &s.scan, 0);
    s.field.index[3] = 8; /* a field of the sphere that is there */
    expect(ctx, &s, 0, FAILING("components", "Euler number", "no part dropped"));
    pc_mesh_free(&small, ctx);
    free_scene(&s, ctx);
}

static void empty_result_fails(void **state) {
    pc_context *ctx = *state;
    scene s;
    make_scene(&s, ctx, 4);
    s.quads.face_count = s.quads.vertex_count = 0;
    expect(ctx, &s, 0, FAILING("broken cells", "components", "no part dropped", "surface area"));
    free_scene(&s, ctx);
}

static void refused_memory_leaves_nothing(void **state) {
    pc_context *ctx = *state;
    scene s;
    pc_quality q;
    make_scene(&s, ctx, 4);
    pc_quality_input input = {.scan = &s.scan, .quads = &s.quads, .field = &s.field};
    pc_status status = PC_E_NOMEM;
    for (size_t n = 1; status == PC_E_NOMEM && n < 200; n++) {
        pc_memory_fail_at(ctx, n);
        status = pc_quality_measure(&q, ctx, &input);
    }
    pc_memory_fail_at(ctx, 0);
    assert_int_equal(status, PC_OK);
    free_scene(&s, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(torus_has_its_figures, make_context, free_context),
        cmocka_unit_test_setup_teardown(field_angle_is_measured, make_context, free_context),
        cmocka_unit_test_setup_teardown(irregular_vertices_and_tees, make_context, free_context),
        cmocka_unit_test_setup_teardown(threads_do_not_matter, make_context, free_context),
        cmocka_unit_test_setup_teardown(good_meshes_pass, make_context, free_context),
        cmocka_unit_test_setup_teardown(broken_meshes_fail, make_context, free_context),
        cmocka_unit_test_setup_teardown(wrong_areas_fail, make_context, free_context),
        cmocka_unit_test_setup_teardown(doubled_face_and_stray_vertex_fail, make_context, free_context),
        cmocka_unit_test_setup_teardown(dropped_parts_fail, make_context, free_context),
        cmocka_unit_test_setup_teardown(empty_result_fails, make_context, free_context),
        cmocka_unit_test_setup_teardown(refused_memory_leaves_nothing, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
