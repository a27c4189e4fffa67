/* Pictures of splines: they show the surface and not how it is cut into triangles or patches; the distances
 * that they show are distances. */
#include "insertion.h"
#include "memory.h"
#include "random.h"
#include "scene_spline.h"
#include "synth.h"
#include "synth_quads.h"
#include "tessellation.h"
#include "testing.h"
#include <omp.h>
#include <stdlib.h>

static const pc_tmesh_options defaults = PC_TMESH_DEFAULTS;
static const pc_picture_options small = {
    .width = 320, .height = 240, .samples = 2, .view = PC_VIEW_ISO, .up = PC_UP_Y};

static void make_torus(pc_tspline *spline, pc_context *ctx) {
    pc_polymesh quads;
    assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 1, 14, 8));
    assert_ok(ctx, pc_tspline_make(spline, ctx, &quads, &defaults));
    pc_polymesh_free(&quads, ctx);
}

/* Cuts faces at random; the surface stays. */
static void refine(pc_tspline *spline, pc_context *ctx, uint64_t seed) {
    pc_random random = {seed};
    uint8_t *wish = NULL;
    pc_closure_stats stats;
    assert_ok(ctx, pc_new(&wish, ctx, spline->mesh.face_count));
    for (pc_index f = 0; f < spline->mesh.face_count; f++)
        if (pc_random_uniform(&random) < 0.3) wish[f] = (uint8_t)(1 + (int)(3 * pc_random_uniform(&random)));
    assert_ok(ctx, pc_insertion_refine(spline, &stats, ctx, wish));
    pc_free(ctx, wish);
}

typedef pc_status scene(pc_picture *picture, pc_context *ctx, const pc_tspline *spline);

static uint8_t *draw(pc_context *ctx, scene *what, const pc_tspline *spline, const pc_tspline *framed_on) {
    pc_picture picture;
    uint8_t *pixels = NULL;
    assert_ok(ctx, pc_picture_make(&picture, ctx, framed_on->position, framed_on->mesh.vertex_count, &small));
    assert_ok(ctx, what(&picture, ctx, spline));
    assert_ok(ctx, pc_picture_pixels(&pixels, ctx, &picture));
    pc_picture_free(&picture, ctx);
    return pixels;
}

/* The same surface in other patches has the same reflections. */
static void stripes_do_not_show_the_patches(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 3; seed++) {
        pc_tspline spline, refined;
        make_torus(&spline, ctx);
        make_torus(&refined, ctx);
        refine(&refined, ctx, seed);
        assert_true(refined.mesh.vertex_count > spline.mesh.vertex_count);
        uint8_t *a = draw(ctx, pc_scene_zebra, &spline, &spline);
        uint8_t *b = draw(ctx, pc_scene_zebra, &refined, &spline);
        size_t far = 0, dark = 0, light = 0;
        for (int i = 0; i < 3 * 320 * 240; i++) {
            far += abs(a[i] - b[i]) > 60;
            dark += a[i]<70, light += a[i]> 200;
        }
        /* only at the rim, where stripes are narrower than pixels */
        if (far > 3 * 320 * 240 / 300) fail_msg("seed %d: %zu values differ", (int)seed, far);
        assert_true(dark > 3 * 320 * 240 / 10 && light > 3 * 320 * 240 / 10);
        pc_free(ctx, a);
        pc_free(ctx, b);
        pc_tspline_free(&refined, ctx);
        pc_tspline_free(&spline, ctx);
    }
}

/* Vertices inside of elements are on the surface with its normal, those on rims very near it. */
static void tessellation_is_on_the_surface(void **state) {
    pc_context *ctx = *state;
    pc_tspline spline;
    pc_tessellation t;
    make_torus(&spline, ctx);
    refine(&spline, ctx, 5);
    assert_ok(ctx, pc_tessellation_make(&t, ctx, &spline, 0.05));
    assert_int_equal(t.start[spline.basis.element_count], t.vertex_count);
    for (pc_index e = 0; e < spline.basis.element_count; e++) {
        const pc_element *element = spline.basis.element + e;
        const pc_index row = t.cells[e][0] + 1U;
        assert_int_equal(t.start[e + 1] - t.start[e], row * (t.cells[e][1] + 1U));
        for (pc_index k = 0; k < t.start[e + 1] - t.start[e]; k++) {
            double u = (double)(k % row) / t.cells[e][0], v = (double)(k / row) / t.cells[e][1]; /* NOLINT */
            pc_surface_place place = {e, element->low[0] + u * (element->high[0] - element->low[0]),
                                      element->low[1] + v * (element->high[1] - element->low[1])};
            pc_surface_point x = pc_tspline_evaluate(&spline, place);
            bool rim = u <= 0 || u >= 1 || v <= 0 || v >= 1;
            pc_vec3 p = pc_vec3_at(t.position, t.start[e] + k), n = pc_unit(pc_cross(x.s, x.t));
            const float *m = t.normal + 3 * (size_t)(t.start[e] + k);
            assert_true(pc_distance(p, x.p) < (rim ? 0.02 : 1e-14));
            assert_true(n.x * (double)m[0] + n.y * (double)m[1] + n.z * (double)m[2] >
                        (rim ? 0.999 : 1 - 1e-6));
        }
    }
    for (size_t k = 0; k < 3 * (size_t)t.face_count; k++) { /* no side much longer than asked for */
        size_t next = k % 3 == 2 ? k - 2 : k + 1;
        assert_true(pc_distance(pc_vec3_at(t.position, t.triangle[k]),
                                pc_vec3_at(t.position, t.triangle[next])) < 0.09);
    }
    pc_tessellation_free(&t, ctx);
    assert_ok(ctx, pc_tessellation_make(&t, ctx, &spline, 0)); /* not finer than memory allows */
    assert_true(t.vertex_count >= 4 * spline.basis.element_count && t.vertex_count <= 6000000);
    pc_tessellation_free(&t, ctx);
    pc_tspline_free(&spline, ctx);
}

