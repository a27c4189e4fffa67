/* Solver kernels in both shapes against the plain-C references. */
#include "devmat.h"
#include "devsolve.h"
#include "memory.h"
#include "random.h"
#include "shape_testing.h"
#include "solver.h"
#include "systems.h"
#include "testing.h"
#include <math.h>

extern const char pc_kernel_cycle[];
extern const char pc_kernel_conjugate[];

static const pc_block_kind kinds[3] = {PC_BLOCK_SCALAR, PC_BLOCK_COMPLEX, PC_BLOCK_TURNED};

static double *random_vector(pc_context *ctx, size_t n, uint64_t seed) {
    pc_random random = {seed};
    double *x = NULL;
    assert_ok(ctx, pc_new(&x, ctx, n));
    for (size_t i = 0; i < n; i++)
        x[i] = 2 * pc_random_uniform(&random) - 1;
    return x;
}

static double relative_residual(pc_context *ctx, const pc_system *system, const double *x, const double *b) {
    size_t n = (size_t)system->row_count * (size_t)pc_block_width(system->kind);
    double *y = NULL;
    double error = 0;
    double size = 0;
    assert_ok(ctx, pc_new(&y, ctx, n));
    pc_system_apply(y, system, x);
    for (size_t i = 0; i < n; i++) {
        error += (y[i] - b[i]) * (y[i] - b[i]);
        size += b[i] * b[i];
    }
    pc_free(ctx, y);
    return sqrt(error / size);
}

/* Iterations; the true residual must be what is claimed. `answer` takes the solution, which the caller frees.
 */
static pc_index solve(pc_context *ctx, pc_device *device, const pc_system *system, pc_preconditioner which,
                      double tolerance, double **answer) {
    size_t n = (size_t)system->row_count * (size_t)pc_block_width(system->kind);
    pc_solver_options options = PC_SOLVER_DEFAULTS;
    pc_solver_stats stats;
    pc_solver *solver = NULL;
    double *b = random_vector(ctx, n, 11);
    double *x = random_vector(ctx, n, 12);
    options.preconditioner = which;
    if (which == PC_PRECONDITION_JACOBI) options.max_iterations = 10000;
    assert_ok(ctx, pc_solver_make(&solver, ctx, device, system, &options));
    assert_ok(ctx, pc_solver_solve(solver, ctx, x, b, tolerance, &stats));
    double residual = relative_residual(ctx, system, x, b);
    assert_true(residual <= 1.01 * tolerance);
    assert_true(fabs(residual - stats.residual) <= 1e-2 * tolerance);
    pc_solver_free(solver, ctx);
    pc_free(ctx, b);
    if (answer)
        *answer = x;
    else
        pc_free(ctx, x);
    return stats.iterations;
}

static void random_systems_on_both_shapes(void **state) {
    pc_context *ctx = *state;
    static const pc_index sizes[] = {1, 2, 7, 9, 100, 3001};
    for (int s = 0; s < 2; s++) {
        pc_device *device = open_device(ctx, shapes[s]);
        if (!device) skip();
        for (size_t k = 0; k < 3 * sizeof sizes / sizeof *sizes; k++) {
            for (int which = 0; which < 2; which++) {
                pc_system system;
                assert_ok(ctx,
                          pc_synth_random_system(&system, ctx, kinds[k % 3], sizes[k / 3], 9, 1.05, 40 + k));
                assert_ok(ctx, pc_system_check(&system, ctx));
                (void)solve(ctx, device, &system, (pc_preconditioner)which, 1e-9, NULL);
                pc_system_free(&system, ctx);
            }
        }
        pc_device_close(device, ctx);
    }
}

/* From one diagonal to another without a new hierarchy: right answers, in about the iterations of a fresh
 * solver. */
