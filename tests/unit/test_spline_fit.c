/* Fits on shapes with known answers: what a spline can be is found again, scale does not matter, and errors
 * fall as cubic splines owe. */
#include "adapt.h"
#include "energy.h"
#include "insertion.h"
#include "memory.h"
#include "random.h"
#include "samples.h"
#include "scan_scene.h"
#include "synth_quads.h"

static const pc_tmesh_options defaults = PC_TMESH_DEFAULTS;
/* At every vertex of the scan; 5 x 5 samples per face. */
static const pc_accuracy_options measuring = {.per_side = 5};

/* Samples on the spline itself, `each` on every element. */
static pc_sample *samples_of(pc_context *ctx, const pc_tspline *spline, pc_index each) {
    pc_sample *sample = NULL;
    size_t count = (size_t)each * spline->basis.element_count;
    assert_ok(ctx, pc_new(&sample, ctx, count));
    for (size_t i = 0; i < count; i++) {
        const pc_element *e = spline->basis.element + i / each;
        size_t k = i % each;
        double s = ((double)(k % 4) + 0.5) / 4;
        double t = ((double)(k / 4) + 0.5) / 4; /* NOLINT(bugprone-integer-division) */
        sample[i].place = (pc_surface_place){(pc_index)(i / each), e->low[0] + s * (e->high[0] - e->low[0]),
                                             e->low[1] + t * (e->high[1] - e->low[1])};
        sample[i].target = pc_tspline_point(spline, sample[i].place);
        sample[i].weight = 1.0 / each;
    }
    return sample;
}

/* The assembled system is that of the energy: where the control points stray from a spline that all samples
 * lie on, the right-hand side is the matrix times the way back. Some may move, or all. */
static void a_spline_is_found_again(void **state) {
    pc_context *ctx = *state;
    for (int some = 0; some < 2; some++) {
        pc_polymesh quads;
        pc_tspline spline;
        pc_energy energy;
        pc_energy_facts facts;
        pc_device *host;
        double *way = NULL, *product = NULL;
        uint8_t *wish = NULL, *free = NULL;
        pc_closure_stats closed;
        pc_random random = {7};
        assert_ok(ctx, pc_device_open(&host, ctx, "host"));
        assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 4));
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        assert_ok(ctx, pc_new(&wish, ctx, spline.mesh.face_count));
        wish[3] = PC_HALVE_S, wish[40] = PC_HALVE_T, wish[50] = PC_HALVE_S | PC_HALVE_T;
        assert_ok(ctx, pc_insertion_refine(&spline, &closed, ctx, wish));
        pc_sample *sample = samples_of(ctx, &spline, 16);
        assert_ok(ctx, pc_new(&free, ctx, spline.mesh.vertex_count));
        for (pc_index v = 0; v < spline.mesh.vertex_count; v++)
            free[v] = !some || v % 3 == 0;
        assert_ok(ctx, pc_energy_make(&energy, ctx, &spline, free));
        size_t rows = energy.row_count;
        assert_int_equal(rows, some ? (spline.mesh.vertex_count + 2) / 3 : spline.mesh.vertex_count);
        assert_ok(ctx, pc_new(&way, ctx, 3 * rows));
        assert_ok(ctx, pc_new(&product, ctx, 2 * rows));
        for (size_t i = 0; i < 3 * rows; i++) {
            way[i] = pc_random_uniform(&random) - 0.5;
            spline.position[3 * (size_t)energy.vertex[i / 3] + i % 3] -= way[i];
        }
        pc_tspline_update(&spline);
        assert_ok(ctx, pc_energy_fill(&energy, &facts, ctx, host, sample,
                                      16 * (size_t)spline.basis.element_count, 0));
        assert_ok(ctx, pc_system_check(&energy.system, ctx));
        assert_true(facts.square > 0 && fabs(facts.weight - energy.element_count) < 1e-9);
        for (size_t k = 0; k < 3; k++) {
            for (size_t r = 0; r < rows; r++)
                product[rows + r] = way[3 * r + k];
            pc_system_apply(product, &energy.system, product + rows);
            for (size_t r = 0; r < rows; r++)
                assert_true(fabs(product[r] - energy.right[3 * r + k]) < 1e-13);
        }
        pc_energy_free(&energy, ctx);
        pc_free(ctx, way);
        pc_free(ctx, product);
        pc_free(ctx, sample);
        pc_free(ctx, wish);
        pc_free(ctx, free);
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
        pc_device_close(host, ctx);
    }
}