/* Grids of unlike fineness side by side: nothing shines through a plane. */
static void patches_leave_no_gap(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 6; seed++) {
        pc_polymesh quads;
        pc_tspline spline;
        pc_picture picture;
        pc_picture_options options = small;
        options.view = PC_VIEW_FRONT;
        assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 3, 2, 7, 5));
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        pc_random random = {seed};
        for (size_t v = 0; v < spline.mesh.vertex_count;
             v++) /* bent, but seen from the front a whole sheet */
            spline.position[3 * v + 2] += 0.2 * pc_random_uniform(&random);
        pc_tspline_update(&spline);
        refine(&spline, ctx, seed);
        assert_ok(ctx, pc_picture_make(&picture, ctx, quads.position, quads.vertex_count, &options));
        assert_ok(ctx, pc_scene_spline(&picture, ctx, &spline));
        float a[3], b[3];
        pc_camera_project(a, &picture.pane[0].camera, (pc_vec3){0.3, 1.7, 0});
        pc_camera_project(b, &picture.pane[0].camera, (pc_vec3){2.7, 0.3, 0});
        for (int y = (int)a[1]; y < (int)b[1]; y++)
            for (int x = (int)a[0]; x < (int)b[0]; x++)
                if (!isfinite(picture.depth[(size_t)y * (size_t)picture.columns + (size_t)x]))
                    fail_msg("seed %d: sample %d %d is not covered", (int)seed, x, y);
        pc_picture_free(&picture, ctx);
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
    }
}

typedef struct plate { /* a flat spline over 0..3 x 0..2, and a flat scan */
    pc_tspline spline;
    pc_mesh scan;
    pc_adjacency adjacency;
    pc_target target;
} plate;

static void make_plate(plate *p, pc_context *ctx, double width, double height) {
    pc_polymesh quads;
    assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 3, 2, 7, 5));
    assert_ok(ctx, pc_tspline_make(&p->spline, ctx, &quads, &defaults));
    assert_ok(ctx, pc_synth_plane(&p->scan, ctx, width, 2, 40, 30));
    for (size_t v = 0; v < p->scan.vertex_count; v++)
        p->scan.position[3 * v + 2] = height;
    assert_ok(ctx, pc_adjacency_make(&p->adjacency, ctx, &p->scan));
    assert_ok(ctx, pc_target_make(&p->target, ctx, &p->scan, &p->adjacency));
    pc_polymesh_free(&quads, ctx);
}

static void free_plate(plate *p, pc_context *ctx) {
    pc_target_free(&p->target, ctx);
    pc_adjacency_free(&p->adjacency, ctx);
    pc_mesh_free(&p->scan, ctx);
    pc_tspline_free(&p->spline, ctx);
}

static double total(const double *bins) {
    double sum = 0;
    for (int k = 0; k < PC_ERRORS_BINS; k++)
        sum += bins[k];
    return sum;
}

static void distances_are_told_as_they_are(void **state) {
    pc_context *ctx = *state;
    const double tolerance[3] = {0.02, 0.005, 0.0001};
    plate p;
    make_plate(&p, ctx, 3, 0.01);
    for (int k = 0; k < 3; k++) {
        pc_errors errors;
        assert_ok(ctx, pc_errors_make(&errors, ctx, &p.spline, &p.target, tolerance[k], 0.01));
        assert_true(fabs(errors.largest - 0.01) < 1e-6);
        assert_true(fabs(errors.high - (k == 0 ? 0.02 : k == 1 ? 0.01 : 0.0006)) < 1e-6);
        assert_true(fabs(total(errors.surface) - 1) < 1e-12 && fabs(total(errors.scan) - 1) < 1e-12);
        assert_true(fabs(errors.within - (k == 0)) < 1e-12);
        for (int q = 0; q < PC_ERRORS_QUANTILES; q++)
            assert_true(fabs(errors.quantile[q] - 0.01) < 1e-6);
        for (int i = 0; i <= 8; i++)
            if (k == 0)
                assert_true(fabs((double)pc_errors_at(&errors, 17, i / 8.0, 1 - i / 8.0) - 0.01) < 1e-6);
        pc_errors_free(&errors, ctx);
    }
    free_plate(&p, ctx);
}