static void diagonals_change(pc_context *ctx, pc_device *device, pc_block_kind kind,
                             pc_preconditioner which) {
    enum { CHANGES = 4 };
    static const double shift[CHANGES] = {1e-4, 1e-2, 1, 1e-2};
    pc_system system;
    pc_synth_options options = PC_SYNTH_DEFAULTS;
    pc_solver_options solving = {which, 10000, 0, true};
    pc_solver *solver = NULL;
    pc_solver_stats stats;
    options.around = 61, options.across = 50;
    assert_ok(ctx, pc_synth_torus_system(&system, ctx, kind, &options));
    size_t n = (size_t)system.row_count * (size_t)pc_block_width(kind);
    double *first = NULL;
    assert_ok(ctx, pc_new(&first, ctx, system.row_count));
    memcpy(first, system.diagonal, system.row_count * sizeof *first);
    assert_ok(ctx, pc_solver_make(&solver, ctx, device, &system, &solving));
    for (int k = 0; k < CHANGES; k++) {
        double *b = random_vector(ctx, n, 21);
        double *x = random_vector(ctx, n, 22);
        for (pc_index i = 0; i < system.row_count; i++)
            system.diagonal[i] = first[i] + shift[k] * (1 + 0.5 * sin(0.01 * i));
        assert_ok(ctx, pc_solver_set_diagonal(solver, ctx, system.diagonal));
        assert_ok(ctx, pc_solver_solve(solver, ctx, x, b, 1e-9, &stats));
        assert_true(relative_residual(ctx, &system, x, b) <= 1.01e-9);
        pc_index fresh = solve(ctx, device, &system, which, 1e-9, NULL);
        assert_true(stats.iterations <= fresh + fresh / 4 + 2);
        pc_free(ctx, b);
        pc_free(ctx, x);
    }
    first[system.row_count / 2] *= 0.9;
    assert_int_equal(pc_solver_set_diagonal(solver, ctx, first), PC_E_BUG);
    pc_context_clear_message(ctx);
    pc_solver_free(solver, ctx);
    pc_free(ctx, first);
    pc_system_free(&system, ctx);
}

static void diagonals_change_everywhere(void **state) {
    pc_context *ctx = *state;
    pc_device *host = NULL;
    assert_ok(ctx, pc_device_open(&host, ctx, "host"));
    for (int k = 0; k < 3; k++)
        for (int which = 0; which < 2; which++)
            diagonals_change(ctx, host, kinds[k], (pc_preconditioner)which);
    pc_device_close(host, ctx);
    for (int s = 0; s < 2; s++) {
        pc_device *device = open_device(ctx, shapes[s]);
        if (!device) skip();
        for (int k = 0; k < 3; k++)
            for (int which = 0; which < 2; which++)
                diagonals_change(ctx, device, kinds[k], (pc_preconditioner)which);
        pc_device_close(device, ctx);
    }
}

static void device_iterates_like_the_host(void **state) {
    pc_context *ctx = *state;
    pc_device *host = NULL;
    assert_ok(ctx, pc_device_open(&host, ctx, "host"));
    for (int k = 0; k < 3; k++) {
        pc_system system;
        pc_synth_options options = PC_SYNTH_DEFAULTS;
        double *expected = NULL;
        options.around = 90;
        options.across = 70;
        assert_ok(ctx, pc_synth_torus_system(&system, ctx, kinds[k], &options));
        size_t n = (size_t)system.row_count * (size_t)pc_block_width(system.kind);
        pc_index its = solve(ctx, host, &system, PC_PRECONDITION_MULTIGRID, 1e-10, &expected);
        for (int s = 0; s < 2; s++) {
            pc_device *device = open_device(ctx, shapes[s]);
            double *x = NULL;
            double largest = 0;
            double difference = 0;
            if (!device) continue;
            pc_index on_device = solve(ctx, device, &system, PC_PRECONDITION_MULTIGRID, 1e-10, &x);
            assert_true(on_device + 1 >= its && on_device <= its + 1);
            for (size_t i = 0; i < n; i++) {
                largest = fmax(largest, fabs(expected[i]));
                difference = fmax(difference, fabs(x[i] - expected[i]));
            }
            assert_true(difference <= 1e-4 * largest);
            pc_free(ctx, x);
            pc_device_close(device, ctx);
        }
        pc_free(ctx, expected);
        pc_system_free(&system, ctx);
    }
    pc_device_close(host, ctx);
}