/* The right-hand side is minus half the energy's gradient, bending included: against differences of the
 * energy of the samples and of the plates, which a third-order rule integrates exactly. */
static double energy_of(const pc_tspline *spline, const pc_sample *sample, size_t count, double fairness,
                        const float *stiffness) {
    static const double node[4] = {0.06943184420297371, 0.33000947820757187, 0.6699905217924281,
                                   0.9305681557970262};
    static const double weight[4] = {0.17392742256872692, 0.32607257743127307, 0.32607257743127307,
                                     0.17392742256872692};
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        double d = pc_distance(pc_tspline_point(spline, sample[i].place), sample[i].target);
        sum += sample[i].weight * d * d;
    }
    for (pc_index e = 0; e < spline->basis.element_count; e++)
        for (int q = 0; q < 16; q++) {
            const pc_element *element = spline->basis.element + e;
            const double *size = spline->mesh.face[element->face].size;
            double a = element->high[0] - element->low[0], b = element->high[1] - element->low[1];
            pc_surface_point p =
                pc_tspline_evaluate(spline, (pc_surface_place){e, element->low[0] + a * node[q % 4],
                                                               element->low[1] + b * node[q / 4]});
            double part = a / size[0] * b / size[1] * weight[q % 4] * weight[q / 4], s = size[0], t = size[1];
            sum += fairness * (double)stiffness[element->face] * part *
                   (s * s * s * s * pc_dot(p.ss, p.ss) + 2 * s * s * t * t * pc_dot(p.st, p.st) +
                    t * t * t * t * pc_dot(p.tt, p.tt));
        }
    return sum;
}

static void right_sides_are_gradients(void **state) {
    pc_context *ctx = *state;
    const double fairness = 1e-3, step = 1e-3;
    pc_polymesh quads;
    pc_tspline spline;
    pc_energy energy;
    pc_energy_facts facts;
    pc_device *host;
    float *stiffness = NULL;
    assert_ok(ctx, pc_device_open(&host, ctx, "host"));
    assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 3));
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    pc_sample *sample = samples_of(ctx, &spline, 9);
    size_t count = 9 * (size_t)spline.basis.element_count;
    for (size_t i = 0; i < count; i++)
        sample[i].target = pc_scale(1.1 + 0.1 * sin((double)i), sample[i].target);
    assert_ok(ctx, pc_energy_make(&energy, ctx, &spline, NULL));
    assert_ok(ctx, pc_new(&stiffness, ctx, spline.mesh.face_count));
    for (pc_index f = 0; f < spline.mesh.face_count; f++)
        stiffness[f] = (float)(1 + f % 7);
    energy.stiffness = stiffness;
    assert_ok(ctx, pc_energy_fill(&energy, &facts, ctx, host, sample, count, fairness));
    for (pc_index r = 0; r < energy.row_count; r += 5) {
        double *x = spline.position + 3 * (size_t)energy.vertex[r] + r % 3, at = *x, side[2];
        for (int k = 0; k < 2; k++) {
            *x = at + (k ? step : -step);
            pc_tspline_update(&spline);
            side[k] = energy_of(&spline, sample, count, fairness, stiffness);
        }
        *x = at;
        double gradient = (side[1] - side[0]) / (2 * step); /* exact: the energy is quadratic */
        if (fabs(gradient + 2 * energy.right[3 * (size_t)r + r % 3]) > 1e-9)
            fail_msg("row %u: gradient %.12g, right-hand side %.12g", r, gradient,
                     energy.right[3 * (size_t)r + r % 3]);
    }
    pc_energy_free(&energy, ctx);
    pc_free(ctx, stiffness);
    pc_free(ctx, sample);
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
    pc_device_close(host, ctx);
}

/* Nearest points of a fine torus: the error falls faster than the size of the quads to the third power. (On
 * exact samples it is the fourth: test_spline_convergence.) */