/* A scan that ends at two thirds: beyond there is no data, and none of it counts. */
static void where_the_scan_ends_nothing_is_known(void **state) {
    pc_context *ctx = *state;
    plate p;
    pc_errors errors;
    make_plate(&p, ctx, 2, 0);
    assert_ok(ctx, pc_errors_make(&errors, ctx, &p.spline, &p.target, 1e-3, 0));
    int unknown = 0, known = 0;
    for (pc_index e = 0; e < errors.element_count; e++) {
        const pc_element *element = p.spline.basis.element + e;
        pc_vec3 x =
            pc_tspline_point(&p.spline, (pc_surface_place){e, 0.5 * (element->low[0] + element->high[0]),
                                                           element->low[1] + 0.01});
        float d = pc_errors_at(&errors, e, 0.5, 0.01);
        if (x.x > 2.3) assert_true(isnan(d)), unknown++;
        if (x.x < 1.7) assert_true(d < 1e-6F), known++;
    }
    assert_true(unknown > 3 && known > 10);
    assert_true(errors.largest <= 1e-3 && fabs(total(errors.surface) - 1) < 1e-12);
    pc_errors_free(&errors, ctx);
    free_plate(&p, ctx);
}

static void colours_change_at_the_tolerance(void **state) {
    (void)state;
    pc_color color[PC_ERROR_COLORS];
    pc_error_colors(color, 0.25, 1);
    for (int k = 0; k < PC_ERROR_COLORS; k++) {
        int red = pc_color_channel(color[k], 0), blue = pc_color_channel(color[k], 2);
        double d = (double)k / (PC_ERROR_COLORS - 1);
        if (d < 0.24 && d > 0.01) assert_true(blue > red);
        if (d > 0.26) assert_true(red > blue);
    }
}

static pc_status draw_all(uint8_t **pixels, pc_context *ctx, const plate *p, int width) {
    pc_picture picture = {0};
    pc_errors errors = {0};
    pc_picture_options options = small;
    pc_status status = PC_OK;
    options.legend = 1, options.width = width, options.height = 3 * width / 8;
    PC_TRY(pc_picture_make(&picture, ctx, p->scan.position, p->scan.vertex_count, &options));
    PC_TRY(pc_errors_make(&errors, ctx, &p->spline, &p->target, 0.004, 0.01));
    PC_TRY(pc_scene_zebra(&picture, ctx, &p->spline));
    PC_TRY(pc_scene_errors(&picture, ctx, &p->spline, &errors, 0.004));
    PC_TRY(pc_scene_spline(&picture, ctx, &p->spline));
    if (pixels) PC_TRY(pc_picture_pixels(pixels, ctx, &picture));
done:
    pc_errors_free(&errors, ctx);
    pc_picture_free(&picture, ctx);
    return status;
}

static void threads_change_no_byte(void **state) {
    pc_context *ctx = *state;
    uint8_t *one = NULL, *many = NULL;
    const int before = omp_get_max_threads();
    plate p;
    make_plate(&p, ctx, 2.5, 0.01);
    refine(&p.spline, ctx, 4);
    omp_set_num_threads(1);
    assert_ok(ctx, draw_all(&one, ctx, &p, 640));
    omp_set_num_threads(5);
    assert_ok(ctx, draw_all(&many, ctx, &p, 640));
    omp_set_num_threads(before);
    assert_memory_equal(one, many, 3 * 640 * 240);
    pc_free(ctx, one);
    pc_free(ctx, many);
    free_plate(&p, ctx);
}

static void refused_memory_leaves_nothing_behind(void **state) {
    pc_context *ctx = *state;
    plate p;
    bool finished = false;
    make_plate(&p, ctx, 3, 0.01);
    for (size_t n = 1; n < 400 && !finished; n += n < 30 ? 1 : 4) {
        size_t before = pc_memory_used(ctx);
        pc_memory_fail_at(ctx, n);
        pc_status status = draw_all(NULL, ctx, &p, 480);
        pc_memory_fail_at(ctx, 0);
        finished = status == PC_OK;
        if (!finished) assert_int_equal(status, PC_E_NOMEM);
        assert_int_equal(pc_memory_used(ctx), before);
        pc_context_clear_message(ctx);
    }
    assert_true(finished);
    free_plate(&p, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(stripes_do_not_show_the_patches, make_context, free_context),
        cmocka_unit_test_setup_teardown(tessellation_is_on_the_surface, make_context, free_context),
        cmocka_unit_test_setup_teardown(patches_leave_no_gap, make_context, free_context),
        cmocka_unit_test_setup_teardown(distances_are_told_as_they_are, make_context, free_context),
        cmocka_unit_test_setup_teardown(where_the_scan_ends_nothing_is_known, make_context, free_context),
        cmocka_unit_test_setup_teardown(colours_change_at_the_tolerance, make_context, free_context),
        cmocka_unit_test_setup_teardown(threads_change_no_byte, make_context, free_context),
        cmocka_unit_test_setup_teardown(refused_memory_leaves_nothing_behind, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