/* Small allocations split the matrices; the answer's bytes stay. */
static void split_matrices_give_the_same_bytes(void **state) {
    pc_context *ctx = *state;
    for (int k = 0; k < 6; k++) {
        pc_device *device = open_device(ctx, shapes[k / 3]);
        pc_system system;
        pc_synth_options options = PC_SYNTH_DEFAULTS;
        double *whole = NULL;
        double *split = NULL;
        if (!device) skip();
        options.around = options.across = 120;
        assert_ok(ctx, pc_synth_torus_system(&system, ctx, kinds[k % 3], &options));
        size_t n = (size_t)system.row_count * (size_t)pc_block_width(system.kind);
        (void)solve(ctx, device, &system, PC_PRECONDITION_MULTIGRID, 1e-8, &whole);
        pc_device_set_allocation_cap(device, 3 * n * sizeof(double));
        (void)solve(ctx, device, &system, PC_PRECONDITION_MULTIGRID, 1e-8, &split);
        assert_memory_equal(whole, split, n * sizeof *whole);
        pc_free(ctx, whole);
        pc_free(ctx, split);
        pc_system_free(&system, ctx);
        pc_device_close(device, ctx);
    }
}

static void order_keeps_every_row(void **state) {
    pc_context *ctx = *state;
    pc_system system;
    pc_multigrid multigrid;
    pc_row_order order;
    assert_ok(ctx, pc_synth_random_system(&system, ctx, PC_BLOCK_COMPLEX, 1000, 12, 1.2, 3));
    assert_ok(ctx, pc_multigrid_make_finest(&multigrid, ctx, &system));
    assert_ok(ctx, pc_row_order_make(&order, ctx, &multigrid.level[0].matrix));
    for (pc_index i = 0; i < 1000; i++) {
        assert_int_equal(order.row[order.place[i]], i);
        assert_int_equal(order.place[i] / 256, i / 256);
        if (i % 256 > 0) {
            pc_index here = order.row[i];
            pc_index before = order.row[i - 1];
            assert_true(system.start[here + 1] - system.start[here] <=
                        system.start[before + 1] - system.start[before]);
        }
    }
    pc_row_order_free(&order, ctx);
    pc_multigrid_free(&multigrid, ctx);
    pc_system_free(&system, ctx);
}

/* v to eleven binary digits, or to multiples of 2^-24 where these are coarser. */
static double as_half(double v) {
    int power = 0;
    (void)frexp(v, &power);
    const int unit = power - 11 > -24 ? power - 11 : -24;
    return ldexp(rint(ldexp(v, -unit)), unit);
}

/* The numbers of m as halves in units of a power of two for each row, which the largest one reaches half of.
 */
static float *halved(pc_context *ctx, const pc_blockmat *m) {
    const size_t size = (size_t)pc_form_size(m->form);
    float *out = NULL;
    assert_ok(ctx, pc_new(&out, ctx, size * m->start[m->row_count]));
    for (pc_index i = 0; i < m->row_count; i++) {
        double largest = 0;
        int power = 0;
        for (size_t k = size * m->start[i]; k < size * m->start[i + 1]; k++)
            largest = fmax(largest, fabs((double)m->value[k]));
        (void)frexp(largest, &power);
        for (size_t k = size * m->start[i]; k < size * m->start[i + 1]; k++)
            out[k] = (float)ldexp(as_half(ldexp((double)m->value[k], -power)), power);
    }
    return out;
}

/* Items and group size of a kernel that takes slices one by one, or rows. */
static size_t items_of(const pc_device *device, const pc_devmat *m, size_t slices_per_item, size_t group) {
    const size_t rows = pc_devmat_padded(m);
    return pc_device_shape(device) == PC_SHAPE_CHUNK
               ? ((size_t)m->slice_count + slices_per_item - 1) / slices_per_item
               : (rows + group - 1) / group * group;
}