static void torus_converges(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    double before = 0;
    assert_ok(ctx, pc_synth_torus(&s.scan, ctx, 2, 1, 384, 192));
    open_scene(&s, ctx);
    for (pc_index n = 1; n <= 2; n++) {
        pc_polymesh quads;
        pc_tspline spline;
        pc_fit_options options = PC_FIT_DEFAULTS;
        pc_fit_stats stats;
        pc_accuracy accuracy;
        pc_matching matching;
        assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 1, 12 * n, 6 * n));
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        assert_ok(ctx, pc_matching_make(&matching, ctx, &spline, &s.target, 5));
        options.fairness = 1e-8;
        assert_ok(ctx, pc_fit(&spline, &stats, ctx, s.host, &s.target, &matching, &options));
        assert_ok(ctx, pc_accuracy_measure(&accuracy, NULL, ctx, &spline, &s.target, &measuring));
        pc_matching_free(&matching, ctx);
        print_message("torus of %u points: max %.3g, mean %.3g; %u iterations\n", spline.mesh.vertex_count,
                      accuracy.scan_max, accuracy.scan_mean, stats.iterations);
        if (n > 1) assert_true(before / accuracy.scan_max > 8);
        before = accuracy.scan_max;
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
    }
    close_scene(&s, ctx);
}

static double largest_distance(pc_context *ctx, const scene *s, const pc_polymesh *quads, double within) {
    pc_tspline spline;
    pc_matching matching;
    pc_fit_options options = PC_FIT_DEFAULTS;
    pc_fit_stats stats;
    pc_accuracy accuracy;
    assert_ok(ctx, pc_tspline_make(&spline, ctx, quads, &defaults));
    assert_ok(ctx, pc_matching_make(&matching, ctx, &spline, &s->target, 5));
    options.within = within;
    options.rounds = 12;
    assert_ok(ctx, pc_fit(&spline, &stats, ctx, s->host, &s->target, &matching, &options));
    assert_ok(ctx, pc_accuracy_measure(&accuracy, NULL, ctx, &spline, &s->target, &measuring));
    print_message("%d rounds: largest distance %.3g, mean %.3g\n", stats.rounds, accuracy.max,
                  accuracy.scan_mean);
    if (within > 0) assert_true(stats.rounds < options.rounds && accuracy.max < 1.1 * within);
    pc_matching_free(&matching, ctx);
    pc_tspline_free(&spline, ctx);
    return accuracy.max;
}

/* A bump narrower than the quads: least squares leave a part of it out, weights that add up do not; and they
 * stop where it is enough. */
static void weights_serve_the_largest_distance(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    pc_polymesh quads;
    open_bump(&s, ctx, 8, 96, 4.3, 3.8, 0.5, 0.3);
    assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 8, 8, 10, 10));
    const double plain = largest_distance(ctx, &s, &quads, 0);
    const double weighted = largest_distance(ctx, &s, &quads, 0.7 * plain);
    assert_true(weighted < 0.8 * plain);
    pc_polymesh_free(&quads, ctx);
    close_scene(&s, ctx);
}

/* A flat surface, and a scan with a low bump between its samples: climbing finds what a far denser grid does.
 */
static void summits_between_samples_are_found(void **state) {
    pc_context *ctx = *state;
    int hidden = 0;
    for (uint64_t seed = 1; seed <= 8; seed++) {
        scene s = {0};
        pc_polymesh quads;
        pc_tspline spline;
        pc_accuracy found[3];
        pc_random random = {seed};
        const double x = 2 + pc_random_uniform(&random), y = 2 + pc_random_uniform(&random);
        open_bump(&s, ctx, 5, 120, x, y, 0.01, 0.03);
        assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 5, 5, 6, 6));
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        const double near[3] = {INFINITY, 0, INFINITY};
        const int per_side[3] = {4, 4, 24};
        for (int k = 0; k < 3; k++) {
            const pc_accuracy_options options = {.per_side = per_side[k], .near = near[k]};
            assert_ok(ctx, pc_accuracy_measure(&found[k], NULL, ctx, &spline, &s.target, &options));
        }
        print_message("seed %d: %.4g on a grid, %.4g climbed to, %.4g on a dense grid\n", (int)seed,
                      found[0].surface_max, found[1].surface_max, found[2].surface_max);
        assert_true(found[1].surface_max > 0.99 * found[2].surface_max);
        assert_true(found[1].surface_mean == found[0].surface_mean);
        hidden += found[0].surface_max < 0.9 * found[1].surface_max;
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
        close_scene(&s, ctx);
    }
    assert_true(hidden > 0);
}

/* A surface past all borders of a flat scan: it is pulled down to the plane, and back only from farther out
 * than the tolerance. */
static void borders_do_not_pull(void **state) {
    pc_context *ctx = *state;
    const double within = 0.04;
    scene s = {0};
    pc_polymesh quads;
    pc_tspline spline;
    pc_matching matching;
    pc_samples samples;
    size_t near = 0, far = 0;
    assert_ok(ctx, pc_synth_plane(&s.scan, ctx, 1, 1, 20, 20));
    open_scene(&s, ctx);
    assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 1.2, 1.2, 12, 12));
    for (pc_index v = 0; v < quads.vertex_count; v++) {
        double *p = quads.position + 3 * (size_t)v;
        p[0] -= 0.1, p[1] -= 0.1, p[2] = 0.02;
    }
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    assert_ok(ctx, pc_matching_make(&matching, ctx, &spline, &s.target, 5));
    pc_matching_follow(&matching, &spline, &s.target, NULL);
    assert_ok(ctx, pc_samples_make(&samples, ctx, &spline, &s.target, &matching, within, NULL));
    for (size_t i = 0; i < samples.count; i++) {
        const pc_vec3 p = pc_tspline_point(&spline, samples.sample[i].place), t = samples.sample[i].target;
        const double u = fmin(fmax(p.x, 0), 1), v = fmin(fmax(p.y, 0), 1), past = hypot(p.x - u, p.y - v);
        const bool of_vertex = hypot(t.x - p.x, t.y - p.y) > 1e-9 && past < within;
        if (of_vertex) continue; /* its place is where it was found before anything was fitted */
        assert_true(fabs(t.z) < 1e-12);
        assert_true(fabs(hypot(t.x - u, t.y - v) - fmin(past, within)) < 1e-9);
        near += past > 0 && past<within, far += past> within;
    }
    assert_true(near > 100 && far > 100);
    pc_samples_free(&samples, ctx);
    pc_matching_free(&matching, ctx);
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
    close_scene(&s, ctx);
}

/* The same sphere a thousand times as large gives the same surface a thousand times as large. */
static void scale_does_not_matter(void **state) {
    pc_context *ctx = *state;
    pc_adapt_stats stats[2];
    pc_index points[2];
    for (int k = 0; k < 2; k++) {
        scene s = {0};
        pc_polymesh quads;
        pc_tspline spline;
        pc_adapt_options options = PC_ADAPT_DEFAULTS;
        double scale = k ? 1024 : 1; /* exact in binary */
        assert_ok(ctx, pc_synth_sphere(&s.scan, ctx, 16));
        assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 2));
        for (size_t i = 0; i < 3 * (size_t)s.scan.vertex_count; i++)
            s.scan.position[i] *= scale;
        for (size_t i = 0; i < 3 * (size_t)quads.vertex_count; i++)
            quads.position[i] *= scale;
        open_scene(&s, ctx);
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        options.tolerance = 6e-3 * scale;
        assert_ok(ctx, pc_adapt(&spline, &stats[k], ctx, s.host, &s.target, &options));
        assert_ok(ctx, pc_tspline_check(&spline, NULL, ctx));
        assert_ok(ctx, pc_closure_check(&spline.mesh, ctx));
        points[k] = spline.mesh.vertex_count;
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
        close_scene(&s, ctx);
    }
    print_message("sphere: %u points, %.3g\n", points[0], stats[0].accuracy.max);
    assert_int_equal(points[0], points[1]);
    assert_true(fabs(stats[1].accuracy.max / stats[0].accuracy.max / 1024 - 1) < 1e-6);
}

/* A bent sheet: the surface reaches its border. */
static void borders_are_reached(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    pc_polymesh quads;
    pc_tspline spline;
    pc_adapt_options options = PC_ADAPT_DEFAULTS;
    pc_adapt_stats stats;
    assert_ok(ctx, pc_synth_plane(&s.scan, ctx, 2, 1, 24, 12));
    for (pc_index v = 0; v < s.scan.vertex_count; v++) {
        double *p = s.scan.position + 3 * (size_t)v;
        p[2] = 0.3 * sin(2 * p[0]) * cos(3 * p[1]);
    }
    assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 2, 1, 6, 3));
    for (pc_index v = 0; v < quads.vertex_count; v++) {
        double *p = quads.position + 3 * (size_t)v;
        p[2] = 0.3 * sin(2 * p[0]) * cos(3 * p[1]);
    }
    open_scene(&s, ctx);
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    options.tolerance = 6e-3; /* the facets of the scan are up to half of that off */
    assert_ok(ctx, pc_adapt(&spline, &stats, ctx, s.host, &s.target, &options));
    assert_ok(ctx, pc_tspline_check(&spline, NULL, ctx));
    print_message("sheet: %u points, %.3g\n", spline.mesh.vertex_count, stats.accuracy.max);
    assert_true(stats.accuracy.scan_max <= 6e-3); /* the scan's border vertices too */
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
    close_scene(&s, ctx);
}