/* One product of a level, kernel against reference. */
static void compare_product(pc_context *ctx, pc_device *device, pc_blockmat *m, const pc_row_order *order,
                            pc_storage storage) {
    static const char *const names[3] = {"cycle_scalar", "cycle_complex", "cycle_turned"};
    const size_t w = (size_t)pc_form_width(m->form);
    const size_t n = w * m->row_count;
    pc_devmat on_device;
    pc_kernel *kernel;
    pc_buffer *x_buffer;
    pc_buffer *y_buffer;
    float *x = NULL;
    float *y = NULL;
    float *placed = NULL;
    float *whole = m->value;
    assert_ok(ctx, pc_devmat_make(&on_device, ctx, device, m, order, order, storage));
    const size_t padded = w * pc_devmat_padded(&on_device);
    assert_ok(ctx, pc_new(&x, ctx, padded));
    assert_ok(ctx, pc_new(&y, ctx, padded));
    assert_ok(ctx, pc_new(&placed, ctx, padded));
    for (size_t i = 0; i < n; i++)
        x[i] = (float)((double)(pc_hash64(i) >> 40) * 0x1p-23 - 1);
    for (size_t i = 0; i < n; i++)
        placed[w * order->place[i / w] + i % w] = x[i];
    assert_ok(ctx, pc_buffer_from(&x_buffer, ctx, device, placed, padded * sizeof *x));
    assert_ok(ctx, pc_buffer_zeroed(&y_buffer, ctx, device, padded * sizeof *x));
    assert_ok(ctx, pc_kernel_get(&kernel, ctx, device, pc_kernel_cycle, names[m->form]));
    assert_int_equal(on_device.part_count, 1);
    const pc_devmat_part *part = &on_device.part[0];
    /* y = 0 - A x with b = y */
    assert_ok(ctx, pc_kernel_run(ctx, kernel, items_of(device, &on_device, 5, 1),
                                 pc_device_shape(device) == PC_SHAPE_CHUNK ? 1 : 0, 0,
                                 PC_ARGS(PC_BUF(part->start), PC_BUF(part->column), PC_BUF(part->value),
                                         PC_BUF(part->exponent), PC_BUF(on_device.diagonal), PC_BUF(x_buffer),
                                         PC_BUF(y_buffer), PC_BUF(y_buffer), PC_U32(0), PC_U32(part->slices),
                                         PC_U32(5), PC_U32(pc_devmat_storage(&on_device, part)), PC_U32(2),
                                         PC_F32(0), PC_F32(0))));
    assert_ok(ctx, pc_buffer_read(placed, ctx, y_buffer, 0, padded * sizeof *placed));
    if (storage == PC_STORE_HALF) m->value = halved(ctx, m);
    pc_blockmat_apply(y, m, x);
    if (storage == PC_STORE_HALF) pc_free(ctx, m->value);
    m->value = whole;
    for (size_t i = 0; i < n; i++) {
        float got = -placed[w * order->place[i / w] + i % w];
        if (!(fabsf(got - y[i]) <= 2e-5F))
            fail_msg("form %d, storage %d, number %zu: kernel %g, reference %g", m->form, storage, i,
                     (double)got, (double)y[i]);
    }
    pc_buffer_free(x_buffer, ctx);
    pc_buffer_free(y_buffer, ctx);
    pc_devmat_free(&on_device, ctx);
    pc_free(ctx, x);
    pc_free(ctx, y);
    pc_free(ctx, placed);
}

static void products_match_their_reference(void **state) {
    pc_context *ctx = *state;
    for (int k = 0; k < 3; k++) {
        pc_system system;
        pc_multigrid multigrid;
        pc_synth_options options = PC_SYNTH_DEFAULTS;
        options.around = 61;
        options.across = 37;
        assert_ok(ctx, pc_synth_torus_system(&system, ctx, kinds[k], &options));
        assert_ok(ctx, pc_multigrid_make(&multigrid, ctx, &system));
        for (int s = 0; s < 2; s++) {
            pc_device *device = open_device(ctx, shapes[s]);
            if (!device) skip();
            for (int level = 0; level < 2; level++) {
                pc_row_order order;
                pc_blockmat *m = &multigrid.level[level].matrix;
                assert_ok(ctx, pc_row_order_make(&order, ctx, m));
                compare_product(ctx, device, m, &order, PC_STORE_FLOAT);
                compare_product(ctx, device, m, &order, PC_STORE_HALF);
                pc_row_order_free(&order, ctx);
            }
            pc_device_close(device, ctx);
        }
        pc_multigrid_free(&multigrid, ctx);
        pc_system_free(&system, ctx);
    }
}

/* The product of conjugate gradients with a vector of doubles or of floats: all digits of the system's. */
static void compare_outer_product(pc_context *ctx, pc_device *device, const pc_system *system, bool wide,
                                  pc_storage storage) {
    static const char *const names[3] = {"conjugate_scalar", "conjugate_complex", "conjugate_turned"};
    enum { GROUP = 128, CHUNK_SLICES = 512 };
    const size_t w = (size_t)pc_block_width(system->kind);
    const size_t n = w * system->row_count;
    pc_multigrid finest;
    pc_row_order order;
    pc_devmat m;
    pc_kernel *kernel;
    pc_buffer *buffer[4];
    assert_ok(ctx, pc_multigrid_make_finest(&finest, ctx, system));
    assert_ok(ctx, pc_row_order_make(&order, ctx, &finest.level[0].matrix));
    assert_ok(ctx, pc_devmat_make(&m, ctx, device, &finest.level[0].matrix, &order, &order, storage));
    const size_t padded = w * pc_devmat_padded(&m);
    double *x = random_vector(ctx, n, 31);
    double *expected = random_vector(ctx, n, 32);
    double *placed = random_vector(ctx, padded, 33);
    double *diagonal = random_vector(ctx, padded, 34);
    float *narrow = NULL;
    assert_ok(ctx, pc_new(&narrow, ctx, padded));
    for (size_t i = 0; i < n; i++) {
        const size_t at = w * order.place[i / w] + i % w;
        narrow[at] = (float)x[i];
        if (!wide) x[i] = (double)narrow[at];
        placed[at] = x[i];
        diagonal[order.place[i / w]] = finest.scale * system->diagonal[i / w];
    }
    pc_system_apply(expected, system, x);
    const void *from = wide ? (void *)placed : (void *)narrow;
    assert_ok(ctx, pc_buffer_from(&buffer[0], ctx, device, diagonal, padded * sizeof(double)));
    assert_ok(
        ctx, pc_buffer_from(&buffer[1], ctx, device, from, padded * (wide ? sizeof(double) : sizeof(float))));
    for (int k = 2; k < 4; k++)
        assert_ok(ctx, pc_buffer_zeroed(&buffer[k], ctx, device, padded * sizeof(double)));
    assert_ok(ctx, pc_kernel_get(&kernel, ctx, device, pc_kernel_conjugate, names[system->kind]));
    const pc_devmat_part *part = &m.part[0];
    assert_ok(ctx,
              pc_kernel_run(ctx, kernel, items_of(device, &m, CHUNK_SLICES, GROUP),
                            pc_device_shape(device) == PC_SHAPE_CHUNK ? 1 : GROUP, 0,
                            PC_ARGS(PC_BUF(part->start), PC_BUF(part->column), PC_BUF(part->value),
                                    PC_BUF(part->rest), PC_BUF(part->last ? part->last : part->rest),
                                    PC_BUF(part->exponent), PC_BUF(buffer[0]), PC_BUF(buffer[1]),
                                    PC_BUF(buffer[2]), PC_BUF(buffer[3]), PC_U32(0), PC_U32(part->slices),
                                    PC_U32(pc_devmat_storage(&m, part)), PC_U32(wide))));
    assert_ok(ctx, pc_buffer_read(placed, ctx, buffer[2], 0, padded * sizeof *placed));
    for (size_t i = 0; i < n; i++) {
        const double got = placed[w * order.place[i / w] + i % w] / finest.scale;
        if (!(fabs(got - expected[i]) <= 2e-14 * system->diagonal[i / w]))
            fail_msg("kind %d, storage %d, number %zu: kernel %.17g, reference %.17g", system->kind, storage,
                     i, got, expected[i]);
    }
    for (int k = 0; k < 4; k++)
        pc_buffer_free(buffer[k], ctx);
    pc_free(ctx, x);
    pc_free(ctx, expected);
    pc_free(ctx, placed);
    pc_free(ctx, diagonal);
    pc_free(ctx, narrow);
    pc_devmat_free(&m, ctx);
    pc_row_order_free(&order, ctx);
    pc_multigrid_free(&finest, ctx);
}