/* Points of a spline over the plane where it faces down. */
static pc_index folded_points(const pc_tspline *spline) {
    enum { SIDE = 6 };
    pc_index count = 0;
    for (pc_index e = 0; e < spline->basis.element_count; e++)
        for (int k = 0; k < SIDE * SIDE; k++) {
            const double u = (k % SIDE + 0.5) / SIDE, v = ((double)(k / SIDE) + 0.5) / SIDE; /* NOLINT */
            const pc_surface_point p = pc_tspline_evaluate(spline, pc_element_place(&spline->basis, e, u, v));
            count += pc_cross(p.s, p.t).z < 0;
        }
    return count;
}

/* Quads that overlap on a gently curved scan: no distance tells, the surface is smooth all the same. */
static void folds_are_smoothed_out(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 8; seed++) {
        scene s = {0};
        pc_polymesh quads;
        pc_tspline spline;
        pc_adapt_options options = PC_ADAPT_DEFAULTS;
        pc_adapt_stats stats;
        pc_random random = {seed};
        assert_ok(ctx, pc_synth_plane(&s.scan, ctx, 1, 1, 30, 30));
        assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 1, 1, 12, 12));
        for (pc_index v = 0; v < quads.vertex_count; v++) {
            double *p = quads.position + 3 * (size_t)v;
            for (int k = 0; k < 2; k++)
                if (fabs(p[0] - 0.5) < 0.3 && fabs(p[1] - 0.5) < 0.3)
                    p[k] += 0.16 * (pc_random_uniform(&random) - 0.5);
            p[2] = 0.1 * sin(3 * p[0]);
        }
        for (pc_index v = 0; v < s.scan.vertex_count; v++)
            s.scan.position[3 * (size_t)v + 2] = 0.1 * sin(3 * s.scan.position[3 * (size_t)v]);
        open_scene(&s, ctx);
        assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
        options.tolerance = 0.01;
        assert_ok(ctx, pc_adapt(&spline, &stats, ctx, s.host, &s.target, &options));
        const pc_index folded = folded_points(&spline);
        if (folded > 0) fail_msg("seed %d: %u points face down", (int)seed, folded);
        pc_tspline_free(&spline, ctx);
        pc_polymesh_free(&quads, ctx);
        close_scene(&s, ctx);
    }
}

/* A budget that is too small is an honest failure. */
static void budgets_are_kept(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    pc_polymesh quads;
    pc_tspline spline;
    pc_adapt_options options = PC_ADAPT_DEFAULTS;
    pc_adapt_stats stats;
    assert_ok(ctx, pc_synth_sphere(&s.scan, ctx, 16));
    assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 2));
    open_scene(&s, ctx);
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    options.tolerance = 0, options.max_points = 10;
    assert_int_equal(pc_adapt(&spline, &stats, ctx, s.host, &s.target, &options), PC_E_NOCONV);
    assert_int_equal(spline.mesh.vertex_count, 26);
    assert_true(stats.accuracy.max > 0);
    assert_non_null(strstr(pc_context_message(ctx), "26 control points"));
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
    close_scene(&s, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_spline_is_found_again, make_context, free_context),
        cmocka_unit_test_setup_teardown(right_sides_are_gradients, make_context, free_context),
        cmocka_unit_test_setup_teardown(torus_converges, make_context, free_context),
        cmocka_unit_test_setup_teardown(weights_serve_the_largest_distance, make_context, free_context),
        cmocka_unit_test_setup_teardown(summits_between_samples_are_found, make_context, free_context),
        cmocka_unit_test_setup_teardown(borders_do_not_pull, make_context, free_context),
        cmocka_unit_test_setup_teardown(scale_does_not_matter, make_context, free_context),
        cmocka_unit_test_setup_teardown(borders_are_reached, make_context, free_context),
        cmocka_unit_test_setup_teardown(folds_are_smoothed_out, make_context, free_context),
        cmocka_unit_test_setup_teardown(budgets_are_kept, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