static void outer_products_keep_all_digits(void **state) {
    pc_context *ctx = *state;
    for (int s = 0; s < 2; s++) {
        pc_device *device = open_device(ctx, shapes[s]);
        if (!device) skip();
        for (int k = 0; k < 3; k++) {
            for (int of = 0; of < 4; of++) {
                pc_system system;
                assert_ok(ctx,
                          pc_synth_random_system(&system, ctx, kinds[k], 3001, 9, 1.05, 70 + (uint64_t)k));
                compare_outer_product(ctx, device, &system, of & 1, of & 2 ? PC_STORE_HALF : PC_STORE_FLOAT);
                pc_system_free(&system, ctx);
            }
        }
        pc_device_close(device, ctx);
    }
}

/* Rows of any size fit into halves, and neither they nor columns of 32 bits cost iterations. */
static void storage_costs_no_iterations(void **state) {
    pc_context *ctx = *state;
    for (int s = 0; s < 2; s++) {
        pc_device *device = open_device(ctx, shapes[s]);
        if (!device) skip();
        for (int k = 0; k < 3; k++) {
            pc_system system;
            pc_index iterations[2] = {0, 0};
            pc_synth_options options = PC_SYNTH_DEFAULTS;
            options.around = k == 1 ? 400 : 120, options.across = 180;
            assert_ok(ctx, pc_synth_torus_system(&system, ctx, kinds[k], &options));
            const size_t n = (size_t)system.row_count * (size_t)pc_block_width(system.kind);
            double *b = random_vector(ctx, n, 61);
            for (int half = 0; half < 2; half++) {
                pc_solver_options solving = PC_SOLVER_DEFAULTS;
                pc_solver *solver = NULL;
                pc_solver_stats stats;
                double *x = NULL;
                solving.half = half;
                assert_ok(ctx, pc_new(&x, ctx, n));
                assert_ok(ctx, pc_solver_make(&solver, ctx, device, &system, &solving));
                assert_ok(ctx, pc_solver_solve(solver, ctx, x, b, 1e-8, &stats));
                assert_true(relative_residual(ctx, &system, x, b) <= 1.01e-8);
                iterations[half] = stats.iterations;
                pc_solver_free(solver, ctx);
                pc_free(ctx, x);
            }
            assert_true(iterations[1] <= iterations[0] + 1 && iterations[0] <= iterations[1] + 1);
            pc_free(ctx, b);
            pc_system_free(&system, ctx);
        }
        pc_device_close(device, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(order_keeps_every_row, make_context, free_context),
        cmocka_unit_test_setup_teardown(products_match_their_reference, make_context, free_context),
        cmocka_unit_test_setup_teardown(outer_products_keep_all_digits, make_context, free_context),
        cmocka_unit_test_setup_teardown(storage_costs_no_iterations, make_context, free_context),
        cmocka_unit_test_setup_teardown(random_systems_on_both_shapes, make_context, free_context),
        cmocka_unit_test_setup_teardown(diagonals_change_everywhere, make_context, free_context),
        cmocka_unit_test_setup_teardown(device_iterates_like_the_host, make_context, free_context),
        cmocka_unit_test_setup_teardown(split_matrices_give_the_same_bytes, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
